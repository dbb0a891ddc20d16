// SPDX-License-Identifier: MIT
#include "limber/sensors/spread_points.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace limber {
namespace {

StereoCalibration of_800_by_600() {
  StereoCalibration out;
  out.cam0.width = out.cam1.width = 800;
  out.cam0.height = out.cam1.height = 600;
  return out;
}

StereoObservation at(std::int64_t id, double u, double v) {
  StereoObservation out;
  out.track_id = id;
  out.in_cam0 = true;
  out.uv_cam0 = {u, v};
  return out;
}

/// Nine points in the first field of the image, one each in two others.
StereoFrame crowded() {
  StereoFrame frame;
  for (int k = 0; k < 9; ++k) {
    frame.observations.push_back(at(k, 10.0 + k, 10.0));
  }
  frame.observations.push_back(at(9, 750.0, 50.0));
  frame.observations.push_back(at(10, 50.0, 550.0));
  return frame;
}

TEST(SpreadPoints, TakesAllWhereThereIsRoom) {
  const StereoFrame frame = crowded();
  const auto chosen = spread_points(frame, of_800_by_600(), 11, std::vector<PointRank>(11));
  EXPECT_EQ(points_at(frame, chosen).observations.size(), 11U);
}

TEST(SpreadPoints, GoesToTheEmptiestFields) {
  EXPECT_EQ(spread_points(crowded(), of_800_by_600(), 4, std::vector<PointRank>(11)),
            (std::vector<std::size_t>{0, 1, 9, 10}));
}

TEST(SpreadPoints, ALowerGroupComesFirstWhereverItIs) {
  std::vector<PointRank> ranks(11, PointRank{1, 0});
  ranks[3].group = ranks[4].group = ranks[5].group = 0;
  EXPECT_EQ(spread_points(crowded(), of_800_by_600(), 4, ranks), (std::vector<std::size_t>{3, 4, 5, 9}));
}

TEST(SpreadPoints, WithinAFieldByOrder) {
  std::vector<PointRank> ranks(11);
  ranks[7].order = -2;
  ranks[2].order = -1;
  EXPECT_EQ(spread_points(crowded(), of_800_by_600(), 4, ranks), (std::vector<std::size_t>{2, 7, 9, 10}));
}

TEST(SpreadPoints, APointOfTheRightImageAloneIsPlacedThere) {
  StereoFrame frame = crowded();
  frame.observations[10].in_cam0 = false;
  frame.observations[10].in_cam1 = true;
  frame.observations[10].uv_cam1 = {15.0, 10.0};
  EXPECT_EQ(spread_points(frame, of_800_by_600(), 3, std::vector<PointRank>(11)),
            (std::vector<std::size_t>{0, 1, 9}));
}

}  // namespace
}  // namespace limber
