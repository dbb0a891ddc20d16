// SPDX-License-Identifier: MIT
#include "limber/sensors/parameters.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "check_jacobian.hpp"
#include "limber/core/so3.hpp"
#include "measure/rigs.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::Generator;

TEST(ParameterNames, AreDifferentAndNameThemselves) {
  const std::set<std::string_view> names(kParameterNames.begin(), kParameterNames.end());
  EXPECT_EQ(names.size(), kParameterNames.size());
  for (std::size_t k = 0; k < kParameterNames.size(); ++k) {
    EXPECT_EQ(parameters_named(kParameterNames[k]), ParameterSet().set(k)) << kParameterNames[k];
  }
}

TEST(ParameterNames, AGroupIsItsMembers) {
  const auto members = [](std::string_view group) {
    std::string text;
    const ParameterSet set = parameters_named(group).value();
    for (std::size_t k = 0; k < set.size(); ++k) {
      text += set[k] ? std::string(kParameterNames[k]) + " " : "";
    }
    return text;
  };
  EXPECT_EQ(members("theta"), "ax ay az tx ty tz ");
  EXPECT_EQ(members("intrinsics0"), "fu0 fv0 cu0 cv0 radial0 ");
  EXPECT_EQ(members("intrinsics1"), "fu1 fv1 cu1 cv1 radial1 ");
  EXPECT_EQ(members("imu"), "imu-ax imu-ay imu-az imu-tx imu-ty imu-tz ");
  EXPECT_EQ(members("IMU"), members("imu"));
  EXPECT_FALSE(parameters_named("intrinsics"));
  EXPECT_FALSE(parameters_named(""));
}

TEST(ParameterNames, HaveTheUnitOfWhatTheyAre) {
  const std::string_view expected[] = {"rad", "rad", "rad", "m",   "m",   "m",  "px", "px",
                                       "px",  "px",  "-",   "s",   "px",  "px", "px", "px",
                                       "-",   "s",   "rad", "rad", "rad", "m",  "m",  "m"};
  for (std::size_t k = 0; k < kParameterNames.size(); ++k) {
    EXPECT_EQ(unit_of(k), expected[k]) << kParameterNames[k];
  }
}

TEST(Corrected, MovesEachParameterAndNothingElse) {
  Generator generator(1);
  const StereoCalibration before = testing::all_rigs(generator).front().calibration;
  for (Index k = 0; k < kParameters; ++k) {
    ParameterVector error = ParameterVector::Zero();
    error(k) = 0.01;
    const StereoCalibration after = corrected(before, error);
    ParameterVector moved;
    const auto camera = [](const Camera& a, const Camera& b, double offset) {
      const auto radial = [](const Camera& c) {
        const auto* d = std::get_if<RadialTangential>(&c.distortion);
        return d == nullptr ? 0.0 : d->k1;
      };
      return (Eigen::Matrix<double, 6, 1>() << b.fu - a.fu, b.fv - a.fv, b.cu - a.cu, b.cv - a.cv,
              radial(b) - radial(a), offset)
          .finished();
    };
    moved << after.theta - before.theta, camera(before.cam0, after.cam0, after.time_offset_s[0]),
        camera(before.cam1, after.cam1, after.time_offset_s[1]),
        so3_log(after.T_body_cam0.R * before.T_body_cam0.R.transpose()),
        after.T_body_cam0.p - before.T_body_cam0.p;
    EXPECT_LE((moved - error).cwiseAbs().maxCoeff(), 1e-12) << kParameterNames[static_cast<std::size_t>(k)];
  }
  const StereoCalibration undistorted;
  EXPECT_TRUE(
      std::holds_alternative<NoDistortion>(corrected(undistorted, ParameterVector::Zero()).cam0.distortion));
}

TEST(IntrinsicsJacobian, MatchesCentralDifferencesForEveryCamera) {
  Generator generator(2);
  int checked = 0;
  for (const testing::NamedCamera& named : testing::all_cameras()) {
    SCOPED_TRACE(named.name);
    for (int i = 0; i < 20; ++i) {
      const Vector3d X(testing::random_scalar(generator, -0.8, 0.8),
                       testing::random_scalar(generator, -0.6, 0.6), i == 0 ? 1e4 : 2.0);
      const auto uv_of = [&](const VectorXd& d) {
        StereoCalibration rig;
        rig.cam0 = named.camera;
        ParameterVector error = ParameterVector::Zero();
        error.segment<5>(first_of(ParameterBlock::kCam0)) = d;
        return project(corrected(rig, error).cam0, X);
      };
      const auto here = uv_of(VectorXd::Zero(5));
      if (!here || !uv_of(VectorXd::Constant(5, 1e-3))) {
        continue;
      }
      testing::check_jacobian(
          MatrixXd(intrinsics_jacobian(named.camera, X, here->uv)),
          [&](const VectorXd& d) { return VectorXd(uv_of(d)->uv); }, 1e-6);
      ++checked;
    }
  }
  EXPECT_GE(checked, 40);
}

TEST(IntrinsicsJacobian, OnTheAxisOfAFisheyeKnowsNoRadius) {
  Camera camera{400.0, 400.0, 320.0, 240.0, 640, 480, Equidistant{0.01, 0.0, 0.0, 0.0}};
  const Eigen::Matrix<double, 2, 5> J =
      intrinsics_jacobian(camera, Vector3d(0, 0, 2), Vector2d(320.0, 240.0));
  EXPECT_TRUE(J.allFinite());
  EXPECT_TRUE(J.col(4).isZero(0.0));
}

}  // namespace
}  // namespace limber
