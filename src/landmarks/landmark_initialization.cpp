// SPDX-License-Identifier: MIT
#include "limber/landmarks/landmark_initialization.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <utility>
#include <vector>

#include "limber/core/median.hpp"
#include "limber/landmarks/map_management.hpp"
#include "limber/measure/point_rows.hpp"
#include "limber/measure/triangulate.hpp"
#include "limber/update/innovation.hpp"

namespace limber {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// A triangulated point further than this many baselines starts there: beyond, depth cannot be told from
/// infinity.
constexpr double kFarthestBaselines = 1000.0;
/// A triangulated point nearer than this many baselines starts there.
constexpr double kNearestBaselines = 0.5;
constexpr int kRefinements = 4;
constexpr double kKnownDepth = 0.3;  // of an inverse depth [-]: it tells what those of others may be
constexpr std::size_t kEnoughDepths = 5;
constexpr double kGuessedWithin = 4.0;  // times the guess: wide enough to say nothing of the map's scale

/// Of the pixels that one or two cameras saw, with respect to the landmark's triplet.
using LandmarkJacobian = Eigen::Matrix<double, Eigen::Dynamic, kTriplet, Eigen::ColMajor, 4, kTriplet>;

/// What both cameras say about a new point, as unit bearings.
struct Sighting {
  Vector3d d0;
  std::optional<Vector3d> d1;
};

std::optional<Sighting> sight(const StereoObservation& observation, const MountedRig& rig) {
  if (!observation.in_cam0) {
    return std::nullopt;
  }
  const std::optional<Vector3d> d0 = unproject(rig[0].camera, observation.uv_cam0);
  if (!d0) {
    return std::nullopt;
  }
  Sighting out{*d0, std::nullopt};
  if (observation.in_cam1) {
    out.d1 = unproject(rig[1].camera, observation.uv_cam1);
  }
  return out;
}

Pose between_cameras(const MountedRig& rig) { return rig[1].T_cam_body * rig[0].T_cam_body.inverse(); }

/// Triangulated inverse depth, kept inside the plausible range.
double start_inverse_depth(const Sighting& sighting, const Pose& T_cam1_cam0) {
  const double baseline = T_cam1_cam0.p.norm();
  const double lowest = 1.0 / (kFarthestBaselines * baseline);
  const double rho = inverse_depth_along(sighting.d0, *sighting.d1, T_cam1_cam0).value_or(lowest);
  return std::clamp(rho, lowest, 1.0 / (kNearestBaselines * baseline));
}

/// A new inverse-depth landmark whose chart points along the left bearing: (a, b) start at zero.
Landmark inverse_depth_landmark(const StereoObservation& observation, const Vector3d& d0, double rho,
                                int anchor, std::int64_t t_ns) {
  Landmark landmark;
  landmark.track_id = observation.track_id;
  landmark.kind = LandmarkKind::kInverseDepth;
  landmark.anchor = anchor;
  landmark.last_seen_ns = t_ns;
  landmark.R_cam0_chart.col(2) = d0;
  landmark.R_cam0_chart.col(0) = d0.unitOrthogonal();
  landmark.R_cam0_chart.col(1) = d0.cross(landmark.R_cam0_chart.col(0));
  landmark.value << 0.0, 0.0, rho;
  return landmark;
}

/// Covariance of (a, b) from the left pixel's noise.
Eigen::Matrix2d bearing_covariance(const Camera& camera, const Landmark& landmark, const Vector2d& sigma_px) {
  const Eigen::Matrix2d J_uv_ab =
      project(camera, landmark.R_cam0_chart.col(2))->J_uv_X * landmark.R_cam0_chart.leftCols<2>();
  const Eigen::Matrix2d J = J_uv_ab.inverse();
  return J * sigma_px.cwiseAbs2().asDiagonal() * J.transpose();
}

/// Bearing from the left pixel, inverse depth from `rho` and its sigma; correlated with nothing but its
/// anchor.
Matrix3d diffuse_covariance(const MountedRig& rig, const Landmark& landmark, const PixelNoise& sigma_px,
                            double rho_sigma) {
  Matrix3d P_ll = Matrix3d::Zero();
  P_ll.topLeftCorner<2, 2>() = bearing_covariance(rig[0].camera, landmark, sigma_px.head<2>());
  P_ll(2, 2) = rho_sigma * rho_sigma;
  return P_ll;
}

/// Reprojection of a landmark that is not in the state yet into the cameras that saw it: two or four rows at
/// `measurement`, H_l beside it. The landmark's own blocks are taken out of H.
bool linearise_new_landmark(const Estimate& estimate, const StereoObservation& observation,
                            const MountedRig& rig, const PixelNoise& sigma_px, Landmark& landmark,
                            const Anchor* anchor, LinearMeasurement& measurement, LandmarkJacobian& H_l) {
  const Index cameras = observation.in_cam1 ? 2 : 1;
  measurement = empty_measurement(2 * cameras, jacobian_width(rig));
  H_l.resize(2 * cameras, kTriplet);
  landmark.at = -1;
  for (Index cam = 0; cam < cameras; ++cam) {
    const MountedCamera& mounted = rig[static_cast<std::size_t>(cam)];
    const std::optional<PointProjection> projection = project_point(
        mounted, body_point_at_exposure(mounted, estimate.nav().T_world_body, landmark, anchor));
    if (!projection) {
      return false;
    }
    write_point_rows(measurement, 2 * cam, cam == 0 ? observation.uv_cam0 : observation.uv_cam1,
                     sigma_px.segment<2>(2 * cam), *projection, landmark, anchor, estimate.layout());
    H_l.middleRows<2>(2 * cam) = projection->J_landmark;
  }
  std::erase_if(measurement.H.blocks, [](const SparseJacobian::Block& block) { return block.col < 0; });
  return true;
}

/// Least-squares initialisation: x_l from all four pixels, with what the pose and theta add (classical SLAM).
bool initialize_classically(Estimate& estimate, const StereoObservation& observation, const MountedRig& rig,
                            const PixelNoise& sigma_px, Landmark landmark, const Anchor* anchor) {
  LinearMeasurement measurement;
  LandmarkJacobian H_l;
  const Eigen::Vector4d weight = sigma_px.cwiseInverse();
  Eigen::Matrix<double, 3, 4> G;  // whitened pixels to landmark
  for (int i = 0; i < kRefinements; ++i) {
    if (!linearise_new_landmark(estimate, observation, rig, sigma_px, landmark, anchor, measurement, H_l)) {
      return false;
    }
    const Eigen::Matrix<double, 4, 3> A = weight.asDiagonal() * H_l;
    const Eigen::FullPivLU<Matrix3d> AtA(A.transpose() * A);
    if (!AtA.isInvertible()) {
      return false;
    }
    G = AtA.solve(A.transpose());
    if (i + 1 < kRefinements) {
      landmark.value += G * weight.cwiseProduct(measurement.residual);
    }
  }
  const Innovation innovation = form_innovation(estimate.P(), measurement);
  const MatrixXd P_xl = -innovation.PHt * G.transpose();
  estimate.add_landmark(landmark, G * innovation.S * G.transpose(), P_xl);
  return true;
}

/// The same for what the left camera alone saw of a point: its bearing from the pixel, with what the pose and
/// the parameters add; its inverse depth is that of `landmark`, +- rho_sigma.
bool initialize_bearing(Estimate& estimate, StereoObservation observation, const MountedRig& rig,
                        const PixelNoise& sigma_px, Landmark landmark, double rho_sigma) {
  observation.in_cam1 = false;
  LinearMeasurement measurement;
  LandmarkJacobian H_l;
  Eigen::Matrix2d G = Eigen::Matrix2d::Zero();  // whitened pixel to (a, b)
  for (int i = 0; i < kRefinements; ++i) {
    if (!linearise_new_landmark(estimate, observation, rig, sigma_px, landmark, estimate.anchor_of(landmark),
                                measurement, H_l)) {
      return false;
    }
    const Eigen::FullPivLU<Eigen::Matrix2d> J(H_l.leftCols<2>());
    if (!J.isInvertible()) {
      return false;
    }
    G = J.inverse() * sigma_px.head<2>().asDiagonal();
    if (i + 1 < kRefinements) {
      landmark.value.head<2>() += G * sigma_px.head<2>().cwiseInverse().cwiseProduct(measurement.residual);
    }
  }
  const Innovation innovation = form_innovation(estimate.P(), measurement);
  const Vector2d of_rho = -G * sigma_px.head<2>().cwiseInverse().cwiseProduct(H_l.col(2));
  const double variance = rho_sigma * rho_sigma;
  Matrix3d P_ll;
  P_ll.topLeftCorner<2, 2>() = G * innovation.S * G.transpose() + variance * of_rho * of_rho.transpose();
  P_ll.topRightCorner<2, 1>() = variance * of_rho;
  P_ll.bottomLeftCorner<1, 2>() = variance * of_rho.transpose();
  P_ll(2, 2) = variance;
  MatrixXd P_xl = MatrixXd::Zero(estimate.size(), kTriplet);
  P_xl.leftCols<2>() = -innovation.PHt * G.transpose();
  estimate.add_landmark(landmark, P_ll, P_xl);
  return true;
}

/// Whether the left pixel shows a bearing from the body's pose at the stamp and nothing else.
bool left_pixel_is_clean(const MountedCamera& cam0) {
  return !cam0.depends_on_theta && !cam0.with_parameters && cam0.time_offset_s == 0.0;
}

/// Leaves the bearing to the stacked update as well.
void forget_bearing(Matrix3d& P_ll) { P_ll.topLeftCorner<2, 2>() = Eigen::Matrix2d::Identity(); }

std::optional<RemainingRows> initialize_mono(Estimate& estimate, const StereoObservation& observation,
                                             const Sighting& sighting, const MountedRig& rig,
                                             const PixelNoise& sigma_px, std::int64_t t_ns, int anchor,
                                             const LandmarkInitOptions& options) {
  Landmark landmark =
      inverse_depth_landmark(observation, sighting.d0, options.mono_inverse_depth, anchor, t_ns);
  landmark.depth_guessed = true;
  const double rho_sigma = options.mono_inverse_depth_sigma;
  Matrix3d P_ll = diffuse_covariance(rig, landmark, sigma_px, rho_sigma);
  if (left_pixel_is_clean(rig[0])) {
    estimate.add_landmark(landmark, P_ll);
    return RemainingRows::kNone;
  }
  if (options.mode == LandmarkInitMode::kDiffuse) {
    forget_bearing(P_ll);
    estimate.add_landmark(landmark, P_ll);
    return RemainingRows::kAll;
  }
  return initialize_bearing(estimate, observation, rig, sigma_px, landmark, rho_sigma)
             ? std::optional(RemainingRows::kNone)
             : std::nullopt;
}

std::optional<RemainingRows> initialize_inverse_depth(Estimate& estimate,
                                                      const StereoObservation& observation,
                                                      const Sighting& sighting, const MountedRig& rig,
                                                      const PixelNoise& sigma_px, std::int64_t t_ns,
                                                      int anchor, const LandmarkInitOptions& options) {
  if (!sighting.d1) {
    return initialize_mono(estimate, observation, sighting, rig, sigma_px, t_ns, anchor, options);
  }
  const Pose T_cam1_cam0 = between_cameras(rig);
  Landmark landmark = inverse_depth_landmark(observation, sighting.d0,
                                             start_inverse_depth(sighting, T_cam1_cam0), anchor, t_ns);
  if (options.mode == LandmarkInitMode::kClassical) {
    if (!initialize_classically(estimate, observation, rig, sigma_px, landmark,
                                estimate.anchor_of(landmark))) {
      return std::nullopt;
    }
    return RemainingRows::kNone;
  }
  landmark.rho_assumed = landmark.value.z();
  const double rho_sigma = options.inverse_depth_sigma_baselines / T_cam1_cam0.p.norm();
  Matrix3d P_ll = diffuse_covariance(rig, landmark, sigma_px, rho_sigma);
  if (!left_pixel_is_clean(rig[0])) {
    forget_bearing(P_ll);
    estimate.add_landmark(landmark, P_ll);
    return RemainingRows::kAll;
  }
  estimate.add_landmark(landmark, P_ll);
  return RemainingRows::kRight;
}

std::optional<RemainingRows> initialize_cartesian(Estimate& estimate, const StereoObservation& observation,
                                                  const Sighting& sighting, const MountedRig& rig,
                                                  const PixelNoise& sigma_px, std::int64_t t_ns,
                                                  const LandmarkInitOptions& options) {
  if (!sighting.d1) {
    return std::nullopt;  // a Cartesian point needs its depth at once
  }
  const Eigen::Vector4d X = triangulate_dlt(sighting.d0, *sighting.d1, between_cameras(rig));
  const Vector3d p_cam0 = X.head<3>() / std::max(X(3), 1e-9);
  if (!(p_cam0.dot(sighting.d0) > 0.0)) {
    return std::nullopt;
  }
  Landmark landmark;
  landmark.track_id = observation.track_id;
  landmark.kind = LandmarkKind::kCartesian;
  landmark.last_seen_ns = t_ns;
  landmark.value = estimate.nav().T_world_body * (rig[0].T_cam_body.inverse() * p_cam0);
  if (options.mode == LandmarkInitMode::kClassical) {
    if (!initialize_classically(estimate, observation, rig, sigma_px, landmark, nullptr)) {
      return std::nullopt;
    }
    return RemainingRows::kNone;
  }
  estimate.add_landmark(landmark, Matrix3d::Identity() * (options.cartesian_sigma * options.cartesian_sigma));
  return RemainingRows::kAll;
}

}  // namespace

void guess_depth_as_in_map(const Estimate& estimate, const MountedCamera& cam0, std::int64_t since_ns,
                           LandmarkInitOptions& options) {
  const Vector3d p_world_cam0 = estimate.nav().T_world_body * cam0.T_cam_body.inverse().p;
  std::vector<double> inverse_depths;
  for (const Landmark& landmark : estimate.landmarks()) {
    if (!landmark.passive && landmark.last_seen_ns >= since_ns &&
        depth_doubt(estimate, landmark) < kKnownDepth) {
      const Vector3d ray = world_position(landmark, estimate.anchor_of(landmark)) - p_world_cam0;
      inverse_depths.push_back(1.0 / ray.norm());
    }
  }
  if (inverse_depths.size() < kEnoughDepths) {
    return;
  }
  options.mono_inverse_depth = median(std::move(inverse_depths));
  options.mono_inverse_depth_sigma = kGuessedWithin * options.mono_inverse_depth;
}

std::optional<RemainingRows> initialize_landmark(Estimate& estimate, const StereoObservation& observation,
                                                 const MountedRig& rig, const PixelNoise& sigma_px,
                                                 std::int64_t t_ns, int anchor,
                                                 const LandmarkInitOptions& options) {
  const std::optional<Sighting> sighting = sight(observation, rig);
  if (!sighting) {
    return std::nullopt;
  }
  return options.kind == LandmarkKind::kInverseDepth
             ? initialize_inverse_depth(estimate, observation, *sighting, rig, sigma_px, t_ns, anchor,
                                        options)
             : initialize_cartesian(estimate, observation, *sighting, rig, sigma_px, t_ns, options);
}

}  // namespace limber
