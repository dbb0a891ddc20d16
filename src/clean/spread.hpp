// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "limber/core/median.hpp"

namespace limber::detail {

/// Half of them are no longer [px].
inline double median_norm(const std::vector<Eigen::Vector2d>& offsets) {
  std::vector<double> lengths;
  for (const Eigen::Vector2d& offset : offsets) {
    lengths.push_back(offset.norm());
  }
  return upper_median(std::move(lengths));
}

/// What the median of all is taken away from, then the median of what is left [px].
inline double spread(std::vector<Eigen::Vector2d> offsets) {
  Eigen::Vector2d middle;
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    std::vector<double> values;
    for (const Eigen::Vector2d& offset : offsets) {
      values.push_back(offset(axis));
    }
    middle(axis) = upper_median(std::move(values));
  }
  for (Eigen::Vector2d& offset : offsets) {
    offset -= middle;
  }
  return median_norm(offsets);
}

}  // namespace limber::detail
