// SPDX-License-Identifier: MIT
#include "limber/measure/camera_pose.hpp"

#include <gtest/gtest.h>

#include "check_jacobian.hpp"
#include "limber/core/so3.hpp"
#include "measure/rigs.hpp"
#include "state/small_map.hpp"

namespace limber {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::Generator;

const Vector3d kGyro(0.3, -0.8, 1.1);

/// cam0 of a rig as an estimate corrects it, on a body that moves as it says.
MountedCamera cam0_of(const Estimate& estimate, const StereoCalibration& rig) {
  ParameterVector error;
  error << RigParameters::Zero(), estimate.more();
  MountedCamera out = mount(corrected(rig, error))[0];
  out.motion.v_world = estimate.nav().v_world_body;
  out.motion.omega_body = estimate.layout().motion == MotionModel::kImu
                              ? Vector3d(kGyro - estimate.nav().bias_gyro)
                              : estimate.nav().omega_body;
  return out;
}

MatrixXd dense(const CameraPose& pose, Eigen::Index columns) {
  MatrixXd out = MatrixXd::Zero(6, columns);
  for (const CameraPose::Block& block : pose.blocks) {
    out.middleCols<kTriplet>(block.col) += block.value;
  }
  return out;
}

struct Setting {
  StereoCalibration rig;
  Estimate estimate;

  [[nodiscard]] CameraPose pose() const {
    return cam0_pose(cam0_of(estimate, rig), estimate.nav().T_world_body, estimate.layout());
  }
};

Setting make(Generator& generator, MotionModel motion, double offset) {
  StateLayout layout{motion, true};
  layout.has_more = {true, false, true};
  Setting out{testing::all_rigs(generator).front().calibration, testing::random_estimate(generator, layout)};
  for (const std::size_t k : {0U, 2U}) {
    out.estimate.mutable_P().set_diagonal_block(layout.more(k),
                                                testing::random_positive_definite(generator, 6, 0.01));
  }
  out.rig.time_offset_s[0] = offset;
  testing::move_body(out.estimate, [](NavigationState& nav) {
    nav.v_world_body << 1.5, -2.0, 0.4;
    nav.omega_body << -0.4, 0.9, 0.2;
  });
  return out;
}

TEST(Cam0Pose, JacobianMatchesCentralDifferencesOfTheRetractedEstimate) {
  Generator generator(1);
  for (const MotionModel motion :
       {MotionModel::kImu, MotionModel::kConstantVelocity, MotionModel::kOdometry}) {
    for (const double offset : {0.0, 0.02}) {
      SCOPED_TRACE(::testing::Message() << "motion " << static_cast<int>(motion) << ", offset " << offset);
      const Setting s = make(generator, motion, offset);
      const Pose here = s.pose().T_world_cam;
      testing::check_jacobian(
          dense(s.pose(), s.estimate.size()),
          [&](const VectorXd& dx) {
            Setting moved = s;
            moved.estimate.retract(dx);
            const Pose there = moved.pose().T_world_cam;
            VectorXd out(6);
            out << there.p - here.p, so3_log(here.R.transpose() * there.R);
            return out;
          },
          1e-7);
    }
  }
}

TEST(Cam0Pose, AsAnAnchorHasTheCovarianceThatFollows) {
  Generator generator(2);
  Setting s = make(generator, MotionModel::kImu, 0.01);
  const MatrixXd P = s.estimate.P().dense();
  const CameraPose pose = s.pose();
  const MatrixXd J = dense(pose, P.cols());
  const int index = s.estimate.add_camera_anchor(pose);
  testing::add_random_landmark(generator, s.estimate, 7, index);
  const Anchor& anchor = *s.estimate.anchor_of(*s.estimate.find(7));
  EXPECT_EQ(anchor.T_world_body.p, pose.T_world_cam.p);
  EXPECT_TRUE(anchor.T_body_cam0.R.isIdentity(0.0));
  const MatrixXd with_anchor = s.estimate.P().dense();
  EXPECT_EQ(anchor.attitude_at, anchor.position_at + kTriplet);
  const double scale = P.cwiseAbs().maxCoeff();
  EXPECT_LE((with_anchor.block(anchor.position_at, 0, 6, P.cols()) - J * P).cwiseAbs().maxCoeff(),
            1e-12 * scale);
  const MatrixXd own =
      with_anchor.block<6, 6>(anchor.position_at, anchor.position_at) - J * P * J.transpose();
  EXPECT_LE(own.cwiseAbs().maxCoeff(), 1e-11);  // the jitter
  EXPECT_GT(own.diagonal().minCoeff(), 0.0);
}

}  // namespace
}  // namespace limber
