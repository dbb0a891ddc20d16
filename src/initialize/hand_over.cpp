// SPDX-License-Identifier: MIT
#include "hand_over.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <optional>

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

}  // namespace

InitialState hand_over(const WindowModel& model, const WindowState& state, const WindowNormal& normal,
                       const MatrixXd& frames) {
  const Index body = model.body_size();
  const Index last = static_cast<Index>(state.frames.size() - 1) * model.frame_size();
  InitialState out;
  out.nav = state.frames.back().nav;
  out.body_covariance = frames.block(last, last, body, body);
  const std::vector<Index> rest = normal.layout.rest();
  std::vector<MatrixXd> rows;  // each point's error in those of the frames
  std::vector<Matrix3d> own;   // and what it has beside
  for (std::size_t j = 0; j < state.points.size(); ++j) {
    const WindowPoint& point = state.points[j];
    if (!(point.landmark.value.z() > 0.0)) {
      continue;
    }
    const LastView view = view_from_last(model, state, point);
    const Matrix3d V = normal.V[j].inverse();
    const Matrix3d JV = view.J_point * V;
    MatrixXd B = MatrixXd::Zero(3, frames.cols());
    B(Eigen::all, rest) = -JV * normal.W.middleCols<3>(static_cast<Index>(3 * j)).transpose();
    B.middleCols<6>(last) += view.J_last;
    B.middleCols<6>(static_cast<Index>(point.anchor()) * model.frame_size()) += view.J_anchor;
    rows.push_back(std::move(B));
    own.push_back(JV * view.J_point.transpose());
    out.landmarks.push_back(view.landmark);
  }
  const auto n = static_cast<Index>(3 * rows.size());
  MatrixXd B(n, frames.cols());
  for (std::size_t j = 0; j < rows.size(); ++j) {
    B.middleRows<3>(static_cast<Index>(3 * j)) = rows[j];
  }
  const MatrixXd BC = multiply(B, frames);
  out.landmarks_body = BC.middleCols(last, body);
  out.landmarks_covariance = multiply(BC, transposed(B));
  for (std::size_t j = 0; j < own.size(); ++j) {
    out.landmarks_covariance.block<3, 3>(static_cast<Index>(3 * j), static_cast<Index>(3 * j)) += own[j];
  }
  return out;
}

double scale_information(const InitialState& state) {
  const auto n = static_cast<Index>(state.landmarks.size());
  if (n < 3) {
    return 0.0;
  }
  MatrixXd C(n, n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      C(i, j) = state.landmarks_covariance(3 * i + 2, 3 * j + 2) /
                (state.landmarks[static_cast<std::size_t>(i)].value.z() *
                 state.landmarks[static_cast<std::size_t>(j)].value.z());
    }
  }
  const VectorXd x = Cholesky(C).solve(VectorXd::Ones(n));
  return x.allFinite() && x.sum() > 0.0 ? x.sum() : 0.0;
}

void take_noise_from_scale(InitialState& state) {
  const double stated = scale_information(state);
  if (stated == 0.0) {
    return;
  }
  const double known = std::max(stated - kNoiseInformation, kLeastInformation);
  VectorXd scale = VectorXd::Zero(state.landmarks_covariance.rows());
  for (std::size_t j = 0; j < state.landmarks.size(); ++j) {
    scale[3 * static_cast<Index>(j) + 2] = state.landmarks[j].value.z();
  }
  state.landmarks_covariance += std::max(1.0 / known - 1.0 / stated, 0.0) * scale * scale.transpose();
}

}  // namespace limber::detail
