// SPDX-License-Identifier: MIT
#include "factors.hpp"
#include "limber/core/so3.hpp"

namespace limber::detail {
namespace {

/// Residual of a point that the camera cannot see at all, in standard deviations: no step leads there.
constexpr double kBehind = 1e3;

template <int Cols>
using Rows = Eigen::Map<Eigen::Matrix<double, 2, Cols, Eigen::RowMajor>>;

/// What follows landmark, theta and parameters in the list of blocks, counted from the landmark's.
struct Places {
  int pose = -1, anchor = -1, landmark = 0, theta = -1, more = -1;
};

Places places_of(const PointSight& sight) {
  Places out;
  int next = 0;
  if (!sight.in_anchor) {
    out.pose = next++;
    out.anchor = next++;
  }
  out.landmark = next++;
  if (sight.theta) {
    out.theta = next++;
  }
  if (sight.more) {
    out.more = next;
  }
  return out;
}

void write_pose_jacobian(double* out, const Eigen::Matrix<double, 2, 3>& position,
                         const Eigen::Matrix<double, 2, 3>& attitude) {
  Rows<kPoseBlock> J(out);
  J << position, attitude, Eigen::Vector2d::Zero();
}

}  // namespace

PointFactor::PointFactor(const PointSight& sight) : sight_(sight) {
  set_num_residuals(2);
  std::vector<std::int32_t>& sizes = *mutable_parameter_block_sizes();
  if (!sight.in_anchor) {
    sizes = {kPoseBlock, kPoseBlock};
  }
  sizes.push_back(kTriplet);
  if (sight.theta) {
    sizes.push_back(kBlockSize);
  }
  if (sight.more) {
    sizes.push_back(kMoreParameters);
  }
}

bool PointFactor::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
  const Places at = places_of(sight_);
  Landmark landmark = sight_.landmark;
  landmark.value = Eigen::Map<const Eigen::Vector3d>(blocks[at.landmark]);
  Anchor anchor;
  anchor.T_body_cam0 = sight_.T_body_cam0;
  Pose T_world_body;
  if (!sight_.in_anchor) {
    T_world_body = pose_of(blocks[at.pose]);
    anchor.T_world_body = pose_of(blocks[at.anchor]);
  }
  MountedCamera camera = *sight_.camera;
  camera.motion = sight_.motion;
  const auto projection =
      project_point(camera, body_point_at_exposure(camera, T_world_body, landmark, &anchor));
  const Eigen::Vector2d weight = sight_.sigma_px.cwiseInverse();
  Eigen::Map<Eigen::Vector2d> r(residuals);
  if (!projection) {
    r.setConstant(kBehind);
    for (std::size_t k = 0; jacobians != nullptr && k < parameter_block_sizes().size(); ++k) {
      if (jacobians[k] != nullptr) {
        std::fill_n(jacobians[k], 2 * parameter_block_sizes()[k], 0.0);
      }
    }
    return true;
  }
  r = weight.asDiagonal() * (sight_.uv - projection->uv);
  if (jacobians == nullptr) {
    return true;
  }
  const Eigen::DiagonalMatrix<double, 2> W(Eigen::Vector2d(-weight));
  if (at.pose >= 0 && jacobians[at.pose] != nullptr) {
    write_pose_jacobian(jacobians[at.pose], W * projection->J_position, W * projection->J_attitude);
  }
  if (at.anchor >= 0 && jacobians[at.anchor] != nullptr) {
    write_pose_jacobian(jacobians[at.anchor], W * projection->J_anchor_position,
                        W * projection->J_anchor_attitude);
  }
  if (jacobians[at.landmark] != nullptr) {
    Rows<3> J(jacobians[at.landmark]);
    J = W * projection->J_landmark;
  }
  if (at.theta >= 0 && jacobians[at.theta] != nullptr) {
    Rows<6> J(jacobians[at.theta]);
    J = W * projection->J_theta;
  }
  if (at.more >= 0 && jacobians[at.more] != nullptr) {
    Rows<kMoreParameters> J(jacobians[at.more]);
    J = W * *projection->J_more;
    // The mount is Exp(error) R: a further error turns what the first one has turned already.
    constexpr Eigen::Index kTurn = kMoreParameters - kBlockSize;
    J.middleCols<3>(kTurn) *= so3_right_jacobian(-Eigen::Map<const Eigen::Vector3d>(blocks[at.more] + kTurn));
  }
  return true;
}

}  // namespace limber::detail
