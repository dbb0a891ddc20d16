// SPDX-License-Identifier: MIT
#include "limber/render/picture_truth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "limber/core/time.hpp"
#include "limber/measure/rig.hpp"
#include "render/place_boxes.hpp"

namespace limber {
namespace {

constexpr int kRowIterations = 20;
constexpr double kSameRow = 1e-9;  ///< [px]
constexpr double kEdge = 0.2;      ///< change of the distance

const PictureOptions& require_sensible(const PictureOptions& options) {
  const auto require = [](bool holds, const char* what) {
    if (!holds) throw std::invalid_argument(fmt::format("render_recording: expected {}", what));
  };
  const auto is_share = [](double x) { return x >= 0.0 && x <= 1.0; };
  require(options.noise >= 0.0 && options.noise <= 100.0, "0 <= noise <= 100");
  require(options.gain_difference >= 0.0 && options.gain_difference < 1.0, "0 <= gain_difference < 1");
  require(is_share(options.vignetting), "0 <= vignetting <= 1");
  require(options.exposure >= 0.0 && options.exposure <= 1.0, "0 <= exposure <= 1 s");
  require(options.rolling_shutter >= 0.0 && options.rolling_shutter <= 1.0, "0 <= rolling_shutter <= 1 s");
  require(options.moving_objects >= 0 && options.moving_objects <= 100, "0 <= moving_objects <= 100");
  require(is_share(options.low_texture), "0 <= low_texture <= 1");
  require(is_share(options.dropped), "0 <= dropped <= 1");
  require(is_share(options.swapped), "0 <= swapped <= 1");
  return options;
}

/// The world around a trajectory: nothing stands where the rig goes.
Scene scene_around(const SplineTrajectory& trajectory, const Scenario& scenario,
                   const PictureOptions& options, std::uint64_t seed) {
  Eigen::AlignedBox3d free;
  for (double t = 0.0; t <= scenario.duration; t += 0.05) free.extend(trajectory.at(t).T_world_body.p);
  // Room for the rig, which may point anywhere.
  const double reach = 0.5 + 1.5 * scenario.rig.theta.tail<3>().norm() + scenario.rig.T_imu_cam0.p.norm();
  return {options.scene, {free.min().array() - reach, free.max().array() + reach}, seed, options.low_texture};
}

}  // namespace

PictureTruth::PictureTruth(const Scenario& scenario, const PictureOptions& options, std::uint64_t seed,
                           std::uint64_t run)
    : duration_(scenario.duration),
      rolling_shutter_(require_sensible(options).rolling_shutter),
      trajectory_(make_trajectory(scenario, seed, run)),
      decalibration_(scenario.decalibration, scenario.duration, seed, run),
      calibration_(nominal_calibration(scenario)),
      scene_(scene_around(trajectory_, scenario, options, seed)) {
  const auto cameras = [this](double t) {
    return std::array{view(0, t).T_world_cam, view(1, t).T_world_cam};
  };
  detail::add_moving_boxes(scene_, options.scene, options.moving_objects, {cameras, duration_}, seed, run);
}

double PictureTruth::time_of_row(std::size_t camera, std::int64_t stamp_ns, double v) const {
  return to_seconds(stamp_ns) + (v / lens(camera).height - 0.5) * rolling_shutter_;
}

View PictureTruth::view(std::size_t camera, double t) const {
  const double within = std::clamp(t, 0.0, duration_);
  const std::int64_t t_ns = std::llround(1e9 * within);
  const TrueRig rig{t_ns, calibration_.theta + decalibration_.at(t_ns)};
  const Pose T_world_cam0 = trajectory_.at(within).T_world_body * body_from_cam0(calibration_, rig);
  return {t, camera == 0 ? T_world_cam0 : T_world_cam0 * pose_from_rig(rig.theta).inverse()};
}

std::optional<Place> PictureTruth::place(std::size_t camera, std::int64_t stamp_ns,
                                         const Eigen::Vector2d& uv) const {
  const auto bearing = unproject(lens(camera), uv);
  if (!bearing) return std::nullopt;
  const View from = view(camera, time_of_row(camera, stamp_ns, uv.y()));
  return scene_.hit(from.T_world_cam.p, from.T_world_cam.R * *bearing, from.t);
}

std::optional<Eigen::Vector2d> PictureTruth::pixel(std::size_t camera, std::int64_t stamp_ns,
                                                   const Place& place) const {
  double row = 0.5 * lens(camera).height;
  for (int k = 0; k < kRowIterations; ++k) {  // the row says when, and when says the row
    const View from = view(camera, time_of_row(camera, stamp_ns, row));
    const auto seen = project(lens(camera), from.T_world_cam.inverse() * scene_.moved(place, from.t));
    if (!seen) return std::nullopt;
    if (std::abs(seen->uv.y() - row) < kSameRow || rolling_shutter_ == 0.0) return seen->uv;
    row = seen->uv.y();
  }
  return std::nullopt;
}

bool PictureTruth::on_an_edge(std::size_t camera, std::int64_t stamp_ns, const Eigen::Vector2d& uv,
                              double radius) const {
  const auto distance = [&](const Eigen::Vector2d& at) {
    const auto seen = place(camera, stamp_ns, at);
    return seen ? (seen->p - view(camera, seen->t).T_world_cam.p).norm() : 1e9;
  };
  const double here = distance(uv), diagonal = 0.75 * radius;
  for (const Eigen::Vector2d& by :
       {Eigen::Vector2d(diagonal, diagonal), Eigen::Vector2d(-diagonal, diagonal),
        Eigen::Vector2d(diagonal, -diagonal), Eigen::Vector2d(-diagonal, -diagonal),
        Eigen::Vector2d(radius, 0), Eigen::Vector2d(-radius, 0), Eigen::Vector2d(0, radius),
        Eigen::Vector2d(0, -radius)}) {
    if (std::abs(distance(uv + by) / here - 1.0) > kEdge) return true;
  }
  return false;
}

}  // namespace limber
