// SPDX-License-Identifier: MIT
#include "window_pixels.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "limber/measure/stereo_model.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::Vector2d;

namespace {

constexpr double kHuberSigmas = 3.0;     // standard deviations of a pixel, both axes
constexpr double kFreeBaselines = 10.0;  // sigma of an inverse depth, over the baseline: as good as unknown
constexpr double kLost = 30.0;           // cost of a point that does not project

/// Columns of a sighting's rows: its unknowns, and the residual beside them. Filled up to whole vectors of
/// the processor.
enum SightingColumn : Index {
  kPose = 0,
  kAnchor = 6,
  kTheta = 12,
  kPoint = 18,
  kResidual = 21,
  kColumns = 24
};

/// Both pixels of a sighting, whitened and weighted; residual: measured minus predicted. Zero where there is
/// no pixel.
using SightingRows = Eigen::Matrix<double, 4, kColumns, Eigen::RowMajor>;
using SightingNormal = Eigen::Matrix<double, kColumns, kColumns>;

/// Rows of one pixel, or the cost of a point that is lost.
/// @return the cost
double fill_rows(const WindowModel& model, std::size_t cam, const Vector2d& uv, const MountedCamera& mounted,
                 const BodyPoint& point, SightingRows& out) {
  const std::optional<PointProjection> projection = project_point(mounted, point);
  if (!projection) {
    return kLost;
  }
  const auto first = 2 * static_cast<Index>(cam);
  const Vector2d whiten = model.options.sigma_px.segment<2>(first).cwiseInverse();
  const Vector2d r = whiten.cwiseProduct(uv - projection->uv);
  const double norm = r.norm();
  const bool gross = norm > kHuberSigmas;
  const double weight = gross ? std::sqrt(kHuberSigmas / norm) : 1.0;
  const Eigen::DiagonalMatrix<double, 2> G((weight * whiten).eval());
  auto rows = out.middleRows<2>(first);
  rows.middleCols<3>(kPose) = G * projection->J_position;
  rows.middleCols<3>(kPose + 3) = G * projection->J_attitude;
  rows.middleCols<3>(kAnchor) = G * projection->J_anchor_position;
  rows.middleCols<3>(kAnchor + 3) = G * projection->J_anchor_attitude;
  rows.middleCols<3>(kPoint) = G * projection->J_landmark;
  rows.col(kResidual) = weight * r;
  if (mounted.depends_on_theta) {
    rows.middleCols(kTheta, model.directions.cols()) = G * projection->J_theta * model.directions;
  }
  return gross ? kHuberSigmas * (norm - 0.5 * kHuberSigmas) : 0.5 * norm * norm;
}

/// The pixels of a sighting that are used.
/// @return their cost
double fill_rows(const WindowModel& model, const WindowState& state, const MountedRig& rig,
                 const WindowPoint& point, const WindowSighting& sighting, SightingRows& out) {
  const StereoObservation& o = sighting.observation;
  double cost = 0.0;
  if (o.in_cam0) {
    cost += fill_rows(model, 0, o.uv_cam0, rig[0], point_in_body(state, rig, 0, point, sighting.frame), out);
  }
  if (o.in_cam1 && model.right) {
    cost += fill_rows(model, 1, o.uv_cam1, rig[1], point_in_body(state, rig, 1, point, sighting.frame), out);
  }
  return cost;
}

/// Where the unknowns of a frame stand.
struct FramePlaces {
  Index pose, theta;                  // among all of the frames
  Index pose_in_rest, theta_in_rest;  // in the layout's rest
};

FramePlaces places_of(const FrameLayout& layout, std::size_t frame) {
  const auto k = static_cast<Index>(frame);
  const Index at = k * layout.size();
  return {at, at + layout.pose + layout.chain, layout.pose_in_rest(k), layout.theta_in_rest(k)};
}

/// What a sighting says of its own frame.
void add_frame(const SightingNormal& H, const FramePlaces& at, Index point, WindowNormal& out) {
  const Index b = out.layout.theta;
  out.A.block<6, 6>(at.pose, at.pose) += H.block<6, 6>(kPose, kPose);
  out.A.block(at.theta, at.pose, b, 6) += H.block(kTheta, kPose, b, 6);
  out.A.block(at.theta, at.theta, b, b) += H.block(kTheta, kTheta, b, b);
  out.W.block<6, 3>(at.pose_in_rest, point) += H.block<6, 3>(kPose, kPoint);
  out.W.block(at.theta_in_rest, point, b, 3) += H.block(kTheta, kPoint, b, 3);
  out.g.segment<6>(at.pose) += H.col(kResidual).segment<6>(kPose);
  out.g.segment(at.theta, b) += H.col(kResidual).segment(kTheta, b);
}

/// And of the anchor's, if that is another one.
void add_anchor(const SightingNormal& H, const FramePlaces& at, const FramePlaces& anchor, Index point,
                WindowNormal& out) {
  const Index b = out.layout.theta;
  out.A.block<6, 6>(anchor.pose, anchor.pose) += H.block<6, 6>(kAnchor, kAnchor);
  out.A.block<6, 6>(at.pose, anchor.pose) += H.block<6, 6>(kPose, kAnchor);
  out.A.block(at.theta, anchor.pose, b, 6) += H.block(kTheta, kAnchor, b, 6);
  out.W.block<6, 3>(anchor.pose_in_rest, point) += H.block<6, 3>(kAnchor, kPoint);
  out.g.segment<6>(anchor.pose) += H.col(kResidual).segment<6>(kAnchor);
}

void add_sightings(const WindowModel& model, const WindowState& state, const std::vector<MountedRig>& rigs,
                   std::size_t j, WindowNormal& out) {
  const WindowPoint& point = state.points[j];
  const auto column = static_cast<Index>(3 * j);
  const FramePlaces anchor = places_of(out.layout, point.anchor());
  for (const WindowSighting& sighting : point.seen) {
    SightingRows rows = SightingRows::Zero();
    out.cost += fill_rows(model, state, rigs[sighting.frame], point, sighting, rows);
    const bool own = sighting.frame == point.anchor();
    if (own) {
      rows.middleCols<6>(kPose) += rows.middleCols<6>(kAnchor);
    }
    const SightingNormal H = rows.transpose().lazyProduct(rows);
    const FramePlaces at = places_of(out.layout, sighting.frame);
    add_frame(H, at, column, out);
    if (!own) {
      add_anchor(H, at, anchor, column, out);
    }
    out.V[j] += H.block<3, 3>(kPoint, kPoint);
    out.g_points.segment<3>(column) += H.col(kResidual).segment<3>(kPoint);
  }
}

/// Squared residuals of the pixels over what is expected of them where the motion is free.
double misfit_of_pixels(const WindowModel& model, const WindowState& state) {
  const auto of_frame = static_cast<std::size_t>(StateLayout::kPoseSize + model.directions.cols());
  const auto unknowns = static_cast<double>(3 * state.points.size() + of_frame * state.frames.size());
  return cost_of_pixels(model, state) / std::max(expected_cost(model, state) - 0.5 * unknowns, 1.0);
}

}  // namespace

double cost_of_pixels(const WindowModel& model, const WindowState& state) {
  const std::vector<MountedRig> rigs = rigs_of(model, state);
  double cost = 0.0;
  SightingRows rows;
  for (const WindowPoint& point : state.points) {
    for (const WindowSighting& sighting : point.seen) {
      cost += fill_rows(model, state, rigs[sighting.frame], point, sighting, rows);
    }
  }
  return cost;
}

double expected_cost(const WindowModel& model, const WindowState& state) {
  double rows = 0.0;
  for (const WindowPoint& point : state.points) {
    for (const WindowSighting& s : point.seen) {
      rows += (s.observation.in_cam0 ? 2.0 : 0.0) + (s.observation.in_cam1 && model.right ? 2.0 : 0.0);
    }
  }
  return 0.5 * rows;
}

WindowModel with_shown_pixels(WindowModel model, const WindowState& state) {
  const double sharpest = fine_pixels(model);
  const double misfit = std::clamp(misfit_of_pixels(model, state), std::min(sharpest * sharpest, 1.0), 1.0);
  model.options.sigma_px *= std::sqrt(misfit);
  return model;
}

void add_points(const WindowModel& model, const WindowState& state, WindowNormal& out) {
  const std::vector<MountedRig> rigs = rigs_of(model, state);
  const double sigma = kFreeBaselines / model.calibration.baseline();
  const double free = 1.0 / (sigma * sigma);
  for (std::size_t j = 0; j < state.points.size(); ++j) {
    add_sightings(model, state, rigs, j, out);
    const double rho = state.points[j].landmark.value.z();
    out.V[j](2, 2) += free;
    out.g_points(static_cast<Index>(3 * j) + 2) -= free * rho;
    out.cost += 0.5 * free * rho * rho;
  }
}

}  // namespace limber::detail
