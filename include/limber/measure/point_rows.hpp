// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/core/linear_measurement.hpp"
#include "limber/measure/stereo_model.hpp"
#include "limber/state/state.hpp"

namespace limber {

/// @brief A measurement of `rows` rows, all zero.
/// @param parameters  columns of D: those of theta, or all (jacobian_width)
[[nodiscard]] LinearMeasurement empty_measurement(Eigen::Index rows, Eigen::Index parameters = kBlockSize);

/// @brief Writes the two rows of one point in one camera at `row` of a stacked measurement: residual, sigma,
/// the blocks of H, and the parameters' share, which goes to D, and to H as well for those in the state.
/// @param anchor    of the landmark; null if Cartesian
/// @param sigma_px  standard deviations of (u, v) [px]
void write_point_rows(LinearMeasurement& measurement, Eigen::Index row, const Eigen::Vector2d& uv_measured,
                      const Eigen::Vector2d& sigma_px, const PointProjection& projection,
                      const Landmark& landmark, const Anchor* anchor, const StateLayout& layout);

}  // namespace limber
