// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "limber/core/covariance.hpp"
#include "limber/core/linear_measurement.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/update/update.hpp"
#include "random_geometry.hpp"

/// Update problems from random stereo geometry: a covariance, a stacked frame, and the constraints.
namespace limber::testing {

/// A point of the frame, in the left camera, and who sees it.
struct SeenPoint {
  Eigen::Vector3d X_cam0;
  bool in_cam0 = true, in_cam1 = true;
};

/// The paper's rig (2 m) or a drone's (0.12 m).
StereoCalibration stereo_rig(double baseline, BodyFrame body = BodyFrame::kImu);

struct StereoProblem {
  std::string name;
  Covariance P;
  LinearMeasurement z;
  Eigen::MatrixXd C;  ///< all six directions, scaled to one plausible error each

  [[nodiscard]] Eigen::MatrixXd H() const;
  [[nodiscard]] Eigen::MatrixXd R() const;
  [[nodiscard]] ParameterErrorModel constrained() const { return {C, {}}; }
};

/// Symmetric positive definite, correlated, with the standard deviations `sigma`.
Eigen::MatrixXd random_covariance(Generator& generator, const Eigen::VectorXd& sigma);

/// Landmarks of both kinds in turn, all inverse-depth ones on one anchor beside the body; 0.5 px noise.
StereoProblem make_problem(Generator& generator, std::string name, const StereoCalibration& calibration,
                           const std::vector<SeenPoint>& points);

/// Points in the view of the left camera, depths log-uniform in [near, far].
std::vector<SeenPoint> random_points(Generator& generator, int count, double near, double far);

/// Theta becomes six states at the end, of variance 1e-4 each, which the rows see as they see theta.
void make_theta_a_state(StereoProblem& problem);

/// Geometry that gives the constraints little or nothing to hold on to.
std::vector<StereoProblem> degenerate_problems(Generator& generator);

/// Standard deviations of the prior: the units in which differences are judged.
Eigen::VectorXd prior_sigma(const Covariance& P);

/// Largest entry of a − b in units of `sigma`, relative to the largest of b.
double relative_difference(const Eigen::VectorXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& sigma);

/// Largest entry of A − B as a correlation: each in units of two prior standard deviations.
double relative_difference(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, const Eigen::VectorXd& sigma);

/// The gain of `update`, column by column: dx is linear in the residual.
Eigen::MatrixXd gain(const StereoProblem& problem, const ParameterErrorModel& model);

/// What an update makes of a copy.
struct Updated {
  UpdateReport report;
  Eigen::MatrixXd P;
};

Updated updated(const StereoProblem& problem, const ParameterErrorModel& model);

/// The textbook: K = P Hᵀ S⁻¹, dx = K r, Joseph's form of P. All dense.
Updated textbook_ekf(const StereoProblem& problem);

}  // namespace limber::testing
