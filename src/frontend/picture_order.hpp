// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "clean/exchanged_pictures.hpp"
#include "limber/sensors/samples.hpp"

namespace limber::frontend {

/// @brief Knows which of a pair's pictures is the left one: the one that goes on from the left one before.
/// Of the first pairs that is not known. Pictures that stay exchanged for a second are taken as they are.
class PictureOrder {
 public:
  /// Whether the pair should be tried with its pictures put back.
  [[nodiscard]] bool doubts(const StereoFrame& as_given) const;
  /// Whether it goes on clearly better with its pictures put back.
  [[nodiscard]] bool prefers(const StereoFrame& put_back, const StereoFrame& as_given) const;
  /// The next pairs go on from this one.
  void remember(const StereoFrame& taken);

 private:
  detail::ExchangedPictures pictures_;
  int pairs_ = 0;  ///< remembered, as far as that matters
  std::optional<std::int64_t> put_back_since_;
};

}  // namespace limber::frontend
