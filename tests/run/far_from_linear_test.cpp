// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "limber/datasets/read_recording.hpp"
#include "limber/run/input_summary.hpp"
#include "limber/run/run_recording.hpp"
#include "real_data.hpp"

namespace limber {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

/// A room, five points a frame, and up to two seconds without images: the state is far off where they come
/// again, and linear updates led 113 m away.
RunRecord run_in_room(const Recording& recording, RunOptions options, bool doubt_mount) {
  options.doubt_odometry_mount = doubt_mount;
  RunRecord record = run_recording(recording, options, matched_frames(recording));
  for (const TrajectoryRow& row : record.trajectory) {
    EXPECT_LE(row.T_world_body.p.norm(), 10.0) << doubt_mount << ' ' << row.t_ns;
  }
  return record;
}

TEST(FarFromLinear, StarryNightWithOneCameraStaysInItsRoom) {
  LIMBER_NEED_DATA(folder, "track_logs/starry_night");
  const Recording recording = read_recording(folder);
  RunOptions options;
  options.method = Method::kMonoLeft;
  run_in_room(recording, options, false);
  run_in_room(recording, options,
              true);  // the mount is in the state: all rows have derivatives by parameters
}

std::vector<std::string> remarks_on(const Recording& recording, Method method, double degrees) {
  RunOptions options;
  options.method = method;
  options.assume_error.head<2>().setConstant(degrees * detail::kDegree);
  std::vector<FrameReport> frames = run_in_room(recording, options, true).frames;
  std::erase_if(frames, [](const FrameReport& frame) { return !frame.led_astray; });  // few remarks are shown
  return remarks_on_inputs(summarize_inputs(frames));
}

/// A method that trusts a rig which is 4 degrees off meets some. One that does not finds the body in its map
/// first, and has none to make.
TEST(FarFromLinear, StarryNightWithARigFourDegreesOffSaysWhichCorrectionsItDoesNotMake) {
  LIMBER_NEED_DATA(folder, "track_logs/starry_night");
  const Recording recording = read_recording(folder);
  const auto not_made = HasSubstr("correcting it would have put them farther off");
  EXPECT_THAT(remarks_on(recording, Method::kEkf, 4.0), Contains(not_made));
  EXPECT_THAT(remarks_on(recording, Method::kLcekf, 2.0), Not(Contains(not_made)));
}

}  // namespace
}  // namespace limber
