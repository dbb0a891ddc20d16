// SPDX-License-Identifier: MIT
#include "limber/diagnose/trusted_rig.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "limber/core/angle.hpp"
#include "limber/run/trusted_axes.hpp"
#include "limber/simulate/simulator.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr std::int64_t kSecond = 1'000'000'000;  // [ns]

RigParameters trusted_theta() { return -0.12 * RigParameters::Unit(3); }

std::vector<std::string> trusted(Method method, const char* constraints = "",
                                 MotionModel motion = MotionModel::kImu) {
  RunOptions options;
  options.method = method;
  if (*constraints != '\0') {
    options.constraints = constraint_set_from_string(constraints);
  }
  std::vector<std::string> out;
  for (const TrustedPart& part : trusted_parts(options, motion, trusted_theta())) {
    out.push_back(part.name);
  }
  return out;
}

TEST(TrustedParts, AreThoseThatAMethodNeitherConstrainsNorCarriesNorEstimates) {
  EXPECT_THAT(trusted(Method::kEkf), ElementsAre("ax", "ay", "az", "tx", "ty", "tz"));
  for (const Method method : {Method::kLcekf, Method::kEkfFull, Method::kSoft, Method::kConsider,
                              Method::kAdaptive, Method::kMonoLeft, Method::kOracle}) {
    EXPECT_THAT(trusted(method), IsEmpty()) << to_string(method);
  }
  EXPECT_THAT(trusted(Method::kLcekf, "rotation"), ElementsAre("tx", "ty", "tz"));
  EXPECT_THAT(trusted(Method::kLcekf, "ax,ay,tx"), ElementsAre("az", "ty", "tz"));
  EXPECT_THAT(trusted(Method::kLcekf, "none"), ElementsAre("ax", "ay", "az", "tx", "ty", "tz"));
  EXPECT_THAT(trusted(Method::kLcekf, "rotation+direction"), ElementsAre("baseline"));
  EXPECT_THAT(trusted(Method::kLcekf, "", MotionModel::kConstantVelocity), IsEmpty());
  EXPECT_THAT(trusted(Method::kLcekf, "rotation+direction", MotionModel::kConstantVelocity), IsEmpty());
  RunOptions options;
  options.method = Method::kEkf;
  options.softened(4) = 0.001;
  options.estimated(0) = 0.001;
  EXPECT_EQ(trusted_parts(options, MotionModel::kImu, trusted_theta()).size(), 4u);
}

TEST(TrustsLength, IsOfTheAxisAlongTheBaseline) {
  RunOptions options;
  const auto trusts = [&options] { return trusts_length(options, MotionModel::kImu, trusted_theta()); };
  EXPECT_FALSE(trusts());
  options.constraints = constraint_set_from_string("rotation+direction");
  EXPECT_TRUE(trusts());
  options.constraints = constraint_set_from_string("ax,ay,az,tx");
  EXPECT_FALSE(trusts());
  options.constraints = constraint_set_from_string("ax,ay,az,ty,tz");
  EXPECT_TRUE(trusts());
  options.constraints.reset();
  options.method = Method::kEkf;
  EXPECT_TRUE(trusts());
  options.estimated(3) = 0.001;
  EXPECT_FALSE(trusts());
}

TEST(TrustsLength, OfVisionAloneAreThoseWhoseDefaultKeepsIt) {
  RunOptions options;
  const auto trusts = [&options](MotionModel motion) {
    return trusts_length(options, motion, trusted_theta());
  };
  for (const Method method : {Method::kLcekf, Method::kAdaptive}) {
    options.method = method;
    EXPECT_TRUE(trusts(MotionModel::kConstantVelocity)) << to_string(method);
    EXPECT_FALSE(trusts(MotionModel::kImu)) << to_string(method);
    EXPECT_FALSE(trusts(MotionModel::kOdometry)) << to_string(method);
  }
  options.method = Method::kLcekf;
  options.constraints = constraint_set_from_string("full");
  EXPECT_FALSE(trusts(MotionModel::kConstantVelocity));
}

/// A stretch whose ty is off by so many sigmas of 0.4 mm.
CalibrationState stretch(double sigmas, std::int64_t from_s = 0) {
  CalibrationState out;
  out.from_ns = from_s * kSecond;
  out.to_ns = (from_s + 10) * kSecond;
  out.tracks = out.deep_tracks = 100;
  out.estimate.covariance = 1e-8 * Eigen::Matrix<double, 6, 6>::Identity();
  out.estimate.covariance(4, 4) = 0.0004 * 0.0004;
  out.estimate.delta(4) = sigmas * 0.0004;
  return out;
}

std::vector<TrustedPart> of_ekf() {
  RunOptions options;
  options.method = Method::kEkf;
  return trusted_parts(options, MotionModel::kImu, trusted_theta());
}

HealthSummary rig_of(const CalibrationState& present) {
  HealthSummary out;
  out.verdict = HealthVerdict::kOk;
  out.present = present;
  return out;
}

/// Student's t with 24 degrees exceeds 4.46 with 0.001 / 6.
TEST(TrustedRigOff, IsBeyondWhatOneInAThousandExactRigsShows) {
  EXPECT_FALSE(trusted_rig_off(rig_of(stretch(4.4)), of_ekf()));
  const auto off = trusted_rig_off(rig_of(stretch(4.55)), of_ekf());
  ASSERT_TRUE(off);
  EXPECT_EQ(off->in_words, "ty +1.8 ± 0.4 mm");
  EXPECT_FALSE(trusted_rig_off(rig_of(stretch(8.0)), {}));
}

TEST(TrustedRigOff, IsLookedForInWhatWasBeforeToo) {
  HealthSummary rig = rig_of(stretch(1.0, 10));
  rig.past = {stretch(-8.0)};
  const auto off = trusted_rig_off(rig, of_ekf());
  ASSERT_TRUE(off);
  EXPECT_EQ(off->from_ns, 0);
  EXPECT_EQ(off->to_ns, 10 * kSecond);
  // Two stretches are two chances.
  rig.past = {stretch(4.55)};
  EXPECT_FALSE(trusted_rig_off(rig, of_ekf()));
}

TEST(TrustedRigOff, IsNeverByFewTracks) {
  CalibrationState few = stretch(20.0);
  few.tracks = 29;
  EXPECT_FALSE(trusted_rig_off(rig_of(few), of_ekf()));
  few = stretch(20.0);
  few.deep_tracks = 29;
  EXPECT_FALSE(trusted_rig_off(rig_of(few), of_ekf()));
}

struct TrustingRun {
  std::vector<std::string> notes;
  std::vector<RunEvent> events;
};

TrustingRun run_trusting(const Recording& recording, Method method, bool lost = false) {
  RunOptions options;
  options.method = method;
  RunRecord record = run_recording(recording, options, matched_frames(recording));
  RunSummary summary = summarize(recording, options, record);
  if (lost) {
    summary.inputs.lost_since_ns = recording.frames.front().t_ns;
  }
  add_trusted_rig(options, record, summary);
  return {record.notes, summary.inputs.events};
}

const auto kSaysSo = HasSubstr("sigmas of ekf take the rig for exact");

/// 0.04 deg of roll: the verdict is ok, and ekf is too sure.
TEST(TrustedRig, IsSaidOfEkfWhereTheRigIsGoodEnoughAndNotExact) {
  Scenario scenario = testing::shipped("drone_none", 15.0);
  const Recording exact = simulate(scenario, 2);
  Recording off = exact;
  off.calibration.theta(2) += 0.04 / kToDegrees;
  const TrustingRun of_ekf = run_trusting(off, Method::kEkf);
  EXPECT_THAT(of_ekf.notes,
              Contains(::testing::AllOf(kSaysSo, HasSubstr("at the end by az -0.0"), HasSubstr(" deg"),
                                        HasSubstr(", within the tolerance: they are"))));
  EXPECT_THAT(of_ekf.events, Contains(Field(&RunEvent::kind, RunEventKind::kTrustedRigOff)));
  EXPECT_THAT(run_trusting(off, Method::kEkf, true).notes, Not(Contains(kSaysSo)));
  EXPECT_THAT(run_trusting(off, Method::kLcekf).events, IsEmpty());
  EXPECT_THAT(run_trusting(exact, Method::kEkf).notes, Not(Contains(kSaysSo)));
}

}  // namespace
}  // namespace limber
