// SPDX-License-Identifier: MIT
#include "limber/diagnose/time_offset.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "diagnose/epipolar_error.hpp"
#include "limber/core/median.hpp"
#include "limber/core/so3.hpp"
#include "limber/core/time.hpp"
#include "limber/initialize/stereo_motion.hpp"

namespace limber {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLongestStep = 0.3;  // [s] between frames that follow each other
constexpr std::size_t kEnoughRows = 200, kEnoughPairs = 50;
constexpr double kHuber = 2.0;  // robust standard deviations
constexpr double kMadToSigma = 1.4826;
constexpr int kReweightings = 5, kShifts = 8;
constexpr double kDerivativeStep = 1e-6;  // of numerical derivatives [rad, shares of the baseline]
constexpr double kLargestOffset = 1.0;    // [s]

/// Rows of y = A x + noise; rows of one cluster share their noise. Z are the instruments: the same as A, but
/// where A is measured with noise, something that goes with it and has noise of its own. Without them noise
/// in A would make x too small.
struct Rows {
  std::vector<VectorXd> A, Z;
  std::vector<double> y;
  std::vector<std::int64_t> cluster;
};

struct Solution {
  VectorXd x;
  double sigma_of_last = 0.0;
};

double robust_sigma(std::vector<double> residuals) {
  for (double& r : residuals) {
    r = std::abs(r);
  }
  return kMadToSigma * upper_median(std::move(residuals));
}

/// Iteratively reweighted instrumental variables, with a covariance that is robust to clusters.
std::optional<Solution> solve(const Rows& rows) {
  const Eigen::Index n = rows.A.front().size();
  VectorXd x = VectorXd::Zero(n);
  MatrixXd A;
  std::map<std::int64_t, VectorXd> scores;
  for (int i = 0; i < kReweightings; ++i) {
    std::vector<double> residuals;
    for (std::size_t k = 0; k < rows.y.size(); ++k) {
      residuals.push_back(rows.y[k] - rows.A[k].dot(x));
    }
    const double limit = kHuber * robust_sigma(residuals);
    A = MatrixXd::Zero(n, n);
    VectorXd b = VectorXd::Zero(n);
    scores.clear();
    for (std::size_t k = 0; k < rows.y.size(); ++k) {
      const double size = std::abs(residuals[k]);
      const double weight = size <= limit || size == 0.0 ? 1.0 : limit / size;
      A += weight * rows.Z[k] * rows.A[k].transpose();
      b += weight * residuals[k] * rows.Z[k];
      auto& score = scores.try_emplace(rows.cluster[k], VectorXd::Zero(n)).first->second;
      score += weight * residuals[k] * rows.Z[k];
    }
    const Eigen::FullPivLU<MatrixXd> factor(A);
    if (!factor.isInvertible()) {
      return std::nullopt;
    }
    x += factor.solve(b);
  }
  MatrixXd B = MatrixXd::Zero(n, n);
  for (const auto& [cluster, score] : scores) {
    B += score * score.transpose();
  }
  const MatrixXd inverse = A.inverse();
  return Solution{x, std::sqrt((inverse * B * inverse.transpose())(n - 1, n - 1))};
}

/// The rig moved along one of the five directions that stereo points alone can see.
std::array<Pose, 5> moved_rigs(const RigParameters& theta) {
  const Vector3d t = theta.tail<3>();
  const Eigen::Matrix3d basis = Eigen::HouseholderQR<Vector3d>(t).householderQ();
  std::array<Pose, 5> out;
  for (Eigen::Index k = 0; k < 5; ++k) {
    RigParameters step = RigParameters::Zero();
    if (k < 3) {
      step(k) = kDerivativeStep;
    } else {
      step.tail<3>() = kDerivativeStep * t.norm() * basis.col(k - 2);
    }
    out[static_cast<std::size_t>(k)] = pose_from_rig(theta + step);
  }
  return out;
}

using Followed = std::unordered_map<std::int64_t, StereoBearings>;

Followed followed(const StereoCalibration& calibration, const StereoFrame& frame) {
  Followed out;
  for (const StereoObservation& o : frame.observations) {
    if (const auto pair = detail::bearings(calibration, o)) {
      out[o.track_id] = *pair;
    }
  }
  return out;
}

Rows epipolar_rows(const StereoCalibration& calibration, std::span<const StereoFrame> frames) {
  const Pose T_cam1_cam0 = pose_from_rig(calibration.theta);
  const std::array<Pose, 5> moved = moved_rigs(calibration.theta);
  Rows rows;
  Followed before = followed(calibration, frames[0]), now = followed(calibration, frames[1]);
  for (std::size_t n = 1; n + 1 < frames.size(); ++n) {
    Followed after = followed(calibration, frames[n + 1]);
    const double dt = seconds_between(frames[n - 1].t_ns, frames[n + 1].t_ns);
    for (const auto& [id, pair] : now) {
      const auto a = before.find(id), b = after.find(id);
      if (a == before.end() || b == after.end() || dt > 2.0 * kLongestStep) {
        continue;
      }
      const double error = detail::epipolar_error(pair, T_cam1_cam0);
      VectorXd row(6);
      for (std::size_t k = 0; k < 5; ++k) {
        row(static_cast<Eigen::Index>(k)) =
            (detail::epipolar_error(pair, moved[k]) - error) / kDerivativeStep;
      }
      const Vector3d line = detail::epipolar_line(pair.cam0, T_cam1_cam0);
      row(5) = line.dot(b->second.cam1 - a->second.cam1) / dt;
      rows.A.push_back(row);
      row(5) = line.dot(T_cam1_cam0.R * (b->second.cam0 - a->second.cam0)) / dt;
      rows.Z.push_back(row);
      rows.y.push_back(error);
      rows.cluster.push_back(id);
    }
    before = std::move(now);
    now = std::move(after);
  }
  return rows;
}

/// The gyro's rate at a time, linear between samples; nothing outside of them.
std::optional<Vector3d> rate_at(std::span<const ImuSample> imu, double t_s) {
  const auto t_ns = static_cast<std::int64_t>(std::llround(1e9 * t_s)) + imu.front().t_ns;
  const auto b = std::upper_bound(imu.begin(), imu.end(), t_ns,
                                  [](std::int64_t t, const ImuSample& sample) { return t < sample.t_ns; });
  if (b == imu.begin() || b == imu.end()) {
    return std::nullopt;
  }
  const auto a = b - 1;
  const double share = seconds_between(a->t_ns, t_ns) / seconds_between(a->t_ns, b->t_ns);
  return Vector3d((1.0 - share) * a->omega_imu + share * b->omega_imu);
}

/// Mean rate between two times, by Simpson's rule on two intervals.
std::optional<Vector3d> mean_rate(std::span<const ImuSample> imu, double begin_s, double end_s) {
  constexpr std::array kWeights = {1.0, 4.0, 2.0, 4.0, 1.0};
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < kWeights.size(); ++k) {
    const auto rate = rate_at(imu, begin_s + (end_s - begin_s) * static_cast<double>(k) / 4.0);
    if (!rate) {
      return std::nullopt;
    }
    sum += kWeights[k] / 12.0 * *rate;
  }
  return sum;
}

struct Turn {
  double begin_s = 0.0, end_s = 0.0;  ///< since the first IMU sample
  Vector3d rate;                      ///< by the cameras [rad/s]
};

std::vector<Turn> turns_of(const StereoCalibration& calibration, std::span<const StereoFrame> frames,
                           std::int64_t origin_ns) {
  std::vector<Turn> out;
  for (std::size_t n = 0; n + 1 < frames.size(); ++n) {
    const double dt = seconds_between(frames[n].t_ns, frames[n + 1].t_ns);
    if (dt > kLongestStep) {
      continue;
    }
    const std::vector<StampedPose> motion = stereo_motion(frames.subspan(n, 2), calibration);
    if (motion.size() == 2) {
      out.push_back({seconds_between(origin_ns, frames[n].t_ns),
                     seconds_between(origin_ns, frames[n + 1].t_ns), so3_log(motion[1].T_world_body.R) / dt});
    }
  }
  return out;
}

/// Rows for (bias, a change of tau) at the present tau. The instrument of the gyro's slope is its slope over
/// the intervals before and behind: noise of the samples between is in both sides, and alone looks like
/// milliseconds.
Rows gyro_rows(const std::vector<Turn>& turns, std::span<const ImuSample> imu, double tau) {
  Rows rows;
  const double sample =
      seconds_between(imu.front().t_ns, imu.back().t_ns) / static_cast<double>(imu.size() - 1);
  for (std::size_t k = 0; k < turns.size(); ++k) {
    const double begin = turns[k].begin_s + tau, end = turns[k].end_s + tau;
    const auto mean = mean_rate(imu, begin, end), first = rate_at(imu, begin), last = rate_at(imu, end);
    const double span = end - begin;
    const auto before = mean_rate(imu, begin - sample - span, begin - sample),
               behind = mean_rate(imu, end + sample, end + sample + span);
    if (!mean || !first || !last || !before || !behind) {
      continue;
    }
    const Vector3d slope = (*last - *first) / span;
    const Vector3d around = (*behind - *before) / (2.0 * (span + sample));
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      VectorXd row = VectorXd::Zero(4);
      row(axis) = 1.0;
      row(3) = slope(axis);
      rows.A.push_back(row);
      row(3) = around(axis);
      rows.Z.push_back(row);
      rows.y.push_back(turns[k].rate(axis) - (*mean)(axis));
      rows.cluster.push_back(static_cast<std::int64_t>(k));
    }
  }
  return rows;
}

}  // namespace

std::optional<TimeOffset> cam1_time_offset(const StereoCalibration& calibration,
                                           std::span<const StereoFrame> frames) {
  if (frames.size() < 3) {
    return std::nullopt;
  }
  const Rows rows = epipolar_rows(calibration, frames);
  if (rows.y.size() < kEnoughRows) {
    return std::nullopt;
  }
  const auto solution = solve(rows);
  return solution ? std::optional(TimeOffset{solution->x(5), solution->sigma_of_last}) : std::nullopt;
}

std::optional<TimeOffset> camera_time_offset(const StereoCalibration& calibration,
                                             std::span<const StereoFrame> frames,
                                             std::span<const ImuSample> imu) {
  if (calibration.body != BodyFrame::kImu || imu.size() < 2 || frames.size() < kEnoughPairs) {
    return std::nullopt;
  }
  const std::vector<Turn> turns = turns_of(calibration, frames, imu.front().t_ns);
  TimeOffset out;
  for (int i = 0; i < kShifts; ++i) {
    const Rows rows = gyro_rows(turns, imu, out.seconds);
    const auto solution = rows.y.size() < 3 * kEnoughPairs ? std::nullopt : solve(rows);
    if (!solution) {
      return std::nullopt;
    }
    out.seconds += solution->x(3);
    out.sigma = solution->sigma_of_last;
    if (std::abs(out.seconds) > kLargestOffset) {
      return std::nullopt;
    }
  }
  return out;
}

}  // namespace limber
