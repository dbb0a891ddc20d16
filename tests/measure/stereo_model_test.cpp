// SPDX-License-Identifier: MIT
#include "limber/measure/stereo_model.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "check_jacobian.hpp"
#include "limber/core/so3.hpp"
#include "limber/state/estimate.hpp"
#include "rigs.hpp"

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::check_jacobian;
using testing::Generator;
using testing::random_pose;
using testing::random_scalar;
using testing::random_vector;

constexpr double kTolerance = 2e-6;

/// A body, an anchor and a landmark that the rig sees.
struct Scene {
  StereoCalibration calibration;
  Pose T_world_body;
  Anchor anchor;
  Landmark landmark;

  [[nodiscard]] const Anchor* used_anchor() const {
    return landmark.kind == LandmarkKind::kCartesian ? nullptr : &anchor;
  }
  [[nodiscard]] BodyPoint point() const { return body_point(T_world_body, landmark, used_anchor()); }
};

Pose moved(Pose pose, const Vector3d& dp, const Vector3d& dtheta) {
  pose.p += dp;
  pose.R = pose.R * so3_exp(dtheta);
  return pose;
}

/// The scene with every variable moved: position, attitude, landmark, anchor position, anchor attitude,
/// theta.
Scene moved(Scene scene, const VectorXd& d) {
  scene.T_world_body = moved(scene.T_world_body, d.segment<3>(0), d.segment<3>(3));
  scene.landmark.value += d.segment<3>(6);
  scene.anchor.T_world_body = moved(scene.anchor.T_world_body, d.segment<3>(9), d.segment<3>(12));
  scene.calibration.theta += d.segment<6>(15);
  return scene;
}

Scene random_scene(Generator& generator, const StereoCalibration& calibration) {
  Scene scene;
  scene.calibration = calibration;
  scene.T_world_body = random_pose(generator, 5.0);
  const Vector3d shift = random_vector(generator, 0.3);
  scene.anchor.T_world_body = moved(scene.T_world_body, shift, 0.1 * random_vector(generator, 1.0));
  scene.anchor.T_body_cam0 = body_from_cam0(calibration);
  return scene;
}

Scene cartesian_scene(Generator& generator, const StereoCalibration& calibration, double depth) {
  Scene scene = random_scene(generator, calibration);
  const Vector3d X_cam0 =
      depth * Vector3d{random_scalar(generator, -0.3, 0.3), random_scalar(generator, -0.3, 0.3), 1.0};
  scene.landmark.kind = LandmarkKind::kCartesian;
  scene.landmark.value = scene.T_world_body * (body_from_cam0(calibration) * X_cam0);
  return scene;
}

/// Seen from its anchor in a direction near the axis, at the inverse depth rho [1/m].
Scene inverse_depth_scene(Generator& generator, const StereoCalibration& calibration, double rho) {
  Scene scene = random_scene(generator, calibration);
  const Vector3d d =
      Vector3d{random_scalar(generator, -0.2, 0.2), random_scalar(generator, -0.2, 0.2), 1.0}.normalized();
  scene.landmark.kind = LandmarkKind::kInverseDepth;
  scene.landmark.R_cam0_chart.col(2) = d;
  scene.landmark.R_cam0_chart.col(0) = d.unitOrthogonal();
  scene.landmark.R_cam0_chart.col(1) = d.cross(scene.landmark.R_cam0_chart.col(0));
  scene.landmark.value << random_scalar(generator, -0.05, 0.05), random_scalar(generator, -0.05, 0.05), rho;
  return scene;
}

/// A scene of each kind for one rig: near, usual, far, at infinity, and just beyond it.
std::vector<Scene> scenes(Generator& generator, const StereoCalibration& calibration) {
  std::vector<Scene> out;
  for (const double depth : {2.0, 10.0, 100.0, 1e4}) {
    out.push_back(cartesian_scene(generator, calibration, depth));
  }
  for (const double rho : {0.5, 0.1, 1e-2, 1e-8, 0.0, -1e-8, -1e-3}) {
    out.push_back(inverse_depth_scene(generator, calibration, rho));
  }
  return out;
}

TEST(BodyPoint, JacobiansMatchCentralDifferences) {
  Generator generator(1);
  for (const auto& [name, calibration] : testing::all_rigs(generator)) {
    for (const Scene& scene : scenes(generator, calibration)) {
      const BodyPoint point = scene.point();
      MatrixXd J = MatrixXd::Zero(4, 21);
      J.topLeftCorner<3, 15>() << point.J_Y_position, point.J_Y_attitude, point.J_Y_landmark,
          point.J_Y_anchor_position, point.J_Y_anchor_attitude;
      J.block<1, 3>(3, 6) = point.J_w_landmark;
      check_jacobian(
          J,
          [&](const VectorXd& d) {
            const BodyPoint p = moved(scene, d).point();
            return VectorXd(Eigen::Vector4d(p.Y.x(), p.Y.y(), p.Y.z(), p.w));
          },
          1e-7);
    }
  }
}

TEST(ProjectPoint, JacobiansMatchCentralDifferencesForEveryRigAndEveryDepth) {
  Generator generator(2);
  int checked = 0;
  for (const auto& [name, calibration] : testing::all_rigs(generator)) {
    for (const Scene& scene : scenes(generator, calibration)) {
      for (const std::size_t cam : {0U, 1U}) {
        SCOPED_TRACE(name + ", camera " + std::to_string(cam) + ", landmark " +
                     std::to_string(scene.landmark.value.z()));
        const auto projection = project_point(mount(calibration)[cam], scene.point());
        ASSERT_TRUE(projection);
        MatrixXd J(2, 21);
        J << projection->J_position, projection->J_attitude, projection->J_landmark,
            projection->J_anchor_position, projection->J_anchor_attitude, projection->J_theta;
        check_jacobian(
            J,
            [&](const VectorXd& d) {
              const Scene disturbed = moved(scene, d);
              return VectorXd(project_point(mount(disturbed.calibration)[cam], disturbed.point())->uv);
            },
            kTolerance);
        ++checked;
      }
    }
  }
  EXPECT_GE(checked, 1000);
}

TEST(ProjectPoint, PixelIsThatOfTheWorldPointInTheCameraItself) {
  Generator generator(3);
  for (const auto& [name, calibration] : testing::all_rigs(generator)) {
    const MountedRig rig = mount(calibration);
    for (const double rho : {0.5, 0.1, 0.01}) {
      const Scene scene = inverse_depth_scene(generator, calibration, rho);
      const Vector3d p_world = world_position(scene.landmark, &scene.anchor);
      Scene cartesian = scene;
      cartesian.landmark.kind = LandmarkKind::kCartesian;
      cartesian.landmark.value = p_world;
      for (const std::size_t cam : {0U, 1U}) {
        const Vector3d X = rig[cam].T_cam_body * (scene.T_world_body.inverse() * p_world);
        const Vector2d expected = project(rig[cam].camera, X)->uv;
        EXPECT_LE((project_point(rig[cam], scene.point())->uv - expected).norm(), 1e-9) << name;
        EXPECT_LE((project_point(rig[cam], cartesian.point())->uv - expected).norm(), 1e-9) << name;
      }
    }
  }
}

TEST(ProjectPoint, APointAtInfinityDoesNotMoveWithThePosition) {
  Generator generator(4);
  const StereoCalibration calibration = testing::random_calibration(
      generator, BodyFrame::kImu, testing::euroc_camera(), testing::euroc_camera(), 0.05);
  const Scene scene = inverse_depth_scene(generator, calibration, 0.0);
  const MountedRig rig = mount(calibration);
  for (const std::size_t cam : {0U, 1U}) {
    const auto projection = project_point(rig[cam], scene.point());
    EXPECT_TRUE(projection->J_position.isZero(0.0));
    EXPECT_TRUE(projection->J_theta.rightCols<3>().isZero(0.0));
    EXPECT_GT(projection->J_attitude.norm(), 100.0);
  }
}

TEST(ProjectPoint, RefusesAPointBehindTheCamera) {
  Generator generator(5);
  const StereoCalibration calibration = testing::random_calibration(
      generator, BodyFrame::kImu, testing::euroc_camera(), testing::paper_camera(), 0.05);
  const MountedRig rig = mount(calibration);
  const Scene scene = cartesian_scene(generator, calibration, -3.0);
  EXPECT_FALSE(project_point(rig[0], scene.point()));
  EXPECT_FALSE(project_point(rig[1], scene.point()));
}

TEST(ProjectPoint, LeftCameraHasNoThetaJacobianUnlessTheBodyIsInTheMiddle) {
  Generator generator(6);
  for (const auto& [name, calibration] : testing::all_rigs(generator)) {
    const MountedRig rig = mount(calibration);
    const BodyPoint point = cartesian_scene(generator, calibration, 5.0).point();
    const bool middle = calibration.body == BodyFrame::kMiddleOfBaseline;
    EXPECT_EQ(project_point(rig[0], point)->J_theta.isZero(0.0), !middle) << name;
    EXPECT_FALSE(project_point(rig[1], point)->J_theta.isZero(1e-3)) << name;
  }
}

TEST(WorldPosition, JacobianMatchesCentralDifferences) {
  Generator generator(7);
  for (const auto& [name, calibration] : testing::all_rigs(generator)) {
    for (const double rho : {1.0, 0.2, 0.02}) {
      const Scene scene = inverse_depth_scene(generator, calibration, rho);
      check_jacobian(
          world_position_jacobian(scene.landmark, scene.anchor),
          [&](const VectorXd& d) {
            VectorXd all = VectorXd::Zero(21);
            all.segment<3>(9) = d.segment<3>(0);
            all.segment<3>(12) = d.segment<3>(3);
            all.segment<3>(6) = d.segment<3>(6);
            const Scene disturbed = moved(scene, all);
            return VectorXd(world_position(disturbed.landmark, &disturbed.anchor));
          },
          1e-6);
    }
  }
}

TEST(WorldPosition, IsFarButFiniteAtAndBeyondInfinity) {
  Generator generator(8);
  const StereoCalibration calibration = testing::random_calibration(
      generator, BodyFrame::kImu, testing::euroc_camera(), testing::euroc_camera(), 0.05);
  for (const double rho : {0.0, -0.1}) {
    const Scene scene = inverse_depth_scene(generator, calibration, rho);
    const Vector3d p = world_position(scene.landmark, &scene.anchor);
    EXPECT_TRUE(p.allFinite());
    EXPECT_GT(p.norm(), 1e5);
    const Vector3d ray =
        (scene.anchor.T_world_body.R * scene.anchor.T_body_cam0.R * scene.landmark.R_cam0_chart *
         Vector3d(scene.landmark.value.x(), scene.landmark.value.y(), 1.0))
            .normalized();
    EXPECT_GT(p.normalized().dot(ray), 1.0 - 1e-6);
  }
}

}  // namespace
}  // namespace limber
