// SPDX-License-Identifier: MIT
#pragma once

#include "limber/core/so3.hpp"
#include "limber/datasets/recording.hpp"

namespace limber::testing {

/// A recording with something in every list, and numbers that need all their digits. Times as in KITTI: 19
/// digits that a double cannot hold.
inline Recording small_recording() {
  constexpr std::int64_t kStart = 1317384506402996993;
  constexpr std::int64_t kStep = 50'000'001;
  Recording r;
  r.calibration.cam0 = {
      458.654, 457.296, 367.215, 248.375, 752, 480, RadialTangential{-0.28, 0.07, 1.9e-4, 1.7e-05}};
  r.calibration.cam1 = {
      457.587, 456.134, 379.999, 255.238, 752, 480, Equidistant{0.01, -0.02, 1.0 / 3.0, 4e-9}};
  r.calibration.theta << 0.01, -0.02, 0.03, -0.11, 1e-3, -2e-3;
  r.calibration.T_body_cam0 = {so3_exp({0.3, -1.2, 0.7}), {0.1, 1.0 / 3.0, -0.05}};
  r.imu_noise = ImuNoise{1.6968e-04, 1.9393e-05, 2e-3, 3e-3};
  r.odometry_noise = OdometryNoise{{0.1, 0.2, 0.3}, {0.01, 0.02, 1.0 / 30.0}};
  r.pixel_noise = PixelNoise(0.5, 0.6, 0.7, 0.1 + 0.2);
  for (int k = 0; k < 4; ++k) {
    const std::int64_t t_ns = kStart + k * kStep;
    const double s = (k + 1) / 7.0;
    r.imu.push_back({t_ns, {s, -s, 0.1 * s}, {9.81 + s, 1e-17, -s}});
    r.odometry.push_back({t_ns + 1, {s, 0.0, -s}, {1e-300, s, 3.0}});
    r.truth.motion.states.push_back(
        {t_ns + 2, so3_exp({s, 2.0 * s, -3.0}), {s, 1e6 * s, -s}, {1.0, s, 0.0}, {s, 0, 0}, {0, s, 0}});
    TrueRig truth{t_ns + 3, r.calibration.theta};
    truth.theta[3] -= 0.01 * s;
    r.truth.rig.push_back(truth);
    r.truth.landmarks[100 - 7 * k] = {s, -2.0 * s, 1e-3 / s};
  }
  r.truth.motion.has_velocity = r.truth.motion.has_biases = true;
  r.frames = {
      {kStart,
       {{7, {100.125, 1.0 / 3.0}, {88.1, 0.33}, true, true}, {-3, {20.5, 30.25}, {0, 0}, true, false}}},
      {kStart + kStep, {}},
      {kStart + 2 * kStep, {{7, {0, 0}, {90.0, 0.1 + 0.2}, false, true}}}};
  return r;
}

}  // namespace limber::testing
