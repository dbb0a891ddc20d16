// SPDX-License-Identifier: MIT
#include "limber/stack/linearization_point.hpp"

#include <Eigen/LU>
#include <cmath>
#include <optional>
#include <vector>

#include "limber/core/factors.hpp"
#include "limber/measure/stereo_model.hpp"

namespace limber {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
using Matrix2X = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::ColMajor, 2, kParameters>;

namespace {

constexpr double kHuber = 2.5;  // standard deviations
constexpr int kReweightings = 3;

/// Right pixel of a known landmark: residual, D F, and the inverse of the residual's covariance.
struct Clue {
  Vector2d r;
  Matrix2X DF;
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
  if (projection.J_map_scale) {
    J.emplace_back(estimate.layout().map_scale(), Eigen::Matrix<double, 2, 3>::Zero());
    J.back().second.col(0) = *projection.J_map_scale;
  }
  Matrix2d covariance = Matrix2d::Zero();
  for (const auto& [row, J_row] : J) {
    for (const auto& [col, J_col] : J) {
      covariance += J_row * estimate.P().triplet_block(row, col) * J_col.transpose();
    }
  }
  return covariance;
}

std::vector<Clue> collect(const Estimate& estimate, const StereoFrame& frame, const MountedCamera& cam1,
                          const PixelNoise& sigma_px, const Eigen::Ref<const MatrixXd>& F) {
  std::vector<Clue> clues;
  for (const StereoObservation& o : frame.observations) {
    const Landmark* landmark = o.in_cam1 ? estimate.find(o.track_id) : nullptr;
    if (landmark == nullptr) {
      continue;
    }
    const Anchor* anchor = estimate.anchor_of(*landmark);
    std::optional<PointProjection> projection =
        project_point(cam1, body_point_at_exposure(cam1, estimate.nav().T_world_body, *landmark, anchor));
    if (projection) {
      estimate.refer_to_epoch(*landmark, *projection);
      Matrix2d S = predicted_covariance(estimate, *landmark, anchor, *projection);
      S.diagonal() += sigma_px.tail<2>().cwiseAbs2();
      Matrix2X DF = projection->J_theta * F.topRows<kBlockSize>();
      if (F.rows() > kBlockSize) {
        DF += *projection->J_more * F.bottomRows<kMoreParameters>();
      }
      clues.push_back({o.uv_cam1 - projection->uv, DF, S.inverse()});
    }
  }
  return clues;
}

}  // namespace

VectorXd linearization_point(const Estimate& estimate, const StereoFrame& frame, const MountedCamera& cam1,
                             const PixelNoise& sigma_px, const Eigen::Ref<const MatrixXd>& F) {
  VectorXd beta = VectorXd::Zero(F.cols());  // dtheta = F beta, beta ~ N(0, I)
  if (F.isZero(0.0)) {
    return VectorXd::Zero(F.rows());
  }
  const std::vector<Clue> clues = collect(estimate, frame, cam1, sigma_px, F);
  for (int i = 0; i < kReweightings; ++i) {
    MatrixXd A = MatrixXd::Identity(F.cols(), F.cols());
    VectorXd b = VectorXd::Zero(F.cols());
    for (const Clue& clue : clues) {
      const Vector2d e = clue.r - clue.DF * beta;
      const double distance = std::sqrt(e.dot(clue.information * e));
      // The first pass has no idea of theta and takes everything.
      const double weight = i == 0 || distance <= kHuber ? 1.0 : kHuber / distance;
      A += weight * clue.DF.transpose() * clue.information * clue.DF;
      b += weight * clue.DF.transpose() * (clue.information * clue.r);
    }
    beta = solve_symmetric(A, b);
  }
  return F * beta;
}

}  // namespace limber
