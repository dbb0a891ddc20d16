// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "limber/sensors/calibration.hpp"
#include "random_geometry.hpp"
#include "sensors/cameras.hpp"

/// Stereo rigs of all kinds: body = IMU, left camera, middle of the baseline; every pair of camera models.
namespace limber::testing {

struct NamedRig {
  std::string name;
  StereoCalibration calibration;
};

/// 0.3 m baseline, the right camera turned by up to `turn` [rad], an IMU somewhere on the left camera.
StereoCalibration random_calibration(Generator& generator, BodyFrame body, const Camera& cam0,
                                     const Camera& cam1, double turn);

std::vector<NamedRig> all_rigs(Generator& generator);

}  // namespace limber::testing
