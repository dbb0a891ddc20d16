// SPDX-License-Identifier: MIT
#include <nlohmann/json.hpp>

#include "cli/child_process.hpp"
#include "cli/small_log.hpp"
#include "limber/report/write_report.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using testing::expect_refused;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::read_text;
using testing::write_text;

using RunMethods = testing::SmallLog;

std::size_t count_of(const std::string& words, const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) {
    ++count;
  }
  return count;
}

TEST_F(RunMethods, EachIsTheRunOfItsOwnAndTheTableThatOfCompare) {
  const auto result = run({"--methods", "LCEKF,ekf", "--constraints", "rotation"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  ASSERT_EQ(run_into(folder() / "single", {"--method", "ekf"}).exit_code, 0);
  EXPECT_EQ(read_text(out() / "ekf/trajectory.csv"), read_text(folder() / "single/trajectory.csv"));
  const auto summary = nlohmann::json::parse(read_text(out() / "lcekf/summary.json"));
  EXPECT_EQ(summary["options"]["constraints"], "rotation");
  EXPECT_EQ(result.out,
            testing::run_limber({"compare", (out() / "lcekf").string(), (out() / "ekf").string()}).out);
  EXPECT_THAT(result.out, AllOf(HasSubstr("2 runs on log"), HasSubstr("\nekf  lcekf  2")));
  if (can_write_reports()) {
    EXPECT_THAT(read_text(out() / "comparison.html"), HasSubstr("<title>2 runs on log</title>"));
    EXPECT_TRUE(fs::exists(out() / "ekf/report.html"));
  }
}

TEST_F(RunMethods, NotesAreSaidOnce) {
  fs::remove_all(mav0() / "imu0");
  fs::remove_all(mav0() / "odometry0");
  const auto result = run({"--methods", "ekf,lcekf"});
  EXPECT_EQ(count_of("neither IMU nor odometry", result.err), 1U) << result.err;
  EXPECT_THAT(result.err, HasSubstr("limber: lcekf: constraints rotation+direction"));
}

TEST_F(RunMethods, OneThatFailsLeavesTheOthers) {
  fs::remove_all(mav0() / "calibration_truth0");
  const auto result = run({"--methods", "oracle,ekf"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("error: oracle: log does not say what the true calibration is"));
  EXPECT_EQ(count_of("oracle", result.err), 1U);
  EXPECT_THAT(result.out, HasSubstr("1 run on log"));
  EXPECT_TRUE(fs::exists(out() / "ekf/summary.json"));
  EXPECT_FALSE(fs::exists(out() / "oracle"));
  fs::remove_all(mav0() / "state_groundtruth_estimate0");
  expect_refused(run_into(folder() / "no", {"--methods", "lcekf,ekf", "--init", "groundtruth"}), 1,
                 "error: lcekf, ekf: --init groundtruth: log has no ground truth");
}

TEST_F(RunMethods, RefuseWhatMakesNoSenseBeforeTheWork) {
  expect_refused(run({"--methods", "ekf,lcekff"}), 2, "unknown method 'lcekff' (did you mean lcekf?)");
  expect_refused(run({"--methods", "ekf,EKF"}), 2, "ekf is named twice");
  expect_refused(run({"--methods", "ekf", "--method", "lcekf"}), 2, "excludes");
  expect_refused(run({"--methods", "ekf,soft", "--constraints", "full"}), 2, "lcekf alone has constraints");
  EXPECT_FALSE(fs::exists(out()));
  write_text(out() / "lcekf/frames.csv", "mine");
  expect_refused(run({"--methods", "ekf,lcekf"}), 1, "lcekf/frames.csv: expected no file");
  EXPECT_FALSE(fs::exists(out() / "ekf"));
  fs::remove_all(out());
  write_text(out() / "comparison.html", "mine");
  expect_refused(run({"--methods", "ekf,lcekf"}), 1, "comparison.html: expected no file");
  EXPECT_EQ(read_text(out() / "comparison.html"), "mine");
  EXPECT_FALSE(fs::exists(out() / "ekf"));
}

TEST_F(RunMethods, CtrlCKeepsWhatIsDoneAndRunsNoMore) {
  Scenario scenario = testing::short_scenario();
  scenario.duration = 60.0;
  write_track_log(simulate(scenario, 1), folder() / "long");
  // How long a run takes differs: the first one may be done by then, or not begun.
  bool written = false;
  for (useconds_t delay = 1'000'000; !written && delay < 20'000'000; delay *= 2) {
    testing::ChildProcess program({"run", (folder() / "long").string(), "--methods",
                                   "ekf,lcekf,ekf-full,soft", "--init", "groundtruth", "--out",
                                   out().string()});
    usleep(delay);
    program.signal(SIGINT);
    EXPECT_EQ(program.wait(), 1);
    EXPECT_THAT(program.err(),
                AllOf(HasSubstr("stopped: not run: "), HasSubstr("soft"), Not(HasSubstr("error"))));
    written = fs::exists(out() / "ekf/summary.json");
  }
  EXPECT_TRUE(written);
  EXPECT_FALSE(fs::exists(out() / "soft"));
}

}  // namespace
}  // namespace limber
