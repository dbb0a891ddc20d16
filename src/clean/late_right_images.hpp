// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>

#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// Recognises frames whose right picture is that of an earlier frame; see FrameCleaner.
class LateRightImages {
 public:
  /// @return by how many frames the right picture is late; 0: it is not, or that does not show
  [[nodiscard]] std::size_t lag(const StereoFrame& frame);

 private:
  static constexpr std::size_t kLongestLag = 3;

  struct Track {
    std::array<Eigen::Vector2d, kLongestLag + 1> left;  // the last ones, the newest first [px]
    std::size_t seen = 0;                               // how many of them, one frame after the other
    std::optional<Eigen::Vector2d> offset;              // from the left to the right pixel of one instant
    // Of the frame in which doubt began: the offset before it, and that of the frame if the rig has jumped.
    std::optional<Eigen::Vector2d> before, jumped;
  };
  /// How far the right pixels are from where they were to come, half of them [px].
  struct Misses {
    std::array<double, kLongestLag + 1> late;   ///< if the picture is so many frames late
    std::array<double, kLongestLag + 1> apart;  ///< the same, but for what all have in common
    // The same, by the offsets when doubt began: if the picture is late as by then, if the rig jumped then.
    double as_by_then = 0.0, jumped = 0.0;
  };
  enum class Picture { kOfTheFrame, kInDoubt, kLate };

  void follow(const StereoFrame& frame);
  [[nodiscard]] std::optional<Misses> misses(const StereoFrame& frame) const;
  void judge(const Misses& miss, std::int64_t t_ns);
  void judge_of_the_frame(const Misses& miss, std::int64_t t_ns);
  void judge_in_doubt(const Misses& miss, std::int64_t t_ns);
  void judge_late(const Misses& miss);
  [[nodiscard]] double largest_fit() const;
  void is_of_the_frame();
  void learn_offsets(const StereoFrame& frame);

  std::unordered_map<std::int64_t, Track> tracks_;  // of the last frame
  std::optional<std::int64_t> t_ns_;                // of it
  std::int64_t period_ns_ = 0;                      // the shortest between two frames
  Picture picture_ = Picture::kOfTheFrame;
  std::size_t lag_ = 0;
  std::int64_t doubted_ns_ = 0;  // when doubt began
  double usual_ = 0.0;           // miss of a picture that is not late [px]
  std::size_t in_step_ = 0;      // frames that have told it
  bool offsets_show_ = false;    // the frame says which lag it has
};

}  // namespace limber::detail
