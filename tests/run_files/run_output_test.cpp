// SPDX-License-Identifier: MIT
#include "limber/run_files/run_output.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "datasets/files.hpp"
#include "limber/core/so3.hpp"
#include "limber/run_files/calibration_file.hpp"
#include "limber/run_files/frames_file.hpp"
#include "run_files/judged_run.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

using ::testing::UnorderedElementsAre;
using Json = nlohmann::json;
using testing::files_in;
using testing::Judged;
using testing::short_recording;
using testing::TemporaryFolder;
using testing::without_truth;

TEST(WriteRunOutput, WritesEveryFileAndNothingElse) {
  const TemporaryFolder folder;
  const Judged run(short_recording());
  const fs::path out = folder.path() / "a" / "b";
  write_run_output(out, run.options, run.record, run.summary);
  EXPECT_THAT(files_in(out), UnorderedElementsAre("trajectory.tum", "trajectory.csv", "truth.tum",
                                                  "truth.csv", "landmarks.ply", "frames.csv", "health.csv",
                                                  "refusals.csv", "summary.json"));
  const std::vector<TrajectoryRow> rows = read_trajectory_csv(out / "trajectory.csv");
  ASSERT_EQ(rows.size(), run.record.trajectory.size());
  EXPECT_EQ(rows.back().T_world_body.p, run.record.trajectory.back().T_world_body.p);
  EXPECT_EQ(rows.back().covariance, run.record.trajectory.back().covariance);
  EXPECT_EQ(read_tum(out / "trajectory.tum").size(), rows.size());
  const std::string frames = testing::read_text(out / "frames.csv");
  EXPECT_EQ(std::count(frames.begin(), frames.end(), '\n'), 42);
}

TEST(WriteRunOutput, LeavesTheTruthInTheWorldOfTheEstimate) {
  const TemporaryFolder folder;
  const Judged run(short_recording(), StartMode::kAuto);
  write_run_output(folder.path(), run.options, run.record, run.summary);
  const std::vector<StampedPose> truth = read_tum(folder.path() / "truth.tum");
  ASSERT_EQ(truth.size(), run.record.trajectory.size());
  const Pose& start = run.record.trajectory.front().T_world_body;
  EXPECT_NEAR((truth.front().T_world_body.p - start.p).norm(), 0.0, 1e-9);
  // Errors in this world are those of the summary, which was aligned at the first pose.
  double squares = 0.0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    squares += (truth[k].T_world_body.p - run.record.trajectory[k].T_world_body.p).squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(truth.size())), *run.summary.position_rmse_m, 1e-9);
}

TEST(WriteRunOutput, SaysHowAStartFromTheSensorsWent) {
  const TemporaryFolder folder;
  const Judged run(short_recording(), StartMode::kAuto);
  write_run_output(folder.path(), run.options, run.record, run.summary);
  const auto start = Json::parse(testing::read_text(folder.path() / "summary.json")).at("sensor_start");
  EXPECT_EQ(start.at("waited_s"), run.record.sensor_start->waited_s);
  EXPECT_GT(start.at("tilt_sigma_rad").get<double>(), 0.0);
  EXPECT_GT(start.at("scale_sigma").get<double>(), 0.0);
  EXPECT_EQ(start.at("clock_offset_s"), 1e-9 * static_cast<double>(run.record.start.clock_offset_ns));
  EXPECT_GT(start.at("clock_sigma_s").get<double>(), 0.0);
  const Judged told(short_recording());
  write_run_output(folder.path(), told.options, told.record, told.summary);
  EXPECT_TRUE(Json::parse(testing::read_text(folder.path() / "summary.json")).at("sensor_start").is_null());
}

TEST(WriteRunOutput, TakesAwayTheTruthOfAnOlderRun) {
  const TemporaryFolder folder;
  const Judged known(short_recording());
  write_run_output(folder.path(), known.options, known.record, known.summary);
  const Judged unknown(without_truth(), StartMode::kAuto);
  write_run_output(folder.path(), unknown.options, unknown.record, unknown.summary);
  EXPECT_FALSE(fs::exists(folder.path() / "truth.tum"));
  EXPECT_FALSE(fs::exists(folder.path() / "truth.csv"));
}

TEST(WriteRunOutput, LeavesVelocityAndBiasesOfTheTruthInTheWorldOfTheEstimate) {
  const TemporaryFolder folder;
  Recording turned = short_recording();
  const Eigen::Matrix3d R = so3_exp({0.0, 0.0, 1.0});
  for (GroundTruthState& state : turned.truth.motion.states) {
    state.p_world_body = R * state.p_world_body;
    state.v_world_body = R * state.v_world_body;
    state.R_world_body = R * state.R_world_body;
  }
  const Judged run(turned, StartMode::kAuto);
  write_run_output(folder.path(), run.options, run.record, run.summary);
  const GroundTruth truth = read_euroc_groundtruth(folder.path() / "truth.csv");
  const std::vector<TrajectoryRow> rows = read_trajectory_csv(folder.path() / "trajectory.csv");
  EXPECT_TRUE(truth.has_velocity && truth.has_biases);
  ASSERT_EQ(truth.states.size(), rows.size());
  EXPECT_LT((truth.states.back().v_world_body - *rows.back().v_world_body).norm(), 0.3);
  EXPECT_GT((R * truth.states.back().v_world_body - *rows.back().v_world_body).norm(), 0.5);
  EXPECT_EQ(truth.states.back().bias_accel, turned.truth.motion.states.back().bias_accel);
}

TEST(WriteRunOutput, KnowsHowSureTheFilterIsOfVelocityAndBiasesInEveryFrame) {
  for (const StartMode start : {StartMode::kGroundTruth, StartMode::kAuto}) {
    const Judged run(short_recording(), start);
    const GroundTruth& truth = run.summary.truth_motion;
    ASSERT_EQ(truth.states.size(), run.record.trajectory.size());
    for (std::size_t k = 0; k < truth.states.size(); ++k) {
      const TrajectoryRow& row = run.record.trajectory[k];
      ASSERT_TRUE(row.sigma_v && row.sigma_bias_gyro && row.sigma_bias_accel) << k;
      // Five sigma, of 41 frames and three axes: a false alarm in ten thousand.
      const Eigen::Vector3d error = truth.states[k].v_world_body - *row.v_world_body;
      EXPECT_LT((error.array() / row.sigma_v->array()).abs().maxCoeff(), 5.0) << k;
      const Eigen::Vector3d bias = truth.states[k].bias_gyro - *row.bias_gyro;
      EXPECT_LT((bias.array() / row.sigma_bias_gyro->array()).abs().maxCoeff(), 5.0) << k;
    }
  }
}

TEST(WriteRunOutput, LeavesOutMotionThatTheTruthDoesNotKnow) {
  const TemporaryFolder folder;
  Recording recording = short_recording();
  recording.truth.motion.has_velocity = recording.truth.motion.has_biases = false;
  const Judged run(recording);
  write_run_output(folder.path(), run.options, run.record, run.summary);
  EXPECT_TRUE(fs::exists(folder.path() / "truth.tum"));
  EXPECT_FALSE(fs::exists(folder.path() / "truth.csv"));
}

TEST(WriteRunOutput, SummaryHoldsWhatTheUserChose) {
  const TemporaryFolder folder;
  Judged run(short_recording());
  run.options.assume_error.head<6>() << 0.0, M_PI / 180.0, 0.0, 0.1, 0.0, 0.0;
  write_run_output(folder.path(), run.options, run.record, run.summary);
  const Json options = Json::parse(testing::read_text(folder.path() / "summary.json"))["options"];
  EXPECT_EQ(options["method"], "lcekf");
  EXPECT_TRUE(options["constraints"].is_null());
  EXPECT_NEAR(options["assume_error_deg_m"][1].get<double>(), 1.0, 1e-12);
  EXPECT_EQ(options["assume_error_deg_m"][3], 0.1);
  EXPECT_EQ(options["init"], "groundtruth");
}

TEST(CalibrationCsv, GivesBackWhatWasWritten) {
  const TemporaryFolder folder;
  std::vector<CalibrationRow> rows(2);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    rows[n].t_ns = 50 + static_cast<std::int64_t>(n);
    for (const std::size_t k : {0U, 3U, 6U, 17U, 20U}) {
      rows[n].estimate.parameters.set(k);
      rows[n].estimate.error(static_cast<Eigen::Index>(k)) = 0.001 * static_cast<double>(k + n);
      rows[n].estimate.sigma(static_cast<Eigen::Index>(k)) = 0.5 + static_cast<double>(k);
    }
  }
  write_calibration_csv(folder.path() / "calibration.csv", rows);
  EXPECT_EQ(testing::read_text(folder.path() / "calibration.csv").substr(0, 31),
            "#t_ns,ax [deg],sigma_ax [deg],a");
  const std::vector<CalibrationRow> read = read_calibration_csv(folder.path() / "calibration.csv");
  ASSERT_EQ(read.size(), rows.size());
  for (std::size_t n = 0; n < rows.size(); ++n) {
    EXPECT_EQ(read[n].t_ns, rows[n].t_ns);
    EXPECT_EQ(read[n].estimate.parameters, rows[n].estimate.parameters);
    EXPECT_TRUE(read[n].estimate.error.isApprox(rows[n].estimate.error, 1e-14));
    EXPECT_TRUE(read[n].estimate.sigma.isApprox(rows[n].estimate.sigma, 1e-14));
  }
}

TEST(WriteRunOutput, SummaryHoldsWhatWasEstimated) {
  const TemporaryFolder folder;
  Judged run(short_recording());
  write_run_output(folder.path(), run.options, run.record, run.summary);
  EXPECT_TRUE(Json::parse(testing::read_text(folder.path() / "summary.json"))["estimated"].is_null());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "calibration.csv"));
  CalibrationRow row;
  row.t_ns = 5;
  row.estimate.parameters.set(17);
  row.estimate.error(17) = 0.002;
  row.estimate.sigma(17) = 0.001;
  run.record.calibration = {row};
  run.options.estimated(17) = 0.002;
  write_run_output(folder.path(), run.options, run.record, run.summary);
  const Json json = Json::parse(testing::read_text(folder.path() / "summary.json"));
  EXPECT_EQ(json["estimated"]["dt1"]["error"], 0.002);
  EXPECT_EQ(json["estimated"]["dt1"]["sigma"], 0.001);
  EXPECT_EQ(json["estimated"]["dt1"]["unit"], "s");
  EXPECT_EQ(json["options"]["estimate"], "dt1=0.002");
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "calibration.csv"));
}

TEST(ReadFramesCsv, GivesBackWhatWasWritten) {
  const TemporaryFolder folder;
  const Judged run(short_recording());
  write_run_output(folder.path(), run.options, run.record, run.summary);
  const std::vector<FrameRow> rows = read_frames_csv(folder.path() / "frames.csv");
  ASSERT_EQ(rows.size(), run.record.frames.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const FrameReport& frame = run.record.frames[k];
    EXPECT_EQ(rows[k].t_ns, frame.t_ns);
    EXPECT_EQ(rows[k].used, frame.used);
    EXPECT_EQ(rows[k].initialized, frame.initialized);
    EXPECT_EQ(rows[k].refused, frame.refused.size());
    EXPECT_EQ(rows[k].nis, frame.nis);
    EXPECT_EQ(static_cast<Eigen::Index>(rows[k].dof), frame.dof);
    EXPECT_EQ(rows[k].status, frame.status);
    EXPECT_EQ(rows[k].inputs, frame.inputs.status);
    EXPECT_NEAR(rows[k].gap_s, frame.inputs.gap_s, 1e-6);
    EXPECT_EQ(rows[k].reset, frame.reset);
    EXPECT_NEAR(rows[k].sigma_px, frame.sigma_px, 1e-3);
    EXPECT_NEAR(rows[k].inputs_chi2, frame.inputs.chi2, 1e-3 * frame.inputs.chi2);
    EXPECT_NEAR(rows[k].imu_noise.gyro, frame.imu_noise.gyro, 1e-3);
    EXPECT_NEAR(rows[k].imu_noise.accel, frame.imu_noise.accel, 1e-3);
    EXPECT_NEAR(rows[k].filter_ms, run.record.frame_ms[k], 1e-3);
  }
  EXPECT_EQ(rows.back().sigma_px, 0.5);  // stated
  EXPECT_GT(rows.back().inputs_chi2, 0.0);
}

TEST(ReadFramesCsv, ReadsFilesThatDoNotSayTheNoiseOfPixels) {
  const TemporaryFolder folder;
  const fs::path file = testing::write_text(folder.path() / "frames.csv",
                                            "#head\n0,1,1,0,0,0,0,1.5,4,0,updated,sound,0,0,0,0.1,0.2\n");
  const FrameRow row = read_frames_csv(file).at(0);
  EXPECT_EQ(row.sigma_px, 0.0);
  EXPECT_EQ(row.filter_ms, 0.1);
  EXPECT_EQ(row.source_ms, 0.2);
}

TEST(ReadFramesCsv, ReadsFilesThatDoNotSayTheNoiseOfAnImu) {
  const TemporaryFolder folder;
  const fs::path file = testing::write_text(
      folder.path() / "frames.csv", "#head\n0,1,1,0,0,0,0,1.5,4,0,updated,sound,0,0,0,0.5,2.5,0.1,0.2\n");
  const FrameRow row = read_frames_csv(file).at(0);
  EXPECT_EQ(row.sigma_px, 0.5);
  EXPECT_EQ(row.inputs_chi2, 2.5);
  EXPECT_EQ(row.imu_noise.gyro, 1.0);
  EXPECT_EQ(row.filter_ms, 0.1);
  EXPECT_EQ(row.source_ms, 0.2);
}

TEST(ReadFramesCsv, NamesTheLineThatIsWrong) {
  const TemporaryFolder folder;
  const fs::path file = testing::write_text(folder.path() / "frames.csv",
                                            "#head\n0,1,1,0,0,0,0,1.5,4,0,updated,sound,0,0,0,0.1,0.1\n"
                                            "5,1,-1,0,0,0,0,1.5,4,0,updated,sound,0,0,0,0.1,0.1\n");
  const DataError error = testing::data_error_of([&] { (void)read_frames_csv(file); });
  EXPECT_EQ(error.line(), 3u);
  EXPECT_THAT(error.what(), ::testing::HasSubstr("a count"));
  testing::write_text(file, "#head\n0,1,1,0,0,0,0,1.5,4,0,updated,sund,0,0,0,0.1,0.1\n");
  const DataError status = testing::data_error_of([&] { (void)read_frames_csv(file); });
  EXPECT_EQ(status.line(), 2u);
  EXPECT_THAT(status.what(), ::testing::HasSubstr("not needed, sound, faulty, gap, contradicted, none"));
}

TEST(WriteRunOutput, GivesEveryRowOfATableAsManyCellsAsItsHeader) {
  const TemporaryFolder folder;
  Judged run(short_recording());
  run.record.frames[2].refused.push_back({17, RefusalReason::kGate, 30.0, 18.5});
  write_run_output(folder.path(), run.options, run.record, run.summary);
  for (const char* const name : {"frames.csv", "refusals.csv"}) {
    std::ifstream file(folder.path() / name);
    std::string header, line;
    std::getline(file, header);
    std::size_t lines = 0;
    for (; std::getline(file, line); ++lines) {
      EXPECT_EQ(std::count(line.begin(), line.end(), ','), std::count(header.begin(), header.end(), ','));
    }
    EXPECT_GT(lines, 0u) << name;
  }
}

TEST(WriteRunOutput, SummaryHasEveryAgreedKey) {
  const TemporaryFolder folder;
  const Judged run(short_recording());
  write_run_output(folder.path(), run.options, run.record, run.summary);
  const Json json = Json::parse(testing::read_text(folder.path() / "summary.json"));
  for (const char* const key :
       {"method", "frames", "duration_s", "path_length_m", "ate_m", "position_rmse_m", "attitude_rmse_deg",
        "anees", "ms_per_frame", "realtime_factor", "peak_rss_mb", "health", "seed"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  for (const char* const key : {"none", "se3", "sim3", "scale"}) {
    EXPECT_TRUE(json["ate_m"][key].is_number()) << key;
  }
  EXPECT_TRUE(json["ms_per_frame"]["p50"].is_number());
  EXPECT_TRUE(json["ms_per_frame"]["p99"].is_number());
  for (const char* const key :
       {"verdict", "changed_s", "comes_and_goes", "present", "past", "false_alarms_per_hour"}) {
    EXPECT_TRUE(json["health"].contains(key)) << key;
  }
  EXPECT_EQ(json["seed"], 7);
  EXPECT_EQ(json["position_rmse_m"], *run.summary.position_rmse_m);
  EXPECT_EQ(json["notes"].get<std::vector<std::string>>(), run.record.notes);
}

TEST(WriteRunOutput, SummaryIsNullWhereNothingIsKnown) {
  const TemporaryFolder folder;
  const Judged run(without_truth(), StartMode::kAuto);
  write_run_output(folder.path(), run.options, run.record, run.summary);
  const Json json = Json::parse(testing::read_text(folder.path() / "summary.json"));
  for (const char* const key : {"position_rmse_m", "attitude_rmse_deg", "anees"}) {
    EXPECT_TRUE(json.at(key).is_null()) << key;
  }
  for (const char* const key : {"none", "se3", "sim3", "scale"}) {
    EXPECT_TRUE(json["ate_m"].at(key).is_null()) << key;
  }
}

TEST(WriteRunOutput, RefusesAFolderThatCannotBeMade) {
  const TemporaryFolder folder;
  const Judged run(short_recording());
  const fs::path file = testing::write_text(folder.path() / "file", "mine");
  for (const fs::path& out : {file, file / "below"}) {
    const DataError error =
        testing::data_error_of([&] { write_run_output(out, run.options, run.record, run.summary); });
    EXPECT_EQ(error.file(), out.string());
  }
  EXPECT_THAT(files_in(folder.path()), UnorderedElementsAre("file"));
  EXPECT_EQ(testing::read_text(file), "mine");
}

TEST(WriteRunOutput, WritesNothingWhereOneFileCannotBeWritten) {
  const TemporaryFolder folder;
  const Judged run(short_recording());
  // A folder stands where the last file should go: no summary without the rest, and no half of one.
  fs::create_directories(folder.path() / "summary.json" / "occupied");
  (void)testing::data_error_of(
      [&] { write_run_output(folder.path(), run.options, run.record, run.summary); });
  EXPECT_THAT(files_in(folder.path()), UnorderedElementsAre("summary.json"));
}

TEST(WriteRunOutput, LeavesNothingOnAFullDisk) {
  const TemporaryFolder folder;
  const Judged run(short_recording());
  {
    const testing::SmallDisk disk;
    const DataError error = testing::data_error_of(
        [&] { write_run_output(folder.path() / "new", run.options, run.record, run.summary); });
    EXPECT_NE(std::string(error.what()).find("room to write the file"), std::string::npos) << error.what();
  }
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(WriteRunOutput, ReplacesTheResultsOfAnOlderRunAndLeavesOtherFilesAlone) {
  const TemporaryFolder folder;
  testing::write_text(folder.path() / "summary.json", "old");
  testing::write_text(folder.path() / "notes.txt", "mine");
  const Judged run(short_recording());
  write_run_output(folder.path(), run.options, run.record, run.summary);
  EXPECT_EQ(Json::parse(testing::read_text(folder.path() / "summary.json"))["frames"], 41);
  EXPECT_EQ(testing::read_text(folder.path() / "notes.txt"), "mine");
}

}  // namespace
}  // namespace limber
