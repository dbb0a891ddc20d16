// SPDX-License-Identifier: MIT
#include "limber/health/pose_correction.hpp"

#include <algorithm>
#include <cmath>

#include "limber/core/factors.hpp"

namespace limber {

namespace {

/// Directions that are corrected by less, in correlation, say nothing.
constexpr double kWeakestDirection = 1e-4;
constexpr double kShare = 0.1;  // of one frame in the fading mean
constexpr double kNoiseShare = 0.05;
constexpr double kQuarrel = 3.0;      // times what frames usually show
constexpr double kLeastUsual = 0.01;  // of the noise that is assumed
constexpr double kEnoughRows = 40.0;  // to tell whether they do: of few the NIS varies as much by chance

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

bool RecentCorrections::add(const PoseCorrection& c) {
  if (!c.dx.allFinite() || !c.covariance.allFinite() || c.dof <= 0.0) {
    return false;
  }
  last_ = whitened(c);
  rest_ = scatter_beside(c, last_);
  const bool enough = c.dof >= kEnoughRows;
  quarrel_ = enough && !are_of_a_start() ? rest_ / (kQuarrel * std::max(usual_, kLeastUsual)) : 0.0;
  lasting_quarrel_ = std::max((1.0 - kShare) * lasting_quarrel_, quarrel_);
  smoothed_ += kNoiseShare * (rest_ - smoothed_);
  mean_ = (1.0 - kShare) * mean_ + kShare * last_;
  weight_ = (1.0 - kShare) * (1.0 - kShare) * weight_ + kShare * kShare;
  ++frames_;
  usual_ += std::max(kNoiseShare, 1.0 / frames_) * (rest_ - usual_);
  return true;
}

void RecentCorrections::restart_mean() {
  mean_.setZero();
  weight_ = 0.0;
}

double RecentCorrections::noise() const { return std::max({smoothed_, rest_, quarrel_, 1.0}); }

double RecentCorrections::lasting_noise() const { return std::max(noise(), lasting_quarrel_); }

}  // namespace limber
