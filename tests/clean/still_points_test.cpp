// SPDX-License-Identifier: MIT
// Points that go with the camera: found once the view has turned, forgotten from their beginning; none of the
// world's, even where it hardly moves in the image.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "clean/cleaned_frames.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using Eigen::Vector2d;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

using testing::cleaned;
using testing::Frames;

constexpr std::int64_t kDirt = 1'000'000;

/// So many points that both cameras see at places of their own, up to noise of 0.3 px; before all others.
Frames dirty(Frames frames, std::int64_t points) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise(0.0, 0.3);
  std::uniform_real_distribution<double> u(30.0, 600.0), v(30.0, 400.0);
  std::vector<Vector2d> places;
  for (std::int64_t k = 0; k < points; ++k) {
    places.emplace_back(u(random), v(random));
  }
  for (StereoFrame& frame : frames) {
    for (std::int64_t k = 0; k < points; ++k) {
      const Vector2d uv = places[static_cast<std::size_t>(k)] + Vector2d(noise(random), noise(random));
      frame.observations.push_back({kDirt + k, uv, uv - Vector2d(12.0, 0.0), true, true});
    }
  }
  return frames;
}

std::size_t dirt_in(const StereoFrame& frame) {
  return static_cast<std::size_t>(std::ranges::count_if(
      frame.observations, [](const StereoObservation& point) { return point.track_id >= kDirt; }));
}

TEST(StillPoints, AreFoundWhenTheViewHasTurned) {
  const Recording recording = testing::realistic("drone_none", 10.0, 31);
  for (const std::int64_t points : {5, 60}) {
    const auto [frames, report] = cleaned(dirty(recording.frames, points), recording.calibration);
    EXPECT_EQ(report.still_tracks, static_cast<std::size_t>(points));
    EXPECT_EQ(dirt_in(frames.front()), static_cast<std::size_t>(points)) << "nothing turned yet";
    EXPECT_EQ(dirt_in(frames.back()), 0U);
    EXPECT_THAT(in_words(report), Contains(HasSubstr("stand still in the left image while the view turns")));
  }
}

TEST(StillPoints, AreWithdrawnFromTheFramesBefore) {
  const Recording recording = testing::realistic("drone_none", 10.0, 32);
  Frames kept;
  for (const StereoFrame& frame : cleaned(dirty(recording.frames, 5), recording.calibration).frames) {
    withdraw_from(kept, frame);
    kept.push_back(frame);
  }
  ASSERT_EQ(kept.size(), recording.frames.size());
  for (const StereoFrame& frame : kept) {
    EXPECT_EQ(dirt_in(frame), 0U) << frame.t_ns;
    EXPECT_GT(frame.observations.size(), 10U);
  }
}

TEST(StillPoints, AreLeftAloneOnRequest) {
  const Recording recording = testing::realistic("drone_none", 10.0, 33);
  CleaningOptions options;
  options.still_points = false;
  EXPECT_EQ(cleaned(dirty(recording.frames, 5), recording.calibration, options).report.still_tracks, 0U);
}

/// Far points of a car that drives straight on, and all points of a body at rest.
TEST(StillPoints, AreNoneOfTheWorld) {
  for (const char* const name :
       {"drone_none", "drone_moving", "drone_rotation", "paper_i", "rover_walk", "walk", "creeping"}) {
    const Recording recording = testing::realistic(name, 10.0, 34);
    EXPECT_EQ(cleaned(recording.frames, recording.calibration).report.still_tracks, 0U) << name;
  }
}

}  // namespace
}  // namespace limber
