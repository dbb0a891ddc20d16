// SPDX-License-Identifier: MIT
#include "limber/report/run_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "datasets/files.hpp"
#include "limber/core/so3.hpp"
#include "limber/report/write_report.hpp"
#include "limber/run_files/run_output.hpp"
#include "report/find_in_document.hpp"
#include "run/short_recording.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using testing::data_error_of;
using ::testing::ElementsAre;
using testing::figure;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

constexpr double kToDegrees = 180.0 / M_PI;

/// A run of two seconds in a folder of its own.
class RunReport : public ::testing::Test {
 protected:
  void navigate(Recording recording, StartMode start = StartMode::kGroundTruth) {
    RunOptions options;
    options.start = start;
    navigate(std::move(recording), options);
  }
  void navigate(Recording recording, const RunOptions& options) {
    recording_ = std::move(recording);
    record_ = run_recording(recording_, options, matched_frames(recording_));
    write_run_output(folder_.path(), options, record_, summarize(recording_, options, record_));
  }
  fs::path file(const char* name) { return folder_.path() / name; }

  TemporaryFolder folder_;
  Recording recording_;
  RunRecord record_;
};

/// Of case (ii), 5 % of depth: five seconds, after which the verdict is no matter of chance.
Recording degraded_recording() {
  Scenario scenario = testing::short_scenario();
  scenario.duration = 5.0;
  return simulate(scenario, 1);
}

const ReportTrace* find_trace(const ReportFigure& figure, const std::string& name, std::size_t panel = 0) {
  for (const ReportTrace& trace : figure.traces) {
    if (trace.name == name && trace.panel == panel) {
      return &trace;
    }
  }
  return nullptr;
}

std::vector<std::string> section_ids(const ReportDocument& document) {
  std::vector<std::string> ids;
  for (const ReportSection& section : document.sections) {
    ids.push_back(section.id);
  }
  return ids;
}

TEST_F(RunReport, HasItsSectionsInOrder) {
  navigate(testing::short_recording());
  const ReportDocument document = run_report(folder_.path());
  EXPECT_THAT(section_ids(document), ElementsAre("trajectory", "errors", "drift", "motion", "calibration",
                                                 "innovations", "points", "time", "summary"));
  EXPECT_EQ(document.title, "lcekf on short");
  EXPECT_NO_THROW((void)report_json(document));
}

TEST_F(RunReport, OpensOnTheAnswer) {
  navigate(degraded_recording());
  const ReportAnswer answer = run_report(folder_.path()).answer.value();
  EXPECT_EQ(answer.light, ReportAnswer::Light::kYellow);  // case (ii): 5 %
  EXPECT_EQ(answer.headline, "Calibration degraded");
  EXPECT_THAT(answer.sentences,
              ElementsAre(HasSubstr("off the epipolar lines"), HasSubstr("from the truth")));
  EXPECT_THAT(answer.sentences, ::testing::Each(::testing::MatchesRegex("[A-Z].*\\.")));
  EXPECT_THAT(answer.advice, HasSubstr("Recalibrate"));
}

TEST_F(RunReport, OfAnOlderRunOpensOnTheVerdict) {
  navigate(degraded_recording());
  auto summary = nlohmann::ordered_json::parse(testing::read_text(file("summary.json")));
  summary.erase("answer");
  testing::write_text(file("summary.json"), summary.dump());
  const ReportAnswer answer = run_report(folder_.path()).answer.value();
  EXPECT_EQ(answer.light, ReportAnswer::Light::kYellow);
  EXPECT_EQ(answer.headline, "Calibration: degraded");
}

TEST_F(RunReport, DrawsVelocityErrorsAndBiasesWithTheirBounds) {
  navigate(testing::short_recording());
  const ReportDocument document = run_report(folder_.path());
  const ReportFigure& velocity = figure(document, "velocity-error");
  const ReportFigure& gyro = figure(document, "bias-gyro");
  const ReportFigure& accel = figure(document, "bias-accel");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto k = static_cast<Eigen::Index>(axis);
    for (std::size_t n = 0; n < record_.trajectory.size(); ++n) {
      const TrajectoryRow& row = record_.trajectory[n];
      const GroundTruthState& truth = recording_.truth.motion.states[5 * n];  // 100 Hz, frames at 20 Hz
      EXPECT_NEAR(find_trace(velocity, "lcekf", axis)->y[n], (truth.v_world_body - *row.v_world_body)(k),
                  1e-9);
      EXPECT_NEAR(find_trace(velocity, "+3 sigma", axis)->y[n], 3.0 * (*row.sigma_v)(k), 1e-12);
      EXPECT_NEAR(find_trace(velocity, "-3 sigma", axis)->y[n], -3.0 * (*row.sigma_v)(k), 1e-12);
      EXPECT_NEAR(find_trace(gyro, "lcekf", axis)->y[n], (*row.bias_gyro)(k), 1e-12);
      EXPECT_NEAR(find_trace(gyro, "truth", axis)->y[n], truth.bias_gyro(k), 1e-12);
      EXPECT_NEAR(find_trace(accel, "+3 sigma", axis)->y[n],
                  (*row.bias_accel + 3.0 * *row.sigma_bias_accel)(k), 1e-12);
    }
  }
}

TEST_F(RunReport, DrawsTheVelocityItselfWhereNoTruthIsKnown) {
  Recording recording = testing::short_recording();
  recording.truth.motion.has_velocity = recording.truth.motion.has_biases = false;
  navigate(recording);
  const ReportDocument document = run_report(folder_.path());
  EXPECT_THROW((void)figure(document, "velocity-error"), std::out_of_range);
  const ReportTrace* vx = find_trace(figure(document, "velocity"), "lcekf");
  ASSERT_NE(vx, nullptr);
  EXPECT_NEAR(vx->y.back(), record_.trajectory.back().v_world_body->x(), 1e-12);
  EXPECT_EQ(find_trace(figure(document, "bias-gyro"), "truth"), nullptr);
  navigate(testing::vision_only(testing::short_recording()));
  EXPECT_THROW((void)figure(run_report(folder_.path()), "bias-gyro"), std::out_of_range);
}

TEST_F(RunReport, DrawsNoBoundsOfVelocityThatTheFilesDoNotHave) {
  navigate(testing::short_recording());
  std::vector<TrajectoryRow> rows = read_trajectory_csv(file("trajectory.csv"));
  EXPECT_THAT(figure(run_report(folder_.path()), "velocity-error").caption, HasSubstr("Dotted"));
  for (TrajectoryRow& row : rows) {
    row.sigma_v.reset();
  }
  write_trajectory_csv(file("trajectory.csv"), rows);
  const ReportDocument document = run_report(folder_.path());
  const ReportFigure& velocity = figure(document, "velocity-error");
  EXPECT_NE(find_trace(velocity, "lcekf"), nullptr);
  EXPECT_EQ(find_trace(velocity, "+3 sigma"), nullptr);
  EXPECT_THAT(velocity.caption, ::testing::Not(HasSubstr("Dotted")));
  EXPECT_NE(find_trace(figure(document, "bias-gyro"), "+3 sigma"), nullptr);
}

TEST_F(RunReport, DrawsRelativeErrorsOverSeveralDistances) {
  navigate(testing::short_recording());
  const ReportDocument document = run_report(folder_.path());
  const ReportFigure& drift = figure(document, "error-over-distance");
  EXPECT_TRUE(drift.x.log);
  const ReportTrace *position = find_trace(drift, "lcekf", 0), *attitude = find_trace(drift, "lcekf", 1);
  ASSERT_GE(position->x.size(), 3U);
  EXPECT_EQ(attitude->x, position->x);
  const ReportTrace *lower = find_trace(drift, "lower quartile"),
                    *upper = find_trace(drift, "upper quartile");
  for (std::size_t k = 0; k < position->x.size(); ++k) {
    EXPECT_LE(lower->y[k], position->y[k]);
    EXPECT_GE(upper->y[k], position->y[k]);
  }
  const auto& table = std::get<ReportTable>(document.sections[2].blocks[1]);
  EXPECT_EQ(table.rows.size(), position->x.size());
}

TEST_F(RunReport, KnowsWhenAPathWasWhere) {
  navigate(testing::short_recording());
  const ReportDocument document = run_report(folder_.path());
  for (const char* const id : {"path", "path-3d"}) {
    const ReportTrace* path = find_trace(figure(document, id), "lcekf");
    ASSERT_EQ(path->t.size(), path->x.size());
    EXPECT_NEAR(path->t.back(), 2.0, 1e-9);
  }
}

TEST_F(RunReport, DrawsErrorsOfTheFilterAgainstTheTruth) {
  navigate(testing::short_recording());
  const ReportDocument document = run_report(folder_.path());
  const ReportFigure& position = figure(document, "position-error");
  const ReportFigure& attitude = figure(document, "attitude-error");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const ReportTrace* error = find_trace(position, "error", axis);
    const ReportTrace* upper = find_trace(position, "+3 sigma", axis);
    const ReportTrace* turned = find_trace(attitude, "error", axis);
    ASSERT_TRUE(error != nullptr && upper != nullptr && turned != nullptr);
    ASSERT_EQ(error->y.size(), record_.trajectory.size());
    const auto k = static_cast<Eigen::Index>(axis);
    for (std::size_t n = 0; n < record_.trajectory.size(); ++n) {
      const TrajectoryRow& row = record_.trajectory[n];
      const GroundTruthState& truth = recording_.truth.motion.states[5 * n];  // 100 Hz, frames at 20 Hz
      ASSERT_EQ(truth.t_ns, row.t_ns);
      EXPECT_DOUBLE_EQ(error->x[n], 1e-9 * static_cast<double>(row.t_ns));
      EXPECT_NEAR(error->y[n], (truth.p_world_body - row.T_world_body.p)(k), 1e-12);
      EXPECT_NEAR(upper->y[n], 3.0 * std::sqrt((*row.covariance)(k, k)), 1e-12);
      const Eigen::Vector3d dtheta = so3_log(row.T_world_body.R.transpose() * truth.R_world_body);
      EXPECT_NEAR(turned->y[n], kToDegrees * dtheta(k), 1e-7);
    }
  }
}

TEST_F(RunReport, PutsTheTruthIntoTheWorldOfAnEstimateThatStartedElsewhere) {
  Recording moved = testing::short_recording();
  const Eigen::Matrix3d R = so3_exp({0.0, 0.0, 1.0});
  for (GroundTruthState& state : moved.truth.motion.states) {
    state.p_world_body = R * state.p_world_body + Eigen::Vector3d(10.0, -20.0, 5.0);
    state.R_world_body = R * state.R_world_body;
  }
  navigate(moved, StartMode::kAuto);
  const ReportDocument document = run_report(folder_.path());
  const ReportTrace* error = find_trace(figure(document, "position-error"), "error", 0);
  ASSERT_NE(error, nullptr);
  EXPECT_NEAR(error->y.front(), 0.0, 1e-9);
  EXPECT_LT(std::abs(error->y.back()), 1.0);
  EXPECT_THAT(std::get<ReportText>(document.sections[0].blocks[0]).text,
              HasSubstr("aligned by the position and yaw of the first pose"));
  const ReportTrace* truth = find_trace(figure(document, "path"), "truth");
  ASSERT_NE(truth, nullptr);
  EXPECT_NEAR(truth->x.back(), record_.trajectory.back().T_world_body.p.x(), 0.5);
}

TEST_F(RunReport, SaysSoWhereTheWorldOfTheTruthIsNotLevel) {
  Recording tilted = testing::short_recording();
  const Eigen::Matrix3d R = so3_exp({1.2, 0.0, 0.0});
  for (GroundTruthState& state : tilted.truth.motion.states) {
    state.p_world_body = R * state.p_world_body;
    state.R_world_body = R * state.R_world_body;
  }
  navigate(tilted, StartMode::kAuto);
  const ReportDocument document = run_report(folder_.path());
  EXPECT_THAT(document.answer->sentences.back(), HasSubstr("not level"));
  EXPECT_EQ(document.facts[1].name, "attitude RMSE, aligned");
  EXPECT_LT(std::stod(document.facts[1].value), 5.0);  // of 69 deg that the worlds are apart
  const ReportTrace* attitude = find_trace(figure(document, "attitude-error"), "error", 0);
  EXPECT_LT(std::abs(attitude->y.back()), 5.0);
  EXPECT_NE(find_trace(figure(document, "attitude-error"), "+3 sigma"), nullptr);
  navigate(testing::short_recording(), StartMode::kAuto);
  const ReportDocument level = run_report(folder_.path());
  EXPECT_THAT(level.answer->sentences.back(), ::testing::Not(HasSubstr("not level")));
  EXPECT_EQ(level.facts[1].name, "attitude RMSE");
}

TEST_F(RunReport, TakesTheTiltOutOfTheFilesOfAnOlderRun) {
  navigate(testing::short_recording(), StartMode::kAuto);
  // As they were: truth.tum met the estimate at the first pose and leant away from there.
  std::vector<StampedPose> truth = read_tum(file("truth.tum"));
  const Pose first = truth.front().T_world_body;
  for (StampedPose& pose : truth) {
    pose.T_world_body =
        first * Pose{so3_exp({1.2, 0.0, 0.0}), Eigen::Vector3d::Zero()} * first.inverse() * pose.T_world_body;
  }
  write_tum(file("truth.tum"), truth);
  fs::remove(file("truth.csv"));
  auto summary = nlohmann::ordered_json::parse(testing::read_text(file("summary.json")));
  const double rmse = summary["attitude_rmse_deg"];
  summary["attitude_rmse_deg"] = 69.0;
  summary["anees"] = 7e5;
  for (const char* const key : {"answer", "truth_is_level", "truth_tilt_deg"}) {
    summary.erase(key);
  }
  testing::write_text(file("summary.json"), summary.dump());
  const ReportDocument document = run_report(folder_.path());
  EXPECT_THAT(document.answer->sentences.back(), HasSubstr("aligned"));
  EXPECT_EQ(document.facts[1].name, "attitude RMSE, aligned");
  EXPECT_NEAR(std::stod(document.facts[1].value), rmse, 0.5);
  EXPECT_LT(std::stod(document.facts[3].value), 100.0);
}

TEST_F(RunReport, SaysNothingOfErrorsWithoutTruth) {
  Recording recording = testing::short_recording();
  recording.truth.motion.states.clear();
  navigate(recording, StartMode::kAuto);
  const ReportDocument document = run_report(folder_.path());
  const ReportFigure& position = figure(document, "position-error");
  EXPECT_EQ(find_trace(position, "error"), nullptr);
  EXPECT_NE(find_trace(position, "+3 sigma"), nullptr);
  EXPECT_EQ(find_trace(figure(document, "path"), "truth"), nullptr);
  EXPECT_EQ(document.sections[1].title, "Uncertainty");
  for (const ReportFact& fact : document.facts) {  // what is not known is left out
    EXPECT_THAT(fact.name, ::testing::Not(HasSubstr("RMSE")));
  }
}

TEST_F(RunReport, DrawsInnovationsPerDegreeOfFreedomWithinTheirBand) {
  navigate(testing::short_recording());
  const ReportDocument document = run_report(folder_.path());
  const ReportFigure& nis = figure(document, "nis");
  const ReportTrace& values = nis.traces[0];
  const ReportTrace& upper = nis.traces[1];
  const ReportTrace& lower = nis.traces[2];
  std::size_t inside = 0;
  for (std::size_t n = 0; n < record_.frames.size(); ++n) {
    EXPECT_NEAR(values.y[n], record_.frames[n].nis / static_cast<double>(record_.frames[n].dof), 1e-9);
    EXPECT_LT(lower.y[n], 1.0);
    EXPECT_GT(upper.y[n], 1.0);
    inside += values.y[n] > lower.y[n] && values.y[n] < upper.y[n] ? 1 : 0;
  }
  // Binomial(41, 0.95): fewer than 34 within has a probability of 0.0003. One seed, so it cannot flicker.
  EXPECT_GE(inside, 34u);
}

TEST_F(RunReport, DrawsTheCalibrationWhereItWasWatched) {
  navigate(degraded_recording());
  const ReportDocument document = run_report(folder_.path());
  EXPECT_EQ(std::get<ReportText>(document.sections[4].blocks[0]).text,
            "Verdict: degraded.");  // case (ii): 5 %
  const ReportFigure& effect = figure(document, "health-effect");
  for (const char* const name : {"size", "ok", "wrong"}) {
    EXPECT_NE(find_trace(effect, name, 1), nullptr) << name;
  }
  const ReportFigure& rotation = figure(document, "health-rotation");
  ASSERT_NE(find_trace(rotation, "offset", 2), nullptr);
  EXPECT_NE(find_trace(rotation, "upper", 2), nullptr);
  fs::remove(file("health.csv"));
  EXPECT_THAT(section_ids(run_report(folder_.path())), ::testing::Not(::testing::Contains("calibration")));
}

TEST_F(RunReport, DrawsWhatWasEstimatedOfTheCalibration) {
  navigate(testing::short_recording());
  EXPECT_THAT(section_ids(run_report(folder_.path())), ::testing::Not(::testing::Contains("estimated")));
  RunOptions options;
  options.start = StartMode::kGroundTruth;
  options.method = Method::kEkf;
  options.estimated(first_of(ParameterBlock::kCam1)) = 1.0;
  options.estimated(first_of(ParameterBlock::kCam1) + 5) = 1e-3;
  navigate(testing::short_recording(), options);
  const ReportDocument document = run_report(folder_.path());
  const ReportFigure& focal = figure(document, "estimated-4");
  ASSERT_EQ(focal.y.size(), 1U);
  EXPECT_EQ(focal.y[0].title, "fu1");
  const ReportTrace* fu = find_trace(focal, "estimate");
  ASSERT_EQ(fu->y.size(), record_.calibration.size());
  EXPECT_NEAR(fu->y.back(), record_.calibration.back().estimate.error(first_of(ParameterBlock::kCam1)), 1e-9);
  EXPECT_EQ(figure(document, "estimated-5").y[0].unit, "s");
  std::ofstream(file("calibration.csv")) << "1,2,3\n";
  EXPECT_EQ(data_error_of([&] { (void)run_report(folder_.path()); }).line(), 1U);
  navigate(testing::short_recording());  // an older run's file must not stay
  EXPECT_FALSE(fs::exists(file("calibration.csv")));
}

TEST_F(RunReport, TellsOptionsAndNotes) {
  navigate(testing::short_recording());
  const ReportDocument document = run_report(folder_.path());
  const std::string json = report_json(document);
  EXPECT_THAT(json, HasSubstr(R"({"name":"landmarks","value":"inverse-depth"})"));
  EXPECT_THAT(json, HasSubstr(record_.notes.front()));
}

TEST_F(RunReport, NamesTheFileThatIsMissingOrBroken) {
  navigate(testing::short_recording());
  for (const char* const name : {"summary.json", "trajectory.csv", "frames.csv", "landmarks.ply"}) {
    const std::string before = testing::read_text(file(name));
    fs::remove(file(name));
    EXPECT_EQ(data_error_of([&] { (void)run_report(folder_.path()); }).file(), file(name).string());
    testing::write_text(file(name), "{\"broken");
    EXPECT_EQ(data_error_of([&] { (void)run_report(folder_.path()); }).file(), file(name).string());
    testing::write_text(file(name), before);
  }
  EXPECT_NO_THROW((void)run_report(folder_.path()));
}

TEST_F(RunReport, RefusesFilesOfDifferentRuns) {
  navigate(testing::short_recording());
  std::string frames = testing::read_text(file("frames.csv"));
  frames.erase(frames.rfind('\n', frames.size() - 2) + 1);
  testing::write_text(file("frames.csv"), frames);
  const DataError error = data_error_of([&] { (void)run_report(folder_.path()); });
  EXPECT_EQ(error.file(), file("frames.csv").string());
  EXPECT_THAT(error.what(), HasSubstr("41 frames"));
}

}  // namespace
}  // namespace limber
