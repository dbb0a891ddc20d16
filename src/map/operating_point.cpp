// SPDX-License-Identifier: MIT
#include "limber/map/operating_point.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <optional>
#include <vector>

#include "limber/measure/rig.hpp"
#include "limber/measure/stereo_model.hpp"

namespace limber {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
using Matrix26 = Eigen::Matrix<double, 2, 6>;
using Matrix2X = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::ColMajor, 2, 6>;

namespace {

constexpr double kHuber = 2.5;  // standard deviations
constexpr int kReweightings = 3;

/// Right pixel of a known landmark: residual, Jacobian of theta, and the inverse of the residual's
/// covariance.
struct Clue {
  Vector2d r;
  Matrix26 D;
  Matrix2d information;
};

Matrix2d predicted_covariance(const Estimate& estimate, const Landmark& landmark, const Anchor* anchor,
                              const PointProjection& projection) {
  std::vector<std::pair<Eigen::Index, Eigen::Matrix<double, 2, 3>>> J = {
      {StateLayout::kPosition, projection.J_position},
      {StateLayout::kAttitude, projection.J_attitude},
      {landmark.at, projection.J_landmark}};
  if (anchor != nullptr) {
    J.emplace_back(anchor->position_at, projection.J_anchor_position);
    J.emplace_back(anchor->attitude_at, projection.J_anchor_attitude);
  }
  Matrix2d covariance = Matrix2d::Zero();
  for (const auto& [row, J_row] : J) {
    for (const auto& [col, J_col] : J) {
      covariance += J_row * estimate.P.triplet_block(row, col) * J_col.transpose();
    }
  }
  return covariance;
}

std::vector<Clue> collect(const Estimate& estimate, const StereoFrame& frame, const MountedCamera& cam1,
                          const PixelNoise& sigma_px) {
  std::vector<Clue> clues;
  for (const StereoObservation& o : frame.observations) {
    const Landmark* landmark = o.in_cam1 ? estimate.find(o.track_id) : nullptr;
    if (landmark == nullptr) {
      continue;
    }
    const Anchor* anchor = estimate.anchor_of(*landmark);
    const std::optional<PointProjection> projection =
        project_point(cam1, body_point(estimate.nav.T_world_body, *landmark, anchor));
    if (projection) {
      Matrix2d S = predicted_covariance(estimate, *landmark, anchor, *projection);
      S.diagonal() += sigma_px.tail<2>().cwiseAbs2();
      clues.push_back({o.uv_cam1 - projection->uv, projection->J_theta, S.inverse()});
    }
  }
  return clues;
}

}  // namespace

RigParameters operating_point(const Estimate& estimate, const StereoFrame& frame,
                              const StereoCalibration& calibration, const PixelNoise& sigma_px,
                              const Eigen::Ref<const MatrixXd>& F) {
  const std::vector<Clue> clues = collect(estimate, frame, mount(calibration)[1], sigma_px);
  VectorXd beta = VectorXd::Zero(F.cols());  // dtheta = F beta, beta ~ N(0, I)
  for (int i = 0; i < kReweightings; ++i) {
    MatrixXd A = MatrixXd::Identity(F.cols(), F.cols());
    VectorXd b = VectorXd::Zero(F.cols());
    for (const Clue& clue : clues) {
      const Matrix2X DF = clue.D * F;
      const Vector2d e = clue.r - DF * beta;
      const double distance = std::sqrt(e.dot(clue.information * e));
      // The first pass has no idea of theta and takes everything.
      const double weight = i == 0 || distance <= kHuber ? 1.0 : kHuber / distance;
      A += weight * DF.transpose() * clue.information * DF;
      b += weight * DF.transpose() * (clue.information * clue.r);
    }
    beta = A.ldlt().solve(b);
  }
  return calibration.theta + F * beta;
}

}  // namespace limber
