// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "cli/run_program.hpp"
#include "limber/core/so3.hpp"
#include "limber/datasets/trajectory_files.hpp"
#include "real_data.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using testing::run_limber;
using ::testing::StartsWith;
using testing::TemporaryFolder;
using testing::write_text;

using Json = nlohmann::json;

Json evaluation(const fs::path& estimate, const fs::path& truth, std::vector<std::string> more = {}) {
  std::vector<std::string> arguments = {"evaluate", estimate.string(), truth.string(), "--json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const auto result = run_limber(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, IsEmpty());
  return Json::parse(result.out);
}

// A circle of 10 m radius in 4 s, seen at 20 Hz, starting at t0.
std::vector<StampedPose> circle(double radius = 10.0, std::int64_t t0_ns = 1'403'636'579'763'555'584) {
  std::vector<StampedPose> poses;
  for (std::int64_t i = 0; i <= 80; ++i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / 80.0;
    poses.push_back(
        {t0_ns + i * 50'000'000,
         {so3_exp({0.0, 0.0, angle}), {radius * std::cos(angle), radius * std::sin(angle), 1.0}}});
  }
  return poses;
}

// The same as a trajectory.csv, 0.1 m wrong in x with a sigma of 0.05 m and 0.01 rad.
std::vector<TrajectoryRow> wrong_rows() {
  std::vector<TrajectoryRow> rows;
  for (const StampedPose& pose : circle()) {
    TrajectoryRow row;
    row.t_ns = pose.t_ns;
    row.T_world_body = pose.T_world_body;
    row.T_world_body.p.x() -= 0.1;
    row.covariance.emplace(Eigen::Matrix<double, 6, 6>::Identity() * 1e-4);
    row.covariance->topLeftCorner<3, 3>() *= 25.0;
    rows.push_back(row);
  }
  return rows;
}

std::string euroc_text(const std::vector<StampedPose>& poses) {
  std::ostringstream text;
  text.precision(17);
  text << "#timestamp [ns],p_x,p_y,p_z,q_w,q_x,q_y,q_z\n";
  for (const StampedPose& pose : poses) {
    const Eigen::Quaterniond q(pose.T_world_body.R);
    const Eigen::Vector3d& p = pose.T_world_body.p;
    text << pose.t_ns << ',' << p.x() << ',' << p.y() << ',' << p.z() << ',' << q.w() << ',' << q.x() << ','
         << q.y() << ',' << q.z() << '\n';
  }
  return text.str();
}

std::string kitti_text(const std::vector<StampedPose>& poses) {
  std::ostringstream text;
  text.precision(17);
  for (const StampedPose& pose : poses) {
    for (Eigen::Index r = 0; r < 3; ++r) {
      text << pose.T_world_body.R.row(r) << ' ' << pose.T_world_body.p(r) << (r < 2 ? ' ' : '\n');
    }
  }
  return text.str();
}

TEST(EvaluateCommand, ComparesTumWithEuroc) {
  const TemporaryFolder folder;
  const fs::path estimate = folder.path() / "estimate.tum";
  write_tum(estimate, circle(8.0));
  const fs::path truth = write_text(folder.path() / "truth.csv", euroc_text(circle(10.0)));
  const Json json = evaluation(estimate, truth);
  EXPECT_EQ(json["matched"], 81);
  EXPECT_EQ(json["matched_by"], "time");
  EXPECT_NEAR(json["duration_s"].get<double>(), 4.0, 1e-9);
  EXPECT_NEAR(json["ate_m"]["none"].get<double>(), 2.0, 1e-9);
  EXPECT_NEAR(json["ate_m"]["sim3"].get<double>(), 0.0, 1e-9);
  EXPECT_NEAR(json["ate_m"]["scale"].get<double>(), 1.25, 1e-9);
  EXPECT_NEAR(json["ape"]["none"]["rotation_deg"]["max"].get<double>(), 0.0, 1e-6);
  // A chord of the small circle against one of the large.
  const double chord = 2.0 * std::sin(std::numbers::pi / 80.0);
  EXPECT_NEAR(json["rpe"]["1_frame"]["translation_m"]["rmse"].get<double>(), 2.0 * chord, 1e-9);
  EXPECT_EQ(json["rpe"]["1_frame"]["translation_m"]["count"], 80);
  EXPECT_TRUE(json["rpe"]["distance"].is_null());
  EXPECT_TRUE(json["anees"].is_null());
}

TEST(EvaluateCommand, GivesNeesOfARunFolderAgainstARecordingFolder) {
  const TemporaryFolder folder;
  fs::create_directories(folder.path() / "run");
  write_trajectory_csv(folder.path() / "run" / "trajectory.csv", wrong_rows());
  write_text(folder.path() / "rig" / "mav0" / "state_groundtruth_estimate0" / "data.csv",
             euroc_text(circle()));
  const Json json = evaluation(folder.path() / "run", folder.path() / "rig");
  EXPECT_NEAR(json["ate_m"]["none"].get<double>(), 0.1, 1e-9);
  EXPECT_NEAR(json["ape"]["first_pose"]["translation_m"]["rmse"].get<double>(), 0.0, 1e-9);
  // (0.1 / 0.05)^2 = 4, over six d.o.f. and over three; aligned at the first pose nothing is wrong any more.
  EXPECT_NEAR(json["anees"]["none"]["pose"].get<double>(), 4.0 / 6.0, 1e-9);
  EXPECT_NEAR(json["anees"]["none"]["position"].get<double>(), 4.0 / 3.0, 1e-9);
  EXPECT_NEAR(json["anees"]["none"]["attitude"].get<double>(), 0.0, 1e-9);
  EXPECT_EQ(json["anees"]["none"]["frames"], 60);  // later than 1 s
  EXPECT_NEAR(json["anees"]["first_pose"]["pose"].get<double>(), 0.0, 1e-9);

  const auto inside =
      run_limber({"evaluate", (folder.path() / "run").string(), (folder.path() / "rig/mav0").string()});
  EXPECT_EQ(inside.exit_code, 0) << inside.err;
  EXPECT_THAT(inside.out, HasSubstr("Consistency"));
}

TEST(EvaluateCommand, TakesOutTheTiltOfAWorldThatIsNotLevel) {
  const TemporaryFolder folder;
  write_trajectory_csv(folder.path() / "run.csv", wrong_rows());
  std::vector<StampedPose> askew = circle();
  const Pose T_side_level{so3_exp({1.2, 0.0, 0.0}) * so3_exp({0.0, 0.0, 0.4}), {1.0, 2.0, 3.0}};
  for (StampedPose& pose : askew) {
    pose.T_world_body = T_side_level * pose.T_world_body;
  }
  write_tum(folder.path() / "askew.tum", askew);
  write_tum(folder.path() / "level.tum", circle());
  const Json json = evaluation(folder.path() / "run.csv", folder.path() / "askew.tum");
  EXPECT_NEAR(json["tilt_deg"].get<double>(), 1.2 * 180.0 / std::numbers::pi, 1e-6);
  EXPECT_GT(json["ape"]["first_pose"]["rotation_deg"]["rmse"].get<double>(), 60.0);
  EXPECT_NEAR(json["ape"]["upright"]["rotation_deg"]["rmse"].get<double>(), 0.0, 1e-5);
  EXPECT_NEAR(json["ape"]["upright"]["translation_m"]["rmse"].get<double>(), 0.0, 1e-9);
  EXPECT_NEAR(json["anees"]["upright"]["pose"].get<double>(), 0.0, 1e-9);
  const auto text =
      run_limber({"evaluate", (folder.path() / "run.csv").string(), (folder.path() / "askew.tum").string()});
  EXPECT_THAT(text.out, HasSubstr("tilt          68.8 deg between the verticals"));

  const Json level = evaluation(folder.path() / "run.csv", folder.path() / "level.tum");
  EXPECT_NEAR(level["tilt_deg"].get<double>(), 0.0, 1e-6);
  EXPECT_TRUE(level["ape"]["upright"].is_null());
  EXPECT_TRUE(level["anees"]["upright"].is_null());
}

TEST(EvaluateCommand, AgreesWithARunBesideARealTruthThatIsNotLevel) {
  LIMBER_NEED_DATA(april, "track_logs/euroc_imu_april");
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "run";
  const auto run = run_limber({"run", april.string(), "--max-points", "40", "--out", out.string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("the world of the truth is not level, its vertical is 7"));
  const Json summary = Json::parse(testing::read_text(out / "summary.json"));
  EXPECT_EQ(summary["truth_is_level"], false);
  EXPECT_LT(summary["attitude_rmse_deg"], 1.5);  // 77 deg with the tilt in it
  EXPECT_LT(summary["position_rmse_m"], 2.0 * summary["ate_m"]["se3"].get<double>());
  EXPECT_LT(summary["anees"], 100.0);  // 7.6e5
  const Json evaluated = evaluation(out, april);
  const auto expect_equal = [](const Json& a, const Json& b) {
    EXPECT_NEAR(a.get<double>(), b.get<double>(), 1e-6 * std::abs(b.get<double>()));
  };
  expect_equal(evaluated["tilt_deg"], summary["truth_tilt_deg"]);
  expect_equal(evaluated["ape"]["upright"]["translation_m"]["rmse"], summary["position_rmse_m"]);
  expect_equal(evaluated["ape"]["upright"]["rotation_deg"]["rmse"], summary["attitude_rmse_deg"]);
  expect_equal(evaluated["anees"]["upright"]["pose"], summary["anees"]);
}

TEST(EvaluateCommand, SaysHowErrorsGrowWithTheDistance) {
  const TemporaryFolder folder;
  write_tum(folder.path() / "estimate.tum", circle(9.0));
  write_tum(folder.path() / "truth.tum", circle(10.0));
  const Json errors =
      evaluation(folder.path() / "estimate.tum", folder.path() / "truth.tum")["rpe"]["over_distance"];
  ASSERT_EQ(errors.size(), 4U);  // of 63 m: 2, 5, 10 and 20; no two frames are 1 m apart
  EXPECT_EQ(errors[2]["distance_m"], 10.0);
  const Json ten = evaluation(folder.path() / "estimate.tum", folder.path() / "truth.tum",
                              {"--rpe-distance", "10"})["rpe"]["distance"];
  EXPECT_EQ(errors[2]["pieces"], ten["translation_m"]["count"]);
  EXPECT_NEAR(errors[2]["position_percent"]["mean"].get<double>(),
              10.0 * ten["translation_m"]["mean"].get<double>(), 1e-9);
  const auto text = run_limber(
      {"evaluate", (folder.path() / "estimate.tum").string(), (folder.path() / "truth.tum").string()});
  EXPECT_THAT(text.out, HasSubstr("Relative error over distance"));
}

TEST(EvaluateCommand, LeavesRowsWithoutCovarianceOutOfTheNees) {
  const TemporaryFolder folder;
  auto rows = wrong_rows();
  for (std::size_t i = 0; i < 70; ++i) {
    rows[i].covariance.reset();
  }
  write_trajectory_csv(folder.path() / "trajectory.csv", rows);
  write_tum(folder.path() / "truth.tum", circle());
  Json json = evaluation(folder.path() / "trajectory.csv", folder.path() / "truth.tum");
  EXPECT_EQ(json["anees"]["none"]["frames"], 11);
  EXPECT_EQ(json["anees"]["none"]["frames_refused"], 0);

  rows.back().covariance->setConstant(-1.0);
  write_trajectory_csv(folder.path() / "trajectory.csv", rows);
  json = evaluation(folder.path() / "trajectory.csv", folder.path() / "truth.tum");
  EXPECT_EQ(json["anees"]["none"]["frames"], 10);
  EXPECT_EQ(json["anees"]["none"]["frames_refused"], 1);
}

TEST(EvaluateCommand, MatchesFilesWithoutTimesLineByLine) {
  const TemporaryFolder folder;
  const fs::path estimate = write_text(folder.path() / "estimate.txt", kitti_text(circle(9.0)));
  const fs::path truth = write_text(folder.path() / "truth.txt", kitti_text(circle(10.0)));
  const Json json = evaluation(estimate, truth, {"--rpe-distance", "20"});
  EXPECT_EQ(json["matched_by"], "index");
  EXPECT_TRUE(json["duration_s"].is_null());
  EXPECT_NEAR(json["ate_m"]["none"].get<double>(), 1.0, 1e-9);
  EXPECT_FALSE(json["rpe"]["distance"].is_null());
  EXPECT_EQ(json["rpe"]["distance_m"], 20.0);

  auto shorter = circle();
  shorter.pop_back();
  const fs::path short_truth = write_text(folder.path() / "short.txt", kitti_text(shorter));
  const auto result = run_limber({"evaluate", estimate.string(), short_truth.string()});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("81 poses"));
  EXPECT_THAT(result.err, HasSubstr("80"));
}

TEST(EvaluateCommand, SaysWhatAStraightLineDoesNotTell) {
  const TemporaryFolder folder;
  std::vector<StampedPose> line;
  for (std::int64_t i = 0; i < 30; ++i) {
    line.push_back({i * 50'000'000, {Eigen::Matrix3d::Identity(), {static_cast<double>(i), 0.0, 0.0}}});
  }
  write_tum(folder.path() / "line.tum", line);
  const std::string path = (folder.path() / "line.tum").string();
  const Json json = evaluation(path, path);
  EXPECT_TRUE(json["ate_m"]["se3"].is_null());
  EXPECT_TRUE(json["ate_m"]["scale"].is_null());
  EXPECT_EQ(json["ape"]["se3"]["alignment"], "all positions lie on a straight line");
  const auto table = run_limber({"evaluate", path, path});
  EXPECT_THAT(table.out, HasSubstr("not determined: all positions lie on a straight line"));
  EXPECT_THAT(table.out, Not(HasSubstr("nan")));
}

TEST(EvaluateCommand, ReportsTrajectoriesThatDoNotMeetInTime) {
  const TemporaryFolder folder;
  write_tum(folder.path() / "a.tum", circle(10.0, 0));
  write_tum(folder.path() / "b.tum", circle(10.0, 3'600'000'000'000));
  const auto result =
      run_limber({"evaluate", (folder.path() / "a.tum").string(), (folder.path() / "b.tum").string()});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.out, IsEmpty());
  EXPECT_THAT(result.err, HasSubstr("0.000 s to 4.000 s"));
  EXPECT_THAT(result.err, HasSubstr("3600.000 s to 3604.000 s"));
  EXPECT_THAT(result.err, HasSubstr("--max-time-difference"));
}

TEST(EvaluateCommand, WritesTheSameJsonToAFile) {
  const TemporaryFolder folder;
  write_tum(folder.path() / "a.tum", circle());
  const std::string path = (folder.path() / "a.tum").string(), out = (folder.path() / "out.json").string();
  const auto table = run_limber({"evaluate", path, path, "--out", out});
  EXPECT_EQ(table.exit_code, 0);
  EXPECT_THAT(table.out, StartsWith("estimate "));
  const auto printed = run_limber({"evaluate", path, path, "--json"});
  EXPECT_EQ(testing::read_text(out), printed.out);
}

TEST(EvaluateCommand, FailsOnBadFilesAndLeavesNothingBehind) {
  const TemporaryFolder folder;
  write_tum(folder.path() / "good.tum", circle());
  const std::string good = (folder.path() / "good.tum").string();
  const TemporaryFolder outputs;
  const std::string out = (outputs.path() / "out.json").string();
  struct BadFile {
    std::string content, message;
  };
  for (const BadFile& bad :
       {BadFile{"0 0 0 0 0 0 0 1\n1 0 0 nan 0 0 0 1\n", ":2: "}, BadFile{"0 0 0 0 0 0 0 1\n1 0 0\n", ":2: "},
        BadFile{"1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", ":2: "}, BadFile{"", "expected "},
        BadFile{std::string("\x7f"
                            "ELF\0\1\2",
                            7),
                "expected "},
        BadFile{"0 0 0 0 9 0 0 1\n", ":1: "},
        BadFile{"0 1e300 0 0 0 0 0 1\n", ":1: expected tx [m] within"}}) {
    const fs::path file = write_text(folder.path() / "bad.txt", bad.content);
    for (const auto& arguments : {std::vector<std::string>{file.string(), good}, {good, file.string()}}) {
      const auto result = run_limber({"evaluate", arguments[0], arguments[1], "--out", out});
      EXPECT_EQ(result.exit_code, 1) << bad.content;
      EXPECT_THAT(result.out, IsEmpty());
      EXPECT_THAT(result.err, StartsWith("limber: error: " + file.string()));
      EXPECT_THAT(result.err, HasSubstr(bad.message));
      EXPECT_THAT(testing::files_below(outputs.path()), IsEmpty());
    }
  }
}

TEST(EvaluateCommand, FailsOnFilesThatAreMissing) {
  const TemporaryFolder folder;
  write_tum(folder.path() / "good.tum", circle());
  const std::string good = (folder.path() / "good.tum").string();
  const std::string missing = (folder.path() / "missing.tum").string();
  const auto no_file = run_limber({"evaluate", missing, good});
  EXPECT_EQ(no_file.exit_code, 1);
  EXPECT_THAT(no_file.err, StartsWith("limber: error: " + missing));

  fs::create_directories(folder.path() / "empty");
  const auto empty_folder = run_limber({"evaluate", good, (folder.path() / "empty").string()});
  EXPECT_EQ(empty_folder.exit_code, 1);
  EXPECT_THAT(empty_folder.err, HasSubstr("expected "));
}

TEST(EvaluateCommand, FailsWhereTheOutputCannotBeWritten) {
  const TemporaryFolder folder;
  write_tum(folder.path() / "good.tum", circle());
  const std::string good = (folder.path() / "good.tum").string();
  const std::string out = (folder.path() / "no" / "such" / "folder.json").string();
  const auto result = run_limber({"evaluate", good, good, "--out", out});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.out, IsEmpty());
  EXPECT_THAT(result.err, HasSubstr(out));
  EXPECT_EQ(testing::files_below(folder.path()).size(), 1u);
}

TEST(EvaluateCommand, AgreesWithEvoOnARealDrive) {
  LIMBER_NEED_DATA(data, "trajectories");
  const Json evo = Json::parse(std::ifstream(data / "KITTI_00_ORB.evo.json")).at("results");
  const Json json = evaluation(data / "KITTI_00_ORB.txt", data / "KITTI_00_gt.txt");
  const auto expect_equal = [&](const Json& found, const std::string& entry) {
    for (const char* name : {"rmse", "mean", "median", "std", "min", "max", "sse"}) {
      const double size = evo.at(entry).at(name == std::string("sse") ? "sse" : "rmse").get<double>();
      EXPECT_NEAR(found.at(name).get<double>(), evo.at(entry).at(name).get<double>(), 1e-9 * size)
          << entry << " " << name;
    }
  };
  for (const std::string alignment : {"none", "se3", "sim3"}) {
    expect_equal(json["ape"][alignment]["translation_m"], "ape_translation_m_" + alignment);
    expect_equal(json["ape"][alignment]["rotation_deg"], "ape_rotation_deg_" + alignment);
  }
  expect_equal(json["rpe"]["1_frame"]["translation_m"], "rpe_translation_m_1_frame");
  expect_equal(json["rpe"]["1_frame"]["rotation_deg"], "rpe_rotation_deg_1_frame");
  expect_equal(json["rpe"]["distance"]["translation_m"], "rpe_translation_m_100_m_all_pairs");
  expect_equal(json["rpe"]["distance"]["rotation_deg"], "rpe_rotation_deg_100_m_all_pairs");
  EXPECT_NEAR(json["ate_m"]["scale"].get<double>(),
              evo["ape_translation_m_sim3"]["alignment_scale"].get<double>(), 1e-12);
}

}  // namespace
}  // namespace limber
