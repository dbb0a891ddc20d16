// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include "limber/core/so3.hpp"
#include "limber/sensors/calibration.hpp"

namespace limber::testing {

/// A rig in which every number is another one.
inline StereoCalibration some_rig(const Distortion& distortion = RadialTangential{-0.28, 0.07, 2e-4, 2e-5}) {
  StereoCalibration out;
  out.cam0 = {458.654, 457.296, 367.215, 248.375, 752, 480, distortion};
  out.cam1 = {457.587, 456.134, 379.999, 255.238, 752, 480, distortion};
  out.theta << 0.0123, -0.0034, 0.0021, -0.11, 0.0004, -0.0008;
  out.body = BodyFrame::kImu;
  out.T_body_cam0 = {rotation_from_euler_zyx({0.02, -0.01, 1.55}), {-0.0216, -0.0647, 0.0098}};
  return out;
}

inline void expect_same_camera(const Camera& a, const Camera& b) {
  if (std::holds_alternative<Omni>(a.distortion)) {  // times 1 + xi and back
    EXPECT_DOUBLE_EQ(a.fu, b.fu);
    EXPECT_DOUBLE_EQ(a.fv, b.fv);
  } else {
    EXPECT_EQ(a.fu, b.fu);
    EXPECT_EQ(a.fv, b.fv);
  }
  EXPECT_EQ(a.cu, b.cu);
  EXPECT_EQ(a.cv, b.cv);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  ASSERT_EQ(a.distortion.index(), b.distortion.index());
  EXPECT_EQ(coefficients(a.distortion), coefficients(b.distortion));
}

inline void expect_same_pose(const Pose& a, const Pose& b) {
  EXPECT_LE((a.R - b.R).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_LE((a.p - b.p).cwiseAbs().maxCoeff(), 1e-14);
}

}  // namespace limber::testing
