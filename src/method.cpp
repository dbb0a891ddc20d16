// SPDX-License-Identifier: MIT
#include "limber/method.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace limber {

using Eigen::MatrixXd;
using Eigen::Vector3d;

namespace {

constexpr double kPlausibleAngle = 0.1 * M_PI / 180.0;  // [rad]
constexpr double kPlausibleShare = 0.05;                // of the baseline
constexpr std::array<const char*, 6> kParameterNames = {"ax", "ay", "az", "tx", "ty", "tz"};

[[noreturn]] void unknown_set(const std::string& text) {
  throw std::invalid_argument(
      "unknown constraint set '" + text +
      "', expected full, none, rotation, rotation+direction or a list of ax,ay,az,tx,ty,tz");
}

ConstraintSet listed_set(const std::string& text) {
  if (text.empty() || text.back() == ',') {
    unknown_set(text);
  }
  ConstraintSet set{ConstraintSet::Kind::kListed, {}};
  std::istringstream stream(text);
  std::string name;
  while (std::getline(stream, name, ',')) {
    bool known = false;
    for (std::size_t k = 0; k < kParameterNames.size(); ++k) {
      if (name == kParameterNames[k]) {
        set.listed[k] = known = true;
      }
    }
    if (!known) {
      unknown_set(text);
    }
  }
  return set;
}

}  // namespace

std::string to_string(Method method) {
  switch (method) {
    case Method::kEkf:
      return "ekf";
    case Method::kEkfFull:
      return "ekf-full";
    case Method::kLcekf:
      return "lcekf";
    case Method::kSoft:
      return "soft";
    case Method::kConsider:
      return "consider";
    case Method::kAdaptive:
      return "adaptive";
    case Method::kMonoLeft:
      return "mono-left";
    case Method::kOracle:
      break;
  }
  return "oracle";
}

Method method_from_string(const std::string& name) {
  std::string known;
  for (const Method method : kAllMethods) {
    if (to_string(method) == name) {
      return method;
    }
    known += (known.empty() ? "" : ", ") + to_string(method);
  }
  throw std::invalid_argument("unknown method '" + name + "', expected one of " + known);
}

ConstraintSet constraint_set_from_string(const std::string& text) {
  using Kind = ConstraintSet::Kind;
  if (text == "full") {
    return {Kind::kFull, {}};
  }
  if (text == "none") {
    return {Kind::kListed, {}};
  }
  if (text == "rotation") {
    return {Kind::kRotation, {}};
  }
  if (text == "rotation+direction") {
    return {Kind::kRotationDirection, {}};
  }
  return listed_set(text);
}

std::string to_string(const ConstraintSet& set) {
  switch (set.kind) {
    case ConstraintSet::Kind::kFull:
      return "full";
    case ConstraintSet::Kind::kRotation:
      return "rotation";
    case ConstraintSet::Kind::kRotationDirection:
      return "rotation+direction";
    case ConstraintSet::Kind::kListed:
      break;
  }
  std::string names;
  for (std::size_t k = 0; k < kParameterNames.size(); ++k) {
    if (set.listed[k]) {
      names += (names.empty() ? "" : ",") + std::string(kParameterNames[k]);
    }
  }
  return names.empty() ? "none" : names;
}

RigParameters plausible_error(double baseline) {
  RigParameters out;
  out << Vector3d::Constant(kPlausibleAngle), Vector3d::Constant(kPlausibleShare * baseline);
  return out;
}

Eigen::Matrix<double, 6, 6> without_length(const Eigen::Matrix<double, 6, 6>& covariance,
                                           const RigParameters& theta) {
  const Vector3d along = theta.tail<3>().normalized();
  Eigen::Matrix<double, 6, 6> across = Eigen::Matrix<double, 6, 6>::Identity();
  across.bottomRightCorner<3, 3>() -= along * along.transpose();
  return across * covariance * across.transpose();
}

MatrixXd constraint_directions(const ConstraintSet& set, const RigParameters& theta) {
  const RigParameters scale = plausible_error(theta.tail<3>().norm());
  switch (set.kind) {
    case ConstraintSet::Kind::kFull:
      return scale.asDiagonal();
    case ConstraintSet::Kind::kRotation:
      return MatrixXd(scale.asDiagonal()).leftCols<3>();
    case ConstraintSet::Kind::kRotationDirection: {
      const Vector3d along = theta.tail<3>().normalized();
      MatrixXd C = MatrixXd::Zero(6, 5);
      C.topLeftCorner<3, 3>() = scale.head<3>().asDiagonal();
      C.block<3, 1>(3, 3) = scale(3) * along.unitOrthogonal();
      C.block<3, 1>(3, 4) = scale(3) * along.cross(along.unitOrthogonal());
      return C;
    }
    case ConstraintSet::Kind::kListed:
      break;
  }
  MatrixXd C(6, 0);
  for (Eigen::Index k = 0; k < 6; ++k) {
    if (set.listed[static_cast<std::size_t>(k)]) {
      C.conservativeResize(6, C.cols() + 1);
      C.col(C.cols() - 1) = scale(k) * RigParameters::Unit(k);
    }
  }
  return C;
}

}  // namespace limber
