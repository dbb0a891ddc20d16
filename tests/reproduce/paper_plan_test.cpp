// SPDX-License-Identifier: MIT
#include "reproduce/paper_plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <stdexcept>

#include "shipped_scenario.hpp"
#include "source_folder.hpp"

namespace limber {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsSupersetOf;
using ::testing::Not;

std::vector<std::string> labels_of(const StudyCase& study_case) {
  std::vector<std::string> labels;
  for (const MethodVariant& variant : study_case.methods) {
    labels.push_back(to_string(variant));
  }
  return labels;
}

const StudyCase& case_named(const StudyPlan& plan, const std::string& name) {
  for (const StudyCase& study_case : plan.cases) {
    if (study_case.scenario.name == name) {
      return study_case;
    }
  }
  throw std::out_of_range("no case " + name);
}

TEST(PaperPlan, IsMadeOfTheShippedScenariosAndUsesThemAll) {
  std::set<std::string> shipped, used;
  for (const auto& entry : std::filesystem::directory_iterator(testing::source_folder() / "scenarios")) {
    if (entry.path().filename().string().starts_with("paper_")) {
      shipped.insert(entry.path().stem().string());
    }
  }
  const StudyPlan plan = paper_plan({{}, {}, false, 1});
  for (const StudyCase& study_case : plan.cases) {
    const std::string& name = study_case.scenario.name;
    used.insert(name);
    const Scenario file = testing::shipped(name);
    EXPECT_EQ(format_scenario(study_case.scenario), format_scenario(file));
  }
  EXPECT_EQ(used, shipped);
}

TEST(PaperPlan, HasThePapersRunsAndMethods) {
  const StudyPlan plan = paper_plan({{}, {}, false, 7});
  EXPECT_EQ(plan.seed, 7u);
  EXPECT_NO_THROW(check_plan(plan));
  for (const StudyCase& study_case : plan.cases) {
    EXPECT_EQ(study_case.start, StartMode::kGroundTruth);
    EXPECT_EQ(study_case.runs, study_case.scenario.use_imu ? 100u : 10u) << study_case.scenario.name;
    if (study_case.scenario.name == "paper_iii_vision") {  // Table 1
      EXPECT_THAT(labels_of(study_case), ElementsAre("ekf", "ekf-full", "lcekf:full", "ekf-full:walk=0/0",
                                                     "ekf-full:walk=5e-07/0.1", "ekf-full:walk=2e-05/20"));
    } else {
      EXPECT_THAT(labels_of(study_case), ElementsAre("ekf", "ekf-full", "lcekf:full"));
    }
  }
}

TEST(PaperPlan, GoesBeyondThePaperUnlessToldNotTo) {
  const StudyPlan plan = paper_plan({});
  EXPECT_NO_THROW(check_plan(plan));
  for (const StudyCase& study_case : plan.cases) {
    const std::vector<std::string> labels = labels_of(study_case);
    EXPECT_EQ(study_case.start, StartMode::kGroundTruth);
    if (study_case.scenario.name.ends_with("_walks")) {
      EXPECT_THAT(labels,
                  AllOf(IsSupersetOf({"ekf-full:walk=x0.1", "ekf-full:walk=x10"}), Not(Contains("lcekf"))));
      EXPECT_EQ(study_case.runs, 10u);
    } else {
      EXPECT_THAT(labels, IsSupersetOf({"ekf", "ekf-full", "lcekf:full", "lcekf:rotation+direction",
                                        "lcekf:rotation", "mono-left", "oracle"}));
    }
  }
  EXPECT_EQ(case_named(plan, "paper_v_strong_walks").scenario.decalibration.size(), 1u);
}

TEST(PaperPlan, ComputesWhatOneFigureNeeds) {
  const StudyPlan ten = paper_plan({{10}, {}, false, 1});
  ASSERT_EQ(ten.cases.size(), 1u);
  EXPECT_EQ(ten.cases[0].scenario.name, "paper_v_strong");
  EXPECT_EQ(ten.cases[0].scenario.decalibration.at(0).amplitude(3), 0.5);
  const StudyPlan eleven = paper_plan({{11}, 3, false, 1});
  ASSERT_EQ(eleven.cases.size(), 2u);
  EXPECT_EQ(eleven.cases[0].runs, 3u);
  // Figure 5 wants a hundred runs of the case of which Figure 11 wants ten.
  EXPECT_EQ(paper_plan({{11}, {}, false, 1}).cases[0].runs, 10u);
  EXPECT_EQ(paper_plan({{11, 5}, {}, false, 1}).cases[0].runs, 100u);
  EXPECT_EQ(paper_plan({{11, 5}, 1000, false, 1}).cases[0].runs, 100u);
}

TEST(PaperPlan, RefusesAFigureWithoutResults) {
  for (const int number : {0, 1, 2, 19}) {
    EXPECT_THROW((void)paper_plan({{number}, {}, true, 1}), std::invalid_argument);
  }
}

TEST(PaperFigures, RunFromThreeToEighteen) {
  int number = 3;
  for (const PaperFigure& figure : paper_figures()) {
    EXPECT_EQ(figure.number, number++);
    EXPECT_FALSE(figure.cases.empty());
  }
  EXPECT_EQ(number, 19);
  EXPECT_EQ(paper_figures_of("paper_ii"), "Figures 6 and 12");
  EXPECT_EQ(paper_figures_of("paper_v_strong"), "Figure 10");
  EXPECT_EQ(paper_figures_of("paper_iii_vision"), "Figures 13, 15, 16, 17 and 18");
  EXPECT_EQ(paper_figures_of("paper_ii_walks"), "");
}

}  // namespace
}  // namespace limber
