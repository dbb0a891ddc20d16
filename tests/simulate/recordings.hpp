// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

#include "limber/datasets/interpolate.hpp"
#include "limber/datasets/recording.hpp"
#include "limber/sensors/camera.hpp"
#include "same_frames.hpp"

/// What tests ask of simulated recordings.
namespace limber::testing {

inline bool same(const ImuSample& a, const ImuSample& b) {
  return a.t_ns == b.t_ns && a.omega_imu == b.omega_imu && a.accel_imu == b.accel_imu;
}

inline bool same(const OdometrySample& a, const OdometrySample& b) {
  return a.t_ns == b.t_ns && a.v_body == b.v_body && a.omega_body == b.omega_body;
}

inline bool same(const GroundTruthState& a, const GroundTruthState& b) {
  return a.t_ns == b.t_ns && a.R_world_body == b.R_world_body && a.p_world_body == b.p_world_body &&
         a.v_world_body == b.v_world_body && a.bias_gyro == b.bias_gyro && a.bias_accel == b.bias_accel;
}

inline bool same(const TrueRig& a, const TrueRig& b) { return a.t_ns == b.t_ns && a.theta == b.theta; }

/// Whether two lists hold the same bits.
template <typename T>
bool same(const std::vector<T>& a, const std::vector<T>& b) {
  bool equal = a.size() == b.size();
  for (std::size_t i = 0; equal && i < a.size(); ++i) {
    equal = same(a[i], b[i]);
  }
  return equal;
}

/// Residual (u0, v0, u1, v1) [px] of an observation against the recording's own truth; NaN where a camera did
/// not see the point. For the body kImu (cam0 is the body where T_body_cam0 is the identity).
using ResidualVisitor =
    std::function<void(const StereoFrame&, const StereoObservation&, const Eigen::Vector4d&)>;

inline void visit_residuals(const Recording& recording, const ResidualVisitor& visit) {
  for (const StereoFrame& frame : recording.frames) {
    const GroundTruthState state = groundtruth_at(recording.truth.motion.states, frame.t_ns).value();
    const Pose T_world_cam0 =
        Pose{state.R_world_body, state.p_world_body} * recording.calibration.T_body_cam0;
    const Pose T_cam1_cam0 = pose_from_rig(true_rig_at(recording.truth.rig, frame.t_ns).theta);
    for (const StereoObservation& o : frame.observations) {
      const Eigen::Vector3d X_cam0 = T_world_cam0.inverse() * recording.truth.landmarks.at(o.track_id);
      Eigen::Vector4d residual = Eigen::Vector4d::Constant(std::nan(""));
      residual.head<2>() = o.uv_cam0 - project(recording.calibration.cam0, X_cam0).value().uv;
      if (o.in_cam1) {
        residual.tail<2>() = o.uv_cam1 - project(recording.calibration.cam1, T_cam1_cam0 * X_cam0).value().uv;
      }
      visit(frame, o, residual);
    }
  }
}

}  // namespace limber::testing
