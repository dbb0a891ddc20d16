// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string_view>

/// Counter-based randomness: a draw is a pure function of (seed, run, stream, index), so that it does not
/// depend on which other draws are made, in which order, or on which thread.
namespace limber {

/// Philox4x32-10 [Salmon2011]: 128 bit counter and 64 bit key to 128 random bits.
[[nodiscard]] std::array<std::uint32_t, 4> philox4x32(const std::array<std::uint32_t, 4>& counter,
                                                      const std::array<std::uint32_t, 2>& key);

/// FNV-1a, 64 bit: tells texts apart.
[[nodiscard]] std::uint64_t fnv1a(std::string_view text);

/// @brief The draws of one named stream of one run. Streams with different names, runs or seeds are
/// independent. Each draw is addressed by `i`, and by `j` where one index is not enough.
class RandomStream {
 public:
  /// @param name  of the source of randomness: "pixels", "imu", ...
  RandomStream(std::uint64_t seed, std::uint64_t run, std::string_view name);

  /// Uniform in the open interval (0, 1).
  [[nodiscard]] double uniform(std::uint64_t i, std::uint32_t j = 0) const;
  /// Three of them, independent.
  [[nodiscard]] Eigen::Vector3d uniform3(std::uint64_t i, std::uint32_t j = 0) const;

  /// Standard normal (Box-Muller), independent components.
  [[nodiscard]] Eigen::Vector2d normal2(std::uint64_t i, std::uint32_t j = 0) const;
  /// Three of them, independent.
  [[nodiscard]] Eigen::Vector3d normal3(std::uint64_t i, std::uint32_t j = 0) const;

 private:
  [[nodiscard]] Eigen::Vector2d uniform2(std::uint64_t i, std::uint32_t j, std::uint32_t block) const;

  std::array<std::uint32_t, 2> key_;
};

}  // namespace limber
