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

struct NamedCamera {
  std::string name;
  Camera camera;
};

inline std::vector<NamedCamera> all_cameras() {
  return {{"paper", paper_camera()}, {"euroc", euroc_camera()}, {"tum_vi", tum_vi_camera()}};
}

}  // namespace limber::testing
