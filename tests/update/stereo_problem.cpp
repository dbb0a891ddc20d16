// SPDX-License-Identifier: MIT
#include "update/stereo_problem.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "check_covariance.hpp"
#include "limber/core/factors.hpp"
#include "limber/measure/point_rows.hpp"

namespace limber::testing {

StereoCalibration stereo_rig(double baseline, BodyFrame body) {
  StereoCalibration out;
  out.cam0 = {300.0, 300.0, 240.0, 320.0, 480, 640, NoDistortion{}};
  out.cam1 = {310.0, 305.0, 235.0, 322.0, 480, 640, NoDistortion{}};
  out.theta << 0.01, -0.02, 0.005, -baseline, 0.01 * baseline, -0.02 * baseline;
  out.body = body;
  out.T_body_cam0 = {so3_exp(Eigen::Vector3d(-1.2, 1.2, -1.2)), Eigen::Vector3d(0.1, 0.02, -0.03)};
  return out;
}

Eigen::MatrixXd StereoProblem::H() const { return z.H.dense(z.rows(), P.size()); }

Eigen::MatrixXd StereoProblem::R() const { return z.sigma.cwiseAbs2().asDiagonal(); }

Eigen::MatrixXd random_covariance(Generator& generator, const Eigen::VectorXd& sigma) {
  const Eigen::Index n = sigma.size();
  std::normal_distribution<double> draw;
  const Eigen::MatrixXd W = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return draw(generator); });
  const Eigen::MatrixXd correlated = 0.7 / static_cast<double>(n) * W * W.transpose();
  return sigma.asDiagonal() * (correlated + 0.3 * Eigen::MatrixXd::Identity(n, n)) * sigma.asDiagonal();
}

StereoProblem make_problem(Generator& generator, std::string name, const StereoCalibration& calibration,
                           const std::vector<SeenPoint>& points) {
  const StateLayout layout{MotionModel::kImu, false};
  const MountedRig rig = mount(calibration);
  const Pose T_world_body = random_pose(generator, 5.0);
  Anchor anchor;
  anchor.T_world_body = {T_world_body.R * random_rotation(generator, 0.1),
                         T_world_body.p + 0.05 * calibration.baseline() * random_vector(generator, 1.0)};
  anchor.T_body_cam0 = body_from_cam0(calibration);
  anchor.position_at = layout.map_begin();
  anchor.attitude_at = layout.map_begin() + 3;
  const Pose T_anchorcam_cam0 =
      (anchor.T_world_body * anchor.T_body_cam0).inverse() * T_world_body * body_from_cam0(calibration);

  const Eigen::Index n = layout.map_begin() + 6 + 3 * static_cast<Eigen::Index>(points.size());
  Eigen::VectorXd sigma(n);
  sigma.head<21>() << Eigen::Vector3d::Constant(0.1), Eigen::Vector3d::Constant(0.01),
      Eigen::Vector3d::Constant(0.1), Eigen::Vector3d::Constant(1e-3), Eigen::Vector3d::Constant(0.05),
      Eigen::Vector3d::Constant(0.1), Eigen::Vector3d::Constant(0.01);
  StereoProblem out;
  out.name = std::move(name);
  Eigen::Index m = 0;
  for (const SeenPoint& point : points) {
    m += 2 * (Eigen::Index{point.in_cam0} + Eigen::Index{point.in_cam1});
  }
  out.z = empty_measurement(m);
  Eigen::Index row = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector3d& X = points[k].X_cam0;
    Landmark landmark;
    landmark.at = layout.map_begin() + 6 + 3 * static_cast<Eigen::Index>(k);
    landmark.kind = k % 2 == 0 ? LandmarkKind::kCartesian : LandmarkKind::kInverseDepth;
    if (landmark.kind == LandmarkKind::kCartesian) {
      landmark.value = T_world_body * (body_from_cam0(calibration) * X);
      sigma.segment<3>(landmark.at).setConstant(0.02 * X.norm());
    } else {
      const Eigen::Vector3d seen = T_anchorcam_cam0 * X;
      landmark.R_cam0_chart = rotation_between(Eigen::Vector3d::UnitZ(), seen.normalized());
      landmark.value << 0.0, 0.0, 1.0 / seen.norm();
      sigma.segment<3>(landmark.at) << 0.002, 0.002, 0.1 / seen.norm();
    }
    const Anchor* stands_on = landmark.kind == LandmarkKind::kCartesian ? nullptr : &anchor;
    const BodyPoint body = body_point(T_world_body, landmark, stands_on);
    const Eigen::Index first = row;
    for (const std::size_t cam : {0U, 1U}) {
      if (cam == 0 ? points[k].in_cam0 : points[k].in_cam1) {
        const auto projection = project_point(rig[cam], body);
        const Eigen::Vector2d uv = projection.value().uv + 2.0 * random_normal(generator, 2);
        write_point_rows(out.z, row, uv, {0.5, 0.5}, *projection, landmark, stands_on, layout);
        row += 2;
      }
    }
    out.z.groups.push_back({first, row - first, landmark.at});
  }
  out.P.append(n);
  out.P.set_diagonal_block(0, random_covariance(generator, sigma));
  out.C = plausible_error(calibration.baseline()).asDiagonal();
  return out;
}

std::vector<SeenPoint> random_points(Generator& generator, int count, double near, double far) {
  std::vector<SeenPoint> out;
  for (int k = 0; k < count; ++k) {
    const double depth = near * std::pow(far / near, random_scalar(generator, 0.0, 1.0));
    const double v = random_scalar(generator, -0.9, 0.9);
    out.push_back({depth * Eigen::Vector3d(random_scalar(generator, -0.7, 0.7), v, 1.0)});
  }
  return out;
}

void make_theta_a_state(StereoProblem& problem) {
  const Eigen::Index theta = problem.P.append(6);
  problem.P.set_diagonal_block(theta, 1e-4 * Eigen::MatrixXd::Identity(6, 6));
  for (Eigen::Index row = 0; row < problem.z.rows(); row += 2) {
    for (const Eigen::Index half : {0, 3}) {
      problem.z.H.blocks.push_back({row, theta + half, problem.z.D.block<2, 3>(row, half)});
    }
  }
}

std::vector<StereoProblem> degenerate_problems(Generator& generator) {
  std::vector<StereoProblem> out;
  for (const double baseline : {0.12, 2.0}) {
    const auto add = [&](const std::string& name, const std::vector<SeenPoint>& points,
                         BodyFrame body = BodyFrame::kImu) {
      out.push_back(make_problem(generator, name + ", baseline " + std::to_string(baseline),
                                 stereo_rig(baseline, body), points));
    };
    for (const int count : {1, 2, 3, 4, 5}) {
      add(std::to_string(count) + " points", random_points(generator, count, 2.0, 30.0));
      add(std::to_string(count) + " points, middle", random_points(generator, count, 2.0, 30.0),
          BodyFrame::kMiddleOfBaseline);
    }
    for (const double distance : {80.0, 1e4, 1e7}) {
      add("all at one distance", random_points(generator, 20, distance, distance));
      add("all far", random_points(generator, 20, distance, 2.0 * distance));
      add("all far, middle", random_points(generator, 20, distance, 2.0 * distance),
          BodyFrame::kMiddleOfBaseline);
    }
    add("identical points", std::vector<SeenPoint>(6, {Eigen::Vector3d(0.5, 0.3, 8.0)}));
    std::vector<SeenPoint> line;
    for (int k = 0; k < 10; ++k) {
      line.push_back({Eigen::Vector3d(-1.0, 0.5, 6.0) + 0.3 * k * Eigen::Vector3d(1.0, -0.2, 0.5)});
    }
    add("collinear points", line);
    std::vector<SeenPoint> some = random_points(generator, 12, 3.0, 40.0);
    for (std::size_t k = 0; k < some.size(); ++k) {
      some[k].in_cam1 = k % 5 == 0;
      some[k].in_cam0 = k % 4 != 0 || !some[k].in_cam1;
    }
    add("right camera missing for most, left for some", some);
    std::vector<SeenPoint> left = random_points(generator, 8, 3.0, 40.0);
    for (SeenPoint& point : left) {
      point.in_cam1 = false;
    }
    add("right camera missing", left);
    add("right camera missing, middle", left, BodyFrame::kMiddleOfBaseline);
    add("zero columns of D", random_points(generator, 12, 3.0, 40.0));
    out.back().z.D.leftCols<2>().setZero();
    out.back().z.D.col(4).setZero();
    add("all columns of D zero", random_points(generator, 4, 3.0, 40.0));
    out.back().z.D.setZero();
  }
  return out;
}

Eigen::VectorXd prior_sigma(const Covariance& P) { return P.dense().diagonal().cwiseSqrt(); }

double relative_difference(const Eigen::VectorXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& sigma) {
  const Eigen::VectorXd weight = sigma.cwiseInverse();
  return (a - b).cwiseProduct(weight).cwiseAbs().maxCoeff() /
         std::max(1e-300, b.cwiseProduct(weight).cwiseAbs().maxCoeff());
}

double relative_difference(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, const Eigen::VectorXd& sigma) {
  const Eigen::VectorXd weight = sigma.cwiseInverse();
  const Eigen::MatrixXd difference = weight.asDiagonal() * (A - B) * weight.asDiagonal();
  return difference.cwiseAbs().maxCoeff();
}

Eigen::MatrixXd gain(const StereoProblem& problem, const ParameterErrorModel& model) {
  Eigen::MatrixXd L(problem.P.size(), problem.z.rows());
  LinearMeasurement z = problem.z;
  for (Eigen::Index k = 0; k < z.rows(); ++k) {
    z.residual = Eigen::VectorXd::Unit(z.rows(), k);
    Covariance P = problem.P;
    L.col(k) = update(P, z, model).dx;
  }
  return L;
}

Updated updated(const StereoProblem& problem, const ParameterErrorModel& model) {
  Covariance P = problem.P;
  Updated out;
  out.report = update(P, problem.z, model);
  out.P = P.dense();
  return out;
}

Updated textbook_ekf(const StereoProblem& problem) {
  const Eigen::MatrixXd P = problem.P.dense();
  const Eigen::MatrixXd H = problem.H();
  const Eigen::MatrixXd R = problem.R();
  const Eigen::MatrixXd S = congruence(H, P) + R;
  const Eigen::MatrixXd K = Cholesky(S).solve(multiply(H, P)).transpose();
  const Eigen::MatrixXd I_KH = Eigen::MatrixXd::Identity(P.rows(), P.rows()) - multiply(K, H);
  Updated out;
  out.report.dx = K * problem.z.residual;
  out.report.nis = problem.z.residual.dot(Cholesky(S).solve(problem.z.residual));
  out.P = congruence(I_KH, P) + congruence(K, R);
  return out;
}

}  // namespace limber::testing
