// SPDX-License-Identifier: MIT
#include "parameter_roles.hpp"

#include <stdexcept>
#include <string>

namespace limber::detail {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr std::size_t kTimeOffset0 = 11;  // dt0
static_assert(kParameterNames[kTimeOffset0] == "dt0");

bool constrains_theta(const NavigatorOptions& options) {
  return options.method == Method::kLcekf && options.constraints.has_theta();
}

[[noreturn]] void refuse(const ParameterSet& parameters, const std::string& why) {
  std::string names;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    if (parameters[k]) {
      names += (names.empty() ? "" : ", ") + std::string(kParameterNames[k]);
    }
  }
  throw std::invalid_argument("navigator: " + names + " " + why);
}

/// All that the gain is blind to, at least in part.
ParameterSet constrained_parameters(const NavigatorOptions& options) {
  if (!constrains(options)) {
    return {};
  }
  switch (options.constraints.kind) {
    case ConstraintSet::Kind::kListed:
      return options.constraints.listed;
    case ConstraintSet::Kind::kRotation:
      return options.constraints.more() | ParameterSet(0b111);  // ax, ay, az
    case ConstraintSet::Kind::kFull:
    case ConstraintSet::Kind::kRotationDirection:
      break;
  }
  return options.constraints.more() | theta_parameters();
}

/// Of those beyond theta, what the options say something about.
ParameterSet more_with_a_role(const NavigatorOptions& options) {
  const ParameterSet constrained =
      options.method == Method::kLcekf ? options.constraints.more() : ParameterSet{};
  return (estimated(options) | softened(options) | constrained) & ~theta_parameters();
}

}  // namespace

ParameterSet theta_parameters() { return parameters_of(ParameterBlock::kTheta); }

bool always_has_theta(Method method) {
  return method == Method::kEkfFull || method == Method::kConsider || method == Method::kAdaptive;
}

ParameterSet estimated(const NavigatorOptions& options) { return parameters_of(options.estimated); }
bool estimates_time_offset(const NavigatorOptions& options) { return estimated(options)[kTimeOffset0]; }
ParameterSet softened(const NavigatorOptions& options) { return parameters_of(options.softened); }

bool doubts_lenses(const NavigatorOptions& options) {
  return options.method == Method::kEkf && options.learn_pixel_noise;
}

bool considers_theta(const NavigatorOptions& options) {
  return options.method == Method::kConsider ||
         (doubts_lenses(options) && (estimated(options) & theta_parameters()).none());
}

bool has_theta(const NavigatorOptions& options) {
  return always_has_theta(options.method) || considers_theta(options) ||
         (estimated(options) & theta_parameters()).any();
}

bool estimates_theta(const NavigatorOptions& options) {
  return has_theta(options) && !considers_theta(options);
}

bool constrains(const NavigatorOptions& options) {
  return options.method == Method::kLcekf && !options.constraints.empty();
}

bool softens(const NavigatorOptions& options) {
  return options.method == Method::kSoft || softened(options).any();
}

Eigen::Vector3d mount_sigma(const StereoCalibration& calibration) {
  return plausible_errors(calibration).segment<3>(first_of(ParameterBlock::kMount));
}

bool can_doubt_mount(const NavigatorOptions& options, const StereoCalibration& calibration) {
  return options.motion == MotionModel::kOdometry && calibration.body == BodyFrame::kImu &&
         (more_with_a_role(options) & parameters_of(ParameterBlock::kMount)).none();
}

bool has_more(const NavigatorOptions& options) {
  return options.doubt_odometry_mount || more_with_a_role(options).any();
}

bool doubts_by_estimating(const NavigatorOptions& options) {
  return !options.doubt_odometry_mount && (more_with_a_role(options) & ~estimated(options)).none();
}

bool watches(const NavigatorOptions& options) {
  return options.health.has_value() && options.method != Method::kMonoLeft;
}

bool has_witness(const NavigatorOptions& options) { return watches(options) && constrains_theta(options); }

RigParameters theta_sigma(const NavigatorOptions& options, const StereoCalibration& calibration) {
  return options.theta_sigma.isZero() ? plausible_error(calibration.baseline()) : options.theta_sigma;
}

RigParameters theta_prior(const NavigatorOptions& options, const StereoCalibration& calibration) {
  if (options.method == Method::kAdaptive) {
    return kTrustedSigma * plausible_error(calibration.baseline());
  }
  if (doubts_lenses(options) && considers_theta(options)) {
    return kLensSigma * plausible_error(calibration.baseline());
  }
  return always_has_theta(options.method)
             ? theta_sigma(options, calibration)
             : options.estimated.head<6>().cwiseMax(kNotEstimated * plausible_error(calibration.baseline()));
}

MatrixXd unit_directions(const ParameterSet& set, const ParameterVector& scale) {
  MatrixXd out = MatrixXd::Zero(kParameters, static_cast<Index>(set.count()));
  Index column = 0;
  for (std::size_t k = 0; k < set.size(); ++k) {
    if (set[k]) {
      out(static_cast<Index>(k), column++) = scale(static_cast<Index>(k));
    }
  }
  return out;
}

void check_parameters(const NavigatorOptions& options, const StereoCalibration& calibration) {
  const auto demand_none = [](const ParameterSet& parameters, const std::string& why) {
    if (parameters.any()) {
      refuse(parameters, why);
    }
  };
  for (const ParameterVector& sigma : {options.estimated, options.softened}) {
    if (!sigma.allFinite() || sigma.minCoeff() < 0.0) {
      throw std::invalid_argument("navigator: standard deviations of parameters must be finite and positive");
    }
  }
  const ParameterSet constrained = constrained_parameters(options);
  const ParameterSet all = constrained | estimated(options) | softened(options);
  demand_none(constrained & estimated(options), "cannot be constrained and estimated at once");
  demand_none(constrained & softened(options), "cannot be constrained and softened at once");
  if (always_has_theta(options.method)) {
    demand_none(estimated(options) & theta_parameters(),
                "of " + to_string(options.method) + " is in the state already");
  }
  if (options.method == Method::kSoft || options.method == Method::kAdaptive) {
    demand_none(softened(options) & theta_parameters(),
                "is softened by " + to_string(options.method) + " already");
  }
  if (options.method == Method::kMonoLeft) {
    demand_none(all & (theta_parameters() | parameters_of(ParameterBlock::kCam1)),
                "cannot be seen without the right camera");
  }
  if (calibration.body != BodyFrame::kImu) {
    demand_none(all & parameters_of(ParameterBlock::kMount),
                "cannot be wrong where the body is not an IMU but the camera rig itself");
  }
}

}  // namespace limber::detail
