// SPDX-License-Identifier: MIT
// What an embedded user writes: includes limber, links limber::filter, knows Eigen and nothing else.
#include <cstdlib>
#include <iostream>
#include <limber/core/so3.hpp>
#include <limber/sensors/calibration.hpp>

int main() {
  limber::RigParameters theta;
  theta << 0.0, 0.0, 0.0, -2.0, 0.0, 0.0;
  const limber::Camera camera{300.0, 300.0, 240.0, 320.0, 480, 640, limber::NoDistortion{}};
  const auto right = limber::project(camera, limber::pose_from_rig(theta) * Eigen::Vector3d(0.0, 0.0, 10.0));
  std::cout << right->uv.transpose() << "\n";
  return EXIT_SUCCESS;
}
