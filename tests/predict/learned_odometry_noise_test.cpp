// SPDX-License-Identifier: MIT
#include "limber/predict/learned_odometry_noise.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "limber/core/random.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;

const OdometryNoise kBegin{Vector3d::Constant(0.1), Vector3d::Constant(0.02)};
const OdometryNoise kTrue{Vector3d(0.02, 0.05, 0.1), Vector3d(0.001, 0.002, 0.004)};

/// Sample n of a car that drives in a sinuous line and speeds up and slows down, at 10 Hz.
OdometrySample sample(int n, const OdometryNoise& noise = kTrue) {
  const double t = 0.1 * n;
  static const RandomStream stream(7, 0, "odometry");
  const auto k = static_cast<std::uint64_t>(n);
  return {
      static_cast<std::int64_t>(n) * 100'000'000,
      Vector3d(8.0 + 2.0 * std::sin(0.5 * t), 0.0, 0.0) + noise.sigma_v.cwiseProduct(stream.normal3(k, 0)),
      Vector3d(0.0, 0.0, 0.2 * std::sin(0.4 * t)) + noise.sigma_omega.cwiseProduct(stream.normal3(k, 1))};
}

void expect_within(double share, const OdometryNoise& actual, const OdometryNoise& expected) {
  EXPECT_LT((actual.sigma_v.cwiseQuotient(expected.sigma_v).array() - 1.0).abs().maxCoeff(), share)
      << actual.sigma_v.transpose();
  EXPECT_LT((actual.sigma_omega.cwiseQuotient(expected.sigma_omega).array() - 1.0).abs().maxCoeff(), share)
      << actual.sigma_omega.transpose();
}

TEST(LearnedOdometryNoise, BeginsWithWhatItIsTold) {
  LearnedOdometryNoise noise(kBegin);
  for (int n = 0; n < 10; ++n) {
    noise.add(sample(n));
  }
  EXPECT_FALSE(noise.knows());
  EXPECT_EQ(noise.assumed().sigma_v, kBegin.sigma_v);
  EXPECT_EQ(noise.assumed().sigma_omega, kBegin.sigma_omega);
}

TEST(LearnedOdometryNoise, FindsWhiteNoiseOfEachAxisAmongMotion) {
  LearnedOdometryNoise noise(kBegin);
  for (int n = 0; n < 600; ++n) {
    noise.add(sample(n));
  }
  expect_within(0.1, noise.white(), kTrue);
}

TEST(LearnedOdometryNoise, FollowsNoiseThatGrows) {
  LearnedOdometryNoise noise(kBegin);
  OdometryNoise more = kTrue;
  more.sigma_v *= 3.0;
  more.sigma_omega *= 3.0;
  for (int n = 0; n < 6000; ++n) {
    noise.add(sample(n, n < 2000 ? kTrue : more));
  }
  expect_within(0.15, noise.white(), more);
}

TEST(LearnedOdometryNoise, TakesSmoothMotionForNone) {
  LearnedOdometryNoise noise(kBegin);
  for (int n = 0; n < 600; ++n) {
    noise.add(sample(n, {Vector3d::Zero(), Vector3d::Zero()}));
  }
  EXPECT_LT(noise.white().sigma_v.x(), 1e-3);  // the others are never but zero
  EXPECT_LT(noise.white().sigma_omega.z(), 1e-4);
}

TEST(LearnedOdometryNoise, AssumesAShareOfTheSpeedBeside) {
  LearnedOdometryNoise noise(kBegin);
  for (int n = 0; n < 200; ++n) {
    noise.add(sample(n));
  }
  EXPECT_NEAR(noise.assumed(10.0).sigma_v.x(), std::hypot(noise.white().sigma_v.x(), 0.3), 1e-12);
  EXPECT_EQ(noise.assumed(0.0).sigma_v, noise.white().sigma_v);
  EXPECT_EQ(noise.assumed(10.0).sigma_omega, noise.white().sigma_omega);
}

TEST(LearnedOdometryNoise, IsNotMisledByAGapAndASlip) {
  LearnedOdometryNoise noise(kBegin);
  for (int n = 0; n < 600; ++n) {
    OdometrySample s = sample(n);
    s.t_ns += n < 300 ? 0 : 5'000'000'000;                              // five seconds are missing,
    s.v_body += n < 300 ? Vector3d::Zero() : Vector3d(-5.0, 0.0, 0.0);  // in which it braked
    s.v_body.x() += n == 450 ? 3.0 : 0.0;                               // a wheel slips once
    noise.add(s);
    noise.add(s);  // twice the same
  }
  expect_within(0.3, noise.white(), kTrue);
}

/// Encoders count nothing while wheels stand still.
TEST(LearnedOdometryNoise, LearnsNothingAtRest) {
  LearnedOdometryNoise noise(kBegin);
  const auto stand = [&](int from, int to) {
    for (int n = from; n < to; ++n) {
      noise.add({static_cast<std::int64_t>(n) * 100'000'000, Vector3d::Zero(), Vector3d::Zero()});
    }
  };
  stand(0, 100);
  EXPECT_FALSE(noise.knows());
  for (int n = 100; n < 700; ++n) noise.add(sample(n));
  stand(700, 1300);
  expect_within(0.12, noise.white(), kTrue);
}

TEST(LearnedOdometryNoise, KeepsWhatItWasToldOfWhatWheelsDoNotMeasure) {
  LearnedOdometryNoise noise(kBegin);
  for (int n = 0; n < 600; ++n) {
    OdometrySample wheels = sample(n);
    wheels.v_body.tail<2>().setZero();
    wheels.omega_body.head<2>().setZero();
    noise.add(wheels);
  }
  const OdometryNoise expected{{kTrue.sigma_v.x(), 0.1, 0.1}, {0.02, 0.02, kTrue.sigma_omega.z()}};
  expect_within(0.1, noise.white(), expected);
}

}  // namespace
}  // namespace limber
