// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/small_log.hpp"
#include "limber/datasets/read_recording.hpp"

namespace limber {
namespace {

using ::testing::HasSubstr;
using testing::read_text;
using testing::run_limber;

class DecalibrateCommand : public testing::SmallLog {
 protected:
  [[nodiscard]] testing::ProgramResult decalibrate(const std::string& as, const std::string& out) const {
    return run_limber({"decalibrate", log().string(), "--as", as, "--out", out});
  }
};

TEST_F(DecalibrateCommand, WritesALogWhoseTruthRunsAndReportsRead) {
  const auto result = decalibrate("ay=0.3,tx=5%", out().string());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("right pixels moved"));
  const Recording sound = read_recording(log()), bent = read_recording(out());
  EXPECT_EQ(bent.calibration.theta, sound.calibration.theta);
  const RigParameters change = bent.truth.rig.front().theta - sound.truth.rig.front().theta;
  EXPECT_NEAR(change[1], 0.3 * 0.017453292519943295, 1e-9);
  EXPECT_NEAR(std::abs(change[3]), 0.05 * sound.calibration.baseline(), 1e-9);
  const auto run =
      run_limber({"run", out().string(), "--method", "oracle", "--out", (folder() / "run").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST_F(DecalibrateCommand, TakesTheDecalibrationOfAScenario) {
  testing::write_text(folder() / "bend.yaml",
                      "decalibration: [{shape: constant, amplitude: [1, 0, 0, 0, 0, 0]}]\n");
  EXPECT_EQ(decalibrate((folder() / "bend.yaml").string(), out().string()).exit_code, 0);
  testing::write_text(folder() / "sound.yaml", "decalibration: []\n");
  const auto refused = decalibrate((folder() / "sound.yaml").string(), (folder() / "other").string());
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, HasSubstr("expected a scenario with a decalibration, found none"));
}

TEST_F(DecalibrateCommand, SaysOfAProfileWhatTheOptionTakes) {
  const auto expect = [this](const char* as, const std::string& said) {
    const auto refused = decalibrate(as, out().string());
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err, HasSubstr("--as: expected " + said));
    EXPECT_THAT(refused.err, ::testing::Not(HasSubstr("signal")));
  };
  const std::string axes =
      "one of the keys shape, ax, ay, az (degrees), tx, ty, tz (m, or % of the baseline)";
  expect("roll=2", axes + ", found the unknown key 'roll' in 'roll=2'");
  expect("ay=1,shape=ramp,end=3,angle=2", axes + ", start, end, found the unknown key 'angle'");
  expect("ay=1,shape=ramp", "the key end, found no such key in 'ay=1,shape=ramp'");
  expect("ay=much", "amplitude as a number in [-1000000, 1000000] deg, found 'much'");
  expect("ay=1,roll", "amplitudes and a shape such as ay=0.5");
}

TEST_F(DecalibrateCommand, ReplacesOnlyWithForceWhatItMadeAndNeverItsInput) {
  const std::string before = read_text(mav0() / "tracks0" / "data.csv");
  EXPECT_THAT(decalibrate("ay=1", log().string()).err, HasSubstr("expected no folder of this name"));
  EXPECT_THAT(decalibrate("ay=1", (log() / "bent").string()).err,
              HasSubstr("expected a folder outside the recording"));
  EXPECT_EQ(read_text(mav0() / "tracks0" / "data.csv"), before);
  ASSERT_EQ(decalibrate("ay=1", out().string()).exit_code, 0);
  const auto again = decalibrate("ay=2", out().string());
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_THAT(again.err, HasSubstr("found a recording that limber wrote; --force replaces it"));
  const auto forced = [this](const std::string& out) {
    return run_limber({"decalibrate", log().string(), "--as", "ay=2", "--out", out, "--force"});
  };
  EXPECT_EQ(forced(out().string()).exit_code, 0);
  const auto turned_by = [](const std::filesystem::path& folder) {
    return read_recording(folder).truth.rig.front().theta[1];
  };
  EXPECT_NEAR(turned_by(out()) - turned_by(log()), 2.0 * 0.017453292519943295, 1e-9);
  EXPECT_THAT(forced(log().string()).err, HasSubstr("expected a folder outside the recording"));
  EXPECT_EQ(read_text(mav0() / "tracks0" / "data.csv"), before);
  const auto beside = testing::write_text(out() / "run/notes.txt", "mine");
  EXPECT_THAT(forced(out().string()).err, HasSubstr("or not alone"));
  EXPECT_EQ(read_text(beside), "mine");
}

TEST_F(DecalibrateCommand, RefusesProfilesThatItCannotRead) {
  const auto result = decalibrate("ay=fast", out().string());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("expected amplitude as a number"));
  EXPECT_FALSE(std::filesystem::exists(out()));
}

TEST_F(DecalibrateCommand, BendsWhatSimulateHasRendered) {
  const auto scenario = folder() / "small.yaml";
  testing::write_text(scenario,
                      "duration: 0.1\n"
                      "rig: {theta: [0, 0, 0, -0.15, 0, 0], cam0: {resolution: [188, 120], intrinsics: [115, "
                      "115, 93, 60]}}\n");
  const auto pictures = folder() / "pictures";
  const std::vector<std::string> simulate = {"simulate", scenario.string(), "--images",       "--scene",
                                             "hall",     "--out",           pictures.string()};
  const auto rendered = run_limber(simulate);
  ASSERT_EQ(rendered.exit_code, 0) << rendered.err;
  EXPECT_THAT(rendered.out, HasSubstr("3 pairs of images"));
  EXPECT_EQ(read_recording(pictures).images.size(), 3u);
  EXPECT_THAT(run_limber(simulate).err, HasSubstr("expected no folder of this name, or an empty one"));
  auto forced = simulate;
  forced.emplace_back("--force");
  EXPECT_EQ(run_limber(forced).exit_code, 0);
  ASSERT_EQ(run_limber({"decalibrate", pictures.string(), "--as", "az=1", "--out", out().string()}).exit_code,
            0);
  EXPECT_NEAR(read_recording(out()).truth.rig.front().theta[2], 0.017453292519943295, 1e-9);
  const auto moved =
      run_limber({"decalibrate", pictures.string(), "--as", "tx=5%", "--out", (folder() / "moved").string()});
  EXPECT_EQ(moved.exit_code, 1);
  EXPECT_THAT(moved.err, HasSubstr("images can be turned, not moved"));
  EXPECT_FALSE(std::filesystem::exists(folder() / "moved"));
  EXPECT_EQ(
      run_limber({"simulate", scenario.string(), "--scene", "hall", "--out", pictures.string()}).exit_code,
      2);
}

}  // namespace
}  // namespace limber
