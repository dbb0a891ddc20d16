// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "limber/datasets/read_recording.hpp"
#include "limber/run/input_summary.hpp"
#include "limber/run/run_recording.hpp"
#include "real_data.hpp"

namespace limber {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

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

TEST(FarFromLinear, StarryNightWithARigTwoDegreesOffSaysWhichCorrectionsItDoesNotMake) {
  LIMBER_NEED_DATA(folder, "track_logs/starry_night");
  const Recording recording = read_recording(folder);
  RunOptions options;
  options.method = Method::kLcekf;
  options.assume_error.head<2>().setConstant(2.0 * detail::kDegree);
  EXPECT_THAT(remarks_on_inputs(summarize_inputs(run_in_room(recording, options, true).frames)),
              Contains(HasSubstr("correcting it would have put them farther off")));
}

}  // namespace
}  // namespace limber
