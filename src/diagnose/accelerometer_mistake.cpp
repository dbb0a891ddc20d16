// SPDX-License-Identifier: MIT
#include "diagnose/accelerometer_mistake.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "diagnose/accelerations.hpp"
#include "diagnose/clustered_regression.hpp"

namespace limber::detail {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;

constexpr std::size_t kEnoughInstants = 20;
constexpr double kTogether = 2.0;       // what shares its error [s]
constexpr double kFarOff = 0.3;         // of 1, which a sound axis has
constexpr double kDoubtless = 5.0;      // standard deviations ...
constexpr double kHardlyChance = 1e-4;  // ... that chance exceeds as rarely, by Student's law

/// M in a_camera = M f, by least squares, and what is known of it.
class Mount {
 public:
  explicit Mount(ClusteredSolution columns) : columns_(std::move(columns)) {}

  [[nodiscard]] Matrix3d M() const { return columns_.x.reshaped(3, 3); }
  [[nodiscard]] double sigma(Index row, Index column) const { return columns_.sigma(row + 3 * column); }
  /// Whether an entry is, in size, surely more than `less`, which is the row's own where it is not zero.
  [[nodiscard]] bool surely_beyond(double less, Index row, Index column) const {
    const double more = std::abs(M()(row, column)) - less;
    const double sigmas = more / std::hypot(sigma(row, column), less > 0.0 ? sigma(row, row) : 0.0);
    return more > kFarOff && sigmas > kDoubtless &&
           is_rarer_than(kHardlyChance, sigmas, columns_.dof(row + 3 * column));
  }

 private:
  ClusteredSolution columns_;  // one below the other
};

std::optional<Mount> mount_of(const std::vector<Acceleration>& all) {
  ClusteredRows rows;
  for (const Acceleration& one : all) {
    for (Index axis = 0; axis < 3; ++axis) {
      rows.A.emplace_back(one.by_mount.row(axis).transpose());
      rows.y.push_back(one.camera(axis));
      rows.cluster.push_back(static_cast<std::int64_t>(one.t_s / kTogether));
    }
  }
  rows.Z = rows.A;
  auto columns = solve(rows);
  return columns ? std::optional(Mount(*std::move(columns))) : std::nullopt;
}

/// An axis of the IMU, and which one of the samples' counts as it.
struct Axis {
  Index row = 0, column = 0;
  double sign = 1.0;

  [[nodiscard]] bool is_itself() const { return row == column && sign > 0.0; }
  [[nodiscard]] bool is_reversed() const { return row == column && sign < 0.0; }
  [[nodiscard]] std::string words() const {
    return is_reversed()
               ? fmt::format("{} has the wrong sign", "xyz"[row])
               : fmt::format("{} is given as {}{}", "xyz"[row], sign < 0.0 ? "-" : "", "xyz"[column]);
  }
};

/// What counts as an axis, surely more than itself; or surely itself. Nothing where neither is sure.
std::optional<Axis> axis_of(const Mount& mount, Index row) {
  const Matrix3d M = mount.M();
  Index column = 0;
  M.row(row).cwiseAbs().maxCoeff(&column);
  const double itself = column == row ? 0.0 : std::max(0.0, M(row, row));
  if (!mount.surely_beyond(itself, row, column)) {
    return std::nullopt;
  }
  return Axis{row, column, M(row, column) < 0.0 ? -1.0 : 1.0};
}

std::string in_words(const std::vector<Axis>& told, const Mount& mount) {
  std::string which, sizes;
  for (const Axis& axis : told) {
    if (!axis.is_itself()) {
      const std::string comma = which.empty() ? "" : ", ";
      which += comma + axis.words();
      sizes += fmt::format("{}{:.2f} ± {:.2f}", comma, std::abs(mount.M()(axis.row, axis.column)),
                           mount.sigma(axis.row, axis.column));
    }
  }
  const std::string mistake =
      std::ranges::all_of(told, &Axis::is_reversed)
          ? "the accelerometer has the wrong sign: at rest it has to point up, against gravity"
          : "the accelerometer's axes are not those of the gyro and of T_BS: " + which;
  return mistake +
         fmt::format(" (of how the body accelerated by the cameras it shows {} that way, 1 expected)", sizes);
}

}  // namespace

std::optional<std::string> accelerometer_mistake(const StereoCalibration& calibration,
                                                 std::span<const StereoFrame> frames,
                                                 std::span<const ImuSample> imu) {
  const std::vector<Acceleration> all = accelerations(calibration, frames, imu);
  const auto mount = all.size() < kEnoughInstants ? std::nullopt : mount_of(all);
  if (!mount) {
    return std::nullopt;
  }
  std::vector<Axis> told;
  bool wrong = false;
  for (Index row = 0; row < 3; ++row) {
    if (const auto axis = axis_of(*mount, row)) {
      told.push_back(*axis);
      wrong = wrong || !axis->is_itself();
    }
  }
  return wrong ? std::optional(in_words(told, *mount)) : std::nullopt;
}

}  // namespace limber::detail
