// SPDX-License-Identifier: MIT
#pragma once

#include "sensors/lenses/planar.hpp"

namespace limber::detail {

template <>
struct Lens<NoDistortion> : PlanarLens<NoDistortion> {
  static constexpr std::string_view kName = "none";
  static constexpr std::array<Coefficient<NoDistortion>, 0> kCoefficients{};

  static std::optional<Distorted> distort(const NoDistortion& /*none*/, const Eigen::Vector2d& m) {
    return Distorted{m, Eigen::Matrix2d::Identity()};
  }
};

}  // namespace limber::detail
