// SPDX-License-Identifier: MIT
#include "limber/landmarks/landmark_budget.hpp"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "state/small_map.hpp"

namespace limber {
namespace {

using testing::empty_map;

constexpr std::int64_t kFrame = 50'000'000;

StereoCalibration small_images() {
  StereoCalibration out;
  out.cam0.width = out.cam1.width = 800;
  out.cam0.height = out.cam1.height = 600;
  return out;
}

/// Five metres ahead.
void add_landmark(Estimate& estimate, std::int64_t id, std::int64_t seen_ns) {
  testing::add_landmark_ahead(estimate, id, 5.0, 1e-3, seen_ns);
}

/// All in one field of the image.
StereoFrame frame_of(std::int64_t t_ns, const std::vector<std::int64_t>& ids) {
  StereoFrame frame;
  frame.t_ns = t_ns;
  for (const std::int64_t id : ids) {
    StereoObservation point;
    point.track_id = id;
    point.in_cam0 = true;
    point.uv_cam0 = {10.0 + static_cast<double>(id), 10.0};
    frame.observations.push_back(point);
  }
  return frame;
}

std::set<std::int64_t> ids_of(const StereoFrame& frame) {
  std::set<std::int64_t> out;
  for (const StereoObservation& point : frame.observations) {
    out.insert(point.track_id);
  }
  return out;
}

using Ids = std::set<std::int64_t>;

TEST(LandmarkBudget, LeavesAFrameWithRoomAlone) {
  LandmarkBudget budget(small_images(), 3);
  EXPECT_EQ(ids_of(budget.choose(frame_of(0, {5, 6, 7}), empty_map(), -1)), (Ids{5, 6, 7}));
}

TEST(LandmarkBudget, LandmarksInUseGoOnThenKnownOnesThenNewOnes) {
  Estimate estimate = empty_map();
  add_landmark(estimate, 8, 0);
  add_landmark(estimate, 9, kFrame);
  const StereoFrame frame = frame_of(2 * kFrame, {5, 6, 8, 9});
  for (const auto& [most, chosen] :
       std::vector<std::pair<std::size_t, Ids>>{{1, {9}}, {2, {8, 9}}, {3, {5, 8, 9}}}) {
    EXPECT_EQ(ids_of(LandmarkBudget(small_images(), most).choose(frame, estimate, kFrame)), chosen);
  }
}

TEST(LandmarkBudget, NewPointsTakeTheirTurn) {
  LandmarkBudget budget(small_images(), 2);
  const Estimate estimate = empty_map();
  EXPECT_EQ(ids_of(budget.choose(frame_of(0, {1, 2, 3}), estimate, -1)), (Ids{1, 2}));
  // What was chosen and became no landmark stands behind those that have waited.
  EXPECT_EQ(ids_of(budget.choose(frame_of(kFrame, {1, 2, 3}), estimate, 0)), (Ids{1, 3}));
  EXPECT_EQ(ids_of(budget.choose(frame_of(2 * kFrame, {1, 2, 3}), estimate, kFrame)), (Ids{1, 2}));
  // Who leaves the view for a frame waits anew.
  EXPECT_EQ(ids_of(budget.choose(frame_of(3 * kFrame, {1, 2}), estimate, 2 * kFrame)), (Ids{1, 2}));
  EXPECT_EQ(ids_of(budget.choose(frame_of(4 * kFrame, {1, 2, 3}), estimate, 3 * kFrame)), (Ids{1, 2}));
}

}  // namespace
}  // namespace limber
