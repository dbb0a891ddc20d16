// SPDX-License-Identifier: MIT
#include "limber/render/render_recording.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>

#include "datasets/files.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/frontend/stereo_tracker.hpp"
#include "limber/measure/rig.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

/// A small rig with lenses that differ, which bends by two degrees.
Scenario small_drone(double seconds) {
  Scenario scenario;
  scenario.duration = seconds;
  scenario.trajectory = FigureEightTrajectory{.half_length = 3.0, .min_speed = 0.8, .max_speed = 1.2};
  scenario.rig.cam0 = {230.0, 229.0, 186.0, 121.0, 376, 240, RadialTangential{-0.28, 0.07, 2e-4, 1e-4}};
  scenario.rig.cam1 = {228.0, 231.0, 190.0, 118.0, 376, 240, RadialTangential{-0.27, 0.06, -1e-4, 2e-4}};
  scenario.rig.theta << 0.0, 0.0, 0.0, -0.15, 0.0, 0.0;
  scenario.rig.T_imu_cam0.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  DecalibrationSignal bend;
  bend.amplitude << 0.02, -0.03, 0.035, 0.01, 0.0, 0.0;
  scenario.decalibration = {bend};
  return scenario;
}

/// Where both cameras are at a frame of a rendered recording.
struct TruePoses {
  TruePoses(const Recording& recording, std::int64_t t_ns) {
    StereoCalibration rig = recording.calibration;
    rig.theta = calibration_at(recording.calibration_true, t_ns);
    const auto body = groundtruth_at(recording.groundtruth, t_ns).value();
    T_world_cam0 = Pose{body.R_world_body, body.p_world_body} * body_from_cam0(rig);
    T_world_cam1 = T_world_cam0 * pose_from_rig(rig.theta).inverse();
  }
  Pose T_world_cam0, T_world_cam1;
};

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

/// Whether the picture around a pixel shows two things, one behind the other: what is tracked there is no
/// place.
bool on_an_edge(const Scene& scene, const Pose& T_world_cam, const Camera& camera,
                const Eigen::Vector2d& uv) {
  const auto range = [&](const Eigen::Vector2d& at) {
    const auto bearing = unproject(camera, at);
    const auto seen = bearing ? scene.hit(T_world_cam.p, T_world_cam.R * *bearing) : std::nullopt;
    return seen ? (seen->p - T_world_cam.p).norm() : 1e9;
  };
  const double here = range(uv);
  for (const Eigen::Vector2d& by :
       {Eigen::Vector2d(6, 6), Eigen::Vector2d(-6, 6), Eigen::Vector2d(6, -6), Eigen::Vector2d(-6, -6),
        Eigen::Vector2d(8, 0), Eigen::Vector2d(-8, 0), Eigen::Vector2d(0, 8), Eigen::Vector2d(0, -8)}) {
    if (std::abs(range(uv + by) / here - 1.0) > 0.2) return true;
  }
  return false;
}

class RenderedScene : public ::testing::TestWithParam<SceneKind> {};

TEST_P(RenderedScene, IsTrackedToLessThanASixthOfAPixel) {
  const testing::TemporaryFolder scratch;
  const Scenario scenario = small_drone(0.6);
  ASSERT_EQ(render_recording(scenario, 5, 0, {.scene = GetParam()}, scratch.path()), 13u);
  const Scene scene = PictureTruth(scenario, {.scene = GetParam()}, 5, 0).scene();
  const Recording recording = read_recording(scratch.path());
  StereoTracker tracker(recording.calibration);  // assumes the nominal rig
  std::map<std::int64_t, Eigen::Vector3d> places;
  std::vector<double> left, right;
  int edges = 0;
  for (const ImagePair& pair : recording.images) {
    const TruePoses poses(recording, pair.t_ns);
    for (const StereoObservation& point : tracker.process(pair.t_ns, pair.cam0, pair.cam1).observations) {
      const auto seen = scene.hit(
          poses.T_world_cam0.p, poses.T_world_cam0.R * *unproject(recording.calibration.cam0, point.uv_cam0));
      if (!seen) continue;
      if (on_an_edge(scene, poses.T_world_cam0, recording.calibration.cam0, point.uv_cam0)) {
        places.erase(point.track_id);
        ++edges;
        continue;
      }
      const auto [place, is_new] = places.try_emplace(point.track_id, seen->p);
      const auto expected0 =
          project(recording.calibration.cam0, poses.T_world_cam0.inverse() * place->second);
      if (!is_new && expected0) left.push_back((expected0->uv - point.uv_cam0).norm());
      const auto expected1 = project(recording.calibration.cam1, poses.T_world_cam1.inverse() * seen->p);
      if (point.in_cam1 && expected1) right.push_back((expected1->uv - point.uv_cam1).norm());
    }
  }
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
                         ::testing::Values(SceneKind::kRoom, SceneKind::kHall, SceneKind::kStreet));

TEST(PictureCamera, SeesTheSamePaintOfAPlaceFromEverywhere) {
  const Scenario scenario = small_drone(0.6);
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
      const auto seen = scene.hit(a.p, a.R * *unproject(camera, Eigen::Vector2d(u, v)));
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
  EXPECT_THROW(last_right("wrong", 1, {.noise = -1.0}), std::invalid_argument);
}

}  // namespace
}  // namespace limber
