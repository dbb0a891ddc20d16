// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/small_log.hpp"

namespace limber {
namespace {

using ::testing::HasSubstr;
using testing::run_limber;

class SimulateImages : public testing::SmallLog {
 protected:
  [[nodiscard]] testing::ProgramResult render(std::vector<std::string> options) const {
    const auto scenario = testing::write_text(folder() / "small.yaml",
                                              "duration: 0.2\n"
                                              "rig: {theta: [0, 0, 0, -0.15, 0, 0], cam0: {resolution: [188, "
                                              "120], intrinsics: [115, 115, 93, 60]}}\n");
    options.insert(options.begin(), {"simulate", scenario.string(), "--out", out().string()});
    return run_limber(options);
  }
};

TEST_F(SimulateImages, TakesEverySwitch) {
  const auto result = render({"--images", "--rolling-shutter", "0.02", "--moving-objects", "2",
                              "--low-texture", "0.5", "--dropped", "1", "--swapped", "1"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto scene = out() / "mav0" / "scene0";
  EXPECT_THAT(testing::read_text(scene / "faulty_frames.csv"), HasSubstr("0,right,left\n50000000,"));
  EXPECT_THAT(testing::read_text(scene / "moving_boxes.csv"), HasSubstr("\n1,"));
  EXPECT_THAT(testing::read_text(scene / "data.csv"), HasSubstr(",1\n"));
  EXPECT_THAT(testing::read_text(out() / "mav0" / "cam0" / "sensor.yaml"),
              ::testing::Not(HasSubstr("readout")));
  const auto again = run_limber({"run", out().string(), "--out", (folder() / "run").string()});
  EXPECT_THAT(again.err, HasSubstr("have no partner with the same timestamp and are left out"));
}

TEST_F(SimulateImages, TellsTheReadoutTimeIfAsked) {
  ASSERT_EQ(render({"--images", "--rolling-shutter", "0.02", "--tell-readout"}).exit_code, 0);
  EXPECT_THAT(testing::read_text(out() / "mav0" / "cam1" / "sensor.yaml"), HasSubstr("readout_time: 0.02"));
  EXPECT_EQ(render({"--images", "--tell-readout"}).exit_code, 2) << "without --rolling-shutter";
}

TEST_F(SimulateImages, SaysThatErrorsOfPixelsAreNotForThem) {
  const auto result = render({"--images", "--pixels", "realistic"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("errors of pixels are for matched points"));
}

TEST_F(SimulateImages, RefusesWhatMakesNoSense) {
  EXPECT_EQ(render({"--rolling-shutter", "0.02"}).exit_code, 2) << "without --images";
  EXPECT_THAT(render({"--images", "--dropped", "2"}).err, HasSubstr("expected a number from 0 to 1"));
  EXPECT_THAT(render({"--images", "--moving-objects", "-1"}).err, HasSubstr("expected a whole number"));
  const auto crowded = render({"--images", "--moving-objects", "100"});
  EXPECT_EQ(crowded.exit_code, 1);
  EXPECT_THAT(crowded.err, HasSubstr("expected room for 100 moving objects, found it for"));
  EXPECT_FALSE(std::filesystem::exists(out()));
}

}  // namespace
}  // namespace limber
