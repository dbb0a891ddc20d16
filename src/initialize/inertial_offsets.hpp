// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "limber/initialize/inertial_evidence.hpp"
#include "window_problem.hpp"

namespace limber::detail {

/// Where the offsets of a factor stand among all.
struct OffsetPlace {
  Eigen::Index first = 0, size = 0;
};

/// In the order of InertialFactor; both scales of the accelerometer are in the same place, axis by axis.
inline OffsetPlace place_of(InertialFactor factor) {
  constexpr std::array<OffsetPlace, 7> kPlaces = {{{0, 3}, {3, 3}, {6, 3}, {9, 3}, {12, 1}, {13, 1}, {6, 3}}};
  return kPlaces[static_cast<std::size_t>(factor)];
}

/// @brief The evidence of a window's solution. Bodies move by an offset so that the cameras stay where the
/// pixels want them, which leaves it to the inputs alone: their residuals' derivatives by the offsets, less
/// what the frames' errors can take up of them.
/// @param normal      at the solution
/// @param covariance  of the frames' errors there, see frame_covariance
[[nodiscard]] InertialEvidence evidence_of(const WindowModel& model, WindowState state,
                                           const WindowNormal& normal, const Eigen::MatrixXd& covariance);

}  // namespace limber::detail
