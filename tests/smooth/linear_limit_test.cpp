// SPDX-License-Identifier: MIT
#include <ceres/problem.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <vector>

#include "check_covariance.hpp"
#include "limber/measure/point_rows.hpp"
#include "limber/navigate/method.hpp"
#include "smooth/factors.hpp"
#include "smooth/least_squares.hpp"
#include "smooth/pose_manifold.hpp"
#include "smooth/reduced_system.hpp"
#include "update/stereo_problem.hpp"

/// One frame, one linearisation: the smoother with a rig that is free in every frame is the filter's update
/// with all six directions constrained. docs/derivations/smoother.md.
namespace limber::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using limber::testing::Generator;

/// Pose, anchor and landmarks in inverse depth, with a prior that correlates all of them; one stereo frame.
struct OneFrame {
  OneFrame(Generator& generator, double baseline, int points)
      : calibration(limber::testing::stereo_rig(baseline)), rig(mount(calibration)) {
    const StateLayout layout{MotionModel::kOdometry};
    pose = limber::testing::random_pose(generator, 5.0);
    anchor.T_world_body = {pose.R * limber::testing::random_rotation(generator, 0.1),
                           pose.p + 0.3 * baseline * limber::testing::random_vector(generator, 1.0)};
    anchor.T_body_cam0 = body_from_cam0(calibration);
    anchor.position_at = layout.map_begin();
    anchor.attitude_at = layout.map_begin() + 3;
    const Pose T_anchorcam_cam0 =
        (anchor.T_world_body * anchor.T_body_cam0).inverse() * pose * anchor.T_body_cam0;
    const auto seen = limber::testing::random_points(generator, points, 2.0 * baseline, 15.0 * baseline);
    VectorXd sigma = VectorXd::Zero(12 + 3 * points);
    sigma.head<12>() << VectorXd::Constant(3, 0.05), VectorXd::Constant(3, 0.01), VectorXd::Constant(3, 0.05),
        VectorXd::Constant(3, 0.01);
    z = empty_measurement(4 * points);
    for (int k = 0; k < points; ++k) {
      const Eigen::Vector3d X = T_anchorcam_cam0 * seen[static_cast<std::size_t>(k)].X_cam0;
      Landmark& landmark = landmarks.emplace_back();
      landmark.at = 12 + 3 * k;
      landmark.R_cam0_chart = rotation_between(Eigen::Vector3d::UnitZ(), X.normalized());
      landmark.value << 0.0, 0.0, 1.0 / X.norm();
      sigma.segment<3>(landmark.at) << 0.01, 0.01, 0.3 / X.norm();
      const BodyPoint body = body_point(pose, landmark, &anchor);
      for (const std::size_t camera : {0U, 1U}) {
        const auto projection = project_point(rig[camera], body);
        uv.emplace_back(projection.value().uv + 2.0 * limber::testing::random_normal(generator, 2));
        write_point_rows(z, 4 * k + 2 * static_cast<Index>(camera), uv.back(), {0.5, 0.5}, *projection,
                         landmark, &anchor, layout);
      }
      z.groups.push_back({4 * k, 4, landmark.at});
    }
    P.append(sigma.size());
    P.set_diagonal_block(0, limber::testing::random_covariance(generator, sigma));
  }

  StereoCalibration calibration;
  MountedRig rig;
  Pose pose;
  Anchor anchor;
  std::vector<Landmark> landmarks;
  std::vector<Eigen::Vector2d> uv;
  LinearMeasurement z;
  Covariance P;
};

struct Step {
  VectorXd dx;
  MatrixXd P;
};

/// Gauss and Newton's step of the smoother's own terms, theta eliminated.
Step least_squares_step(OneFrame frame, const RigParameters& rig_sigma) {
  std::array<PoseBlock, 2> poses;
  write_pose(frame.pose, poses[0].data());
  write_pose(frame.anchor.T_world_body, poses[1].data());
  RigParameters theta = frame.calibration.theta;
  ceres::Problem problem;
  Columns columns;
  std::vector<int> sizes = {kPoseBlock, kPoseBlock};
  VectorXd x0(2 * kPoseBlock + 3 * static_cast<Index>(frame.landmarks.size()));
  for (std::size_t k = 0; k < 2; ++k) {
    problem.AddParameterBlock(poses[k].data(), kPoseBlock, new PoseManifold);
    columns.kept.push_back(poses[k].data());
    x0.segment<kPoseBlock>(kPoseBlock * static_cast<Index>(k)) =
        Eigen::Map<const VectorXd>(poses[k].data(), kPoseBlock);
  }
  for (std::size_t k = 0; k < frame.landmarks.size(); ++k) {
    columns.kept.push_back(frame.landmarks[k].value.data());
    sizes.push_back(3);
    x0.segment<3>(2 * kPoseBlock + 3 * static_cast<Index>(k)) = frame.landmarks[k].value;
  }
  problem.AddResidualBlock(
      new BlockPrior(sizes, x0, whitener_of(frame.P.dense()), VectorXd::Zero(frame.P.size())), nullptr,
      columns.kept);
  problem.AddResidualBlock(
      new BlockPrior({6}, theta, rig_sigma.cwiseInverse().asDiagonal(), VectorXd::Zero(6)), nullptr,
      theta.data());
  columns.kept.push_back(theta.data());
  for (std::size_t k = 0; k < frame.uv.size(); ++k) {
    PointSight sight;
    sight.camera = &frame.rig[k % 2];
    sight.landmark = frame.landmarks[k / 2];
    sight.T_body_cam0 = frame.anchor.T_body_cam0;
    sight.theta = k % 2 == 1;
    sight.uv = frame.uv[k];
    sight.sigma_px << 0.5, 0.5;
    std::vector<double*> blocks = {poses[0].data(), poses[1].data(), frame.landmarks[k / 2].value.data()};
    if (sight.theta) {
      blocks.push_back(theta.data());
    }
    problem.AddResidualBlock(new PointFactor(sight), nullptr, blocks);
  }
  const ReducedSystem system = reduce(problem, columns);
  // Units differ by orders of magnitude: scaled to a unit diagonal.
  const VectorXd scale = system.information.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd lower = scale.asDiagonal() * system.information * scale.asDiagonal();
  const Eigen::LLT<MatrixXd> llt(lower.selfadjointView<Eigen::Lower>());
  const MatrixXd inverse = scale.asDiagonal() * llt.solve(MatrixXd(scale.asDiagonal()));
  const Index n = frame.P.size();
  return {VectorXd(-inverse * system.gradient).head(n), inverse.topLeftCorner(n, n)};
}

struct Difference {
  double dx, P;
};

Difference difference(const OneFrame& frame, const RigParameters& rig_sigma) {
  Covariance P = frame.P;
  const UpdateReport report = update(P, frame.z, {constraint_directions({}, frame.calibration.theta), {}});
  EXPECT_EQ(report.rank, 6);
  const Step step = least_squares_step(frame, rig_sigma);
  const VectorXd sigma = limber::testing::prior_sigma(frame.P);
  return {limber::testing::relative_difference(step.dx, report.dx, sigma),
          limber::testing::relative_difference(step.P, P.dense(), sigma)};
}

TEST(LinearLimit, OneFrameWithAFreeRigIsTheConstrainedUpdate) {
  Generator generator(1);
  for (const double baseline : {0.12, 0.5, 2.0}) {
    for (int run = 0; run < 5; ++run) {
      const OneFrame frame(generator, baseline, 25);
      SmootherOptions options;
      options.rig = RigModel::kFree;
      const Difference d = difference(frame, sigma_of_rig(options, baseline));
      EXPECT_LT(d.dx, 1e-6);
      EXPECT_LT(d.P, 1e-6);
    }
  }
}

TEST(LinearLimit, TheDifferenceFallsWithTheSquareOfWhatTheRigMayBeOffBy) {
  Generator generator(2);
  const OneFrame frame(generator, 0.5, 25);
  const auto dx = [&](double errors) { return difference(frame, errors * plausible_error(0.5)).dx; };
  EXPECT_NEAR(dx(30.0) / dx(300.0), 100.0, 5.0);
  EXPECT_GT(dx(3.0), 1e-3);  // a rig that is nearly known is another problem
}

}  // namespace
}  // namespace limber::detail
