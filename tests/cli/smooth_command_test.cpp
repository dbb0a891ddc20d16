// SPDX-License-Identifier: MIT
#include <nlohmann/json.hpp>

#include "cli/small_log.hpp"
#include "limber/datasets/trajectory_files.hpp"
#include "limber/run_files/calibration_file.hpp"

namespace limber {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::Not;
using Json = nlohmann::json;
using testing::expect_refused;
using testing::files_below;
using testing::ProgramResult;
using testing::read_text;
using testing::run_limber;
using testing::write_text;

class SmoothCommand : public testing::SmallLog {
 protected:
  [[nodiscard]] ProgramResult smooth(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"smooth", log().string(), "--out", out().string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_limber(arguments);
  }
  [[nodiscard]] Json summary() const { return Json::parse(read_text(out() / "summary.json")); }
};

TEST_F(SmoothCommand, WritesTheFilesOfARun) {
  const ProgramResult result = smooth({"--theta", "constant"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(files_below(out()),
              IsSupersetOf({"trajectory.tum", "trajectory.csv", "truth.tum", "landmarks.ply", "frames.csv",
                            "calibration.csv", "refusals.csv", "summary.json"}));
  EXPECT_THAT(files_below(out()), Not(Contains("health.csv")));
  EXPECT_EQ(read_trajectory_csv(out() / "trajectory.csv").size(), 41u);
  EXPECT_EQ(summary()["method"], "smooth-constant");
  EXPECT_EQ(summary()["frames_of_recording"], 41);  // else no run counts as one of the same recording
}

TEST_F(SmoothCommand, FindsTheRigOfTheLogWithinItsSigma) {
  ASSERT_EQ(smooth({"--theta", "constant", "--init", "groundtruth"}).exit_code, 0);
  // The log is of case (ii): tx is off by 0.1 m.
  const Json tx = summary()["estimated"]["tx"];
  EXPECT_LT(tx["sigma"].get<double>(), 0.05);
  EXPECT_NEAR(tx["error"].get<double>(), 0.1, 4.0 * tx["sigma"].get<double>());
}

TEST_F(SmoothCommand, IsNoWorseThanTheFilterItBeganWith) {
  ASSERT_EQ(smooth({"--theta", "free", "--init", "groundtruth"}).exit_code, 0);
  const double smoothed = summary()["position_rmse_m"];
  ASSERT_EQ(run_again({"--method", "lcekf", "--init", "groundtruth"}).exit_code, 0);
  EXPECT_LE(smoothed, summary()["position_rmse_m"].get<double>());
}

TEST_F(SmoothCommand, AnswersEachFrameByWhatCameUntilThenIfAsked) {
  ASSERT_EQ(smooth({"--theta", "constant", "--init", "groundtruth", "--causal", "--window", "0.6"}).exit_code,
            0);
  EXPECT_EQ(read_trajectory_csv(out() / "trajectory.csv").size(), 41u);
  EXPECT_EQ(summary()["method"], "smooth-constant-causal");
  EXPECT_THAT(summary()["notes"].dump(), HasSubstr("smoothed over the 0.6 s before each of 41 frames"));
  const std::vector<CalibrationRow> rows = read_calibration_csv(out() / "calibration.csv");
  ASSERT_EQ(rows.size(), 41u);
  EXPECT_LT(rows.back().estimate.sigma(0), rows[1].estimate.sigma(0)) << "known ever better";
  const Json tx = summary()["estimated"]["tx"];
  EXPECT_NEAR(tx["error"].get<double>(), 0.1, 4.0 * tx["sigma"].get<double>());
}

TEST_F(SmoothCommand, KeepsOtherPeoplesFilesUnlessForced) {
  write_text(out() / "frames.csv", "mine");
  expect_refused(smooth({}), 1, "frames.csv: expected no file of this name");
  EXPECT_EQ(read_text(out() / "frames.csv"), "mine");
  EXPECT_EQ(smooth({"--force"}).exit_code, 0);
}

TEST_F(SmoothCommand, RefusesWhatItDoesNotKnow) {
  expect_refused(smooth({"--theta", "bent"}), 2, "piecewise:SECONDS");
  expect_refused(smooth({"--theta", "piecewise:0"}), 2, "piecewise:SECONDS");
  expect_refused(smooth({"--guess", "oracular"}), 2, "lcekf");
  expect_refused(smooth({"--soften", "theta"}), 2, "--soften");
  expect_refused(smooth({"--window", "2"}), 2, "--causal");
  expect_refused(smooth({"--causal", "--window", "0"}), 2, "--window");
}

}  // namespace
}  // namespace limber
