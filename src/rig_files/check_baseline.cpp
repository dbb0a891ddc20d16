// SPDX-License-Identifier: MIT
#include "rig_files/check_baseline.hpp"

#include <fmt/format.h>

#include <cmath>

#include "limber/core/errors.hpp"

namespace limber::detail {
namespace {

constexpr double kSmallestBaseline = 1e-6, kLargestBaseline = 1e3;  // [m]

}  // namespace

std::string check_baseline(const RigParameters& theta, const std::filesystem::path& place, std::size_t line,
                           const std::string& hint) {
  const Eigen::Vector3d t = theta.tail<3>();
  if (t.norm() <= kSmallestBaseline) {
    throw DataError(place.string(), line, "two cameras that stand apart",
                    fmt::format("a baseline of zero ({:.3g} m)", t.norm()));
  }
  if (!(t.norm() < kLargestBaseline)) {
    throw DataError(place.string(), line, fmt::format("cameras less than {} m apart", kLargestBaseline),
                    fmt::format("a baseline of {:.3g} m", t.norm()));
  }
  Eigen::Index main_axis = 0;
  t.cwiseAbs().maxCoeff(&main_axis);
  if (main_axis != 0) {
    return fmt::format(
        "the baseline is mainly along the {} axis of the cameras (T_cam1_cam0 = {:.3f}, {:.3f}, {:.3f} m): "
        "if the "
        "cameras stand side by side, {}",
        main_axis == 1 ? "y" : "z", t.x(), t.y(), t.z(), hint);
  }
  if (t.x() > 0.0) {
    throw DataError(place.string(), line, "cam1 to the right of cam0 (x of T_cam1_cam0 below zero)",
                    fmt::format("{:.3f} m, cam1 to the left: {}", t.x(), hint));
  }
  return {};
}

}  // namespace limber::detail
