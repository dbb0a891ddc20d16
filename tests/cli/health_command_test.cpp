// SPDX-License-Identifier: MIT
#include <nlohmann/json.hpp>

#include "cli/small_log.hpp"
#include "limber/rig_files/write_rig_files.hpp"
#include "limber/run_files/health_file.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using Json = nlohmann::json;
using testing::expect_refused;
using testing::files_below;
using testing::ProgramResult;
using testing::run_limber;

class HealthCommand : public testing::SmallLog {
 protected:
  /// `limber health` on the log, from the truth: what is tested here is what the program says.
  [[nodiscard]] ProgramResult health(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"health", log().string(), "--init", "groundtruth"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_limber(arguments);
  }
  void write(const Recording& recording) { write_track_log(recording, log(), true); }
};

Recording sound() {
  Scenario scenario = testing::short_scenario();
  scenario.duration = 4.0;
  scenario.decalibration.clear();
  return simulate(scenario, 1);
}

Recording with_a_blind_right_camera() {
  Recording recording = sound();
  for (StereoFrame& frame : recording.frames) {
    std::erase_if(frame.observations, [](const StereoObservation& o) { return !o.in_cam0; });
    for (StereoObservation& o : frame.observations) {
      o.in_cam1 = false;
    }
  }
  return recording;
}

TEST_F(HealthCommand, EndsWithZeroOnASoundRig) {
  Scenario drone = testing::shipped("drone_none", 8.0);
  write(simulate(drone, 1));
  const ProgramResult result = health();
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  EXPECT_THAT(result.out, HasSubstr("log: ok\nwithin the tolerance"));
  EXPECT_THAT(result.out, HasSubstr("What to do: nothing"));
}

/// Points at 50 m and white pixel noise of 1 px: vergence comes out too large (docs/health.md, limits).
TEST_F(HealthCommand, CallsNoSoundRigOfTwoMetresDecalibrated) {
  write(sound());
  EXPECT_NE(health().exit_code, 3);
}

TEST_F(HealthCommand, EndsWithThreeOnAWrongCalibrationAndNamesWhatIsWrong) {
  write(sound());
  const ProgramResult result = health({"--assume-error", "0,0,0.5,0,0,0", "--json"});
  EXPECT_EQ(result.exit_code, 3) << result.out << result.err;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["verdict"], "decalibrated");
  const Json& present = json["health"]["present"];
  EXPECT_EQ(present["most_likely_axis"], "az");
  EXPECT_NEAR(present["axes"]["az"]["error"].get<double>(), -0.5,
              3.0 * present["axes"]["az"]["sigma"].get<double>());
}

TEST_F(HealthCommand, EndsWithFourWhereNothingCanBeTold) {
  write(with_a_blind_right_camera());
  const ProgramResult result = health();
  EXPECT_EQ(result.exit_code, 4) << result.out << result.err;
  EXPECT_THAT(result.out, HasSubstr("log: cannot tell"));
}

TEST_F(HealthCommand, RecognisesSwappedCameras) {
  Recording recording = sound();
  for (StereoFrame& frame : recording.frames) {
    for (StereoObservation& o : frame.observations) {
      std::swap(o.uv_cam0, o.uv_cam1);
      std::swap(o.in_cam0, o.in_cam1);
    }
  }
  write(recording);
  const ProgramResult result = health();
  EXPECT_EQ(result.exit_code, 3) << result.out << result.err;
  EXPECT_THAT(result.out, HasSubstr("the two cameras are swapped"));
}

TEST_F(HealthCommand, KeepsTheRunWhereItIsTold) {
  EXPECT_EQ(health({"--out", out().string(), "--assume-error", "0,0,1,0,0,0"}).exit_code, 3);
  EXPECT_THAT(files_below(out()), IsSupersetOf({"health.csv", "summary.json"}));
  EXPECT_EQ(read_health_csv(out() / "health.csv").size(), 3u);
  const Json summary = Json::parse(testing::read_text(out() / "summary.json"));
  EXPECT_EQ(summary["health"]["verdict"], "decalibrated");
  EXPECT_EQ(summary["options"]["false_alarms_per_hour"], 0.1);
}

/// A drone with a sound rig, and one that is bent by that much.
Recording drone_bent_by(const RigParameters& error, std::uint64_t seed) {
  Scenario drone = testing::shipped("drone_none", 8.0);
  drone.decalibration = {{error, ConstantShape{}}};
  return simulate(drone, seed);
}

TEST_F(HealthCommand, SaysWhatMovedSinceAnEarlierRecording) {
  write(drone_bent_by(RigParameters::Zero(), 1));
  const std::string monday = (folder() / "monday").string();
  ASSERT_EQ(health({"--out", monday}).exit_code, 0);
  EXPECT_THAT(files_below(monday), Contains("health_state.json"));

  write(drone_bent_by(0.0087 * RigParameters::Unit(0), 2));  // half a degree of nod
  const ProgramResult moved = health({"--since", monday, "--json"});
  EXPECT_EQ(moved.exit_code, 3) << moved.err;
  const Json since = Json::parse(moved.out)["since"];
  EXPECT_EQ(since["recording"], "log");
  EXPECT_EQ(since["verdict"], "decalibrated");
  EXPECT_EQ(since["most_likely_axis"], "ax");
  EXPECT_NEAR(since["axes"]["ax"]["error"].get<double>(), 0.5, 0.05);

  // Another calibration is assumed, which is wrong; the rig did not move.
  write(drone_bent_by(RigParameters::Zero(), 3));
  const ProgramResult assumed = health({"--since", monday, "--assume-error", "0.5,0,0,0,0,0"});
  EXPECT_EQ(assumed.exit_code, 3) << assumed.err;
  EXPECT_THAT(assumed.out, HasSubstr("Since log: nothing moved that matters"));
  EXPECT_THAT(assumed.out, HasSubstr("now - then"));
}

TEST_F(HealthCommand, ComparesNothingThatCannotBeCompared) {
  write(drone_bent_by(RigParameters::Zero(), 1));
  const std::string monday = (folder() / "monday").string();
  ASSERT_EQ(health({"--out", monday}).exit_code, 0);
  expect_refused(health({"--since", monday, "--out", monday}), 1, "another folder than that of --since");
  EXPECT_TRUE(fs::exists(fs::path(monday) / "health_state.json"));
  expect_refused(health({"--since", (folder() / "sunday").string()}), 2, "sunday");
  expect_refused(health({"--since", log().string()}), 1, "health_state.json");
  write(sound());
  expect_refused(health({"--since", monday}), 1, "the cameras of this recording, cam0");
}

TEST_F(HealthCommand, OfAFleetIsATableWithTheExitCodeOfTheWorst) {
  const auto log_of = [this](const std::string& day) { return (folder() / day).string(); };
  write_track_log(drone_bent_by(RigParameters::Zero(), 1), log_of("monday"));
  write_track_log(drone_bent_by(0.0087 * RigParameters::Unit(0), 2), log_of("tuesday"));
  const std::vector<std::string> both = {"health", log_of("monday"), log_of("tuesday"), "--fleet",
                                         "--init", "groundtruth",    "--out",           out().string()};
  const ProgramResult result = run_limber(both);
  EXPECT_EQ(result.exit_code, 3) << result.err;
  EXPECT_THAT(result.out, HasSubstr("since " + log_of("monday")));
  EXPECT_THAT(files_below(out()), IsSupersetOf({"01-monday/health_state.json", "02-tuesday/health.csv"}));
  for (std::size_t at = result.err.find("limber: "); at != std::string::npos;
       at = result.err.find("limber: ", at + 1)) {
    const std::string line = result.err.substr(at, result.err.find('\n', at) - at);
    EXPECT_EQ(result.err.find(line, at + 1), std::string::npos) << "said twice: " << line;
  }

  std::vector<std::string> json = both;
  json.resize(6);
  json.insert(json.begin() + 3, {(folder() / "sunday").string(), "--json"});
  const ProgramResult with_a_missing_one = run_limber(json);
  EXPECT_EQ(with_a_missing_one.exit_code, 1);
  const Json rigs = Json::parse(with_a_missing_one.out);
  ASSERT_EQ(rigs.size(), 3u);
  EXPECT_EQ(rigs[0]["verdict"], "ok");
  EXPECT_EQ(rigs[1]["since"]["most_likely_axis"], "ax");
  EXPECT_TRUE(rigs[1]["trend"].is_null()) << "of two recordings there is none";
  EXPECT_THAT(rigs[2]["failure"].get<std::string>(), HasSubstr("sunday"));

  expect_refused(run_limber({"health", log_of("monday"), log_of("tuesday")}), 2, "--fleet judges them all");
}

TEST_F(HealthCommand, OfAFleetJudgesTheOthersWhereACalibrationDoesNotFitOne) {
  const auto log_of = [this](const std::string& day) { return (folder() / day).string(); };
  const Recording monday = drone_bent_by(RigParameters::Zero(), 1);
  write_track_log(monday, log_of("monday"));
  Recording tuesday = drone_bent_by(RigParameters::Zero(), 2);
  tuesday.calibration.cam0.width = tuesday.calibration.cam1.width += 1;
  write_track_log(tuesday, log_of("tuesday"));
  const fs::path file = testing::write_text(folder() / "camchain.yaml", kalibr_camchain(monday.calibration));
  const ProgramResult result = run_limber({"health", log_of("tuesday"), log_of("monday"), "--fleet", "--json",
                                           "--init", "groundtruth", "--calib", file.string()});
  EXPECT_EQ(result.exit_code, 1) << result.err;
  const Json rigs = Json::parse(result.out);
  ASSERT_EQ(rigs.size(), 2u);
  EXPECT_THAT(rigs[0]["failure"].get<std::string>(),
              HasSubstr("camchain.yaml: the calibration of cam0 is for images of"));
  EXPECT_EQ(rigs[1]["verdict"], "ok");
}

TEST_F(HealthCommand, WithoutAFolderLeavesNothing) {
  const auto before = files_below(folder());
  (void)health();
  EXPECT_EQ(files_below(folder()), before);
}

TEST_F(HealthCommand, RefusesBadOptions) {
  for (const std::vector<std::string>& bad :
       std::vector<std::vector<std::string>>{{"--false-alarms", "0"},
                                             {"--false-alarms", "-1"},
                                             {"--gravity", "nan"},
                                             {"--tolerance", "px=0"},
                                             {"--tolerance", "nod=1"},
                                             {"--assume-error", "1,2"}}) {
    expect_refused(health(bad), 2, bad.front());
  }
  expect_refused(run_limber({"health"}), 2, "DATASET");
  expect_refused(run_limber({"health", (folder() / "none").string()}), 1, "none");
}

TEST_F(HealthCommand, IsExplained) {
  const ProgramResult help = run_limber({"health", "--help"});
  EXPECT_THAT(help.out, HasSubstr("0 ok, 3 decalibrated, 4 cannot tell, 5 degraded"));
  EXPECT_THAT(help.out, HasSubstr("limber health data/v101"));
}

}  // namespace
}  // namespace limber
