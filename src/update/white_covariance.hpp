// SPDX-License-Identifier: MIT
#pragma once

#include "limber/core/dense.hpp"
#include "limber/update/update.hpp"

namespace limber {

/// S + D Sigma_w Dᵀ of an innovation, full symmetric: row for row, whatever its stateless rows say.
inline Eigen::MatrixXd with_white_covariance(const Innovation& innovation,
                                             const ParameterErrorModel& treatment) {
  Eigen::MatrixXd S = innovation.S;
  if (treatment.white_covariance.size() > 0) {
    add_product(S, 1.0, innovation.D, multiply(treatment.white_covariance, transposed(innovation.D)));
  }
  return S;
}

}  // namespace limber
