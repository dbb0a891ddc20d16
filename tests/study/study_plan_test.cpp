// SPDX-License-Identifier: MIT
#include "limber/study/study_plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/files.hpp"
#include "limber/study/exact_sum.hpp"
#include "study/tiny_study.hpp"

namespace limber {
namespace {

using ::testing::HasSubstr;
using testing::tiny_plan;
using testing::tiny_scenario;

std::string refusal_of_plan(const StudyPlan& plan) {
  try {
    check_plan(plan);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(CheckPlan, AcceptsAPlanAndNamesWhatIsWrongWithOthers) {
  EXPECT_EQ(refusal_of_plan(tiny_plan(3)), "");
  EXPECT_THAT(refusal_of_plan({}), HasSubstr("no scenario"));
  EXPECT_THAT(refusal_of_plan(tiny_plan(0)), HasSubstr("case 'tiny' has 0 runs"));
  EXPECT_THAT(refusal_of_plan(tiny_plan(kMaxTerms + 1)), HasSubstr("expected 1 to 16777216"));

  StudyPlan plan = tiny_plan(1);
  plan.cases.push_back(plan.cases.front());
  EXPECT_THAT(refusal_of_plan(plan), HasSubstr("two scenarios are called 'tiny'"));
  plan = tiny_plan(1);
  plan.cases[0].methods.push_back(plan.cases[0].methods[0]);
  EXPECT_THAT(refusal_of_plan(plan), HasSubstr("has the method ekf twice"));
  plan.cases[0].methods.clear();
  EXPECT_THAT(refusal_of_plan(plan), HasSubstr("has no method"));
  plan = tiny_plan(1);
  plan.cases[0].scenario.noise.pixel = -1.0;
  EXPECT_THAT(refusal_of_plan(plan), HasSubstr("pixel"));
}

TEST(DefinitionOf, ChangesWithEverythingThatResultsDependOn) {
  const StudyCase study_case = tiny_plan(1).cases[0];
  const std::string definition = definition_of(study_case);
  EXPECT_EQ(definition_of(tiny_plan(7).cases[0]), definition);  // more runs leave the others as they are
  StudyCase other = study_case;
  other.scenario.noise.pixel = 0.51;
  EXPECT_NE(definition_of(other), definition);
  other = study_case;
  other.scenario.filter.max_landmarks = 399;
  EXPECT_NE(definition_of(other), definition);
  other = study_case;
  other.start = StartMode::kAuto;
  EXPECT_NE(definition_of(other), definition);
  other = study_case;
  other.methods[2].constraints = ConstraintSet{ConstraintSet::Kind::kRotation, {}};
  EXPECT_NE(definition_of(other), definition);
}

TEST(DefinitionOf, KnowsATrajectoryByItsContentNotByItsPlace) {
  const testing::TemporaryFolder folder;
  const std::string text = "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n";
  const auto a = testing::write_text(folder.path() / "a.tum", text);
  const auto b = testing::write_text(folder.path() / "b.tum", text);
  const auto c = testing::write_text(folder.path() / "c.tum", text + "3 3 0 0 0 0 0 1\n");
  StudyCase study_case = tiny_plan(1).cases[0];
  const auto along = [&](const std::filesystem::path& path) {
    study_case.scenario.trajectory = FileTrajectory{path};
    return definition_of(study_case);
  };
  EXPECT_EQ(along(a), along(b));
  EXPECT_NE(along(a), along(c));
  EXPECT_THROW((void)along(folder.path() / "nowhere.tum"), DataError);
}

TEST(FrameTimes, RunFromZeroToTheEnd) {
  const std::vector<double> times = frame_times(tiny_scenario());
  ASSERT_EQ(times.size(), 21u);
  EXPECT_EQ(times.front(), 0.0);
  EXPECT_EQ(times[7], 0.35);
  EXPECT_EQ(times.back(), 1.0);
}

TEST(RunOptionsOfAStudy, FollowTheScenarioAndTheVariant) {
  Scenario scenario = tiny_scenario();
  scenario.initial.position = 0.5;
  scenario.filter.initial.position = 0.25;
  scenario.filter.gate = true;
  scenario.filter.max_landmarks = 77;
  scenario.filter.acceleration_noise = 0.125;
  scenario.filter.angular_noise = 0.0625;
  scenario.filter.theta_sigma.setConstant(0.75);
  scenario.gravity = 1.62;
  const RunOptions options = run_options(scenario, method_variant_from_string("lcekf:rotation:cartesian"),
                                         StartMode::kGroundTruth, 4, 9);
  EXPECT_EQ(options.method, Method::kLcekf);
  EXPECT_EQ(options.constraints->kind, ConstraintSet::Kind::kRotation);
  EXPECT_EQ(options.landmarks, LandmarkKind::kCartesian);
  EXPECT_EQ(options.start, StartMode::kGroundTruth);
  EXPECT_EQ(options.initial_error->position, 0.5);
  EXPECT_EQ(options.initial.position, 0.25);
  EXPECT_TRUE(options.gate);
  EXPECT_EQ(options.max_landmarks, 77u);
  EXPECT_EQ(options.constant_velocity_noise->acceleration_density, 0.125);
  EXPECT_EQ(options.constant_velocity_noise->angular_acceleration_density, 0.0625);
  EXPECT_EQ(*options.theta_sigma, RigParameters::Constant(0.75));
  EXPECT_EQ(options.gravity, 1.62);
  EXPECT_EQ(options.seed, 4u);
  EXPECT_EQ(options.run, 9u);
}

TEST(RunOptionsOfAStudy, StartFromTheSensorsUnlessTheCaseSaysOtherwise) {
  EXPECT_EQ(StudyCase{}.start, StartMode::kAuto);
  EXPECT_EQ(run_options(tiny_scenario(), {}, StartMode::kAuto, 1, 0).start, StartMode::kAuto);
}

TEST(RunOptionsOfAStudy, LetThetaWalkAsTheVariantSays) {
  const Scenario scenario = tiny_scenario();  // 1e-6 rad^2 and 1 mm^2 in every 10 ms
  const auto walk = [&](const std::string& variant) {
    return *run_options(scenario, method_variant_from_string(variant), StartMode::kAuto, 1, 0).theta_walk;
  };
  EXPECT_EQ(walk("ekf-full"), scenario.filter.theta_walk);
  EXPECT_TRUE(walk("ekf-full:walk=x10").isApprox(10.0 * scenario.filter.theta_walk, 1e-15));
  EXPECT_TRUE(walk("ekf-full:walk=0/0").isZero(0.0));
  EXPECT_TRUE(walk("ekf-full:walk=1e-6/1").isApprox(scenario.filter.theta_walk, 1e-12));
  const RigParameters over = walk("ekf-full:walk=2e-5/20");
  EXPECT_NEAR(over[0], 2e-3, 1e-15);
  EXPECT_NEAR(over[3], 2e-3, 1e-15);
}

}  // namespace
}  // namespace limber
