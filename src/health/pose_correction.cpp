// SPDX-License-Identifier: MIT
#include "limber/health/pose_correction.hpp"

#include <algorithm>
#include <cmath>

#include "limber/core/factors.hpp"

namespace limber {

namespace {

/// Directions that are corrected by less, in correlation, say nothing.
constexpr double kWeakestDirection = 1e-4;

}  // namespace

PoseCorrection::Vector6 whitened(const PoseCorrection& c) {
  using Vector6 = PoseCorrection::Vector6;
  const Vector6 sigma = c.covariance.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const PoseCorrection::Matrix6 correlation =
      sigma.cwiseInverse().asDiagonal() * c.covariance * sigma.cwiseInverse().asDiagonal();
  const SymmetricEigen eigen = symmetric_eigen(correlation);
  Vector6 z = eigen.vectors.transpose() * c.dx.cwiseQuotient(sigma);
  for (Eigen::Index k = 0; k < 6; ++k) {
    z(k) = eigen.values(k) > kWeakestDirection ? z(k) / std::sqrt(eigen.values(k)) : 0.0;
  }
  return eigen.vectors * z;
}

double scatter_beside(const PoseCorrection& c, const PoseCorrection::Vector6& z) {
  return std::max(c.nis - z.squaredNorm(), 0.0) / std::max(c.dof - 6.0, 1.0);
}

double scatter_beside(const PoseCorrection& c) { return scatter_beside(c, whitened(c)); }

}  // namespace limber
