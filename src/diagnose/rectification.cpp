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

#include "diagnose/clustered_regression.hpp"
#include "diagnose/left_turn.hpp"
#include "limber/core/median.hpp"
#include "limber/core/time.hpp"
#include "limber/measure/epipolar.hpp"
#include "limber/measure/triangulate.hpp"
#include "measure/two_views.hpp"

namespace limber::detail {
namespace {

constexpr std::size_t kFewestPairs = 10, kMostPairs = 60;
constexpr double kLeast_px = 0.5, kRatio = 1.5;  // of what is left, and of what the other lens leaves
constexpr double kApart = 0.6;                   // [s]
constexpr double kRawApart = 0.2;                // [s]: a tracker that judges by a wrong lens loses points
constexpr std::size_t kMostRawPairs = 150;
constexpr double kLeastBarrel = 0.1, kSurely = 6.0;  // a distortion, and its sigmas, that are named ...
constexpr double kMostLeft = 0.98;                   // ... where no more than this is left of the squares
constexpr double kUsualBarrel = -0.3;
/// Of a distortion that the calibration has, and the images have not.
constexpr double kHardlyAny = 1.0 / 3.0;  // share of it that may be found
constexpr double kChance = 1e-3;          // by Student's law, for as many sigmas between the two
constexpr double kRightLens = 2.0 / 3.0;  // share of it from where on nothing else need be looked for
constexpr double kSame = 3.0;             // sigmas between two solutions that are one
constexpr double kLeastRadius = 0.1;      // [-] nearer to the centre nothing shows
constexpr double kLongestStep = 0.15, kShortestStep = 0.01;
constexpr int kSteps = 6;

/// Two frames of a turn.
using FramePair = std::pair<const StereoFrame*, const StereoFrame*>;

/// Evenly over the recording.
std::vector<FramePair> some_pairs(std::span<const StereoFrame> frames, double apart, std::size_t most) {
  std::vector<FramePair> out;
  for (std::size_t n = 0; n < frames.size(); n += frames.size() / most + 1) {
    if (const auto end = frame_after(frames, n, apart)) {
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
    return fmt::format(
        "are off by {} {}, {} by {:.2f} px ({} s apart)",
        std::isfinite(given) ? fmt::format("{:.2f} px", given) : "more than any motion explains", as_given,
        as_other, other, kApart);
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

/// A lens that puts at r what a pinhole would put at r / (1 + lambda r^2): below zero a barrel. One number
/// fits lenses of cameras as they are, wide ones, too.
struct RadialLens {
  double lambda = 0.0, sigma = 0.0;
  double dof = 0.0;      ///< of sigma, in the sense of Student's law
  double squares = 0.0;  ///< that motions leave, of a pair in the mean

  [[nodiscard]] bool is_surely_not(double other) const {
    const double sigmas = std::abs(lambda - other) / sigma;
    return sigmas > kSurely && is_rarer_than(kChance, sigmas, dof);
  }
};

MovingPoints through_lens(const StereoCalibration& calibration, const Pose& T_cam1_cam0, double lambda,
                          const StereoFrame& frame) {
  const auto stretch = [&](const Eigen::Vector2d& x) { return 1.0 / (1.0 + lambda * x.squaredNorm()); };
  const auto undistorted = [&](const Eigen::Vector3d& bearing) -> Eigen::Vector3d {
    return (stretch(bearing.head<2>()) * bearing.head<2>()).homogeneous();
  };
  MovingPoints out;
  for (const StereoObservation& o : frame.observations) {
    const auto bearing = o.in_cam0 ? unproject(calibration.cam0, o.uv_cam0) : std::nullopt;
    if (!bearing || !(bearing->z() > 0.0)) {
      continue;
    }
    const Eigen::Vector2d x = bearing->hnormalized();
    const double times = stretch(x);
    MovingPoint& point = out[o.track_id];
    point.place = times * x;
    point.slope = -times * times * x.squaredNorm() * x;
    if (const auto pair = bearings(calibration, o)) {
      point.inverse_depth =
          inverse_depth_along(undistorted(pair->cam0), undistorted(pair->cam1).normalized(), T_cam1_cam0);
    }
  }
  return out;
}

/// What pairs of frames say of a change of lambda.
struct LensRows {
  ClusteredRows rows;
  double squares = 0.0;  ///< a pair, in the mean
};

LensRows lens_rows(const StereoCalibration& calibration, double lambda, const std::vector<FramePair>& pairs) {
  const Pose T_cam1_cam0 = pose_from_rig(calibration.theta);
  LensRows out;
  for (const auto& [from, to] : pairs) {
    const auto fit = parameter_between(through_lens(calibration, T_cam1_cam0, lambda, *from),
                                       through_lens(calibration, T_cam1_cam0, lambda, *to),
                                       calibration.cam0.fu, calibration.baseline());
    if (fit && fit->information > 0.0) {
      const double root = std::sqrt(fit->information);
      out.rows.A.push_back(Eigen::VectorXd::Constant(1, root));
      out.rows.y.push_back(fit->gradient / root);
      out.rows.cluster.push_back(
          static_cast<std::int64_t>(seconds_between(pairs[0].first->t_ns, from->t_ns)));
      out.squares += fit->squares;
    }
  }
  out.squares /= std::max(1.0, static_cast<double>(out.rows.y.size()));
  out.rows.Z = out.rows.A;
  return out;
}

/// By Gauss-Newton steps; sigma is the jackknife's over seconds. Nothing where it is not found.
std::optional<RadialLens> lens_from(double begin, const StereoCalibration& calibration,
                                    const std::vector<FramePair>& pairs) {
  RadialLens out{.lambda = begin};
  for (int i = 0; i < kSteps; ++i) {
    const LensRows at = lens_rows(calibration, out.lambda, pairs);
    const auto step = at.rows.y.size() < kFewestPairs ? std::nullopt : solve(at.rows);
    if (!step) {
      return std::nullopt;
    }
    out.sigma = step->sigma_of_last();
    out.dof = step->dof_of_last();
    out.squares = at.squares;
    if (std::abs(step->x(0)) < kShortestStep) {
      return out;
    }
    out.lambda += std::clamp(step->x(0), -kLongestStep, kLongestStep);
  }
  return std::nullopt;
}

/// The better one of what is found from no distortion on, and from one as it is usual.
std::optional<RadialLens> radial_lens(const StereoCalibration& calibration,
                                      const std::vector<FramePair>& pairs) {
  const auto from_none = lens_from(0.0, calibration, pairs);
  const auto from_barrel = lens_from(kUsualBarrel, calibration, pairs);
  return !from_none || (from_barrel && from_barrel->squares < from_none->squares) ? from_barrel : from_none;
}

std::optional<std::string> raw_mistake(const StereoCalibration& calibration,
                                       std::span<const StereoFrame> frames) {
  const std::vector<FramePair> pairs = some_pairs(frames, kRawApart, kMostRawPairs);
  const auto lens = radial_lens(calibration, pairs);
  if (!lens || -lens->lambda < std::max(kLeastBarrel, kSurely * lens->sigma)) {
    return std::nullopt;
  }
  const double left = lens->squares / lens_rows(calibration, 0.0, pairs).squares;
  if (!(left < kMostLeft)) {
    return std::nullopt;
  }
  return fmt::format(
      "the images look raw, and the calibration is that of rectified ones: a barrel distortion, "
      "r / (1 + k r^2) with k = {:.2f} ± {:.2f}, leaves {:.0f} % of what no motion of the left camera "
      "explains without",
      lens->lambda, lens->sigma, 100.0 * left);
}

/// The radial lens that the left camera's distortion is about, by the places of the points seen.
double lambda_of(const Camera& camera, std::span<const StereoFrame> frames) {
  Camera plain = camera;
  plain.distortion = NoDistortion{};
  std::vector<double> out;
  for (std::size_t n = 0; n < frames.size(); n += frames.size() / kMostPairs + 1) {
    for (const StereoObservation& o : frames[n].observations) {
      const auto truly = o.in_cam0 ? unproject(camera, o.uv_cam0) : std::nullopt;
      const auto seen = o.in_cam0 ? unproject(plain, o.uv_cam0) : std::nullopt;
      if (truly && seen && truly->z() > 0.0) {
        const double r = seen->hnormalized().norm(), r_true = truly->hnormalized().norm();
        if (r > kLeastRadius) {
          out.push_back((r / r_true - 1.0) / (r * r));
        }
      }
    }
  }
  return out.empty() ? 0.0 : upper_median(std::move(out));
}

/// Where the camera hardly turns no pair tells, but all of them together may.
std::optional<std::string> rectified_mistake(const StereoCalibration& calibration,
                                             const StereoCalibration& plain,
                                             std::span<const StereoFrame> frames) {
  const double given = lambda_of(calibration.cam0, frames);
  if (std::abs(given) < kLeastBarrel) {
    return std::nullopt;
  }
  const std::vector<FramePair> pairs = some_pairs(frames, kRawApart, kMostRawPairs);
  const auto beside = lens_from(given, plain, pairs);  // of few pairs there may be two solutions
  // Then the other would be within 3 sigmas of it and 6 from what is given only if it were more than a third.
  if (beside && beside->lambda / given > kRightLens) {
    return std::nullopt;
  }
  const auto lens = radial_lens(plain, pairs);
  if (!lens || (beside && std::abs(beside->lambda - lens->lambda) > kSame * lens->sigma) ||
      lens->lambda / given > kHardlyAny || !lens->is_surely_not(given)) {
    return std::nullopt;
  }
  const double left = lens->squares / lens_rows(plain, given, pairs).squares;
  if (!(left < kMostLeft)) {
    return std::nullopt;
  }
  return fmt::format(
      "the images look rectified, and the calibration is that of raw ones: its distortion is about "
      "r / (1 + k r^2) with k = {:.2f}, and the left camera's motions say k = {:.2f} ± {:.2f}",
      given, lens->lambda, lens->sigma);
}

}  // namespace

std::optional<std::string> rectification_mistake(const StereoCalibration& calibration,
                                                 const RigParameters& turned,
                                                 std::span<const StereoFrame> frames) {
  if (std::holds_alternative<NoDistortion>(calibration.cam0.distortion)) {
    return raw_mistake(calibration, frames);
  }
  const std::vector<FramePair> pairs = some_pairs(frames, kApart, kMostPairs);
  StereoCalibration plain = calibration;
  plain.cam0.distortion = plain.cam1.distortion = NoDistortion{};
  const auto without = compared(left_over_px(calibration, turned, pairs), left_over_px(plain, turned, pairs));
  if (!without || !without->tells()) {
    return rectified_mistake(calibration, plain, frames);
  }
  return "the images look rectified, and the calibration is that of raw ones: the left camera's points " +
         without->in_words("with its distortion", "without");
}

}  // namespace limber::detail
