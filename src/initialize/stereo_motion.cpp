// SPDX-License-Identifier: MIT
#include "limber/initialize/stereo_motion.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_map>

#include "limber/core/so3.hpp"
#include "limber/measure/rig.hpp"
#include "limber/measure/stereo_model.hpp"
#include "limber/measure/triangulate.hpp"

namespace limber {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr std::size_t kFewestPairs = 6;
constexpr double kFarthestPair = 300.0;  // beyond, a triangulated point says nothing about translation
constexpr double kHuberPixels = 2.0;     // [px]
constexpr int kMotionIterations = 12;

/// Points of the first frame in its body frame.
using Points = std::unordered_map<std::int64_t, Vector3d>;

Points triangulate_first(const StereoFrame& frame, const MountedRig& rig) {
  const Pose T_body_cam0 = rig[0].T_cam_body.inverse();
  const Pose T_cam1_cam0 = rig[1].T_cam_body * T_body_cam0;
  const double lowest = 1.0 / (kFarthestPair * T_cam1_cam0.p.norm());
  Points points;
  for (const StereoObservation& o : frame.observations) {
    if (!o.in_cam0 || !o.in_cam1) {
      continue;
    }
    const std::optional<Vector3d> d0 = unproject(rig[0].camera, o.uv_cam0);
    const std::optional<Vector3d> d1 = unproject(rig[1].camera, o.uv_cam1);
    if (d0 && d1) {
      const double rho = inverse_depth_along(*d0, *d1, T_cam1_cam0).value_or(0.0);
      if (rho > lowest) {
        points[o.track_id] = T_body_cam0 * Vector3d(*d0 / rho);
      }
    }
  }
  return points;
}

/// Normal equations of one frame's left pixels at a pose; the weighted cost and the number of points.
struct Normal {
  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
  std::size_t points = 0;
};

Normal normal_equations(const StereoFrame& frame, const MountedRig& rig, const Points& points,
                        const Pose& T) {
  Normal out;
  Landmark landmark;
  landmark.kind = LandmarkKind::kCartesian;
  for (const StereoObservation& o : frame.observations) {
    const auto it = points.find(o.track_id);
    if (it == points.end() || !o.in_cam0) {
      continue;
    }
    landmark.value = it->second;
    const std::optional<PointProjection> projection = project_point(rig[0], body_point(T, landmark, nullptr));
    if (!projection) {
      continue;
    }
    const Vector2d r = o.uv_cam0 - projection->uv;
    const double weight = r.norm() <= kHuberPixels ? 1.0 : kHuberPixels / r.norm();
    Eigen::Matrix<double, 2, 6> J;
    J << projection->J_position, projection->J_attitude;
    out.A += weight * J.transpose() * J;
    out.b += weight * J.transpose() * r;
    ++out.points;
  }
  return out;
}

std::optional<Pose> locate(const StereoFrame& frame, const MountedRig& rig, const Points& points, Pose T) {
  for (int i = 0; i < kMotionIterations; ++i) {
    const Normal normal = normal_equations(frame, rig, points, T);
    if (normal.points < kFewestPairs) {
      return std::nullopt;
    }
    const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> ldlt(normal.A);
    const Eigen::Matrix<double, 6, 1> step = ldlt.solve(normal.b);
    if (ldlt.info() != Eigen::Success || !step.allFinite()) {
      return std::nullopt;
    }
    T.p += step.head<3>();
    T.R = so3_normalized(T.R * so3_exp(step.tail<3>()));
    if (step.norm() < 1e-9) {
      break;
    }
  }
  return T;
}

}  // namespace

std::vector<StampedPose> stereo_motion(std::span<const StereoFrame> frames,
                                       const StereoCalibration& calibration) {
  std::vector<StampedPose> motion;
  if (frames.empty()) {
    return motion;
  }
  const MountedRig rig = mount(calibration);
  const Points points = triangulate_first(frames.front(), rig);
  motion.push_back({frames.front().t_ns, Pose{}});
  for (const StereoFrame& frame : frames.subspan(1)) {
    const std::optional<Pose> T = locate(frame, rig, points, motion.back().T_world_body);
    if (!T) {
      break;
    }
    motion.push_back({frame.t_ns, *T});
  }
  return motion;
}

}  // namespace limber
