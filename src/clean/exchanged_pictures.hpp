// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <unordered_map>

#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// Recognises frames whose left and right pictures are exchanged; see FrameCleaner.
class ExchangedPictures {
 public:
  [[nodiscard]] bool is_exchanged(const StereoFrame& frame);

 private:
  struct Seen {
    Eigen::Vector2d left, right;                                                                  // [px]
    Eigen::Vector2d left_speed = Eigen::Vector2d::Zero(), right_speed = Eigen::Vector2d::Zero();  // [px/s]
  };
  void remember(const StereoFrame& frame);

  std::optional<std::int64_t> t_ns_;               // of the last frame that was not
  std::unordered_map<std::int64_t, Seen> before_;  // its points that both cameras see
};

}  // namespace limber::detail
