// SPDX-License-Identifier: MIT
#include "limber/measure/epipolar.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "check_jacobian.hpp"
#include "limber/core/so3.hpp"
#include "random_geometry.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::Generator;

/// A rig of any make, and a right bearing that is somewhat off the epipolar line.
struct Seen {
  RigParameters theta;
  StereoBearings pair;
};

std::vector<Seen> seen_by_random_rigs() {
  Generator generator(5);
  std::vector<Seen> out;
  for (int k = 0; k < 20; ++k) {
    Seen seen;
    seen.theta.head<3>() = testing::random_vector(generator, 0.3);
    seen.theta.tail<3>() = testing::random_vector(generator, 1.0);
    const Vector3d point = Vector3d(0.5, 0.5, 4.0) + testing::random_vector(generator, 1.0);
    const Vector3d from_right = pose_from_rig(seen.theta) * point;
    seen.pair.cam0 = point / point.z();
    seen.pair.cam1 = from_right / from_right.z();
    seen.pair.cam1.head<2>() += testing::random_vector(generator, 0.05).head<2>();
    out.push_back(seen);
  }
  return out;
}

TEST(EpipolarSlope, IsThatOfCentralDifferencesByTurnAndTranslation) {
  for (const Seen& seen : seen_by_random_rigs()) {
    const Pose rig = pose_from_rig(seen.theta);
    testing::check_jacobian(detail::epipolar_slope(seen.pair, rig), [&](const VectorXd& d) {
      const Pose moved{so3_exp(d.head<3>()) * rig.R, rig.p + d.tail<3>()};
      return VectorXd(VectorXd::Constant(1, detail::epipolar_error(seen.pair, moved)));
    });
  }
}

TEST(EpipolarSlope, IsThatOfCentralDifferencesByTheta) {
  for (const Seen& seen : seen_by_random_rigs()) {
    const detail::PoseSlope slope =
        detail::epipolar_slope(seen.pair, pose_from_rig(seen.theta)) * detail::pose_by_theta(seen.theta);
    testing::check_jacobian(slope, [&](const VectorXd& d) {
      return VectorXd(
          VectorXd::Constant(1, detail::epipolar_error(seen.pair, pose_from_rig(seen.theta + d))));
    });
  }
}

TEST(EpipolarSlope, DoesNotSeeHowLongTheBaselineIs) {
  for (const Seen& seen : seen_by_random_rigs()) {
    const Pose rig = pose_from_rig(seen.theta);
    EXPECT_NEAR(detail::epipolar_slope(seen.pair, rig).tail<3>().dot(rig.p), 0.0, 1e-12);
  }
}

}  // namespace
}  // namespace limber
