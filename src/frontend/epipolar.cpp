// SPDX-License-Identifier: MIT
#include "frontend/epipolar.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "limber/core/factors.hpp"
#include "limber/core/so3.hpp"

namespace limber::frontend {
namespace {

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

constexpr std::size_t kRecentFrames = 10;
constexpr double kMinAgreement = 0.6;     ///< of the pairs that are asked for a geometry
constexpr double kClearAgreement = 0.95;  ///< no need to look for a better geometry
constexpr double kStillAgreement = 0.5;   ///< below it, the present frame contradicts the geometry
constexpr double kSigmaStart = 0.02;      ///< [rad] of a start; also what a rig may bend by in a frame
constexpr int kRansacIterations = 100;    ///< 60 % inliers: 3e-4 that all samples hold an outlier
constexpr int kRefineIterations = 6;

/// Residual of a pair [rad], with its derivative for R <- R Exp(phi), t <- t + d (phi, d stacked).
struct Residual {
  double value = 0.0;
  Eigen::Matrix<double, 6, 1> J = Eigen::Matrix<double, 6, 1>::Zero();
};

Residual residual(const EpipolarGeometry& geometry, const BearingPair& pair) {
  const Eigen::Vector3d Ra = geometry.R_b_a * pair.a;
  const Eigen::Vector3d normal_b = geometry.t.cross(Ra);
  const Eigen::Vector3d normal_a = geometry.R_b_a.transpose() * pair.b.cross(geometry.t);
  const double e = pair.b.dot(normal_b);
  // The parts of both gradients that lie in the tangent planes of the sphere.
  const double scale = std::sqrt(normal_a.squaredNorm() + normal_b.squaredNorm() - 2.0 * e * e);
  Residual result;
  if (scale < 1e-9) return result;  // on the baseline every bearing fits
  result.value = e / scale;
  result.J << pair.a.cross(normal_a) / scale, Ra.cross(pair.b) / scale;
  return result;
}

/// Two unit vectors orthogonal to t and to each other.
Eigen::Matrix<double, 3, 2> tangent_basis(const Eigen::Vector3d& t) {
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = t.unitOrthogonal();
  basis.col(1) = t.cross(basis.col(0));
  return basis;
}

std::vector<BearingPair> joined(const std::deque<std::vector<BearingPair>>& groups) {
  std::vector<BearingPair> all;
  for (const auto& group : groups) all.insert(all.end(), group.begin(), group.end());
  return all;
}

double agreement(const std::vector<bool>& inliers) {
  if (inliers.empty()) return 0.0;
  return static_cast<double>(std::count(inliers.begin(), inliers.end(), true)) /
         static_cast<double>(inliers.size());
}

/// The essential matrix with the most inliers, as one of the (equivalent) motions it stands for.
std::optional<EpipolarGeometry> ransac(const std::vector<BearingPair>& pairs, double threshold) {
  std::vector<cv::Point2d> a, b;
  for (const BearingPair& pair : pairs) {
    if (pair.a.z() < 0.1 || pair.b.z() < 0.1) continue;  // too far off axis for a plane
    a.emplace_back(pair.a.x() / pair.a.z(), pair.a.y() / pair.a.z());
    b.emplace_back(pair.b.x() / pair.b.z(), pair.b.y() / pair.b.z());
  }
  if (a.size() < kMinPairs) return std::nullopt;
  const cv::Mat E =
      cv::findEssentialMat(a, b, cv::Mat::eye(3, 3, CV_64F), cv::RANSAC, 0.999, threshold, kRansacIterations);
  if (E.rows != 3 || E.cols != 3 || !cv::checkRange(E)) return std::nullopt;
  cv::Mat R1, R2, t;
  cv::decomposeEssentialMat(E, R1, R2, t);
  EpipolarGeometry geometry;
  for (int row = 0; row < 3; ++row) {
    geometry.t[row] = t.at<double>(row);
    for (int col = 0; col < 3; ++col) geometry.R_b_a(row, col) = R1.at<double>(row, col);
  }
  if (!geometry.R_b_a.allFinite() || std::abs(geometry.t.norm() - 1.0) > 1e-6) return std::nullopt;
  return geometry;
}

}  // namespace

double epipolar_distance(const EpipolarGeometry& geometry, const BearingPair& pair) {
  return std::abs(residual(geometry, pair).value);
}

std::vector<bool> epipolar_inliers(const EpipolarGeometry& geometry, const std::vector<BearingPair>& pairs,
                                   double threshold) {
  std::vector<bool> inliers;
  for (const BearingPair& pair : pairs) inliers.push_back(epipolar_distance(geometry, pair) < threshold);
  return inliers;
}

EpipolarGeometry refine_epipolar(const EpipolarGeometry& start, const std::vector<BearingPair>& pairs,
                                 double threshold) {
  EpipolarGeometry geometry = start;
  const Eigen::Matrix<double, 3, 2> basis = tangent_basis(start.t);
  const Matrix5d prior = Matrix5d::Identity() / (kSigmaStart * kSigmaStart);
  Vector5d moved = Vector5d::Zero();  // from the start: rotation to first order, t in its tangent plane
  for (int iteration = 0; iteration < kRefineIterations; ++iteration) {
    // Wide at first, so that a start some thresholds off is pulled in; then the outliers are shut out.
    const double scale = 0.5 * threshold * std::max(1.0, 4.0 * std::pow(0.5, iteration));
    Matrix5d A = prior;
    Vector5d g = -prior * moved;
    for (const BearingPair& pair : pairs) {
      const Residual r = residual(geometry, pair);
      const double x = r.value / scale;
      const double weight = 1.0 / ((1.0 + x * x) * (1.0 + x * x) * scale * scale);  // Geman-McClure
      Vector5d J;
      J << r.J.head<3>(), basis.transpose() * r.J.tail<3>();
      A += weight * J * J.transpose();
      g -= weight * r.value * J;
    }
    const Vector5d step = solve_symmetric(A, g);
    if (!step.allFinite()) return geometry;
    moved += step;
    geometry.R_b_a = so3_normalized(geometry.R_b_a * so3_exp(step.head<3>()));
    geometry.t = (start.t + basis * moved.tail<2>()).normalized();
  }
  return geometry;
}

std::optional<EpipolarGeometry> fit_epipolar(const std::vector<BearingPair>& pairs, double threshold,
                                             const std::optional<EpipolarGeometry>& start) {
  if (start && pairs.size() >= kMinPairs) {
    const EpipolarGeometry near = refine_epipolar(*start, pairs, threshold);
    if (agreement(epipolar_inliers(near, pairs, threshold)) >= kClearAgreement) return near;
  }
  const std::optional<EpipolarGeometry> rough = ransac(pairs, threshold);
  if (!rough) return std::nullopt;
  const EpipolarGeometry fine = refine_epipolar(*rough, pairs, threshold);
  const double rough_agreement = agreement(epipolar_inliers(*rough, pairs, threshold));
  const double fine_agreement = agreement(epipolar_inliers(fine, pairs, threshold));
  if (std::max(rough_agreement, fine_agreement) < kMinAgreement) return std::nullopt;
  return fine_agreement >= rough_agreement ? fine : *rough;
}

std::vector<bool> LeftRightConsensus::judge(const std::vector<BearingPair>& pairs) {
  if (pairs.empty()) return {};
  recent_.push_back(pairs);
  if (recent_.size() > kRecentFrames) recent_.pop_front();

  if (geometry_) {
    geometry_ = refine_epipolar(*geometry_, joined(recent_), threshold_);
    const EpipolarGeometry now = refine_epipolar(*geometry_, pairs, threshold_);
    const std::vector<bool> inliers = epipolar_inliers(now, pairs, threshold_);
    if (agreement(inliers) >= kStillAgreement) return inliers;
  }
  // The rig has moved, or nothing is known yet: ask the present frame alone, and if it is too poor, all.
  geometry_ = fit_epipolar(pairs, threshold_);
  if (geometry_) {
    recent_.assign(1, pairs);
  } else {
    geometry_ = fit_epipolar(joined(recent_), threshold_);
  }
  if (!geometry_) return std::vector<bool>(pairs.size(), false);
  return epipolar_inliers(*geometry_, pairs, threshold_);
}

}  // namespace limber::frontend
