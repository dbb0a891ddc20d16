// SPDX-License-Identifier: MIT
#include "measure/rigs.hpp"

#include <utility>

namespace limber::testing {

StereoCalibration random_calibration(Generator& generator, BodyFrame body, const Camera& cam0,
                                     const Camera& cam1, double turn) {
  StereoCalibration out;
  out.cam0 = cam0;
  out.cam1 = cam1;
  out.body = body;
  out.theta << random_vector(generator, turn), -0.3, random_scalar(generator, -0.02, 0.02),
      random_scalar(generator, -0.02, 0.02);
  out.T_body_cam0 = random_pose(generator, 0.2);
  return out;
}

std::vector<NamedRig> all_rigs(Generator& generator) {
  const std::vector<std::pair<std::string, BodyFrame>> bodies = {
      {"imu", BodyFrame::kImu}, {"cam0", BodyFrame::kCam0}, {"middle", BodyFrame::kMiddleOfBaseline}};
  std::vector<NamedRig> out;
  for (const auto& [body_name, body] : bodies) {
    for (const NamedCamera& left : all_cameras()) {
      for (const NamedCamera& right : all_cameras()) {
        for (const double turn : {0.0, 1e-8, 0.1}) {
          out.push_back({body_name + ", " + left.name + " and " + right.name,
                         random_calibration(generator, body, left.camera, right.camera, turn)});
        }
      }
    }
  }
  return out;
}

}  // namespace limber::testing
