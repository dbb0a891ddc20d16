// SPDX-License-Identifier: MIT
#include "limber/health/health_monitor.hpp"
#include "limber/core/factors.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <functional>
#include <limits>
#include <stdexcept>

#include "check_covariance.hpp"
#include "limber/navigate/method.hpp"
#include "random_geometry.hpp"

namespace limber {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::Generator;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kBaseline = 0.5;
constexpr std::int64_t kFrameNs = 50'000'000;

/// White evidence of a rig whose error is `beta` [plausible errors], with correlated axes.
class Frames {
 public:
  explicit Frames(std::uint64_t seed, double information = 20.0) : generator_(seed) {
    const MatrixXd W = testing::random_normal(generator_, 36).reshaped(6, 6);
    information_ = information * (W * W.transpose() / 6.0 + 0.5 * MatrixXd::Identity(6, 6));
  }

  HealthInput next(const Vector6& beta, double noise = 1.0) {
    HealthInput out;
    out.t_ns = t_ns_ += kFrameNs;
    out.directions = plausible_error(kBaseline).asDiagonal();
    const SymmetricEigen eigen = symmetric_eigen(information_);
    const VectorXd e = eigen.vectors * eigen.values.cwiseMax(0.0).cwiseSqrt().cwiseProduct(
                                           testing::random_normal(generator_, 6));
    out.frame = {information_, information_ * beta + noise * e};
    out.nis = noise * noise * 100.0;
    out.dof = 100.0;
    return out;
  }

  void hide(int axis) {
    information_.row(axis).setZero();
    information_.col(axis).setZero();
  }

  [[nodiscard]] Vector6 sigma() const { return information_.inverse().diagonal().cwiseSqrt(); }

 private:
  Generator generator_;
  MatrixXd information_;
  std::int64_t t_ns_ = 0;
};

int alarms(double noise, double per_hour, double hours) {
  Frames frames(5);
  HealthMonitor monitor({.false_alarms_per_hour = per_hour}, kBaseline);
  int count = 0;
  for (int k = 0; k < static_cast<int>(hours * 72000.0); ++k) {
    count += monitor.judge(frames.next(Vector6::Zero(), noise)).alarm ? 1 : 0;
  }
  return count;
}

TEST(HealthMonitor, ASoundRigRaisesAsManyAlarmsAsAskedFor) {
  // 200 expected; the looks at a growing window overlap, so that there are somewhat fewer.
  const int count = alarms(1.0, 100.0, 2.0);
  EXPECT_GE(count, 120);
  EXPECT_LE(count, 240);
}

TEST(HealthMonitor, NoiseThatIsLargerThanStatedRaisesNone) { EXPECT_LE(alarms(2.0, 100.0, 1.0), 125); }

TEST(HealthMonitor, AStepIsFoundAtOnceAndItsAxisNamed) {
  for (int axis = 0; axis < 6; ++axis) {
    Frames frames(static_cast<std::uint64_t>(10 + axis));
    HealthMonitor monitor({}, kBaseline);
    const Vector6 step = 12.0 * frames.sigma()(axis) * Vector6::Unit(axis);
    std::int64_t since = 0;
    for (int k = 0; k < 300; ++k) {
      const HealthReport report = monitor.judge(frames.next(k < 200 ? Vector6::Zero() : step));
      if (k < 200) {
        EXPECT_FALSE(report.alarm);
      } else {
        EXPECT_EQ(report.verdict, HealthVerdict::kDecalibrated) << "frame " << k << ", axis " << axis;
        since = report.changed_ns.value_or(0);
        for (std::size_t other = 0; other < 6; ++other) {
          EXPECT_EQ(report.axes[other] == HealthVerdict::kDecalibrated, other == std::size_t(axis))
              << "frame " << k << ", axis " << axis << ", named " << other;
        }
      }
    }
    EXPECT_EQ(since, 201 * kFrameNs);
  }
}

TEST(HealthMonitor, ALargeErrorIsFoundInTheFirstFrame) {
  HealthMonitor monitor({}, kBaseline);
  EXPECT_TRUE(monitor.judge(Frames(5).next(Vector6::Constant(20.0))).alarm);
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    HealthMonitor sound({}, kBaseline);
    EXPECT_FALSE(sound.judge(Frames(seed).next(Vector6::Zero())).alarm) << seed;
  }
}

/// A match that is wrong is another one in the next frame.
TEST(HealthMonitor, AFrameThatTheNextOneDoesNotConfirmRaisesNoAlarm) {
  Frames frames(7);
  HealthMonitor monitor({.confirm_frames = true}, kBaseline);
  const Vector6 far = 20.0 * frames.sigma();
  for (int k = 0; k < 400; ++k) {
    const bool wrong = k % 20 == 10;  // five a window
    const HealthReport report = monitor.judge(frames.next(wrong ? far : Vector6::Zero()));
    EXPECT_FALSE(report.alarm) << k;
    EXPECT_EQ(monitor.restarts(), k % 20 == 11) << k << ": what was gathered with it is forgotten";
  }
  HealthReport report = monitor.judge(frames.next(far));
  EXPECT_FALSE(report.alarm);
  report = monitor.judge(frames.next(far));
  EXPECT_TRUE(report.alarm);
  EXPECT_EQ(report.changed_ns, report.t_ns - kFrameNs);
}

/// One that sees nothing neither confirms nor denies.
TEST(HealthMonitor, AFrameIsConfirmedByTheNextOneThatSeesTheRig) {
  Frames frames(8);
  HealthMonitor monitor({.confirm_frames = true}, kBaseline);
  const Vector6 far = 20.0 * frames.sigma();
  EXPECT_FALSE(monitor.judge(frames.next(far)).alarm);
  HealthInput blind = frames.next(far);
  blind.frame = {};
  EXPECT_FALSE(monitor.judge(blind).alarm);
  EXPECT_TRUE(monitor.judge(frames.next(far)).alarm);
}

TEST(HealthMonitor, WhatOneFrameCannotShowAWindowDoes) {
  Frames frames(3);
  HealthMonitor monitor({.false_alarms_per_hour = 6.0}, kBaseline);
  const Vector6 step = 2.0 * frames.sigma()(3) * Vector6::Unit(3);
  int first = -1;
  for (int k = 0; k < 200 && first < 0; ++k) {
    if (monitor.judge(frames.next(step)).alarm) {
      first = k;
    }
  }
  EXPECT_GE(first, 1);
  EXPECT_LE(first, 100) << "two windows";
}

TEST(HealthMonitor, ARigThatComesBackIsOkAgain) {
  Frames frames(4);
  HealthMonitor monitor({}, kBaseline);
  HealthReport report;
  for (int k = 0; k < 400; ++k) {
    report =
        monitor.judge(frames.next(k >= 100 && k < 200 ? Vector6(Vector6::Constant(3.0)) : Vector6::Zero()));
    if (k == 199) {
      EXPECT_EQ(report.verdict, HealthVerdict::kDecalibrated);
    }
  }
  EXPECT_EQ(report.verdict, HealthVerdict::kOk);
  EXPECT_FALSE(report.changed_ns.has_value());
}

TEST(HealthMonitor, TellsOffsetsInRadiansAndMetres) {
  Frames frames(6, 2000.0);
  HealthMonitor monitor({}, kBaseline);
  Vector6 beta;
  beta << 1.0, -2.0, 0.5, 3.0, -1.0, 0.25;
  const RigParameters delta = beta.cwiseProduct(plausible_error(kBaseline));
  HealthReport report;
  for (int k = 0; k < 40; ++k) {
    report = monitor.judge(frames.next(beta));
  }
  for (int k = 0; k < 6; ++k) {
    EXPECT_NEAR(report.delta(k), delta(k), 4.0 * report.sigma(k));
    EXPECT_NEAR(report.gathered_delta(k), delta(k), 4.0 * report.gathered_sigma(k));
    EXPECT_LT(report.gathered_sigma(k), report.sigma(k));
  }
}

TEST(HealthMonitor, SaysWhatItCannotSee) {
  Frames frames(7);
  frames.hide(3);
  HealthMonitor monitor({}, kBaseline);
  HealthReport report;
  for (int k = 0; k < 100; ++k) {
    report = monitor.judge(frames.next(Vector6::Zero()));
    EXPECT_FALSE(report.alarm);
  }
  EXPECT_EQ(report.axes[3], HealthVerdict::kCannotTell);
  EXPECT_EQ(report.axes[0], HealthVerdict::kOk);
  EXPECT_EQ(report.verdict, HealthVerdict::kOk);
}

TEST(HealthMonitor, WithoutEvidenceItCannotTell) {
  HealthMonitor monitor({}, kBaseline);
  HealthInput nothing;
  nothing.directions = plausible_error(kBaseline).asDiagonal();
  for (int k = 0; k < 100; ++k) {
    nothing.t_ns += kFrameNs;
    EXPECT_EQ(monitor.judge(nothing).verdict, HealthVerdict::kCannotTell);
  }
}

TEST(HealthMonitor, ConstrainedDirectionsThatLeaveTheLengthAloneLeaveItUnknown) {
  Frames frames(8);
  HealthMonitor monitor({}, kBaseline);
  RigParameters theta = RigParameters::Zero();
  theta(3) = -kBaseline;
  HealthReport report;
  for (int k = 0; k < 100; ++k) {
    HealthInput input = frames.next(Vector6::Zero());
    input.directions = constraint_directions({ConstraintSet::Kind::kRotationDirection, {}}, theta);
    input.frame.information = input.frame.information.topLeftCorner(5, 5).eval();
    input.frame.vector = input.frame.vector.head(5).eval();
    report = monitor.judge(input);
  }
  EXPECT_EQ(report.axes[3], HealthVerdict::kCannotTell);
  EXPECT_EQ(report.axes[4], HealthVerdict::kOk);
}

TEST(HealthMonitor, RefusesNumbersThatMakeNoSense) {
  EXPECT_THROW(HealthMonitor({.false_alarms_per_hour = 0.0}, 1.0), std::invalid_argument);
  EXPECT_THROW(HealthMonitor({.window_s = -1.0}, 1.0), std::invalid_argument);
  EXPECT_THROW(HealthMonitor({.resolution = std::numeric_limits<double>::quiet_NaN()}, 1.0),
               std::invalid_argument);
}

}  // namespace
}  // namespace limber
