// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "limber/datasets/interpolate.hpp"
#include "limber/run/run_recording.hpp"

/// Runs over short recordings, and what is expected of each.
namespace limber::testing {

inline RunOptions from_truth(Method method = Method::kLcekf) {
  RunOptions options;
  options.method = method;
  options.start = StartMode::kGroundTruth;
  return options;
}

inline RunRecord run(const Recording& recording, const RunOptions& options) {
  return run_recording(recording, options, matched_frames(recording));
}

inline void expect_sound(const RunRecord& record, std::size_t frames) {
  ASSERT_EQ(record.trajectory.size(), frames);
  EXPECT_EQ(record.frames.size(), frames);
  EXPECT_EQ(record.frame_ms.size(), frames);
  EXPECT_EQ(record.source_ms.size(), frames);
  for (std::size_t k = 0; k < frames; ++k) {
    const auto& P = record.trajectory[k].covariance.value();
    EXPECT_EQ(P, P.transpose());
    EXPECT_EQ(P.llt().info(), Eigen::Success) << k;
    EXPECT_EQ(record.trajectory[k].t_ns, record.frames[k].t_ns);
  }
}

inline double last_error(const Recording& recording, const RunRecord& record) {
  const TrajectoryRow& last = record.trajectory.back();
  const GroundTruthState truth = groundtruth_at(recording.truth.motion.states, last.t_ns).value();
  return (truth.p_world_body - last.T_world_body.p).norm();
}

inline bool same_run(const RunRecord& a, const RunRecord& b) {
  bool equal = a.trajectory.size() == b.trajectory.size() && a.landmarks == b.landmarks && a.theta == b.theta;
  for (std::size_t k = 0; equal && k < a.trajectory.size(); ++k) {
    const TrajectoryRow &x = a.trajectory[k], &y = b.trajectory[k];
    equal = x.t_ns == y.t_ns && x.T_world_body.p == y.T_world_body.p &&
            x.T_world_body.R == y.T_world_body.R && x.v_world_body == y.v_world_body &&
            x.bias_gyro == y.bias_gyro && x.bias_accel == y.bias_accel && x.covariance == y.covariance &&
            a.frames[k].nis == b.frames[k].nis;
  }
  return equal;
}

}  // namespace limber::testing
