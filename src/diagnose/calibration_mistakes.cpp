// SPDX-License-Identifier: MIT
#include "limber/diagnose/calibration_mistakes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>

#include "diagnose/placement.hpp"
#include "diagnose/rectification.hpp"

namespace limber {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kEnoughPoints = 100;
constexpr double kShareOutside = 0.01;
constexpr double kOffCentre = 0.2, kCorner = 0.6;  // of width and height
constexpr double kLongestBaseline = 10.0;          // [m]: of what is taken for a rig

/// Lengths in another unit than metres. Neither images nor, for some seconds, an IMU contradict a rig that is
/// a thousand times as long in a world that is, too.
std::optional<std::string> unit_mistake(const StereoCalibration& calibration) {
  const double baseline = calibration.baseline();
  if (baseline < kLongestBaseline) {
    return std::nullopt;
  }
  return fmt::format(
      "the cameras are {0:.3g} m apart: is the calibration in mm (then {1:.3g} m) or cm ({2:.3g} m)? metres "
      "are expected",
      baseline, 1e-3 * baseline, 1e-2 * baseline);
}

void check_image(const Camera& camera, const std::vector<Vector2d>& pixels, const std::string& name,
                 std::vector<std::string>& out) {
  const Vector2d size(camera.width, camera.height);
  const Vector2d centre = Vector2d(camera.cu, camera.cv).cwiseQuotient(size);
  if ((centre - Vector2d::Constant(0.5)).cwiseAbs().maxCoeff() > kOffCentre) {
    out.push_back(
        fmt::format("the principal point of {} ({:.0f}, {:.0f}) lies far from the centre of {} x {} pixels: "
                    "intrinsics of "
                    "another resolution?",
                    name, camera.cu, camera.cv, camera.width, camera.height));
  }
  if (pixels.size() < kEnoughPoints) {
    return;
  }
  const auto outside = std::count_if(pixels.begin(), pixels.end(),
                                     [&](const Vector2d& uv) { return !in_image(camera, uv, -0.5); });
  const double share = static_cast<double>(outside) / static_cast<double>(pixels.size());
  Vector2d largest = Vector2d::Zero();
  for (const Vector2d& uv : pixels) {
    largest = largest.cwiseMax(uv);
  }
  if (share > kShareOutside) {
    out.push_back(
        fmt::format("{:.0f} % of the points of {} lie outside its {} x {} pixels, up to ({:.0f}, {:.0f}): "
                    "wrong resolution?",
                    100.0 * share, name, camera.width, camera.height, largest.x(), largest.y()));
  } else if (largest.cwiseQuotient(size).maxCoeff() < kCorner) {
    out.push_back(fmt::format(
        "no point of {} lies beyond ({:.0f}, {:.0f}) in an image of {} x {} pixels: wrong resolution?", name,
        largest.x(), largest.y(), camera.width, camera.height));
  }
}

}  // namespace

std::vector<std::string> calibration_mistakes(const StereoCalibration& calibration,
                                              std::span<const StereoFrame> frames) {
  std::vector<Vector2d> pixels0, pixels1;
  for (const StereoFrame& frame : frames) {
    for (const StereoObservation& o : frame.observations) {
      if (o.in_cam0) {
        pixels0.push_back(o.uv_cam0);
      }
      if (o.in_cam1) {
        pixels1.push_back(o.uv_cam1);
      }
    }
  }
  std::vector<std::string> out;
  check_image(calibration.cam0, pixels0, "cam0", out);
  check_image(calibration.cam1, pixels1, "cam1", out);
  if (const auto mistake = unit_mistake(calibration)) {
    out.push_back(*mistake);
  }
  const detail::StereoPairs pairs = detail::stereo_pairs(calibration, frames);
  if (const auto mistake = detail::placement_mistake(calibration, pairs)) {
    out.push_back(*mistake);
  } else if (out.empty() &&
             pairs.as_given.size() >= detail::kEnoughStereo) {  // intrinsics of another resolution do not fit
    const RigParameters turned = rig_from_pose(
        detail::turned_by_lines(pose_from_rig(calibration.theta), pairs.as_given, calibration.cam1.fu));
    if (const auto lens = detail::rectification_mistake(calibration, turned, frames)) {
      out.push_back(*lens);
    }
  }
  return out;
}

std::optional<std::string> placement_mistake(const StereoCalibration& calibration,
                                             std::span<const StereoFrame> frames) {
  const std::optional<std::string> units = unit_mistake(calibration);
  return units ? units : detail::placement_mistake(calibration, detail::stereo_pairs(calibration, frames));
}

}  // namespace limber
