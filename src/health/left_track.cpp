// SPDX-License-Identifier: MIT
#include "limber/health/left_track.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "limber/core/median.hpp"

namespace limber::detail {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kMoving_px = 3.0;  // rms of a track's left pixels about one point: it moved, or is none
constexpr std::size_t kShortestTrack = 4;  // frames
constexpr double kFarOff = 4.0;            // of the views' size: a mismatch
constexpr double kLeastFarOff_px = 1.0;
constexpr int kPixelSteps = 4;  // of Gauss-Newton

/// The point nearest to all rays, by distance over range. Noise of the bearings draws it nearer.
Vector3d midpoint(const std::vector<LeftView>& views) {
  const Vector3d& origin = views.front().T_world_cam0.p;
  Vector3d point = origin;
  for (int step = 0; step < 3; ++step) {
    Matrix3d N = Matrix3d::Zero();
    Vector3d n = Vector3d::Zero();
    for (const LeftView& view : views) {
      const Vector3d bearing = (view.T_world_cam0.R * view.d0).normalized();
      const double range2 = step == 0 ? 1.0 : std::max((point - view.T_world_cam0.p).squaredNorm(), 1e-6);
      const Matrix3d across = (Matrix3d::Identity() - bearing * bearing.transpose()) / range2;
      N += across;
      n += across * (view.T_world_cam0.p - origin);
    }
    point = origin + N.ldlt().solve(n);
  }
  return point;
}

/// Normal equations of the point's pixels (z = 1), which noise does not draw nearer.
struct PixelEquations {
  Matrix3d information = Matrix3d::Zero();
  Vector3d vector = Vector3d::Zero();
  std::vector<double> off;  // of each view
  bool in_front = true;
};

PixelEquations pixel_equations(const std::vector<LeftView>& views, const Vector3d& point) {
  PixelEquations out;
  for (const LeftView& view : views) {
    const Matrix3d& R = view.T_world_cam0.R;
    const Vector3d p = R.transpose() * (point - view.T_world_cam0.p);
    if (!(p.z() > 0.0)) {
      out.in_front = false;
      return out;
    }
    const Eigen::Vector2d r = view.d0.head<2>() - p.head<2>() / p.z();
    Eigen::Matrix<double, 2, 3> J;
    J << 1.0, 0.0, -p.x() / p.z(), 0.0, 1.0, -p.y() / p.z();
    J = (J / p.z() * R.transpose()).eval();
    out.information.noalias() += J.transpose() * J;
    out.vector.noalias() += J.transpose() * r;
    out.off.push_back(r.norm());
  }
  return out;
}

}  // namespace

namespace {

/// A point, and how far each view is off it; nothing behind a camera.
struct PointOfViews {
  LeftPoint point;
  std::vector<double> off;  // z = 1
};

std::optional<PointOfViews> fit(const std::vector<LeftView>& views) {
  Vector3d point = midpoint(views);
  PixelEquations pixels;
  for (int step = 0; step < kPixelSteps && pixels.in_front; ++step) {
    pixels = pixel_equations(views, point);
    point += pixels.information.ldlt().solve(pixels.vector);
  }
  pixels = pixel_equations(views, point);
  if (!pixels.in_front) {
    return std::nullopt;
  }
  return PointOfViews{{point, pixels.information.ldlt().solve(Matrix3d::Identity())}, std::move(pixels.off)};
}

}  // namespace

std::optional<LeftPoint> triangulate(std::vector<LeftView> views, double focal_px) {
  while (views.size() >= kShortestTrack) {
    const std::optional<PointOfViews> found = fit(views);
    if (!found) {
      return std::nullopt;
    }
    const double limit = std::max(kFarOff * sigma_of_magnitudes(found->off), kLeastFarOff_px / focal_px);
    std::size_t kept = 0;
    double squares = 0.0;
    for (std::size_t k = 0; k < views.size(); ++k) {
      if (found->off[k] <= limit) {
        views[kept++] = views[k];
        squares += found->off[k] * found->off[k];
      }
    }
    if (kept == views.size()) {
      const double rms = std::sqrt(squares / static_cast<double>(kept));
      return rms * focal_px <= kMoving_px ? std::optional(found->point) : std::nullopt;
    }
    views.resize(kept);
  }
  return std::nullopt;
}

}  // namespace limber::detail
