// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/run_program.hpp"
#include "limber/datasets/read_recording.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using testing::files_below;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using testing::ProgramResult;
using testing::read_text;
using testing::run_limber;
using testing::write_text;

const char* const kSmallScenario =
    "duration: 1\n"
    "odometry: {rate: 20}\n"
    "decalibration: [{shape: constant, amplitude: [0.1, 0, 0, 5%, 0, 0]}]\n";

class SimulateCommand : public ::testing::Test {
 protected:
  SimulateCommand() { write_text(scenario(), kSmallScenario); }

  [[nodiscard]] fs::path folder() const { return folder_.path(); }
  [[nodiscard]] fs::path scenario() const { return folder() / "case.yaml"; }
  [[nodiscard]] fs::path out() const { return folder() / "out"; }

  [[nodiscard]] ProgramResult simulate_into(const fs::path& out,
                                            const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"simulate", scenario().string(), "--out", out.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_limber(arguments);
  }
  [[nodiscard]] ProgramResult simulate(const std::vector<std::string>& more = {}) const {
    return simulate_into(out(), more);
  }
  void expect_refused(const ProgramResult& result, int exit_code, const std::string& words) const {
    EXPECT_EQ(result.exit_code, exit_code);
    EXPECT_THAT(result.out, IsEmpty());
    EXPECT_THAT(result.err, AllOf(HasSubstr("limber: error: "), HasSubstr(words)));
    EXPECT_FALSE(fs::exists(out()));
  }

 private:
  testing::TemporaryFolder folder_;
};

/// Names and contents of all files below a folder.
std::string content_of_all(const fs::path& folder) {
  std::vector<std::string> names = files_below(folder);
  std::sort(names.begin(), names.end());
  std::string content;
  for (const std::string& name : names) {
    content += name + "\n" + (fs::is_regular_file(folder / name) ? read_text(folder / name) : "");
  }
  return content;
}

TEST_F(SimulateCommand, WritesATrackLogAndSaysWhatIsInIt) {
  const ProgramResult result = simulate({"--seed", "3"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, IsEmpty());
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("case: 21 frames in 1.0 s"), HasSubstr("written to " + out().string()),
                    Not(HasSubstr("\r")), Not(HasSubstr("\x1b"))));
  const Recording recording = read_recording(out());
  EXPECT_EQ(recording.frames.size(), 21u);
  EXPECT_EQ(recording.imu.size(), 101u);
  EXPECT_EQ(recording.odometry.size(), 21u);
  EXPECT_EQ(recording.truth.motion.states.size(), 101u);
  EXPECT_TRUE(recording.truth.motion.has_velocity && recording.truth.motion.has_biases);
  EXPECT_FALSE(recording.truth.landmarks.empty());
  ASSERT_FALSE(recording.truth.rig.empty());
  EXPECT_NEAR(recording.truth.rig.front().theta[3] - recording.calibration.theta[3], 0.1, 1e-12);
  EXPECT_THAT(recording.notes, IsEmpty());
}

TEST_F(SimulateCommand, GivesTheSameBitsTwiceAndOthersForAnotherSeedOrRun) {
  const auto made = [this](const char* name, const std::vector<std::string>& options) {
    EXPECT_EQ(simulate_into(folder() / name, options).exit_code, 0);
    return content_of_all(folder() / name);
  };
  const std::string content = made("a", {"--seed", "7", "--run", "1"});
  EXPECT_EQ(content, made("b", {"--seed", "7", "--run", "1"}));
  EXPECT_NE(content, made("c", {"--seed", "8", "--run", "1"}));
  EXPECT_NE(content, made("d", {"--seed", "7", "--run", "2"}));
}

TEST_F(SimulateCommand, LeavesTheImuOutWhenAsked) {
  ASSERT_EQ(simulate({"--without-imu"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(out() / "mav0/imu0"));
  EXPECT_TRUE(fs::exists(out() / "mav0/odometry0"));
}

TEST_F(SimulateCommand, PrintsAScenarioThatGivesTheSameRecording) {
  ASSERT_EQ(simulate().exit_code, 0);
  const std::string content = content_of_all(out());
  const ProgramResult printed = run_limber({"simulate", scenario().string(), "--print"});
  EXPECT_EQ(printed.exit_code, 0);
  EXPECT_THAT(printed.out, AllOf(HasSubstr("duration: 1  # s"), HasSubstr("gravity: 9.81")));
  write_text(scenario(), printed.out);
  ASSERT_EQ(simulate_into(folder() / "again").exit_code, 0);
  EXPECT_EQ(content, content_of_all(folder() / "again"));
}

TEST_F(SimulateCommand, MakesPixelsRealisticAndSensorsFaultyWhenAsked) {
  ASSERT_EQ(simulate_into(folder() / "sound").exit_code, 0);
  const ProgramResult result =
      simulate({"--pixels", "realistic", "--fault", "imu-gap=0.2:0.3", "--fault", "frame-gap=0.5:0.2"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("case_realistic_imu-gap=0.2:0.3_frame-gap=0.5:0.2: 17 frames"));
  EXPECT_FALSE(fs::exists(out() / "mav0/tracks0/sensor.yaml"));
  EXPECT_FALSE(fs::exists(out() / "mav0/odometry0/sensor.yaml"));
  const Recording sound = read_recording(folder() / "sound"), faulty = read_recording(out());
  EXPECT_EQ(faulty.imu.size(), 71u);
  EXPECT_EQ(faulty.frames.size(), 17u);
  EXPECT_EQ(faulty.truth.motion.states.back().p_world_body, sound.truth.motion.states.back().p_world_body);
  EXPECT_NE(faulty.frames[0].observations[0].uv_cam0, sound.frames[0].observations[0].uv_cam0);
}

TEST_F(SimulateCommand, RefusesOptionsThatMakeNoSenseAsWrongUsage) {
  expect_refused(simulate({"--seed", "-1"}), 2, "--seed: expected a whole number");
  expect_refused(simulate({"--run", "x"}), 2, "--run: expected a whole number");
  expect_refused(simulate({"--pixels", "pink"}), 2, "--pixels");
  expect_refused(simulate({"--fault", "imu-gap=5"}), 2, "imu-gap=at:duration");
  expect_refused(simulate({"--fault", "imu-gap=5:0"}), 2, "expected duration as a number in (0, 1000000] s");
  expect_refused(simulate({"--sed", "1"}), 2, "unknown option --sed");
  expect_refused(run_limber({"simulate", scenario().string()}), 2, "--out is required");
  expect_refused(run_limber({"simulate", scenario().string(), "--out", ""}), 2, "--out: expected a name");
  expect_refused(run_limber({"simulate"}), 2, "SCENARIO is required");
}

TEST_F(SimulateCommand, RefusesBrokenScenariosWithFileAndLine) {
  struct BadScenario {
    std::string text, place, words;
  };
  for (const BadScenario& bad : {
           BadScenario{"duration: 1\ndurration: 2\n", ":2: ", "the unknown key 'durration'"},
           {"duration: soon\n", ":1: ", "expected duration as a number in (0, 10000] s, found 'soon'"},
           {"noise:\n  pixel: -1\n", ":2: ", "expected noise.pixel as a number in [0, 1000] px, found '-1'"},
           {"noise: {pixel: .nan}\n", ":1: ", "noise.pixel"},
           {"world: {min_range: 10, max_range: 5}\n", ":1: ", "world.max_range not below min_range"},
           {"world: {points: 1e300}\n", ":1: ", "world.points as a number in [0, 1000000]"},
           {"rig: {theta: [0, 0, 0, 2, 0, 0]}\n", ":1: ", "cam1 to the right of cam0"},
           {"rig: {cam0: {resolution: 640}}\n", ":1: ", "rig.cam0.resolution as a list of 2 numbers"},
           {"decalibration: [{shape: wobble, amplitude: [0, 0, 0, 0, 0, 0]}]\n",
            ":1: ", "as one of constant"},
           {"duration: [1\n", ":", "expected valid YAML"},
           {"", ": ", "found an empty file"},
           {std::string("\x00\x01", 2), ":1: ", "expected text, found binary data"},
       }) {
    write_text(scenario(), bad.text);
    expect_refused(simulate(), 1, "error: " + scenario().string() + bad.place);
    expect_refused(simulate(), 1, bad.words);
  }
  write_text(scenario(), "trajectory: {kind: file, path: nowhere.tum}\n");
  expect_refused(simulate(), 1,
                 (folder() / "nowhere.tum").string() + ": expected a text file, found no such file");
  fs::remove(scenario());
  expect_refused(simulate(), 1, scenario().string() + ": expected a text file, found no such file");
  expect_refused(run_limber({"simulate", folder().string(), "--out", out().string()}), 1,
                 folder().string() + ": expected a text file, found something that is not a file");
}

TEST_F(SimulateCommand, WarnsWhereNoCameraSeesAnything) {
  write_text(scenario(), "duration: 1\nworld: {points: 0}\n");
  const ProgramResult result = simulate();
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("limber: warning: no camera sees any point"));
}

TEST_F(SimulateCommand, FailsWhereTheOutputCannotBeWritten) {
  const fs::path file = write_text(folder() / "file", "mine");
  for (const fs::path& place : {file, file / "below", fs::path("/proc/limber/log")}) {
    expect_refused(simulate_into(place), 1,
                   place.string() + ": expected a folder that can be made and written");
  }
  EXPECT_EQ(read_text(file), "mine");
}

TEST_F(SimulateCommand, ReplacesAnOlderLogOnlyWithForceAndNobodysImages) {
  ASSERT_EQ(simulate({"--seed", "1"}).exit_code, 0);
  const std::string older = content_of_all(out());
  EXPECT_THAT(simulate({"--seed", "2"}).err,
              HasSubstr("found a recording that limber wrote; --force replaces it"));
  EXPECT_EQ(content_of_all(out()), older);
  ASSERT_EQ(simulate({"--seed", "2", "--force"}).exit_code, 0);
  EXPECT_NE(content_of_all(out()), older);
  write_text(out() / "mav0/cam0/data/1.png", "an image");
  const std::string before = content_of_all(folder());
  const ProgramResult result = simulate({"--seed", "3", "--force"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("expected no folder mav0, or an older track log to replace"));
  EXPECT_EQ(content_of_all(folder()), before);
}

TEST_F(SimulateCommand, LeavesNothingAndTheOlderLogAloneOnAFullDisk) {
  ASSERT_EQ(simulate().exit_code, 0);
  const std::string before = content_of_all(folder());
  {
    const testing::SmallDisk disk;
    for (const fs::path& place : {out(), folder() / "new"}) {
      const ProgramResult result = simulate_into(place, {"--seed", "2", "--force"});
      EXPECT_EQ(result.exit_code, 1);
      EXPECT_THAT(result.err, HasSubstr("room to write the file"));
    }
  }
  EXPECT_EQ(content_of_all(folder()), before);
}

TEST_F(SimulateCommand, LeavesNothingWhenItIsKilledHalfWay) {
  write_text(scenario(), "duration: 1000\n");
  for (const int signal : {SIGKILL, SIGTERM, SIGINT}) {
    ASSERT_TRUE(testing::start_and_kill_limber({"simulate", scenario().string(), "--out", out().string()},
                                               signal, 100));
    EXPECT_EQ(files_below(folder()), std::vector<std::string>{"case.yaml"});
  }
}

TEST_F(SimulateCommand, WritesAnyLensAndRunKnowsItAgain) {
  struct Lens {
    const char *scenario, *info;
  };
  for (const auto& [lens, words] :
       {Lens{"distortion_model: omni, distortion_coefficients: [1.2, -0.25, 0.1, 0.0005, 0]",
             "distortion omni xi=1.2 k1=-0.25"},
        Lens{"distortion_model: rational-polynomial, distortion_coefficients: [-0.37, 0.2, 0.002, 0.001, "
             "-0.07, 0, "
             "0, 0]",
             "distortion rational-polynomial k1=-0.37 k2=0.2 p1=0.002 p2=0.001 k3=-0.07 k4=0"}}) {
    SCOPED_TRACE(lens);
    write_text(scenario(), std::string("duration: 2\nrig: {cam0: {") + lens + "}}\n");
    const ProgramResult made = simulate({"--force"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    EXPECT_THAT(run_limber({"info", out().string()}).out, HasSubstr(words));
    const ProgramResult run = run_limber({"run", out().string(), "--method", "ekf", "--init", "groundtruth",
                                          "--out", (folder() / "run").string(), "--force"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const auto summary = nlohmann::json::parse(read_text(folder() / "run" / "summary.json"));
    EXPECT_LT(summary["position_rmse_m"], 0.1);
  }
  write_text(scenario(),
             "rig: {cam0: {distortion_model: omni, distortion_coefficients: [-1, 0, 0, 0, 0]}}\n");
  EXPECT_THAT(simulate({"--force"}).err, HasSubstr("of a lens that sees straight ahead (omni: xi above -1)"));
}

}  // namespace
}  // namespace limber
