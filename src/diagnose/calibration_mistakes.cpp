// SPDX-License-Identifier: MIT
#include "limber/diagnose/calibration_mistakes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>

#include "diagnose/directions.hpp"
#include "diagnose/rectification.hpp"
#include "limber/measure/epipolar.hpp"
#include "limber/measure/triangulate.hpp"

namespace limber {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kEnoughPoints = 100;
constexpr double kAgrees_px = 3.0;
constexpr double kFewAgree = 0.5, kMostAgree = 0.8;  // shares of the points
constexpr double kShareOutside = 0.01;
constexpr double kOffCentre = 0.2, kCorner = 0.6;  // of width and height

struct Mistake {
  Pose T_cam1_cam0;  ///< without it
  std::string words;
};

/// What may have been written instead of this rig.
std::vector<Mistake> possible_mistakes(const StereoCalibration& calibration) {
  const Pose given = pose_from_rig(calibration.theta);
  std::vector<Mistake> out = {
      {given.inverse(),
       "the two cameras are swapped (their images, or their calibrations), or T_cam1_cam0 is inverted"},
      {{given.R, -given.p}, "the baseline has the wrong sign"}};
  if (calibration.body == BodyFrame::kImu) {
    const Pose T_imu_cam0 = calibration.T_body_cam0;
    const Pose T_imu_cam1 = T_imu_cam0 * given.inverse();
    out.push_back({T_imu_cam1 * T_imu_cam0, "T_BS of cam1 is inverted" + std::string(kDirections)});
    out.push_back(
        {T_imu_cam1.inverse() * T_imu_cam0.inverse(), "T_BS of cam0 is inverted" + std::string(kDirections)});
    out.push_back(
        {T_imu_cam1 * T_imu_cam0.inverse(), "T_BS of both cameras is inverted" + std::string(kDirections)});
  }
  return out;
}

std::vector<StereoBearings> bearings_of(const StereoCalibration& calibration,
                                        std::span<const StereoFrame> frames) {
  std::vector<StereoBearings> out;
  for (const StereoFrame& frame : frames) {
    for (const StereoObservation& o : frame.observations) {
      if (const auto pair = detail::bearings(calibration, o)) {
        out.push_back(*pair);
      }
    }
  }
  return out;
}

bool agrees(const StereoBearings& pair, const Pose& T_cam1_cam0, double focal_px) {
  if (std::abs(detail::epipolar_error(pair, T_cam1_cam0)) * focal_px > kAgrees_px) {
    return false;
  }
  const Vector3d d0 = pair.cam0.normalized(), d1 = pair.cam1.normalized();
  const auto rho = inverse_depth_along(d0, d1, T_cam1_cam0);
  // Far points may lie a few pixels behind infinity.
  const double disparity_px = rho ? *rho * T_cam1_cam0.p.norm() * focal_px : 0.0;
  return disparity_px > -kAgrees_px && (T_cam1_cam0.R * d0).dot(d1) > 0.0;
}

double share_that_agrees(const std::vector<StereoBearings>& pairs, const Pose& T_cam1_cam0, double focal_px) {
  const auto count = std::count_if(pairs.begin(), pairs.end(), [&](const StereoBearings& pair) {
    return agrees(pair, T_cam1_cam0, focal_px);
  });
  return static_cast<double>(count) / static_cast<double>(pairs.size());
}

std::optional<std::string> geometry_mistake(const StereoCalibration& calibration,
                                            const std::vector<StereoBearings>& pairs) {
  if (pairs.size() < kEnoughPoints) {
    return std::nullopt;
  }
  const double focal_px = calibration.cam1.fu;
  const double given = share_that_agrees(pairs, pose_from_rig(calibration.theta), focal_px);
  if (given >= kFewAgree) {
    return std::nullopt;
  }
  double best = kMostAgree;
  std::optional<std::string> words;
  for (const Mistake& mistake : possible_mistakes(calibration)) {
    const double share = share_that_agrees(pairs, mistake.T_cam1_cam0, focal_px);
    if (share > best) {
      best = share;
      words =
          fmt::format("{}: {:.0f} % of the stereo points agree with the calibration, {:.0f} % would without",
                      mistake.words, 100.0 * given, 100.0 * share);
    }
  }
  return words;
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
  const std::vector<StereoBearings> pairs = bearings_of(calibration, frames);
  if (const auto mistake = geometry_mistake(calibration, pairs)) {
    out.push_back(*mistake);
  } else if (out.empty() && pairs.size() >= kEnoughPoints) {  // intrinsics of another resolution do not fit
    if (const auto lens = detail::rectification_mistake(calibration, frames)) {
      out.push_back(*lens);
    }
  }
  return out;
}

std::optional<std::string> placement_mistake(const StereoCalibration& calibration,
                                             std::span<const StereoFrame> frames) {
  return geometry_mistake(calibration, bearings_of(calibration, frames));
}

}  // namespace limber
