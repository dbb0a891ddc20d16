// SPDX-License-Identifier: MIT
#include "diagnose/surest_part.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

namespace limber::detail {
namespace {

constexpr double kSurest = 5.0;  // standard deviations

}  // namespace

SurestPart surest_part(const Eigen::VectorXd& x, const Eigen::MatrixXd& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(covariance);  // the best known first
  Eigen::VectorXd part = Eigen::VectorXd::Zero(x.size());
  SurestPart surest{part, 0.0};
  double most = -std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const Eigen::VectorXd axis = axes.eigenvectors().col(k);
    part += axis * axis.dot(x);
    const Eigen::VectorXd along = part.stableNormalized();
    const double sigma = std::sqrt(along.dot(covariance * along)), sure = part.norm() - kSurest * sigma;
    if (sure > most) {
      most = sure;
      surest = {part, sigma};
    }
  }
  return surest;
}

}  // namespace limber::detail
