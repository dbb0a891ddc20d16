// SPDX-License-Identifier: MIT
#include "diagnose/rectification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
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

/// What the left camera's motion leaves, pair by pair [px]; nothing where no motion was found. Of two rigs
/// that tell depths to begin with the better one: that of the calibration, and that of its epipolar lines.
std::vector<std::optional<double>> left_over_px(StereoCalibration calibration, const RigParameters& turned,
                                                const std::vector<FramePair>& pairs) {
  const std::array rigs = {calibration.theta, turned};
  std::vector<std::optional<double>> out;
  for (const auto& [from, to] : pairs) {
    std::optional<double>& least = out.emplace_back();
    for (const RigParameters& theta : rigs) {
      calibration.theta = theta;
      const auto motion = left_motion(calibration, *from, *to);
      if (motion && (!least || motion->left_px < *least)) {
        least = motion->left_px;
      }
    }
  }
  return out;
}

/// What two lenses leave, as medians [px].
struct Comparison {
  double given = 0.0, other = std::numeric_limits<double>::infinity();

  [[nodiscard]] bool tells() const { return given >= kLeast_px && kRatio * other < given; }
  [[nodiscard]] std::string in_words(std::string_view as_given, std::string_view as_other) const {
    return fmt::format("are off by {:.2f} px {}, {} by {:.2f} px ({} s apart)", given, as_given, as_other,
                       other, kApart);
  }
};

/// Over the pairs in which both lenses have a motion: where the solution of one fails, as it does from depths
/// of a rig that has moved, that is no fault of the lens. Nothing where there are too few.
std::optional<Comparison> compared(const std::vector<std::optional<double>>& given,
                                   const std::vector<std::optional<double>>& other) {
  std::vector<double> of_given, of_other;
  for (std::size_t k = 0; k < given.size(); ++k) {
    if (given[k] && other[k]) {
      of_given.push_back(*given[k]);
      of_other.push_back(*other[k]);
    }
  }
  if (of_given.size() < kFewestPairs) {
    return std::nullopt;
  }
  return Comparison{upper_median(std::move(of_given)), upper_median(std::move(of_other))};
}

/// A calibration that is tried with other lenses.
struct LensTest {
  const StereoCalibration& calibration;
  const RigParameters& turned;
  std::vector<FramePair> pairs;
  std::vector<std::optional<double>> given;

  [[nodiscard]] std::optional<Comparison> with(const Distortion& distortion) const {
    StereoCalibration other = calibration;
    other.cam0.distortion = other.cam1.distortion = distortion;
    return compared(given, left_over_px(other, turned, pairs));
  }
};

struct RadialLens {
  double k1 = 0.0;
  Comparison comparison{};
};

/// The k1 that leaves least, among those around `middle`.
RadialLens best_lens(const LensTest& test, double middle, double reach, double step) {
  RadialLens best;
  const int steps = static_cast<int>(std::lround(reach / step));
  for (int k = -steps; k <= steps; ++k) {
    const double k1 = middle + k * step;
    const auto comparison = test.with(RadialTangential{k1, 0.0, 0.0, 0.0});
    if (comparison && comparison->other < best.comparison.other) {
      best = {k1, *comparison};
    }
  }
  return best;
}

}  // namespace

std::optional<std::string> rectification_mistake(const StereoCalibration& calibration,
                                                 const RigParameters& turned,
                                                 std::span<const StereoFrame> frames) {
  const std::vector<FramePair> pairs = some_pairs(frames);
  const LensTest test{calibration, turned, pairs, left_over_px(calibration, turned, pairs)};
  if (!std::holds_alternative<NoDistortion>(calibration.cam0.distortion)) {
    const auto without = test.with(NoDistortion{});
    if (!without || !without->tells()) {
      return std::nullopt;
    }
    return "the images look rectified, and the calibration is that of raw ones: the left camera's points " +
           without->in_words("with its distortion", "without");
  }
  const RadialLens coarse = best_lens(test, 0.0, kLargestK1, kStepK1);
  const RadialLens lens = best_lens(test, coarse.k1, kStepK1, kFineK1);
  if (!lens.comparison.tells()) {
    return std::nullopt;
  }
  return "the images look raw, and the calibration is that of rectified ones: the left camera's points " +
         lens.comparison.in_words("without distortion", fmt::format("with k1 = {:.2f}", lens.k1));
}

}  // namespace limber::detail
