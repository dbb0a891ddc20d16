// SPDX-License-Identifier: MIT
#include "limber/render/render_recording.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "datasets/files.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/frontend/stereo_tracker.hpp"
#include "render/small_drone.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

using testing::small_drone;

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double share_above(const std::vector<double>& values, double limit) {
  return static_cast<double>(
             std::count_if(values.begin(), values.end(), [&](double v) { return v > limit; })) /
         static_cast<double>(values.size());
}

/// How far the tracker's pixels are from the truth [px].
struct TrackingErrors {
  std::vector<double> left, right;    ///< of points of the world
  std::vector<double> left_on_boxes;  ///< of points on boxes that move
  int edges = 0;                      ///< points that are not judged
};

TrackingErrors tracking_errors(const Scenario& scenario, const PictureOptions& options) {
  const testing::TemporaryFolder scratch;
  EXPECT_EQ(render_recording(scenario, 5, 0, options, scratch.path()), 13u);
  const PictureTruth truth(scenario, options, 5, 0);
  const Recording recording = read_recording(scratch.path());
  StereoTracker tracker(recording.calibration);  // assumes the nominal rig
  std::map<std::int64_t, Place> places;
  TrackingErrors errors;
  for (const ImagePair& pair : recording.images) {
    for (const StereoObservation& point : tracker.process(pair.t_ns, pair.cam0, pair.cam1).observations) {
      const auto seen = truth.place(0, pair.t_ns, point.uv_cam0);
      if (!seen) continue;
      if (truth.on_an_edge(0, pair.t_ns, point.uv_cam0)) {
        places.erase(point.track_id);
        ++errors.edges;
        continue;
      }
      const auto [place, is_new] = places.try_emplace(point.track_id, *seen);
      const auto expected0 = truth.pixel(0, pair.t_ns, place->second);
      auto& left = place->second.box ? errors.left_on_boxes : errors.left;
      if (!is_new && expected0) left.push_back((*expected0 - point.uv_cam0).norm());
      const auto expected1 = truth.pixel(1, pair.t_ns, *seen);
      if (point.in_cam1 && expected1) errors.right.push_back((*expected1 - point.uv_cam1).norm());
    }
  }
  return errors;
}

class RenderedScene : public ::testing::TestWithParam<PictureOptions> {};

TEST_P(RenderedScene, IsTrackedToLessThanASixthOfAPixel) {
  const auto [left, right, on_boxes, edges] = tracking_errors(small_drone(0.6), GetParam());
  std::printf(
      "left %.4f px rms, right %.4f px rms, beyond 1 px %.4f and %.4f, %zu and %zu points, %d on edges\n",
      rms(left), rms(right), share_above(left, 1.0), share_above(right, 1.0), left.size(), right.size(),
      edges);
  ASSERT_GT(left.size(), 500u);
  ASSERT_GT(right.size(), 500u);
  EXPECT_LT(rms(left), 0.15);
  EXPECT_LT(rms(right), 0.15);
  EXPECT_LT(share_above(left, 1.0), 0.005);
  EXPECT_LT(share_above(right, 1.0), 0.005);
}
INSTANTIATE_TEST_SUITE_P(Scenes, RenderedScene,
                         ::testing::Values(PictureOptions{.scene = SceneKind::kRoom},
                                           PictureOptions{.scene = SceneKind::kHall},
                                           PictureOptions{.scene = SceneKind::kStreet},
                                           PictureOptions{.rolling_shutter = 0.03}));

TEST(MovingBoxes, AreTrackedWhereTheyGoAndTheWorldBesideThem) {
  auto [left, right, on_boxes, edges] = tracking_errors(small_drone(0.6), {.moving_objects = 3});
  ASSERT_GT(left.size(), 500u);
  ASSERT_GT(on_boxes.size(), 30u);
  EXPECT_LT(rms(left), 0.15);
  EXPECT_LT(rms(right), 0.15);
  std::sort(on_boxes.begin(), on_boxes.end());
  EXPECT_LT(on_boxes[on_boxes.size() / 2], 0.15);  // some slide along the edges of boxes
}

TEST(RenderedFaults, RepeatFramesAndDelayTheRightCamera) {
  const testing::TemporaryFolder sound, faulty;
  Scenario scenario = small_drone(0.3);
  ASSERT_EQ(render_recording(scenario, 5, 0, {}, sound.path()), 7u);
  scenario.faults = {FramesRepeated{.at = 0.1, .duration = 0.1},
                     RightLate{.at = 0.2, .duration = 0.1, .delay = 0.05}};
  ASSERT_EQ(render_recording(scenario, 5, 0, {}, faulty.path()), 7u);
  const auto image = [](const testing::TemporaryFolder& folder, const char* camera, int k) {
    return testing::read_text(folder.path() / "mav0" / camera / "data" /
                              fmt::format("{:019}.png", 50'000'000L * k));
  };
  const std::array<int, 7> left = {0, 1, 1, 1, 4, 5, 6}, right = {0, 1, 1, 1, 3, 4, 6};
  for (int k = 0; k < 7; ++k) {
    EXPECT_EQ(image(faulty, "cam0", k), image(sound, "cam0", left[k])) << k;
    EXPECT_EQ(image(faulty, "cam1", k), image(sound, "cam1", right[k])) << k;
  }
  EXPECT_NE(image(sound, "cam0", 3), image(sound, "cam0", 4));
}

class PictureLens : public ::testing::TestWithParam<Distortion> {};

TEST_P(PictureLens, SeesTheSamePaintOfAPlaceFromEverywhere) {
  Scenario scenario = small_drone(0.6);
  scenario.rig.cam0.distortion = GetParam();
  const Scene scene = PictureTruth(scenario, {}, 2, 0).scene();
  const Camera& camera = scenario.rig.cam0;
  const PictureCamera pictures(camera);
  const SplineTrajectory trajectory = make_trajectory(scenario, 2, 0);
  const Pose a = trajectory.at(0.0).T_world_body * scenario.rig.T_imu_cam0;
  const Pose b = trajectory.at(0.05).T_world_body * scenario.rig.T_imu_cam0;
  const std::vector<float> in_a = pictures.light(scene, View{0.0, a}),
                           in_b = pictures.light(scene, View{0.05, b});
  std::vector<double> differences;
  for (int v = 20; v < 220; v += 7) {
    for (int u = 20; u < 356; u += 7) {
      const auto bearing = unproject(camera, Eigen::Vector2d(u, v));
      ASSERT_TRUE(bearing) << u << " " << v;
      const auto seen = scene.hit(a.p, a.R * *bearing);
      const auto again = project(camera, b.inverse() * seen->p);
      if (!again || !in_image(camera, again->uv, 2.0)) continue;
      const Eigen::Vector2d whole = again->uv.array().floor(), part = again->uv - whole;
      const auto at = [&](int du, int dv) {
        return in_b[static_cast<std::size_t>((static_cast<int>(whole.y()) + dv) * camera.width +
                                             static_cast<int>(whole.x()) + du)];
      };
      const double grey = (1 - part.y()) * ((1 - part.x()) * at(0, 0) + part.x() * at(1, 0)) +
                          part.y() * ((1 - part.x()) * at(0, 1) + part.x() * at(1, 1));
      differences.push_back(std::abs(grey - in_a[static_cast<std::size_t>(v * camera.width + u)]));
    }
  }
  ASSERT_GT(differences.size(), 800u);
  std::sort(differences.begin(), differences.end());
  EXPECT_LT(differences[differences.size() / 2], 3.0);  // of 16 to 240: interpolation of an image with edges
}

INSTANTIATE_TEST_SUITE_P(
    Lenses, PictureLens,
    ::testing::Values(Distortion(RadialTangential{-0.28, 0.07, 2e-4, 1e-4}),
                      Distortion(Equidistant{-0.01, 0.002, 0.0, 0.0}),
                      Distortion(Rational{-0.25, 0.08, 2e-3, 1e-3, -0.01, 0.0, 0.0, 0.0}),
                      Distortion(Rational{0.46, -2.6, 1e-3, -2e-4, 1.5, 0.34, -2.4, 1.4}),
                      Distortion(Omni{1.2, -0.3, 0.1, 6e-4, 5e-4})),
    [](const auto& test) { return "Lens" + std::to_string(test.index); });

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(RenderRecording, GivesTheSameBitsAgainAndOthersWithEverySwitch) {
  const testing::TemporaryFolder scratch;
  const Scenario scenario = small_drone(0.05);
  const auto last_right = [&](const std::string& name, std::uint64_t seed, const PictureOptions& options) {
    render_recording(scenario, seed, 0, options, scratch.path() / name);
    return bytes_of(read_recording(scratch.path() / name).images.back().cam1);
  };
  const std::string plain = last_right("plain", 1, {});
  EXPECT_EQ(plain, last_right("again", 1, {}));
  EXPECT_NE(plain, last_right("seed", 2, {}));
  EXPECT_NE(plain, last_right("noise", 1, {.noise = 2.0}));
  EXPECT_NE(plain, last_right("gain", 1, {.gain_difference = 0.2}));
  EXPECT_NE(plain, last_right("corners", 1, {.vignetting = 0.3}));
  EXPECT_NE(plain, last_right("blur", 1, {.exposure = 0.02}));
  EXPECT_TRUE(fs::exists(scratch.path() / "plain" / "mav0" / "scene0" / "data.csv"));
  EXPECT_NE(plain, last_right("rolling", 1, {.rolling_shutter = 0.02}));
  EXPECT_NE(plain, last_right("plain walls", 1, {.low_texture = 0.5}));
  EXPECT_NE(plain, last_right("swapped", 1, {.swapped = 1.0}));
  EXPECT_THROW(last_right("wrong", 1, {.noise = -1.0}), std::invalid_argument);
}

}  // namespace
}  // namespace limber
