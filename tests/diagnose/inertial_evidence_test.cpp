// SPDX-License-Identifier: MIT
// What a stretch says of mount and IMU: the offset that was put in comes out, and without one chance rules.
#include "limber/initialize/inertial_evidence.hpp"

#include <gtest/gtest.h>

#include <array>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "limber/core/so3.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/run/run_options.hpp"
#include "limber/sensors/parameters.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using enum InertialFactor;

constexpr std::array kAllFactors = {kMountTurn, kLeverArm, kAccelScale, kAccelTurn,
                                    kGyroScale, kClock,    kAccelScales};

/// Every other frame of some seconds, with the true states.
struct Seen {
  std::vector<StereoFrame> frames;
  std::vector<NavigationState> states;
};

Seen seen_in(const Recording& recording, double from_s, double to_s) {
  Seen out;
  const std::int64_t begin_ns = recording.frames.front().t_ns;
  for (std::size_t k = 0; k < recording.frames.size(); k += 3) {
    const StereoFrame& frame = recording.frames[k];
    const double at = 1e-9 * static_cast<double>(frame.t_ns - begin_ns);
    const auto truth = groundtruth_at(recording.truth.motion.states, frame.t_ns);
    if (at < from_s || at > to_s || !truth) {
      continue;
    }
    out.frames.push_back(frame);
    out.states.push_back({});
    out.states.back().t_ns = frame.t_ns;
    out.states.back().T_world_body = {truth->R_world_body, truth->p_world_body};
    out.states.back().v_world_body = truth->v_world_body;
    out.states.back().bias_gyro = truth->bias_gyro;
    out.states.back().bias_accel = truth->bias_accel;
  }
  return out;
}

std::optional<InertialEvidence> evidence_in(const Recording& recording, double from_s, double to_s) {
  const Seen seen = seen_in(recording, from_s, to_s);
  return inertial_evidence(set_up_run(recording, {}).navigator, recording.calibration, seen.frames,
                           recording.imu, seen.states);
}

/// Offsets of one factor, if it is that factor alone.
VectorXd offsets_of(const InertialEvidence& evidence, InertialFactor factor) {
  const MatrixXd of = directions_of(factor);
  const MatrixXd information = of.transpose() * evidence.information * of;
  return information.ldlt().solve(VectorXd(of.transpose() * evidence.score));
}

/// The recording, had that been taken for exact wrongly: true minus assumed is the offset.
Recording wrong_by(Recording recording, InertialFactor factor, const Vector3d& offset) {
  ParameterVector mount = ParameterVector::Zero();
  const Index first = first_of(ParameterBlock::kMount) + (factor == kLeverArm ? 3 : 0);
  mount.segment<3>(first) = -offset;
  if (factor == kMountTurn || factor == kLeverArm) {
    recording.calibration = corrected(recording.calibration, mount);
  }
  for (ImuSample& sample : recording.imu) {
    if (factor == kAccelScale) {
      sample.accel_imu /= 1.0 + offset.x();
    } else if (factor == kAccelScales) {
      sample.accel_imu.array() /= 1.0 + offset.array();
    } else if (factor == kGyroScale) {
      sample.omega_imu /= 1.0 + offset.x();
    } else if (factor == kAccelTurn) {
      sample.accel_imu = so3_exp(Vector3d(-offset)) * sample.accel_imu;
    } else if (factor == kClock) {  // what the IMU saw when a camera did is stamped later
      sample.t_ns += static_cast<std::int64_t>(1e9 * offset.x());
    }
  }
  return recording;
}

/// One linearisation finds what was put in, whatever noise there is: the same noise with and without it.
TEST(InertialEvidence, FindsTheOffsetThatWasPutIn) {
  const Recording sound = simulate(testing::shipped("drone_none", 10.0), 31);
  const auto without = evidence_in(sound, 3.0, 8.0);
  ASSERT_TRUE(without);
  struct Case {
    InertialFactor factor;
    Vector3d offset;
  };
  for (const Case& one : {Case{kMountTurn, {0.004, 0.0, 0.0}}, Case{kMountTurn, {0.0, -0.004, 0.006}},
                          Case{kLeverArm, {0.1, 0.0, 0.0}}, Case{kLeverArm, {0.0, -0.1, 0.15}},
                          Case{kAccelScale, {0.02, 0.0, 0.0}}, Case{kAccelTurn, {0.01, -0.01, 0.02}},
                          Case{kGyroScale, {-0.005, 0.0, 0.0}}, Case{kAccelScales, {0.01, -0.01, 0.02}}}) {
    const auto with = evidence_in(wrong_by(sound, one.factor, one.offset), 3.0, 8.0);
    ASSERT_TRUE(with) << to_string(one.factor);
    const VectorXd found = offsets_of(*with, one.factor) - offsets_of(*without, one.factor);
    EXPECT_LT((found - one.offset.head(found.size())).norm(), 0.1 * one.offset.norm())
        << to_string(one.factor) << ": " << found.transpose();
  }
}

/// A clock is a rival alone, and found roughly: its derivatives are means about a frame.
TEST(InertialEvidence, SeesAClock) {
  const Recording sound = simulate(testing::shipped("drone_none", 10.0), 31);
  for (const double late : {0.003, -0.003}) {
    const auto with = evidence_in(wrong_by(sound, kClock, {late, 0.0, 0.0}), 3.0, 8.0);
    ASSERT_TRUE(with);
    const double found = offsets_of(*with, kClock)(0) / late;
    EXPECT_GT(found, 0.7);
    EXPECT_LT(found, 1.3);
  }
}

/// chi-square per degree of freedom, mean over stretches: 1, where noise is white and as stated; less of what
/// biases could explain, since they are smaller here than a start has to expect.
TEST(InertialEvidence, IsChanceWithoutAnOffset) {
  std::array<double, kAllFactors.size()> sums{};
  double misfit = 0.0, dof = 0.0;
  int count = 0;
  for (std::uint64_t seed = 32; seed < 38; ++seed) {
    const Recording recording = simulate(testing::shipped("drone_none", 21.0), seed);
    for (const double from : {1.0, 6.0, 11.0, 16.0}) {
      const auto evidence = evidence_in(recording, from, from + 5.0);
      ASSERT_TRUE(evidence) << seed << ' ' << from;
      for (std::size_t k = 0; k < kAllFactors.size(); ++k) {
        const MatrixXd of = directions_of(kAllFactors[k]);
        sums[k] += (of.transpose() * evidence->score).dot(offsets_of(*evidence, kAllFactors[k])) /
                   static_cast<double>(of.cols());
      }
      misfit += evidence->misfit;
      dof += evidence->dof;
      ++count;
    }
  }
  for (std::size_t k = 0; k < kAllFactors.size(); ++k) {
    EXPECT_GT(sums[k] / count, 0.2) << to_string(kAllFactors[k]);
    EXPECT_LT(sums[k] / count, 1.8) << to_string(kAllFactors[k]);
  }
  EXPECT_NEAR(misfit / dof, 1.0, 0.25);
}

TEST(InertialEvidence, AddsUp) {
  InertialEvidence a, b;
  a.information.setIdentity();
  a.score.setOnes();
  a.misfit = 2.0;
  a.dof = 1.0;
  b = a;
  b += a;
  EXPECT_EQ(b.information, 2.0 * a.information);
  EXPECT_EQ(b.misfit, 4.0);
  b -= a;
  EXPECT_EQ(b.score, a.score);
  EXPECT_EQ(b.dof, 1.0);
}

TEST(InertialEvidence, IsNoneOfFewFramesOrWithoutAnImu) {
  const Recording recording = simulate(testing::shipped("drone_none", 4.0), 31);
  EXPECT_FALSE(evidence_in(recording, 1.0, 2.0));
  Recording blind = recording;
  blind.imu.clear();
  EXPECT_FALSE(evidence_in(blind, 1.0, 4.0));
  const Seen seen = seen_in(recording, 1.0, 4.0);
  EXPECT_THROW((void)inertial_evidence(set_up_run(recording, {}).navigator, recording.calibration,
                                       seen.frames, recording.imu, std::span(seen.states).first(3)),
               std::invalid_argument);
}

}  // namespace
}  // namespace limber
