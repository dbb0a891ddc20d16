// SPDX-License-Identifier: MIT
// A handful of tracks whose depth is known judges no vergence, neither as an axis nor by the epipolar lines.
#include <gtest/gtest.h>

#include "limber/health/calibration_watch.hpp"

namespace limber {
namespace {

using enum HealthVerdict;

constexpr Eigen::Index kNod = 0, kVergence = 1;

RigParameters theta_of_12_cm() {
  RigParameters theta = RigParameters::Zero();
  theta(3) = -0.12;
  return theta;
}

/// Known to a twentieth of a plausible error (0.005 deg); on the lines a nod of 0.1 deg is 0.8 px, a vergence
/// 0.1 px.
BetaEstimate estimate_of(double nod, double vergence) {
  BetaEstimate out;
  out.beta(kNod) = nod;
  out.beta(kVergence) = vergence;
  out.covariance.setIdentity();
  out.covariance *= 0.05 * 0.05;
  out.epipolar(kNod, kNod) = 0.8 * 0.8;
  out.epipolar(kVergence, kVergence) = 0.1 * 0.1;
  return out;
}

CalibrationState judged(const BetaEstimate& estimate, std::size_t deep_tracks) {
  CalibrationState out;
  out.tracks = 100;
  out.deep_tracks = deep_tracks;
  judge_estimate(estimate, theta_of_12_cm(), true, {}, out);
  return out;
}

/// Ten seconds of 31 tracks, 13 of them with a depth, had said -2.9 +- 0.35 deg, and 2.2 px by that.
TEST(FewDepths, JudgeNoVergence) {
  const BetaEstimate off = estimate_of(0.0, 29.0);
  const CalibrationState known = judged(off, kFewestTracks), few = judged(off, kFewestTracks - 1);
  EXPECT_EQ(known.by_epipolar, kDecalibrated);
  EXPECT_EQ(known.axes[kVergence], kDecalibrated);
  EXPECT_EQ(few.by_epipolar, kOk);
  EXPECT_EQ(few.axes[kVergence], kCannotTell);
  EXPECT_EQ(few.verdict, kCannotTell);
  EXPECT_EQ(few.estimate.delta, known.estimate.delta);  // is still said
}

TEST(FewDepths, JudgeWhatTheLinesTell) {
  const CalibrationState few = judged(estimate_of(5.0, 0.0), kFewestTracks - 1);
  EXPECT_EQ(few.by_epipolar, kDecalibrated);
  EXPECT_EQ(few.axes[kNod], kDecalibrated);
  EXPECT_EQ(few.verdict, kDecalibrated);
}

/// As Kalman has it where a vergence is seen to be the assumed one.
TEST(FewDepths, AVergenceThatIsAssumedTakesAlongWhatGoesWithIt) {
  BetaEstimate estimate = estimate_of(1.0, 2.0);
  estimate.covariance(kNod, kVergence) = estimate.covariance(kVergence, kNod) = 0.5 * 0.05 * 0.05;
  const BetaEstimate assumed = with_assumed_vergence(estimate, theta_of_12_cm());
  EXPECT_NEAR(assumed.beta(kVergence), 0.0, 1e-12);
  EXPECT_NEAR(assumed.beta(kNod), 0.0, 1e-12);  // 1 - 0.5 * 2
  EXPECT_NEAR(assumed.covariance(kVergence, kVergence), 0.0, 1e-15);
  EXPECT_NEAR(assumed.covariance(kNod, kNod), 0.75 * 0.05 * 0.05, 1e-12);
}

}  // namespace
}  // namespace limber
