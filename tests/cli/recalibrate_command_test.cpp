// SPDX-License-Identifier: MIT
#include <nlohmann/json.hpp>

#include "cli/child_process.hpp"
#include "cli/small_log.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/rig_files/rig_file.hpp"

namespace limber {
namespace {

using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::expect_refused;
using testing::files_below;
using testing::ProgramResult;
using testing::read_text;
using testing::run_limber;
using testing::write_text;

/// Four seconds with a sound rig.
class RecalibrateCommand : public ::testing::Test {
 protected:
  RecalibrateCommand() {
    Scenario scenario = testing::short_scenario();
    scenario.duration = 4.0;
    scenario.decalibration.clear();
    write_track_log(simulate(scenario, 3), log());
  }

  [[nodiscard]] fs::path log() const { return folder_.path() / "log"; }
  [[nodiscard]] fs::path out() const { return folder_.path() / "out"; }
  [[nodiscard]] Json report() const { return Json::parse(read_text(out() / "recalibration.json")); }
  [[nodiscard]] ProgramResult recalibrate(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"recalibrate",  log().string(), "--out",
                                          out().string(), "--max-points", "40"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_limber(arguments);
  }

 private:
  testing::TemporaryFolder folder_;
};

TEST_F(RecalibrateCommand, KeepsASoundRig) {
  const ProgramResult result = recalibrate();
  EXPECT_TRUE(result.exit_code == 6 || result.exit_code == 4) << result.err << result.out;
  EXPECT_THAT(result.out, HasSubstr("no calibration was written"));
  EXPECT_FALSE(fs::exists(out() / "camchain.yaml"));
  EXPECT_EQ(report()["files"].size(), 0u);
}

TEST_F(RecalibrateCommand, FindsThePixelNoiseThatNobodyStates) {
  std::string stated = read_text(log() / "mav0/tracks0/sensor.yaml");
  ASSERT_THAT(stated, HasSubstr("sigma_px: [0.5, 0.5, 0.5, 0.5]"));
  fs::remove(log() / "mav0/tracks0/sensor.yaml");
  const ProgramResult result = recalibrate();
  EXPECT_TRUE(result.exit_code == 6 || result.exit_code == 4) << result.err << result.out;
  EXPECT_THAT(result.err,
              ::testing::ContainsRegex("pixel noise by what the smoother leaves: 0\\.(4[5-9]|5[0-5]?) px"));
}

TEST_F(RecalibrateCommand, MendsAWrongOneInEveryFormat) {
  const ProgramResult result = recalibrate({"--assume-error", "2,2,2,20%,20%,20%"});
  ASSERT_EQ(result.exit_code, 0) << result.err << result.out;
  EXPECT_THAT(files_below(out()),
              IsSupersetOf({"cam0/sensor.yaml", "cam1/sensor.yaml", "camchain.yaml", "imu.yaml", "stereo.yml",
                            "calib.txt", "calib_cam_to_cam.txt", "recalibration.json"}));
  const RigParameters truth = read_recording(log()).calibration.theta;
  const StereoCalibration mended = read_rig_file(out() / "camchain.yaml").calibration;
  const Json axes = report()["axes"];
  for (Eigen::Index k = 0; k < 3; ++k) {
    const std::string name = std::string("a") + static_cast<char>('x' + k);
    const double sigma = axes[name]["sigma"].get<double>() * M_PI / 180.0;
    EXPECT_NEAR(mended.theta(k), truth(k), 5.0 * sigma) << name;
    EXPECT_LT(sigma, 0.2 * M_PI / 180.0) << name;
  }
  EXPECT_LT(report()["ate_ekf_m"]["corrected"].get<double>(), report()["ate_ekf_m"]["given"].get<double>());
}

TEST_F(RecalibrateCommand, LeavesNoOlderFileThatCannotSayTheLens) {
  Scenario scenario = testing::short_scenario();
  scenario.duration = 4.0;
  scenario.decalibration.clear();
  scenario.rig.cam0.distortion = scenario.rig.cam1.distortion = Omni{.xi = 0.5};
  fs::remove_all(log());
  write_track_log(simulate(scenario, 3), log());
  for (const char* const name : {"stereo.yml", "calib_cam_to_cam.txt", "camchain.yaml", "notes.txt"}) {
    write_text(out() / name, "of an earlier lens\n");
  }
  const ProgramResult result = recalibrate({"--write-anyway", "--force"});
  EXPECT_NE(result.exit_code, 1) << result.err;
  EXPECT_FALSE(fs::exists(out() / "stereo.yml"));
  EXPECT_FALSE(fs::exists(out() / "calib_cam_to_cam.txt"));
  EXPECT_THAT(read_text(out() / "camchain.yaml"), HasSubstr("omni"));
  EXPECT_TRUE(fs::exists(out() / "notes.txt")) << "no file of ours";
}

TEST_F(RecalibrateCommand, LeavesNothingWhereThereIsNoRoomForAllFiles) {
  constexpr rlim_t kOneFileAtMost = 700;  // [bytes]: enough for a camera's sensor.yaml
  testing::ChildProcess limber({"recalibrate", log().string(), "--out", out().string(), "--write-anyway"},
                               kOneFileAtMost);
  EXPECT_EQ(limber.wait(), 1);
  EXPECT_THAT(limber.err(), HasSubstr("expected room to write the file"));
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(RecalibrateCommand, ReplacesNothingOfOthers) {
  const auto others = write_text(out() / "camchain.yaml", "cam0: mine\n");
  expect_refused(recalibrate(), 1, "camchain.yaml");
  EXPECT_EQ(read_text(others), "cam0: mine\n");
  fs::create_directories(log() / "mav0");
  std::vector<std::string> into = {"recalibrate", log().string(), "--out", (log() / "mav0").string(),
                                   "--force"};
  expect_refused(run_limber(into), 1, "a folder for the results alone");
}

}  // namespace
}  // namespace limber
