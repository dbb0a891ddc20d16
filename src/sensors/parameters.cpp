// SPDX-License-Identifier: MIT
#include "limber/sensors/parameters.hpp"

#include <cmath>
#include <type_traits>
#include <variant>

#include "limber/core/nearest_word.hpp"
#include "limber/core/so3.hpp"

namespace limber {

namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kPlausibleFocal = 0.005;    // of the focal length
constexpr double kPlausiblePrincipal = 2.0;  // [px]
constexpr double kPlausibleRadial = 0.01;    // [-]
constexpr double kPlausibleOffset = 2e-3;    // [s]
constexpr double kPlausibleTurn = 0.5;       // [deg], of the mount
constexpr double kPlausibleShift = 0.02;     // [m], of the mount
constexpr std::size_t kTimeOffset = 5;       // in the block of a camera
constexpr std::size_t kSix = kBlockSize;

struct Group {
  std::string_view name;
  ParameterBlock block;
  bool with_time_offset;
};
constexpr std::array<Group, 4> kGroups = {{{"theta", ParameterBlock::kTheta, true},
                                           {"intrinsics0", ParameterBlock::kCam0, false},
                                           {"intrinsics1", ParameterBlock::kCam1, false},
                                           {"imu", ParameterBlock::kMount, true}}};

Eigen::Matrix<double, kBlockSize, 1> plausible_camera_error(const Camera& camera) {
  Eigen::Matrix<double, kBlockSize, 1> out;
  out << kPlausibleFocal * camera.fu, kPlausibleFocal * camera.fv, kPlausiblePrincipal, kPlausiblePrincipal,
      kPlausibleRadial, kPlausibleOffset;
  return out;
}

Distortion corrected(const Distortion& distortion, double radial) {
  return std::visit(
      [&](const auto& given) -> Distortion {
        if constexpr (std::is_same_v<std::decay_t<decltype(given)>, NoDistortion>) {
          return radial == 0.0 ? Distortion(given) : RadialTangential{radial, 0.0, 0.0, 0.0};
        } else {
          auto out = given;
          out.k1 += radial;
          return out;
        }
      },
      distortion);
}

void correct(Camera& camera, double& time_offset, const Eigen::Ref<const Eigen::VectorXd>& error) {
  camera.fu += error(0);
  camera.fv += error(1);
  camera.cu += error(2);
  camera.cv += error(3);
  camera.distortion = corrected(camera.distortion, error(4));
  time_offset += error(5);
}

}  // namespace

ParameterSet parameters_of(ParameterBlock block) {
  ParameterSet out;
  for (std::size_t k = 0; k < kSix; ++k) {
    out.set(static_cast<std::size_t>(first_of(block)) + k);
  }
  return out;
}

ParameterSet parameters_of(const ParameterVector& values) {
  ParameterSet out;
  for (std::size_t k = 0; k < out.size(); ++k) {
    out.set(k, values(static_cast<Eigen::Index>(k)) != 0.0);
  }
  return out;
}

std::optional<ParameterSet> parameters_named(std::string_view text) {
  const std::string name = in_lower_case(std::string(text));
  for (std::size_t k = 0; k < kParameterNames.size(); ++k) {
    if (name == kParameterNames[k]) {
      return ParameterSet().set(k);
    }
  }
  for (const Group& group : kGroups) {
    if (name == group.name) {
      const std::size_t last = static_cast<std::size_t>(first_of(group.block)) + kTimeOffset;
      return parameters_of(group.block).set(last, group.with_time_offset);
    }
  }
  return std::nullopt;
}

const std::vector<std::string>& parameter_words() {
  static const std::vector<std::string> kAll = [] {
    std::vector<std::string> words(kParameterNames.begin(), kParameterNames.end());
    for (const Group& group : kGroups) {
      words.emplace_back(group.name);
    }
    return words;
  }();
  return kAll;
}

std::string_view unit_of(std::size_t parameter) {
  static constexpr std::array<std::string_view, kSix> kPose = {"rad", "rad", "rad", "m", "m", "m"};
  static constexpr std::array<std::string_view, kSix> kCamera = {"px", "px", "px", "px", "-", "s"};
  const bool camera = parameter / kSix == static_cast<std::size_t>(ParameterBlock::kCam0) ||
                      parameter / kSix == static_cast<std::size_t>(ParameterBlock::kCam1);
  return (camera ? kCamera : kPose)[parameter % kSix];
}

ParameterVector plausible_errors(const StereoCalibration& calibration) {
  ParameterVector out;
  out << plausible_error(calibration.baseline()), plausible_camera_error(calibration.cam0),
      plausible_camera_error(calibration.cam1), Eigen::Vector3d::Constant(kPlausibleTurn * kDegree),
      Eigen::Vector3d::Constant(kPlausibleShift);
  return out;
}

StereoCalibration corrected(const StereoCalibration& calibration, const ParameterVector& error) {
  StereoCalibration out = calibration;
  out.theta += error.head<6>();
  correct(out.cam0, out.time_offset_s[0], error.segment<6>(first_of(ParameterBlock::kCam0)));
  correct(out.cam1, out.time_offset_s[1], error.segment<6>(first_of(ParameterBlock::kCam1)));
  const Eigen::Index mount = first_of(ParameterBlock::kMount);
  out.T_body_cam0.R = so3_exp(error.segment<3>(mount)) * out.T_body_cam0.R;
  out.T_body_cam0.p += error.segment<3>(mount + 3);
  return out;
}

}  // namespace limber
