// SPDX-License-Identifier: MIT
#include "limber/evaluate/consistency.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>
#include <string>

#include "limber/core/chi_square.hpp"
#include "limber/core/so3.hpp"

namespace limber {
namespace {

template <int N>
std::optional<double> nees(const Eigen::Matrix<double, N, 1>& error, const Eigen::Matrix<double, N, N>& P) {
  const Eigen::LLT<Eigen::Matrix<double, N, N>> llt(P);
  if (!P.allFinite() || llt.info() != Eigen::Success) {
    return std::nullopt;
  }
  return llt.matrixL().solve(error).squaredNorm();
}

}  // namespace

PoseErrorVector pose_error(const Pose& estimate, const Pose& truth) {
  PoseErrorVector error;
  error << truth.p - estimate.p, so3_log(estimate.R.transpose() * truth.R);
  return error;
}

std::optional<PoseNees> pose_nees(const PoseErrorVector& error, const PoseCovariance& P) {
  const auto pose = nees<6>(error, P);
  const auto position = nees<3>(error.head<3>(), P.topLeftCorner<3, 3>());
  const auto attitude = nees<3>(error.tail<3>(), P.bottomRightCorner<3, 3>());
  if (!pose || !position || !attitude) {
    return std::nullopt;
  }
  return PoseNees{*pose, *position, *attitude};
}

std::optional<double> distance_nees(const PoseErrorVector& error, const PoseCovariance& P,
                                    const Eigen::Vector3d& from_begin) {
  const double distance = from_begin.norm();
  if (!(distance > 0.0)) {
    return std::nullopt;
  }
  const Eigen::Vector3d direction = from_begin / distance;
  const double variance = direction.dot(P.topLeftCorner<3, 3>() * direction);
  if (!(variance > 0.0) || !std::isfinite(variance)) {
    return std::nullopt;
  }
  const double radial = direction.dot(error.head<3>());
  return radial * radial / variance;
}

PoseCovariance turned(const PoseCovariance& P, const Eigen::Matrix3d& R) {
  PoseCovariance turned_P = P;
  turned_P.topRows<3>() = R * P.topRows<3>();
  turned_P.leftCols<3>() = (turned_P.leftCols<3>() * R.transpose()).eval();
  return turned_P;
}

Consistency average_nees(std::span<const MatchedPose> poses, std::span<const PoseCovariance> covariances,
                         const Alignment& alignment, std::int64_t start_ns, double skip) {
  if (alignment.status != AlignmentStatus::kAligned || alignment.scale != 1.0) {
    throw std::invalid_argument("NEES: needs a rigid alignment");
  }
  const double quantile_95 = chi_square_quantile(0.95, 6.0);
  Consistency result;
  PoseNees sum;
  std::size_t within = 0, with_scale = 0;
  double sum_scale = 0.0;
  for (const MatchedPose& pose : poses) {
    if (pose.index >= covariances.size()) {
      throw std::invalid_argument("NEES: pose " + std::to_string(pose.index) + " has no covariance");
    }
    if (static_cast<double>(pose.t_ns - start_ns) <= skip * 1e9) {
      continue;
    }
    const PoseErrorVector error = pose_error(alignment * pose.estimate, pose.truth);
    const PoseCovariance P = turned(covariances[pose.index], alignment.T_true_est.R);
    const auto nees = pose_nees(error, P);
    if (!nees) {
      ++result.frames_refused;
      continue;
    }
    ++result.frames;
    within += nees->pose <= quantile_95 ? 1 : 0;
    sum.pose += nees->pose / 6.0;
    sum.position += nees->position / 3.0;
    sum.attitude += nees->attitude / 3.0;
    if (const auto scale = distance_nees(error, P, pose.truth.p - poses.front().truth.p)) {
      sum_scale += *scale;
      ++with_scale;
    }
  }
  if (result.frames > 0) {
    const auto n = static_cast<double>(result.frames);
    result.anees = PoseNees{sum.pose / n, sum.position / n, sum.attitude / n};
    result.share_within_95 = static_cast<double>(within) / n;
  }
  if (with_scale > 0) {
    result.anees_scale = sum_scale / static_cast<double>(with_scale);
  }
  return result;
}

Interval normalized_mean_interval(double dof, std::size_t samples, double probability) {
  if (samples == 0 || !(probability > 0.0 && probability < 1.0)) {
    throw std::invalid_argument("chi-square interval: needs samples and a probability in (0, 1), got " +
                                std::to_string(samples) + " and " + std::to_string(probability));
  }
  const double total = dof * static_cast<double>(samples);
  const double tail = 0.5 * (1.0 - probability);
  return {chi_square_quantile(tail, total) / total, chi_square_quantile(1.0 - tail, total) / total};
}

std::optional<NisAverage> average_nis(std::span<const NisSample> samples) {
  NisAverage average;
  double sum = 0.0;
  for (const NisSample& sample : samples) {
    if (!std::isfinite(sample.nis) || sample.nis < 0.0 || !std::isfinite(sample.dof) || sample.dof < 0.0) {
      throw std::invalid_argument("NIS: a sample is negative or not finite");
    }
    sum += sample.nis;
    average.dof += sample.dof;
    ++average.updates;
  }
  if (average.dof <= 0.0) {
    return std::nullopt;
  }
  average.per_dof = sum / average.dof;
  average.interval = normalized_mean_interval(average.dof, 1);
  average.p_value = chi_square_survival(sum, average.dof);
  return average;
}

}  // namespace limber
