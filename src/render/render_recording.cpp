// SPDX-License-Identifier: MIT
#include "limber/render/render_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <future>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "limber/core/errors.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/measure/rig.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

constexpr int kBlurSteps = 8;         ///< instants of an exposure
constexpr double kSwingPeriod = 7.0;  ///< [s] of the exposure of both cameras

void require_sensible(const PictureOptions& options) {
  const auto require = [](bool holds, const char* what) {
    if (!holds) throw std::invalid_argument(fmt::format("render_recording: expected {}", what));
  };
  require(options.noise >= 0.0 && options.noise <= 100.0, "0 <= noise <= 100");
  require(options.gain_difference >= 0.0 && options.gain_difference < 1.0, "0 <= gain_difference < 1");
  require(options.vignetting >= 0.0 && options.vignetting <= 1.0, "0 <= vignetting <= 1");
  require(options.exposure >= 0.0 && options.exposure <= 1.0, "0 <= exposure <= 1 s");
}

/// A scenario in front of the lens.
class Studio {
 public:
  Studio(const Scenario& scenario, std::uint64_t seed, std::uint64_t run, const PictureOptions& options)
      : scenario_(scenario),
        options_(options),
        trajectory_(make_trajectory(scenario, seed, run)),
        decalibration_(scenario.decalibration, scenario.duration, seed, run),
        scene_(make_scene(scenario, options.scene, seed, run)),
        calibration_(nominal_calibration(scenario)),
        cameras_{PictureCamera(calibration_.cam0), PictureCamera(calibration_.cam1)} {}

  /// Grey values of one camera in frame n.
  [[nodiscard]] std::vector<std::uint8_t> picture(std::size_t camera, std::int64_t t_ns,
                                                  std::size_t n) const {
    std::vector<float> light;
    const int steps = options_.exposure > 0.0 ? kBlurSteps : 1;
    for (int k = 0; k < steps; ++k) {
      const double shift = options_.exposure * ((k + 0.5) / steps - 0.5);
      const double t = std::clamp(1e-9 * static_cast<double>(t_ns) + shift, 0.0, scenario_.duration);
      const auto part = cameras_[camera].light(scene_, camera_pose(camera, t));
      light.resize(part.size());
      for (std::size_t i = 0; i < part.size(); ++i) light[i] += part[i] / static_cast<float>(steps);
    }
    const double swing = std::sin(2.0 * M_PI * 1e-9 * static_cast<double>(t_ns) / kSwingPeriod);
    const double darker = camera == 1 ? options_.gain_difference : 0.0;
    const SensorEffects effects{options_.noise, 1.0 - darker + 0.5 * options_.gain_difference * swing,
                                options_.vignetting};
    return develop(light, camera == 0 ? calibration_.cam0 : calibration_.cam1, effects, 2 * n + camera);
  }

 private:
  [[nodiscard]] Pose camera_pose(std::size_t camera, double t) const {
    StereoCalibration rig = calibration_;
    rig.theta += decalibration_.at(std::llround(1e9 * t));
    const Pose T_world_cam0 = trajectory_.at(t).T_world_body * body_from_cam0(rig);
    return camera == 0 ? T_world_cam0 : T_world_cam0 * pose_from_rig(rig.theta).inverse();
  }

  const Scenario& scenario_;
  const PictureOptions& options_;
  SplineTrajectory trajectory_;
  Decalibration decalibration_;
  Scene scene_;
  StereoCalibration calibration_;
  std::array<PictureCamera, 2> cameras_;
};

void write_png(const fs::path& file, const Camera& camera, std::vector<std::uint8_t> pixels) {
  const cv::Mat image(camera.height, camera.width, CV_8U, pixels.data());
  if (!cv::imwrite(file.string(), image)) {
    throw DataError(file.string(), 0, "room to write the file", "a write that failed");
  }
}

void write_text(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) throw DataError(file.string(), 0, "room to write the file", "a write that failed");
}

/// The walls: with poses and theta they say where any pixel is seen by any other camera.
std::string walls_text(const Scene& scene) {
  std::string text = "#corner x,y,z [m],u x,y,z,v x,y,z,width [m],height [m]; seen from the side of u x v\n";
  for (const Wall& w : scene.walls()) {
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", w.corner.x(), w.corner.y(), w.corner.z(),
                        w.u.x(), w.u.y(), w.u.z(), w.v.x(), w.v.y(), w.v.z(), w.width, w.height);
  }
  return text;
}

}  // namespace

Scene make_scene(const Scenario& scenario, SceneKind kind, std::uint64_t seed, std::uint64_t run) {
  const SplineTrajectory trajectory = make_trajectory(scenario, seed, run);
  Eigen::AlignedBox3d free;
  for (double t = 0.0; t <= scenario.duration; t += 0.05) free.extend(trajectory.at(t).T_world_body.p);
  // Room for the rig, which may point anywhere.
  const double reach = 0.5 + 1.5 * scenario.rig.theta.tail<3>().norm() + scenario.rig.T_imu_cam0.p.norm();
  return {kind, {free.min().array() - reach, free.max().array() + reach}, seed};
}

std::size_t render_recording(const Scenario& scenario, std::uint64_t seed, std::uint64_t run,
                             const PictureOptions& options, const fs::path& folder,
                             const std::function<void(std::size_t)>& progress,
                             const std::function<bool()>& stop) {
  require_sensible(options);
  Recording recording = simulate(scenario, seed, run);
  recording.pixel_noise.reset();
  recording.landmarks_true.clear();
  write_track_log(recording, folder);
  const fs::path mav0 = folder / "mav0";
  fs::remove_all(mav0 / "tracks0");
  const Studio studio(scenario, seed, run, options);
  write_text(mav0 / "scene0" / "data.csv", walls_text(make_scene(scenario, options.scene, seed, run)));
  std::string list = "#timestamp [ns],filename\n";
  for (const char* camera : {"cam0", "cam1"}) fs::create_directories(mav0 / camera / "data");
  for (std::size_t n = 0; n < recording.frames.size(); ++n) {
    if (stop && stop()) throw std::runtime_error("stopped: nothing is written");
    const std::int64_t t_ns = recording.frames[n].t_ns;
    const std::string name = fmt::format("{:019}.png", t_ns);
    const auto take = [&](std::size_t camera) {
      write_png(mav0 / (camera == 0 ? "cam0" : "cam1") / "data" / name,
                camera == 0 ? recording.calibration.cam0 : recording.calibration.cam1,
                studio.picture(camera, t_ns, n));
    };
    auto right = std::async(std::launch::async, take, 1);
    take(0);
    right.get();
    list += fmt::format("{},{}\n", t_ns, name);
    if (progress) progress(n + 1);
  }
  for (const char* camera : {"cam0", "cam1"}) write_text(mav0 / camera / "data.csv", list);
  return recording.frames.size();
}

}  // namespace limber
