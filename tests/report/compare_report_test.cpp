// SPDX-License-Identifier: MIT
#include "limber/report/compare_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compare/run_files_of.hpp"
#include "datasets/files.hpp"
#include "limber/report/write_report.hpp"
#include "report/find_in_document.hpp"
#include "run/short_recording.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using testing::figure;
using ::testing::HasSubstr;
using testing::RunFilesOf;
using testing::trace;

class CompareReport : public ::testing::Test {
 protected:
  void add(RunFilesOf run) {
    folders_.push_back(folder_.path() / std::to_string(folders_.size()));
    run.write(folders_.back());
  }
  void navigate(const RunOptions& options) {
    const Recording recording = testing::short_recording();
    const RunRecord record = run_recording(recording, options, matched_frames(recording));
    folders_.push_back(folder_.path() / std::to_string(folders_.size()));
    write_run_output(folders_.back(), options, record, summarize(recording, options, record));
  }
  [[nodiscard]] ReportDocument report() const { return compare_report(folders_); }

 private:
  testing::TemporaryFolder folder_;
  std::vector<fs::path> folders_;
};

std::vector<std::string> ids_of(const ReportDocument& document) {
  std::vector<std::string> ids;
  for (const ReportSection& section : document.sections) {
    for (const ReportBlock& block : section.blocks) {
      if (const auto* figure = std::get_if<ReportFigure>(&block)) {
        ids.push_back(figure->id);
      }
    }
  }
  return ids;
}

double path_time(const ReportDocument& document, const std::string& run) {
  const ReportTrace& path = trace(figure(document, "path"), run);
  return path.t.size() == path.x.size() ? path.t.back() : -1.0;
}

TEST_F(CompareReport, LaysRunsOverEachOtherWithTheAnswerFirst) {
  RunFilesOf good("ekf"), bad("lcekf");
  good.scale = 1.01;
  bad.scale = 1.04;
  bad.yaw = 0.5;
  add(good);
  add(bad);
  const ReportDocument document = report();
  EXPECT_NO_THROW((void)report_json(document));
  EXPECT_EQ(document.title, "2 runs on walk");
  EXPECT_THAT(document.answer->headline, HasSubstr("Closest to the truth: ekf, "));
  EXPECT_THAT(document.answer->sentences,
              ElementsAre(AllOf(HasSubstr("Relative error of lcekf minus that of ekf"), HasSubstr("worse"))));
  EXPECT_EQ(document.facts[0].name, "ekf, ATE");
  const auto& differences = std::get<ReportTable>(document.sections[0].blocks[1]);
  EXPECT_EQ(differences.rows[0][3].mark, TableCell::Mark::kBad);
  EXPECT_THAT(ids_of(document), ElementsAre("path", "position-error", "attitude-error", "relative-error",
                                            "error-over-distance"));
  EXPECT_NEAR(trace(figure(document, "error-over-distance"), "lcekf").y.back(), 3.7,
              0.3);  // % of every length
  EXPECT_NEAR(path_time(document, "ekf"), 60.0, 1e-6);
  // Paths lie on each other and on the truth, though one world is turned.
  const ReportFigure& path = figure(document, "path");
  const ReportTrace &truth = trace(path, "truth"), &ekf = trace(path, "ekf"), &lcekf = trace(path, "lcekf");
  for (std::size_t k = 0; k < truth.x.size(); k += 100) {
    EXPECT_NEAR(ekf.x[k], truth.x[k], 0.6);
    EXPECT_NEAR(lcekf.y[k], truth.y[k], 2.4);
  }
  // The error of a scale: 1 % of the way from the begin.
  const ReportTrace& error = trace(figure(document, "position-error"), "ekf");
  EXPECT_NEAR(error.y.back(), 0.01 * RunFilesOf::position(60.0).norm(), 1e-6);
  EXPECT_NEAR(error.x.back(), 60.0, 1e-6);
  EXPECT_NEAR(trace(figure(document, "position-error"), "3 sigma").y[0], 3.0 * std::sqrt(3.0), 1e-9);
  EXPECT_EQ(trace(figure(document, "relative-error"), "lcekf").y.size(), 12U);
}

TEST_F(CompareReport, WithoutTruthDrawsTheDistance) {
  RunFilesOf a("ekf"), b("lcekf");
  a.has_truth = b.has_truth = false;
  b.yaw = 0.5;
  b.scale = 1.1;
  add(a);
  add(b);
  const ReportDocument document = report();
  EXPECT_THAT(ids_of(document), ElementsAre("path", "position-error", "attitude-error"));
  EXPECT_EQ(figure(document, "position-error").title, "Distance between runs");
  EXPECT_NEAR(trace(figure(document, "position-error"), "lcekf").y.back(),
              0.1 * RunFilesOf::position(60.0).norm(), 1e-6);
  EXPECT_THAT(document.answer->headline, HasSubstr("no truth is known"));
  EXPECT_THAT(document.answer->sentences, ElementsAre(HasSubstr("At the end lcekf is")));
}

TEST_F(CompareReport, ATruthThatIsNotLevelIsSetUpright) {
  RunFilesOf a("ekf"), b("lcekf");
  a.truth_roll = b.truth_roll = 1.2;
  add(a);
  add(b);
  const ReportDocument document = report();
  const ReportFigure& error = figure(document, "position-error");
  EXPECT_LT(trace(error, "ekf").y.back(), 1e-6);
  EXPECT_NEAR(trace(error, "3 sigma").y[0], 3.0 * std::sqrt(3.0), 1e-9);
  EXPECT_LT(trace(figure(document, "attitude-error"), "ekf").y.back(), 1e-6);
  EXPECT_THAT(error.caption, HasSubstr("not level"));
}

TEST_F(CompareReport, EachRecordingHasSectionsOfItsOwn) {
  RunFilesOf a("ekf"), b("ekf"), c("ekf");
  b.recording = c.recording = "elsewhere";
  add(a);
  add(b);
  add(c);
  const ReportDocument document = report();
  EXPECT_NO_THROW((void)report_json(document));
  EXPECT_EQ(document.title, "3 runs on walk, elsewhere");
  EXPECT_EQ(document.answer->headline, "Closest to the truth");
  EXPECT_THAT(document.answer->sentences, ElementsAre(HasSubstr("On walk: 0, "), HasSubstr("On elsewhere: "),
                                                      HasSubstr("minus that of 1")));
  EXPECT_EQ(document.sections[3].id, "trajectory-2");
  EXPECT_EQ(document.sections[3].title, "Trajectory on elsewhere");
  EXPECT_EQ(trace(figure(document, "path-2"), "1").style, "ekf");
  EXPECT_EQ(trace(figure(document, "path-2"), "2").style, "ekf:2");  // a dash of its own
}

TEST_F(CompareReport, DrawsVelocityAndBiasesOfAllRunsWithTheirBounds) {
  RunOptions options;
  options.start = StartMode::kGroundTruth;
  for (const Method method : {Method::kEkf, Method::kLcekf}) {
    options.method = method;
    navigate(options);
  }
  const ReportDocument document = report();
  for (const char* const id : {"velocity-error", "bias-gyro", "bias-accel"}) {
    const ReportFigure& drawn = figure(document, id);
    EXPECT_EQ(trace(drawn, "ekf").y.size(), trace(drawn, "lcekf").y.size()) << id;
    EXPECT_EQ(trace(drawn, "+3 sigma").shape, TraceShape::kBound);
  }
  EXPECT_EQ(trace(figure(document, "bias-gyro"), "truth").style, "truth");
}

TEST_F(CompareReport, DrawsWhatEachFoundOfTheCalibration) {
  RunOptions options;
  options.start = StartMode::kGroundTruth;
  for (const Method method : {Method::kEkf, Method::kEkfFull, Method::kAdaptive}) {
    options.method = method;
    navigate(options);
  }
  const ReportDocument document = report();
  EXPECT_NO_THROW((void)report_json(document));
  EXPECT_EQ(document.sections.back().id, "calibration");
  const ReportFigure& rotation = figure(document, "estimated-0");
  EXPECT_EQ(rotation.y.size(), 3U);
  EXPECT_EQ(trace(rotation, "ekf-full").style, "ekf-full");
  EXPECT_THROW((void)trace(rotation, "ekf"), std::out_of_range);
  const ReportFigure& offset = figure(document, "health-rotation");
  EXPECT_EQ(trace(offset, "ekf").y.size(), trace(offset, "adaptive").y.size());
}

}  // namespace
}  // namespace limber
