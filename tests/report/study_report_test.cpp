// SPDX-License-Identifier: MIT
#include "limber/report/study_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/files.hpp"
#include "limber/report/write_report.hpp"
#include "limber/study/run_study.hpp"
#include "report/find_in_document.hpp"
#include "report/small_study.hpp"
#include "run/short_recording.hpp"

namespace limber {
namespace {

using ::testing::AllOf;
using testing::bent_scenario;
using testing::case_results;
using ::testing::Contains;
using ::testing::ElementsAre;
using testing::Got;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::study_of;
using testing::trace;

StudyResults small_study() {
  Got diverging{"ekf-full"};
  diverging.diverged = 3;
  Got best{"lcekf"};
  best.position = 0.05;
  return study_of({case_results(bent_scenario(), {{"ekf"}, diverging, best, {"mono-left"}})});
}

template <typename Block>
std::vector<Block> blocks(const ReportDocument& document) {
  std::vector<Block> out;
  for (const ReportSection& section : document.sections) {
    for (const ReportBlock& block : section.blocks) {
      if (const auto* found = std::get_if<Block>(&block)) {
        out.push_back(*found);
      }
    }
  }
  return out;
}

ReportFigure figure_ending(const ReportDocument& document, const std::string& suffix) {
  for (const ReportFigure& figure : blocks<ReportFigure>(document)) {
    if (figure.id.ends_with(suffix)) {
      return figure;
    }
  }
  throw std::out_of_range("no figure " + suffix);
}

TEST(StudyReport, DrawsMeanSquaredErrorsBesideNineTimesTheMeanVariance) {
  const ReportDocument document = study_report(small_study());
  const ReportFigure position = figure_ending(document, "-position");
  EXPECT_EQ(trace(position, "lcekf").x.size(), testing::kInstants);
  EXPECT_DOUBLE_EQ(trace(position, "lcekf").y[7], 0.05 * 0.05);
  EXPECT_EQ(trace(position, "lcekf 3σ").shape, TraceShape::kBound);
  EXPECT_DOUBLE_EQ(trace(position, "lcekf 3σ").y[7], 9.0 * 0.1 * 0.1);
  EXPECT_DOUBLE_EQ(trace(figure_ending(document, "-nees"), "ekf").y[7], 1.0);
  EXPECT_DOUBLE_EQ(trace(figure_ending(document, "-landmarks"), "ekf").y[0], 1.0);
}

TEST(StudyReport, BeginsWithThePapersMethodsAndOffersThemWithoutEkf) {
  const ReportFigure position = figure_ending(study_report(small_study()), "-position");
  ASSERT_EQ(position.variants.size(), 4u);
  EXPECT_EQ(position.variants[0].label, "paper");
  EXPECT_THAT(position.variants[0].hidden_styles, ElementsAre("mono-left"));
  EXPECT_EQ(position.variants[1].label, "without ekf");
  EXPECT_THAT(position.variants[1].hidden_styles, ElementsAre("ekf", "mono-left"));
  EXPECT_THAT(position.variants[2].hidden_styles, Contains("ekf-full"));
  EXPECT_TRUE(position.variants[3].hidden_styles.empty());
}

TEST(StudyReport, DrawsTheCalibrationBesideWhatIsEstimated) {
  StudyResults results = small_study();
  StudyMethodResults& full = results.cases[0].methods[1];
  for (std::size_t axis = 0; axis < 6; ++axis) {
    full.curves[theta_axis(CurveQuantity::kDeltaAx, axis)] = testing::constant_curve(0.09);
    full.curves[theta_axis(CurveQuantity::kThetaVarianceAx, axis)] = testing::constant_curve(0.0004);
  }
  const ReportFigure translation = figure_ending(study_report(results), "-calibration-translation");
  EXPECT_EQ(translation.y.size(), 3u);
  EXPECT_DOUBLE_EQ(trace(translation, "truth").y[5], 0.1);  // delta of case (ii)
  EXPECT_DOUBLE_EQ(trace(translation, "ekf-full").y[5], 0.09);
  EXPECT_NEAR(trace(translation, "ekf-full +3σ").y[5], 0.15, 1e-12);
  EXPECT_NEAR(trace(translation, "ekf-full −3σ").y[5], 0.03, 1e-12);
}

TEST(StudyReport, OpensOnTheAnswer) {
  Got sure{"ekf", 0.3};
  sure.anees = 100.0;
  const StudyResults results = study_of({case_results(bent_scenario(), {sure, {"lcekf", 0.1}})});
  const ReportDocument document = study_report(results);
  const auto& blocks = document.sections.front().blocks;
  EXPECT_EQ(document.answer->headline, "Closest to the truth: lcekf");
  EXPECT_THAT(document.answer->sentences,
              ElementsAre(AllOf(
                  HasSubstr("(bent rig), started from the truth (--init groundtruth): lcekf comes closest."),
                  HasSubstr("More than twice as wrong as they claim: ekf (10.0)."))));
  const auto& table = std::get<ReportTable>(blocks.at(0));
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.rows[1][1].text, "lcekf");
  EXPECT_EQ(table.rows[1][2].mark, TableCell::Mark::kBest);
  EXPECT_EQ(table.rows[0][3].text, "3.0");
  EXPECT_EQ(table.rows[0][4].mark, TableCell::Mark::kBad);
  EXPECT_EQ(table.rows[1][4].mark, TableCell::Mark::kNone);
}

TEST(StudyReport, OfManyCasesCountsWhoIsBest) {
  std::vector<StudyCaseResults> cases;
  for (int k = 0; k < 6; ++k) {
    Scenario scenario = bent_scenario();
    scenario.name = std::to_string(k);
    cases.push_back(case_results(scenario, {{"ekf", k < 2 ? 0.01 : 0.3}, {"lcekf", 0.1}}));
  }
  const ReportAnswer answer = study_report(study_of(std::move(cases))).answer.value();
  EXPECT_EQ(answer.headline, "Closest to the truth in 4 of 6 cases: lcekf");
  ASSERT_EQ(answer.sentences.size(), 5u);
  EXPECT_EQ(answer.sentences.back(), "2 more cases in the table below.");
}

TEST(StudyReport, ShowsDivergedRunsAsSuch) {
  const ReportDocument document = study_report(small_study());
  for (const ReportTable& table : blocks<ReportTable>(document)) {
    bool shown = false;
    for (const auto& row : table.rows) {
      for (const TableCell& cell : row) {
        shown =
            shown || (cell.text.find("3") != std::string::npos &&
                      cell.text.find("diverged") != std::string::npos && cell.mark == TableCell::Mark::kBad);
      }
    }
    EXPECT_TRUE(shown) << table.title;
  }
  EXPECT_EQ(document.facts[2].name, "diverged");
  EXPECT_EQ(document.facts[2].value, "3");
}

TEST(StudyReport, MarksTheBestMethodThatNeitherDivergedNorWasToldTheTruth) {
  StudyResults results = small_study();
  Got oracle{"oracle"}, lucky{"soft"};
  oracle.position = lucky.position = 0.01;
  lucky.diverged = 1;
  results.cases = {case_results(bent_scenario(), {{"ekf"}, oracle, lucky, {"mono-left", 0.07}})};
  const ReportTable table = blocks<ReportTable>(study_report(results)).back();
  std::vector<std::string> best;
  for (const auto& row : table.rows) {
    for (const TableCell& cell : row) {
      if (cell.mark == TableCell::Mark::kBest) {
        best.push_back(row[0].text);
      }
    }
  }
  EXPECT_THAT(best, ElementsAre("mono-left"));
}

TEST(StudyReport, GivesEachSetOfRandomWalksATableWithoutEmptyColumns) {
  Scenario tenfold = bent_scenario(), hundredfold = tenfold, tabled = tenfold;
  hundredfold.name = "another";
  tabled.name = "table 1";
  const ReportDocument document = study_report(study_of(
      {case_results(tenfold, {{"ekf-full:walk=x10"}}), case_results(hundredfold, {{"ekf-full:walk=x10"}}),
       case_results(tabled, {{"ekf"}, {"ekf-full:walk=0/0"}})}));
  std::vector<std::vector<std::string>> columns;
  std::vector<std::size_t> rows;
  for (const ReportBlock& block : document.sections.front().blocks) {
    const auto* table = std::get_if<ReportTable>(&block);
    if (table != nullptr && table->columns.at(1) != "method") {
      columns.push_back(table->columns);
      rows.push_back(table->rows.size());
    }
  }
  EXPECT_THAT(columns, ElementsAre(ElementsAre("case", "runs", "ekf"),
                                   ElementsAre("case", "runs", "ekf-full:walk=x10"),
                                   ElementsAre("case", "runs", "ekf-full:walk=0/0")));
  EXPECT_THAT(rows, ElementsAre(1u, 2u, 1u));
}

TEST(StudyReport, PrintsTheScenario) {
  EXPECT_THAT(blocks<ReportListing>(study_report(small_study())).front().text, HasSubstr("decalibration:"));
}

TEST(StudyReport, PutsCommentsWhereTheyBelong) {
  StudyComments comments;
  comments.title = "An experiment";
  comments.facts = {{"agrees", "yes"}};
  comments.overview = {ReportText{"first"}};
  comments.cases = {{"a case", {ReportText{"second"}}}};
  comments.sections = {{"last", "Last", {ReportText{"third"}}}};
  const ReportDocument document = study_report(small_study(), comments);
  EXPECT_EQ(document.title, "An experiment");
  EXPECT_EQ(document.facts.back().name, "agrees");
  const auto texts = blocks<ReportText>(document);
  ASSERT_EQ(texts.size(), 3u);
  EXPECT_EQ(texts[0].text + texts[1].text + texts[2].text, "firstsecondthird");
  EXPECT_EQ(document.sections[1].title, "a case");
  EXPECT_EQ(document.sections.back().title, "Last");
  comments.cases.emplace_back();
  EXPECT_THROW((void)study_report(small_study(), comments), std::invalid_argument);
}

TEST(StudyReport, IsCalledAStudyUnlessToldOtherwise) {
  EXPECT_EQ(study_report(small_study()).title, "Monte Carlo study");
}

TEST(StudyReport, GivesCasesWithSimilarNamesAnchorsOfTheirOwn) {
  std::vector<StudyCaseResults> cases;
  for (const char* const name : {"a b", "a-b", "a  b?"}) {
    Scenario scenario = bent_scenario();
    scenario.name = name;
    cases.push_back(case_results(scenario, {{"ekf"}}));
  }
  EXPECT_NO_THROW((void)report_json(study_report(study_of(std::move(cases)))));
}

TEST(StudyReport, SaysWhatIsStillToCome) {
  StudyResults results = small_study();
  results.cases[0].info.runs = 50;
  const ReportDocument document = study_report(results);
  EXPECT_EQ(document.facts[1].value, "40 of 200");
  EXPECT_THAT(report_json(document), HasSubstr("10 of 50"));
}

TEST(LoadStudy, ReadsWhatAStudyLeft) {
  const testing::TemporaryFolder folder;
  const auto database = folder.path() / "study.sqlite";
  StudyPlan plan;
  plan.cases = {{testing::short_scenario(), method_variants_from_string("ekf-full,lcekf"), 2}};
  (void)run_study(plan, database, {});
  const StudyResults results = load_study(database);
  ASSERT_EQ(results.cases.size(), 1u);
  ASSERT_EQ(results.cases[0].methods.size(), 2u);
  const StudyMethodResults& full = results.cases[0].methods[0];
  EXPECT_EQ(full.summary.label, "ekf-full");
  EXPECT_EQ(full.runs.size(), 2u);
  EXPECT_TRUE(full.curves.contains(CurveQuantity::kDeltaTx));
  EXPECT_FALSE(results.cases[0].methods[1].curves.contains(CurveQuantity::kDeltaTx));
  EXPECT_EQ(results.cases[0].example.truth.size(), 41u);
  EXPECT_EQ(results.cases[0].example.estimate[1].size(), 41u);
  EXPECT_NO_THROW((void)report_json(study_report(results)));
}

TEST(LoadStudy, NamesAFileThatIsNoStudy) {
  const testing::TemporaryFolder folder;
  const auto path = testing::write_text(folder.path() / "study.sqlite", "no database");
  EXPECT_EQ(testing::data_error_of([&] { (void)load_study(path); }).file(), path.string());
}

}  // namespace
}  // namespace limber
