// SPDX-License-Identifier: MIT
#include "smooth/factors.hpp"

#include <ceres/problem.h>
#include <gtest/gtest.h>

#include <memory>
#include <numeric>
#include <vector>

#include "check_covariance.hpp"
#include "check_jacobian.hpp"
#include "predict/navigation_error.hpp"
#include "smooth/pose_manifold.hpp"
#include "update/stereo_problem.hpp"

/// Every term's derivative, with respect to the errors of its blocks, against central differences.
namespace limber::detail {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using limber::testing::Generator;
using limber::testing::random_normal;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::vector<double> block_of(const Pose& pose) {
  std::vector<double> out(kPoseBlock);
  write_pose(pose, out.data());
  return out;
}

std::vector<double> block_of(const VectorXd& x) { return {x.data(), x.data() + x.size()}; }

std::vector<double> moved(const std::vector<double>& block, const VectorXd& d) {
  std::vector<double> out = block;
  if (block.size() == kPoseBlock) {
    EXPECT_TRUE(PoseManifold().Plus(block.data(), d.data(), out.data()));
  } else {
    Eigen::Map<VectorXd>(out.data(), d.size()) += d;
  }
  return out;
}

VectorXd residual(const ceres::CostFunction& factor, const std::vector<std::vector<double>>& blocks) {
  std::vector<const double*> pointers;
  for (const auto& block : blocks) {
    pointers.push_back(block.data());
  }
  VectorXd r(factor.num_residuals());
  EXPECT_TRUE(factor.Evaluate(pointers.data(), r.data(), nullptr));
  return r;
}

void check(const ceres::CostFunction& factor, const std::vector<std::vector<double>>& blocks,
           double tolerance = 1e-6) {
  std::vector<const double*> pointers;
  std::vector<RowMajor> jacobians;
  std::vector<double*> out;
  for (const auto& block : blocks) {
    pointers.push_back(block.data());
    jacobians.emplace_back(factor.num_residuals(), static_cast<Eigen::Index>(block.size()));
  }
  for (RowMajor& J : jacobians) {
    out.push_back(J.data());
  }
  VectorXd r(factor.num_residuals());
  ASSERT_TRUE(factor.Evaluate(pointers.data(), r.data(), out.data()));
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    SCOPED_TRACE("block " + std::to_string(k));
    const bool pose = blocks[k].size() == kPoseBlock;
    const MatrixXd J = pose ? MatrixXd(jacobians[k].leftCols<kPoseTangent>()) : MatrixXd(jacobians[k]);
    limber::testing::check_jacobian(
        J,
        [&](const VectorXd& d) {
          auto with = blocks;
          with[k] = moved(blocks[k], d);
          return residual(factor, with);
        },
        tolerance);
  }
}

MotionBetween some_motion(MotionModel motion, Generator& generator) {
  std::vector<InputStep> steps;
  for (int k = 0; k < 5; ++k) {
    steps.push_back({0, 0.01, limber::testing::random_vector(generator, 1.0),
                     limber::testing::random_vector(generator, 5.0), 1.0});
  }
  return motion_between(motion, 0.05, steps, {}, {}, 0.01, 9.81);
}

TEST(MotionFactor, DerivativesMeetCentralDifferences) {
  Generator generator(1);
  for (const MotionModel motion :
       {MotionModel::kImu, MotionModel::kOdometry, MotionModel::kConstantVelocity}) {
    const MotionBetween between = some_motion(motion, generator);
    std::vector<std::vector<double>> blocks;
    for (int side = 0; side < 2; ++side) {
      NavigationState state = limber::testing::random_navigation_state(generator);
      state.T_world_body.R = limber::testing::random_rotation(generator, 0.5);
      const MotionBlock motion_block = motion_block_of(motion, state);
      blocks.push_back(block_of(state.T_world_body));
      if (motion != MotionModel::kOdometry) {
        blocks.emplace_back(motion_block.begin(), motion_block.begin() + motion_size(motion));
      }
    }
    check(MotionFactor(between, 9.81), blocks);
  }
}

/// A point some metres before a rig, seen from two poses a little apart.
struct PointScene {
  explicit PointScene(Generator& generator, BodyFrame body)
      : calibration(limber::testing::stereo_rig(0.12, body)),
        anchor(limber::testing::random_pose(generator, 3.0)),
        pose{anchor.R * limber::testing::random_rotation(generator, 0.1),
             anchor.p + limber::testing::random_vector(generator, 0.1)} {
    sight.landmark.R_cam0_chart = limber::testing::random_rotation(generator, 0.2);
    sight.T_body_cam0 = body_from_cam0(calibration);
    sight.uv << 200.0, 300.0;
    sight.sigma_px << 0.5, 0.7;
    sight.motion = {Vector3d(0.5, -1.0, 0.3), Vector3d(0.2, 0.1, -0.4)};
  }

  [[nodiscard]] std::vector<std::vector<double>> blocks() const {
    std::vector<std::vector<double>> out;
    if (!sight.in_anchor) {
      out = {block_of(pose), block_of(anchor)};
    }
    out.push_back(block_of(VectorXd(Vector3d(0.02, -0.03, 0.2))));
    return out;
  }

  StereoCalibration calibration;
  Pose anchor, pose;
  PointSight sight;
};

TEST(PointFactor, DerivativesMeetCentralDifferences) {
  Generator generator(2);
  for (const BodyFrame body : {BodyFrame::kImu, BodyFrame::kMiddleOfBaseline}) {
    for (const bool in_anchor : {false, true}) {
      for (const std::size_t camera : {0U, 1U}) {
        PointScene scene(generator, body);
        const MountedRig rig = mount(scene.calibration);
        scene.sight.camera = &rig[camera];
        scene.sight.in_anchor = in_anchor;
        check(PointFactor(scene.sight), scene.blocks());
      }
    }
  }
}

/// The rig follows its blocks: what the evaluation callback does between evaluations.
class RiggedFactor : public ceres::CostFunction {
 public:
  RiggedFactor(const PointScene& scene, std::size_t camera) : scene_(scene), camera_(camera) {
    scene_.sight.theta = scene_.sight.more = true;
    scene_.sight.camera = &mounted_;
    const PointFactor factor(scene_.sight);
    set_num_residuals(2);
    *mutable_parameter_block_sizes() = factor.parameter_block_sizes();
  }
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const std::size_t at = scene_.sight.in_anchor ? 1 : 3;
    ParameterVector error = ParameterVector::Zero();
    error.tail<kMoreParameters>() =
        Eigen::Map<const Eigen::Matrix<double, kMoreParameters, 1>>(blocks[at + 1]);
    StereoCalibration calibration = corrected(scene_.calibration, error);
    calibration.theta = Eigen::Map<const RigParameters>(blocks[at]);
    mounted_ = mount(calibration)[camera_];
    mounted_.with_parameters = true;
    return PointFactor(scene_.sight).Evaluate(blocks, residuals, jacobians);
  }

 private:
  PointScene scene_;
  std::size_t camera_;
  mutable MountedCamera mounted_;
};

TEST(PointFactor, DerivativesOfTheCalibrationMeetCentralDifferences) {
  Generator generator(3);
  for (const bool in_anchor : {false, true}) {
    for (const std::size_t camera : {0U, 1U}) {
      PointScene scene(generator, BodyFrame::kImu);
      scene.sight.in_anchor = in_anchor;
      auto blocks = scene.blocks();
      blocks.push_back(block_of(VectorXd(scene.calibration.theta)));
      VectorXd more = VectorXd::Zero(kMoreParameters);
      more << 3.0, -2.0, 1.0, 2.0, 0.01, 0.004, -1.0, 2.0, 2.0, 1.0, -0.01, 0.002, 0.1, -0.2, 0.15, 0.01, 0.0,
          0.02;
      blocks.push_back(block_of(more));
      check(RiggedFactor(scene, camera), blocks, 1e-5);
    }
  }
}

TEST(BlockPrior, DerivativesMeetCentralDifferences) {
  Generator generator(4);
  const Pose before = limber::testing::random_pose(generator, 2.0);
  VectorXd x0(kPoseBlock + 3);
  write_pose(before, x0.data());
  x0.tail<3>() << 1.0, 2.0, 3.0;
  const MatrixXd A = MatrixXd::Random(9, 9);
  const BlockPrior prior({kPoseBlock, 3}, x0, A, VectorXd::Random(9));
  const Pose now{before.R * limber::testing::random_rotation(generator, 0.5),
                 before.p + limber::testing::random_vector(generator, 1.0)};
  check(prior, {block_of(now), block_of(VectorXd(Vector3d(0.5, 2.5, 1.0)))});
}

TEST(WalkFactor, DerivativesMeetCentralDifferences) {
  const WalkFactor walk((RigParameters() << 0.1, 0.2, 0.3, 0.4, 0.5, 0.6).finished());
  check(walk, {block_of(VectorXd(VectorXd::Random(6))), block_of(VectorXd(VectorXd::Random(6)))});
}

}  // namespace
}  // namespace limber::detail
