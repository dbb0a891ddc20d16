// SPDX-License-Identifier: MIT
#include "limber/health/bounded_influence.hpp"

#include "limber/core/median.hpp"

namespace limber::detail {

namespace {

constexpr double kMostLever = 4.0;  // of the usual derivative

}  // namespace

Eigen::VectorXd lever_weights(const Eigen::MatrixXd& J) {
  Eigen::VectorXd out = Eigen::VectorXd::Ones(J.rows());
  for (Eigen::Index k = 0; k < J.cols(); ++k) {
    const Eigen::VectorXd sizes = J.col(k).cwiseAbs();
    const double limit = kMostLever * upper_median(std::vector<double>(sizes.begin(), sizes.end()));
    if (limit > 0.0) {
      out = out.cwiseMin((limit * sizes.cwiseMax(limit).cwiseInverse()).cwiseAbs2());
    }
  }
  return out;
}

}  // namespace limber::detail
