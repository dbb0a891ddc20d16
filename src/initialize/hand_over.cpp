// SPDX-License-Identifier: MIT
#include "hand_over.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <utility>
#include <vector>

#include "limber/core/factors.hpp"
#include "limber/measure/stereo_model.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix34 = Eigen::Matrix<double, 3, 4>;
using Matrix36 = Eigen::Matrix<double, 3, 6>;

namespace {

/// The 99 % quantile of chi-square of 6: of a body that does not move, the way that noise makes of it in
/// position and velocity, counted in what the inputs know of them.
constexpr double kNoiseInformation = 16.8;
constexpr double kLeastInformation = 0.25;  // a factor of seven either way

/// The inverse depths of n points among their triplets.
constexpr auto kDepths = [](Index n) { return Eigen::seqN(Index{2}, n, Eigen::fix<3>); };

/// A point in the last left camera, and what its error is made of.
struct LastView {
  Landmark landmark;
  Matrix36 J_last, J_anchor;
  Matrix3d J_point;
};

/// (a, b, rho) in the chart along the bearing, with respect to the homogeneous point (X, w).
Matrix34 chart_jacobian(const Landmark& landmark, double distance, double w) {
  const Matrix3d Rt = landmark.R_cam0_chart.transpose();
  Matrix34 J;
  J << Rt.row(0) / distance, 0.0, Rt.row(1) / distance, 0.0, -w / (distance * distance) * Rt.row(2),
      1.0 / distance;
  return J;
}

LastView view_from_last(const WindowModel& model, const WindowState& state, const WindowPoint& point) {
  const Pose T_cam0_body = mount(model.calibration)[0].T_cam_body;
  const Anchor anchor{state.frames[point.anchor()].nav.T_world_body, T_cam0_body.inverse()};
  const BodyPoint in_body = body_point(state.frames.back().nav.T_world_body, point.landmark, &anchor);
  const Vector3d X = T_cam0_body.R * in_body.Y + in_body.w * T_cam0_body.p;
  const double distance = X.norm();
  LastView out;
  out.landmark.track_id = point.landmark.track_id;
  out.landmark.R_cam0_chart.col(2) = X / distance;
  out.landmark.R_cam0_chart.col(0) = (X / distance).unitOrthogonal();
  out.landmark.R_cam0_chart.col(1) = out.landmark.R_cam0_chart.col(2).cross(out.landmark.R_cam0_chart.col(0));
  out.landmark.value << 0.0, 0.0, in_body.w / distance;
  out.landmark.last_seen_ns = state.frames[point.seen.back().frame].nav.t_ns;
  const Matrix34 G = chart_jacobian(out.landmark, distance, in_body.w);
  const Matrix3d GR = G.leftCols<3>() * T_cam0_body.R;
  out.J_last << GR * in_body.J_Y_position, GR * in_body.J_Y_attitude;
  out.J_anchor << GR * in_body.J_Y_anchor_position, GR * in_body.J_Y_anchor_attitude;
  const Vector3d of_w = G.leftCols<3>() * T_cam0_body.p + G.col(3);
  out.J_point = GR * in_body.J_Y_landmark + of_w * in_body.J_w_landmark;
  return out;
}

/// The points that are in front of the last left camera. Their errors are `rows` times those of the layout's
/// rest, and beside that each has its own.
struct LastPoints {
  std::vector<Landmark> landmarks;
  MatrixXd rows;              // 3n × rest
  std::vector<Matrix3d> own;  // covariances
};

LastPoints points_from_last(const WindowModel& model, const WindowState& state, const WindowNormal& normal) {
  const FrameLayout& layout = normal.layout;
  const Index last = layout.pose_in_rest(layout.frames - 1);
  LastPoints out;
  out.rows.resize(normal.W.cols(), layout.rest_size());
  for (std::size_t j = 0; j < state.points.size(); ++j) {
    const WindowPoint& point = state.points[j];
    if (!(point.landmark.value.z() > 0.0)) {
      continue;
    }
    const LastView view = view_from_last(model, state, point);
    const Matrix3d JV = view.J_point * normal.V[j].inverse();
    auto rows = out.rows.middleRows<3>(static_cast<Index>(3 * out.own.size()));
    rows = -JV * normal.W.middleCols<3>(static_cast<Index>(3 * j)).transpose();
    rows.middleCols<6>(last) += view.J_last;
    rows.middleCols<6>(layout.pose_in_rest(static_cast<Index>(point.anchor()))) += view.J_anchor;
    out.own.push_back(JV * view.J_point.transpose());
    out.landmarks.push_back(view.landmark);
  }
  out.rows.conservativeResize(static_cast<Index>(3 * out.own.size()), Eigen::NoChange);
  return out;
}

/// Of what inverse depths have in common, from their covariance.
double common_information(const VectorXd& rho, const MatrixXd& C) {
  if (rho.size() < 3) {
    return 0.0;
  }
  const VectorXd by_depth = rho.cwiseInverse();
  const VectorXd x =
      Cholesky(by_depth.asDiagonal() * C * by_depth.asDiagonal()).solve(VectorXd::Ones(rho.size()));
  return x.allFinite() && x.sum() > 0.0 ? x.sum() : 0.0;
}

VectorXd inverse_depths(const std::vector<Landmark>& landmarks) {
  VectorXd out(static_cast<Index>(landmarks.size()));
  for (std::size_t j = 0; j < landmarks.size(); ++j) {
    out[static_cast<Index>(j)] = landmarks[j].value.z();
  }
  return out;
}

}  // namespace

InitialState hand_over(const WindowModel& model, const WindowState& state, const WindowNormal& normal,
                       const MatrixXd& frames) {
  const Index body = model.body_size();
  const Index last = static_cast<Index>(state.frames.size() - 1) * model.frame_size();
  const std::vector<Index> rest = normal.layout.rest();
  LastPoints points = points_from_last(model, state, normal);
  InitialState out;
  out.nav = state.frames.back().nav;
  out.body_covariance = frames.block(last, last, body, body);
  out.landmarks_body = multiply(points.rows, frames(rest, Eigen::seqN(last, body)).eval());
  out.landmarks_covariance = congruence(points.rows, frames(rest, rest).eval());
  for (std::size_t j = 0; j < points.own.size(); ++j) {
    const auto at = static_cast<Index>(3 * j);
    out.landmarks_covariance.block<3, 3>(at, at) += points.own[j];
  }
  out.landmarks = std::move(points.landmarks);
  return out;
}

double scale_information(const WindowModel& model, const WindowState& state, const WindowNormal& normal,
                         const MatrixXd& frames) {
  const std::vector<Index> rest = normal.layout.rest();
  const LastPoints points = points_from_last(model, state, normal);
  const auto n = static_cast<Index>(points.own.size());
  const MatrixXd of_depths = points.rows(kDepths(n), Eigen::all);
  MatrixXd C = congruence(of_depths, frames(rest, rest).eval());
  for (Index j = 0; j < n; ++j) {
    C(j, j) += points.own[static_cast<std::size_t>(j)](2, 2);
  }
  return common_information(inverse_depths(points.landmarks), C);
}

double without_noise(double scale_information) {
  return std::min(std::max(scale_information - kNoiseInformation, kLeastInformation), scale_information);
}

void take_noise_from_scale(InitialState& state) {
  const VectorXd rho = inverse_depths(state.landmarks);
  const auto depths = kDepths(rho.size());
  const double stated = common_information(rho, state.landmarks_covariance(depths, depths));
  if (stated == 0.0) {
    return;
  }
  state.landmarks_covariance(depths, depths) +=
      (1.0 / without_noise(stated) - 1.0 / stated) * rho * rho.transpose();
}

}  // namespace limber::detail
