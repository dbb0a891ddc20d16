// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "limber/core/so3.hpp"
#include "limber/run_files/run_output.hpp"

namespace limber::testing {

/// The files of a run that never was: a walk of 2 m/s, ten frames a second, and an estimate with the errors
/// asked for.
struct RunFilesOf {
  explicit RunFilesOf(std::string name) : method(std::move(name)) {}

  std::string method, recording = "walk", constraints;
  double seconds = 60.0;
  double scale = 1.0;  ///< of the estimate
  double drift = 0.0;  ///< standard deviation of the position after a second [m]
  double yaw = 0.0;    ///< of the world of estimate and truth.tum [rad]
  double bend = 0.0;   ///< of the path: another motion
  double truth_roll = 0.0;
  std::uint64_t seed = 1;
  std::int64_t begin_ns = 1'000'000'000'000;
  std::size_t frames_of_recording = 0;  ///< 0: those of the run
  std::size_t observed = 30;
  bool complete = true, has_truth = true;
  double lost_after_s = 0.0;  ///< 0: never
  double sigma_px = 0.0;      ///< 0: by default
  RigParameters theta_assumed = RigParameters::Zero();

  [[nodiscard]] static Eigen::Vector3d position(double t, double bend = 0.0) {
    const double s = 2.0 * t;  // a large circle, up and down a little
    return {40.0 * std::sin(s / 40.0), 40.0 * (1.0 - std::cos(s / 40.0)) + bend * s, 0.5 * std::sin(0.3 * t)};
  }

  void write(const std::filesystem::path& folder) const {
    RunOptions options;
    options.method = method_from_string(method);
    if (sigma_px > 0.0) {
      options.sigma_px = sigma_px;
    }
    if (!constraints.empty()) {
      options.constraints = constraint_set_from_string(constraints);
    }
    const RunRecord record = make_record();
    RunSummary summary;
    summary.method = method;
    summary.dataset = recording;
    summary.frames = record.frames.size();
    summary.anees = 1.5;
    summary.ms_per_frame_p50 = 2.0;
    summary.ms_per_frame_p99 = 3.0;
    summary.alignment = has_truth ? "position and yaw of the first pose" : "";
    summary.health.emplace();
    summary.health->verdict = HealthVerdict::kDegraded;
    if (lost_after_s > 0.0) {
      summary.inputs.lost_since_ns = begin_ns + static_cast<std::int64_t>(1e9 * lost_after_s);
    }
    if (has_truth) {
      for (const TrajectoryRow& row : record.trajectory) {
        summary.truth.push_back({row.t_ns, truth_at(1e-9 * static_cast<double>(row.t_ns - begin_ns))});
      }
    }
    write_run_output(folder, options, record, summary);
    std::filesystem::remove(folder / "health.csv");  // no window ends in these frames
  }

 private:
  [[nodiscard]] Pose truth_at(double t) const {
    const Eigen::Matrix3d R = so3_exp({0.0, 0.0, yaw}) * so3_exp({truth_roll, 0.0, 0.0});
    return {R, R * position(t, bend)};
  }

  [[nodiscard]] RunRecord make_record() const {
    RunRecord record;
    std::mt19937_64 generator(seed);
    std::normal_distribution<double> step(0.0, drift * std::sqrt(0.1));
    Eigen::Vector3d walked = Eigen::Vector3d::Zero();
    const Eigen::Matrix3d R = so3_exp({0.0, 0.0, yaw});
    const auto frames = static_cast<std::size_t>(std::lround(10.0 * seconds)) + 1;
    for (std::size_t k = 0; k < frames; ++k) {
      const double t = 0.1 * static_cast<double>(k);
      TrajectoryRow row;
      row.t_ns = begin_ns + static_cast<std::int64_t>(k) * 100'000'000;
      row.T_world_body = {R, R * (scale * position(t, bend) + walked)};
      row.covariance = Eigen::Matrix<double, 6, 6>::Identity();
      row.covariance->bottomRightCorner<3, 3>() *= 1e-4;
      record.trajectory.push_back(row);
      FrameReport frame;
      frame.t_ns = row.t_ns;
      frame.observed = observed;
      record.frames.push_back(frame);
      record.frame_ms.push_back(2.0);
      record.source_ms.push_back(0.0);
      if (drift > 0.0) {
        walked += Eigen::Vector3d(step(generator), step(generator), step(generator));
      }
    }
    record.theta_assumed = theta_assumed;
    record.frames_of_recording = frames_of_recording > 0 ? frames_of_recording : frames;
    record.stopped = !complete;
    return record;
  }
};

}  // namespace limber::testing
