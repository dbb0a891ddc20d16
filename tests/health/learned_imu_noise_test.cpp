// SPDX-License-Identifier: MIT
#include "limber/health/learned_imu_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "check_covariance.hpp"

namespace limber {
namespace {

using Vector6 = PoseCorrection::Vector6;
using Matrix6 = PoseCorrection::Matrix6;
using testing::Generator;

/// A pose that walks by `true_noise` from frame to frame, followed by a filter that takes what was learned,
/// in units of the stated noise, for that.
class Followed {
 public:
  explicit Followed(unsigned seed) : generator_(seed) {}

  /// @return geometric means of what was learned over the last half
  ImuNoiseFactors go(int frames, const ImuNoiseFactors& true_noise, LearnedImuNoise& learned,
                     bool trusts_length = false) {
    double gyro = 0.0, accel = 0.0;
    const Matrix6 R = kPixels * kPixels * Matrix6::Identity();
    for (int k = 0; k < frames; ++k) {
      error_ += deviations(true_noise).cwiseProduct(noise());
      P_.diagonal() += deviations(learned.factors()).cwiseAbs2();
      const Vector6 innovation = error_ + kPixels * noise();
      const Matrix6 S = P_ + R, before = P_;
      const Vector6 dx = P_ * S.inverse() * innovation;
      P_ -= P_ * S.inverse() * P_;
      error_ -= dx;
      const double others = 100.0;  // rows of points: the pose's are among them
      learned.learn(
          {0, 0.05, dx, before - P_, innovation.dot(S.inverse() * innovation) + others, 6.0 + others},
          trusts_length);
      gyro += 2 * k >= frames ? 2.0 / frames * std::log(learned.factors().gyro) : 0.0;
      accel += 2 * k >= frames ? 2.0 / frames * std::log(learned.factors().accel) : 0.0;
    }
    return {std::exp(gyro), std::exp(accel)};
  }

 private:
  static constexpr double kStated = 1e-4, kPixels = 1e-3;

  static Vector6 deviations(const ImuNoiseFactors& factors) {
    Vector6 out;
    out << Eigen::Vector3d::Constant(factors.accel), Eigen::Vector3d::Constant(factors.gyro);
    return kStated * out;
  }
  Vector6 noise() { return testing::random_normal(generator_, 6); }

  Generator generator_;
  Vector6 error_ = Vector6::Zero();
  Matrix6 P_ = Matrix6::Identity() * kPixels * kPixels;
};

TEST(LearnedImuNoise, StaysWhatWasStatedWhereThatIsTrue) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    LearnedImuNoise learned;
    const ImuNoiseFactors usual = Followed(seed).go(2000, {}, learned);
    EXPECT_LT(usual.gyro, 1.3);
    EXPECT_LT(usual.accel, 1.3);
  }
}

/// Somewhat less: corrections that are often larger than usual are allowed.
TEST(LearnedImuNoise, FindsEachOfBothWithinAFactor) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    LearnedImuNoise learned;
    const ImuNoiseFactors usual = Followed(seed).go(2000, {10.0, 3.0}, learned);
    EXPECT_GT(usual.gyro, 5.0);
    EXPECT_LT(usual.gyro, 15.0);
    EXPECT_GT(usual.accel, 1.5);
    EXPECT_LT(usual.accel, 5.0);
  }
}

TEST(LearnedImuNoise, IsForgottenWhenItIsOver) {
  LearnedImuNoise learned({20.0, 1.0});
  EXPECT_EQ(learned.factors().gyro, 20.0);
  EXPECT_LT(Followed(4).go(1000, {}, learned).gyro, 1.5);
}

/// Positions that are corrected too much may be a wrong baseline, and attitudes with them. A start has found
/// the noise where the rig was free.
TEST(LearnedImuNoise, OfAnAccelerometerIsNoMoreThanAStartFoundOfEitherSensorWhereALengthIsTrusted) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    LearnedImuNoise sound;
    EXPECT_EQ(Followed(seed).go(2000, {10.0, 10.0}, sound, true).accel, 1.0);
    LearnedImuNoise noisy_gyro({10.0, 1.0});
    EXPECT_GT(Followed(seed).go(2000, {10.0, 10.0}, noisy_gyro, true).accel, 4.0);
    LearnedImuNoise noisy_accelerometer({1.0, 10.0});
    EXPECT_GT(Followed(seed).go(2000, {1.0, 10.0}, noisy_accelerometer, true).accel, 4.0);
  }
}

/// The size of corrections is measured in the noise that the other rows show.
TEST(LearnedImuNoise, IsNotThatOfPixels) {
  LearnedImuNoise learned;
  Generator generator(5);
  for (int k = 0; k < 500; ++k) {
    const Vector6 dx = 3.0 * testing::random_normal(generator, 6);
    learned.learn({0, 0.05, dx, Matrix6::Identity(), dx.squaredNorm() + 9.0 * 100.0, 106.0});
  }
  EXPECT_LT(learned.factors().gyro, 1.5);
}

TEST(LearnedImuNoise, HasBounds) {
  LearnedImuNoise learned({0.1, 1e9});
  EXPECT_EQ(learned.factors().gyro, 1.0);
  EXPECT_EQ(learned.factors().accel, 100.0);
  const Vector6 nothing = Vector6::Constant(std::numeric_limits<double>::quiet_NaN());
  learned.learn({0, 0.05, nothing, Matrix6::Identity(), 1.0, 1.0});
  EXPECT_EQ(learned.factors().gyro, 1.0);
}

}  // namespace
}  // namespace limber
