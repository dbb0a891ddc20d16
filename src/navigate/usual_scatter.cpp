// SPDX-License-Identifier: MIT
#include "limber/navigate/usual_scatter.hpp"

#include <algorithm>

namespace limber {
namespace {

constexpr int kEnoughFrames = 10;
constexpr double kMostGrowth = 2.0;  // of one frame

}  // namespace

void UsualScatter::learn(const std::optional<double>& scatter, double sigma_px) {
  if (!scatter) {
    return;
  }
  frames_ = std::min(frames_ + 1, kEnoughFrames);
  const double square_px = *scatter * sigma_px * sigma_px;
  const double counted = frames_ < kEnoughFrames ? square_px : std::min(square_px, kMostGrowth * square_px_);
  square_px_ += (counted - square_px_) / frames_;
}

std::optional<double> UsualScatter::beside(double sigma_px) const {
  return frames_ < kEnoughFrames ? std::nullopt : std::optional(square_px_ / (sigma_px * sigma_px));
}

}  // namespace limber
