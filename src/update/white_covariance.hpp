// SPDX-License-Identifier: MIT
#pragma once

#include "limber/update/update.hpp"

namespace limber {

/// S + D Sigma_w Dᵀ of an innovation, full symmetric: row for row, whatever its stateless rows say.
inline Eigen::MatrixXd with_white_covariance(const Innovation& innovation,
                                             const ParameterErrorModel& treatment) {
  Eigen::MatrixXd S = innovation.S;
  if (treatment.white_covariance.size() > 0) {
    S.noalias() += innovation.D * (treatment.white_covariance * innovation.D.transpose()).eval();
  }
  return S;
}

}  // namespace limber
