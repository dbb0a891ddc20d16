// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "check_covariance.hpp"
#include "limber/core/factors.hpp"
#include "stereo_problem.hpp"

namespace limber::testing {

/// A frame with points of 2 and of 4 rows.
inline StereoProblem random_frame(Generator& generator, int count = 20) {
  std::vector<SeenPoint> points = random_points(generator, count, 2.0, 20.0);
  for (std::size_t k = 0; k < points.size(); ++k) {
    points[k].in_cam1 = k % 4 != 1;
    points[k].in_cam0 = k % 7 != 2 || !points[k].in_cam1;
  }
  return make_problem(generator, "", stereo_rig(0.5), points);
}

/// Its residual, drawn from what the filter believes.
inline void draw_residual(Generator& generator, StereoProblem& problem) {
  const Eigen::MatrixXd H = problem.H();
  const Eigen::MatrixXd root = Cholesky(problem.P.dense()).L();
  problem.z.residual = H * root * random_normal(generator, root.rows()) +
                       problem.z.sigma.cwiseProduct(random_normal(generator, H.rows()));
}

}  // namespace limber::testing
