// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <optional>
#include <vector>

#include "limber/frontend/stereo_tracker.hpp"
#include "limber/measure/rig.hpp"
#include "limber/render/picture_truth.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

/// Points that have been followed for so many frames, and those of them that are beyond a pixel from the
/// place where they began, unless that was on the edge of a thing.
struct Slid {
  int old = 0, beyond = 0;
};

Slid follow(const PictureTruth& truth, double rate, double duration, int frames) {
  const StereoCalibration& rig = truth.nominal();
  const PictureCamera left(rig.cam0), right(rig.cam1);
  StereoTracker tracker(rig);
  struct Begin {
    std::optional<Place> place;
    int age = 0;
  };
  std::map<std::int64_t, Begin> tracks;
  const SensorEffects effects{.noise = 2.0};
  std::uint64_t n = 0;
  Slid out;
  for (const std::int64_t t_ns : sample_times(rate, duration)) {
    const View eye = truth.view(0, 1e-9 * static_cast<double>(t_ns)),
               other = truth.view(1, 1e-9 * static_cast<double>(t_ns));
    const auto image0 = develop(left.light(truth.scene(), eye), rig.cam0, effects, n++),
               image1 = develop(right.light(truth.scene(), other), rig.cam1, effects, n++);
    const auto view = [](const Camera& camera, const std::vector<std::uint8_t>& pixels) {
      return GreyImage{camera.width, camera.height, camera.width, pixels.data()};
    };
    for (const StereoObservation& point :
         tracker.process(t_ns, view(rig.cam0, image0), view(rig.cam1, image1)).observations) {
      const auto [track, is_new] = tracks.try_emplace(point.track_id);
      Begin& begin = track->second;
      if (is_new && !truth.on_an_edge(0, t_ns, point.uv_cam0)) {
        begin.place = truth.place(0, t_ns, point.uv_cam0);
      }
      // Where it would be seen, hidden or not: what is hidden is no longer followed.
      const auto expected =
          begin.place ? project(rig.cam0, eye.T_world_cam.inverse() * begin.place->p) : std::nullopt;
      if (++begin.age <= frames || !expected) continue;
      ++out.old;
      out.beyond += (expected->uv - point.uv_cam0).norm() > 1.0;
    }
  }
  return out;
}

// Followed from view to view, points slid along the edges of things by and by (here 10 %), and the filter
// took that for motion.
TEST(LongTracks, StayWhereTheyBegan) {
  const Scenario scenario = testing::shipped("paper_i");
  const PictureTruth truth(scenario, {.scene = SceneKind::kHall}, 22, 0);
  const Slid found = follow(truth, scenario.stereo_rate, 2.5, 30);
  std::printf("%d points, %d beyond a pixel\n", found.old, found.beyond);
  ASSERT_GT(found.old, 1000);
  EXPECT_LT(found.beyond, 0.04 * found.old);
}

}  // namespace
}  // namespace limber
