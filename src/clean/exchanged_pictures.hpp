// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>

#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// How a frame goes on from the one before.
struct FrameContinuity {
  std::size_t had = 0;     ///< points that both cameras saw before
  std::size_t shared = 0;  ///< those of them that both see now
  // By how much they miss the places where they were to come, left and right together, half of them [px]:
  double off = 0.0;        ///< as they are
  double exchanged = 0.0;  ///< if the pictures are exchanged
  // From where the left camera sees a point to where the right one does, its change from point to point, half
  // of them [px]:
  double same = 0.0;      ///< against the offsets before
  double opposite = 0.0;  ///< against those with the other sign
};

/// Recognises frames whose left and right pictures are exchanged; see FrameCleaner.
class ExchangedPictures {
 public:
  /// @return whether the frame's pictures are exchanged; if not, it is remembered
  [[nodiscard]] bool is_exchanged(const StereoFrame& frame);

  /// nothing where too little is remembered, or from too long ago
  [[nodiscard]] std::optional<FrameContinuity> continuity(const StereoFrame& frame) const;
  /// The frame that the next ones are to go on from.
  void remember(const StereoFrame& frame);

 private:
  struct Seen {
    Eigen::Vector2d left, right;                                                                  // [px]
    Eigen::Vector2d left_speed = Eigen::Vector2d::Zero(), right_speed = Eigen::Vector2d::Zero();  // [px/s]
  };

  std::optional<std::int64_t> t_ns_;               // of the last frame that was not
  std::unordered_map<std::int64_t, Seen> before_;  // its points that both cameras see
};

/// Points that a judgement of their order needs.
inline constexpr std::size_t kFewestToJudgeOrder = 8;

/// Whether a frame goes on better with its pictures exchanged.
[[nodiscard]] bool looks_exchanged(const FrameContinuity& continuity);

}  // namespace limber::detail
