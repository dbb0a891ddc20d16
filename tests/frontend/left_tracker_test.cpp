// SPDX-License-Identifier: MIT
#include "frontend/left_tracker.hpp"

#include <gtest/gtest.h>

#include <map>
#include <opencv2/core.hpp>
#include <random>

#include "frontend/painted_room.hpp"

namespace limber::frontend {
namespace {

constexpr double kEdge = 180.0;  // [px] column where a near wall on the right begins in front of a far one
constexpr double kSpeed = 0.5;   // [px] that the near wall moves to the right in each frame
constexpr double kWrong = 0.2;   // [px]

double edge(int k) { return kEdge + kSpeed * k; }

cv::Mat1b two_walls(int k) {
  const Camera camera = testing::small_rig().cam0;
  std::mt19937_64 generator(static_cast<std::uint64_t>(k));
  std::normal_distribution<double> noise(0.0, 1.5);
  cv::Mat1b image(camera.height, camera.width);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const bool is_near = u >= edge(k);
      const double x = is_near ? u - kSpeed * k : u;
      const double grey = 128.0 + 60.0 * testing::lattice_noise(is_near, x / 15.0, v / 15.0) +
                          40.0 * testing::lattice_noise(2 + is_near, x / 5.0, v / 5.0);
      image(v, u) = cv::saturate_cast<std::uint8_t>(grey + noise(generator));
    }
  }
  return image;
}

TEST(LeftTracker, GivesUpPointsThatStandOnTwoThingsWhichMoveApart) {
  LeftTracker tracker(testing::small_rig().cam0, {});
  struct Birth {
    int frame;
    Eigen::Vector2d uv;
  };
  std::map<std::int64_t, Birth> births;
  double sightings = 0.0, wrong = 0.0;
  std::size_t old = 0;
  for (int k = 0; k < 16; ++k) {
    tracker.follow(pyramid_of(two_walls(k)));
    old = 0;
    for (const LeftTrack& track : tracker.tracks()) {
      const Birth& birth = births.try_emplace(track.id, Birth{k, track.uv()}).first->second;
      const double moved = birth.uv.x() >= edge(birth.frame) ? kSpeed * (k - birth.frame) : 0.0;
      sightings += 1.0;
      wrong += (track.uv() - birth.uv - Eigen::Vector2d(moved, 0.0)).norm() > kWrong;
      old += birth.frame == 0;
    }
  }
  EXPECT_LT(wrong / sightings, 0.02);  // 0.03 if they live on
  EXPECT_GT(old, 50u);                 // which is not bought with those that stand on one
}

}  // namespace
}  // namespace limber::frontend
