// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "limber/sensors/camera.hpp"

/// Cameras of real data sets, and the paper's.
namespace limber::testing {

/// The paper's camera, Eq. (35): 480 wide, 640 high.
inline Camera paper_camera() { return {300.0, 300.0, 240.0, 320.0, 480, 640, NoDistortion{}}; }

/// EuRoC MAV cam0.
inline Camera euroc_camera() {
  return {458.654,
          457.296,
          367.215,
          248.375,
          752,
          480,
          RadialTangential{-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}};
}

/// TUM-VI cam0, 512 x 512: a fisheye that sees 195 degrees.
inline Camera tum_vi_camera() {
  return {190.97847715128717,
          190.9733070521226,
          254.93170605935475,
          256.8974428996504,
          512,
          512,
          Equidistant{0.0034823894022493434, 0.0007150348452162257, -0.0020532361418706202,
                      0.00020293673591811182}};
}

/// KITTI raw, 2011_09_26, camera 00: five coefficients.
inline Camera kitti_raw_camera() {
  return {984.2439,
          980.8141,
          690.0,
          233.1966,
          1392,
          512,
          Rational{-0.3728755, 0.2037299, 0.002219027, 0.001383707, -0.07233722, 0.0, 0.0, 0.0}};
}

/// A depth camera's colour lens as its maker's kit states it: OpenCV's eight coefficients.
inline Camera rational_camera() {
  return {607.2,
          607.1,
          638.9,
          367.4,
          1280,
          720,
          Rational{0.4579, -2.5553, 0.00098, -0.0002, 1.4896, 0.338, -2.3753, 1.4155}};
}

/// Of Kalibr's wiki, there with the focal lengths 833.006 and 830.345.
inline Camera kalibr_omni_camera() {
  constexpr double kXi = 0.80065662;
  return {833.006 / (1.0 + kXi),
          830.345 / (1.0 + kXi),
          373.85,
          253.749,
          752,
          480,
          Omni{kXi, -0.3351875, 0.13211436, 0.00055967, 0.00057686}};
}

/// The middle of a fisheye image of KITTI-360, xi > 1: its corners are 138 degrees apart.
inline Camera kitti_360_camera() {
  constexpr double kXi = 2.2134047507854890;
  return {
      1336.3220825849971 / (1.0 + kXi),
      1335.7883350012958 / (1.0 + kXi),
      500.0,
      500.0,
      1000,
      1000,
      Omni{kXi, 0.016798235660113681, 1.6548773243373522, 0.00042223943394772046, 0.00042462134260997584}};
}

struct NamedCamera {
  std::string name;
  Camera camera;
};

inline std::vector<NamedCamera> all_cameras() {
  return {{"paper", paper_camera()},        {"euroc", euroc_camera()},
          {"tum_vi", tum_vi_camera()},      {"kitti_raw", kitti_raw_camera()},
          {"rational", rational_camera()},  {"kalibr_omni", kalibr_omni_camera()},
          {"kitti_360", kitti_360_camera()}};
}

}  // namespace limber::testing
