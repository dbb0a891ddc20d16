// SPDX-License-Identifier: MIT
#include "diagnose/rectification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "diagnose/left_turn.hpp"
#include "limber/core/median.hpp"

namespace limber::detail {
namespace {

constexpr std::size_t kFewestPairs = 10, kMostPairs = 60;
constexpr double kLeast_px = 0.5, kRatio = 1.5;  // of what is left, and of what the other lens leaves
constexpr double kApart = 0.6;                   // [s]
constexpr double kLargestK1 = 0.6, kStepK1 = 0.1, kFineK1 = 0.02;

/// Two frames of a turn.
using FramePair = std::pair<const StereoFrame*, const StereoFrame*>;

/// Evenly over the recording, at most kMostPairs.
std::vector<FramePair> some_pairs(std::span<const StereoFrame> frames) {
  std::vector<FramePair> out;
  for (std::size_t n = 0; n < frames.size(); n += frames.size() / kMostPairs + 1) {
    if (const auto end = frame_after(frames, n, kApart)) {
      out.emplace_back(&frames[n], &frames[*end]);
    }
  }
  return out;
}

/// Median over the pairs of what the left camera's motion leaves [px]; infinity where too few have a motion.
double left_over_px(const StereoCalibration& calibration, const std::vector<FramePair>& pairs) {
  std::vector<double> left;
  for (const auto& [from, to] : pairs) {
    if (const auto motion = left_motion(calibration, *from, *to)) {
      left.push_back(motion->left_px);
    }
  }
  return left.size() < kFewestPairs ? std::numeric_limits<double>::infinity() : upper_median(std::move(left));
}

StereoCalibration with_lens(StereoCalibration calibration, const Distortion& distortion) {
  calibration.cam0.distortion = calibration.cam1.distortion = distortion;
  return calibration;
}

struct RadialLens {
  double k1 = 0.0, left_px = std::numeric_limits<double>::infinity();
};

/// The k1 that leaves least, among those around `middle`.
RadialLens best_lens(const StereoCalibration& calibration, const std::vector<FramePair>& pairs, double middle,
                     double reach, double step) {
  RadialLens best;
  const int steps = static_cast<int>(std::lround(reach / step));
  for (int k = -steps; k <= steps; ++k) {
    const double k1 = middle + k * step;
    const double left = left_over_px(with_lens(calibration, RadialTangential{k1, 0.0, 0.0, 0.0}), pairs);
    if (left < best.left_px) {
      best = {k1, left};
    }
  }
  return best;
}

std::string compared(double given, std::string_view as_given, double other, std::string_view as_other) {
  const std::string wrong = std::isfinite(given) ? fmt::format("are off by {:.2f} px {}", given, as_given)
                                                 : fmt::format("fit no motion {}", as_given);
  return fmt::format("{}, {} by {:.2f} px ({} s apart)", wrong, as_other, other, kApart);
}

}  // namespace

std::optional<std::string> rectification_mistake(const StereoCalibration& calibration,
                                                 std::span<const StereoFrame> frames) {
  const std::vector<FramePair> pairs = some_pairs(frames);
  const double given = left_over_px(calibration, pairs);
  if (given < kLeast_px) {
    return std::nullopt;
  }
  if (!std::holds_alternative<NoDistortion>(calibration.cam0.distortion)) {
    const double without = left_over_px(with_lens(calibration, NoDistortion{}), pairs);
    if (!(kRatio * without < given)) {
      return std::nullopt;
    }
    return "the images look rectified, and the calibration is that of raw ones: the left camera's points " +
           compared(given, "with its distortion", without, "without");
  }
  const RadialLens coarse = best_lens(calibration, pairs, 0.0, kLargestK1, kStepK1);
  const RadialLens lens = best_lens(calibration, pairs, coarse.k1, kStepK1, kFineK1);
  if (!(kRatio * lens.left_px < given)) {
    return std::nullopt;
  }
  return "the images look raw, and the calibration is that of rectified ones: the left camera's points " +
         compared(given, "without distortion", lens.left_px, fmt::format("with k1 = {:.2f}", lens.k1));
}

}  // namespace limber::detail
