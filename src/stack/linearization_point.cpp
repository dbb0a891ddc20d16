// SPDX-License-Identifier: MIT
#include "limber/stack/linearization_point.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
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
constexpr int kLinearizations = 4;
constexpr double kLinearPx = 3.0;  // a right pixel that moves by less does so linearly, to about 0.02 px

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

/// The same as rows of all of beta, wherever they are linear.
void refer_to_assumed(std::vector<Clue>& clues, const VectorXd& beta) {
  for (Clue& clue : clues) {
    clue.r += clue.DF * beta;
  }
}

/// What the clues say from `beta` on, which outliers are judged by first.
VectorXd fitted(const std::vector<Clue>& clues, VectorXd beta, bool beta_is_known) {
  for (int i = 0; i < kReweightings; ++i) {
    MatrixXd A = MatrixXd::Identity(beta.size(), beta.size());
    VectorXd b = VectorXd::Zero(beta.size());
    for (const Clue& clue : clues) {
      const Vector2d e = clue.r - clue.DF * beta;
      const double distance = std::sqrt(e.dot(clue.information * e));
      // The first pass has no idea of theta and takes everything.
      const double weight = (i == 0 && !beta_is_known) || distance <= kHuber ? 1.0 : kHuber / distance;
      A += weight * clue.DF.transpose() * clue.information * clue.DF;
      b += weight * clue.DF.transpose() * (clue.information * clue.r);
    }
    beta = solve_symmetric(A, b);
  }
  return beta;
}

/// [px], of a right pixel.
double largest_move(const std::vector<Clue>& clues, const VectorXd& dbeta) {
  double out = 0.0;
  for (const Clue& clue : clues) {
    out = std::max(out, (clue.DF * dbeta).norm());
  }
  return out;
}

}  // namespace

VectorXd linearization_point(const Estimate& estimate, const StereoFrame& frame, const CameraOff& cam1,
                             const PixelNoise& sigma_px, const Eigen::Ref<const MatrixXd>& F) {
  VectorXd beta = VectorXd::Zero(F.cols());  // dtheta = F beta, beta ~ N(0, I)
  VectorXd off = VectorXd::Zero(F.rows());
  if (F.isZero(0.0)) {
    return off;
  }
  for (int round = 0; round < kLinearizations; ++round) {
    std::vector<Clue> clues = collect(estimate, frame, cam1(off), sigma_px, F);
    refer_to_assumed(clues, beta);
    const VectorXd before = std::exchange(beta, fitted(clues, beta, round > 0));
    off = F * beta;
    if (largest_move(clues, beta - before) < kLinearPx) {
      break;
    }
  }
  return off;
}

}  // namespace limber
