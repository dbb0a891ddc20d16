// SPDX-License-Identifier: MIT
#include "rig_fields.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <string>
#include <vector>

#include "hold_alternative.hpp"

namespace limber {
namespace {

using detail::FieldVisitor;
using detail::hold_alternative;
using detail::kAnyNumber;
using detail::kNoUnit;

constexpr double kMaxRotationError = 1e-6;  // of an entry of R^T R - I
constexpr double kMinBaseline = 1e-3;       // [m]

void visit_distortion(FieldVisitor& io, Distortion& distortion) {
  std::vector<std::string> names;
  for (const Distortion& model : distortion_models()) {
    names.emplace_back(model_name(model));
  }
  hold_alternative(distortion, io.choice("distortion_model", distortion.index(), names));
  std::vector<double> k = coefficients(distortion);
  if (k.empty()) {
    return;
  }
  io.require("distortion_coefficients");
  io.numbers("distortion_coefficients", Eigen::Map<Eigen::VectorXd>(k.data(), std::ssize(k)),
             {.min = -100.0, .max = 100.0}, kNoUnit);
  distortion = with_coefficients(distortion, k);
  io.check("distortion_coefficients",
           project({.distortion = distortion}, Eigen::Vector3d::UnitZ()).has_value(),
           "of a lens that sees straight ahead (omni: xi above -1)", "another");
}

void visit_camera(FieldVisitor& io, Camera& camera) {
  Eigen::Vector2d resolution(camera.width, camera.height);
  io.numbers("resolution", resolution, {.min = 1.0, .max = 1e5}, {"px: width, height"});
  io.check("resolution", resolution == resolution.array().floor().matrix(), "as whole numbers",
           fmt::format("{} x {}", resolution.x(), resolution.y()));
  camera.width = static_cast<int>(resolution.x());
  camera.height = static_cast<int>(resolution.y());

  Eigen::Vector4d intrinsics(camera.fu, camera.fv, camera.cu, camera.cv);
  io.numbers("intrinsics", intrinsics, {.min = -1e5, .max = 1e5}, {"px: fu, fv, cu, cv"});
  io.check("intrinsics", intrinsics[0] > 0.0 && intrinsics[1] > 0.0, "with positive focal lengths",
           fmt::format("fu = {}, fv = {}", intrinsics[0], intrinsics[1]));
  camera.fu = intrinsics[0];
  camera.fv = intrinsics[1];
  camera.cu = intrinsics[2];
  camera.cv = intrinsics[3];
  visit_distortion(io, camera.distortion);
}

void visit_transform(FieldVisitor& io, const std::string& key, Pose& pose) {
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> T = Eigen::Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = pose.R;
  T.topRightCorner<3, 1>() = pose.p;
  io.numbers(key, Eigen::Map<Eigen::VectorXd>(T.data(), 16), kAnyNumber, {"4x4, row by row, m"});
  pose.R = T.topLeftCorner<3, 3>();
  pose.p = T.topRightCorner<3, 1>();
  const double error = (pose.R.transpose() * pose.R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  io.check(key, error <= kMaxRotationError && pose.R.determinant() > 0.0, "with a rotation matrix",
           fmt::format("R^T R - I up to {:.2g}, determinant {:.3g}", error, pose.R.determinant()));
  io.check(key, T.row(3) == Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0), "with 0, 0, 0, 1 as last row",
           "another one");
}

}  // namespace

void detail::visit_rig(FieldVisitor& io, RigScenario& rig) {
  const auto body =
      io.choice("body", static_cast<std::size_t>(rig.body), {"imu", "cam0", "middle_of_baseline"});
  rig.body = static_cast<BodyFrame>(body);
  io.rig_parameters("theta", rig.theta, rig.theta.tail<3>().norm(), kAnyNumber);
  io.check("theta", rig.theta[3] < 0.0 && rig.theta.tail<3>().norm() >= kMinBaseline,
           "with cam1 to the right of cam0 (tx below zero) by at least 1 mm",
           fmt::format("tx = {} m", rig.theta[3]));
  visit_transform(io, "T_imu_cam0", rig.T_imu_cam0);
  io.check("T_imu_cam0",
           rig.body == BodyFrame::kImu || (rig.T_imu_cam0.R.isIdentity(0.0) && rig.T_imu_cam0.p.isZero(0.0)),
           "as the identity (or absent) unless body is imu", "another transform");
  io.mapping("cam0", [&](FieldVisitor& child) { visit_camera(child, rig.cam0); });
  if (!io.has("cam1", true)) {
    rig.cam1 = rig.cam0;
  }
  io.mapping("cam1", [&](FieldVisitor& child) { visit_camera(child, rig.cam1); });
}

}  // namespace limber
