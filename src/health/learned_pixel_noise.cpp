// SPDX-License-Identifier: MIT
#include "limber/health/learned_pixel_noise.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "limber/core/angle.hpp"
#include "limber/core/factors.hpp"
#include "limber/core/median.hpp"
#include "limber/core/so3.hpp"
#include "limber/health/bounded_influence.hpp"
#include "limber/measure/epipolar.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kLeast_px = 0.05, kMost_px = 5.0;
/// What lasts is as alike from frame to frame as docs/evidence/realistic-pixels.md has it, and weighs as long
/// as a point is seen, ten frames at least: its place in the image errs for the next one, too.
constexpr double kLasting = 0.93;
constexpr double kFewestFrames = 10.0;
/// Before frames have told: two thirds of the variance last.
constexpr double kPriorCorrelation = 2.0 / 3.0 * kLasting;
constexpr double kPriorPairs = 100.0, kEnoughPairs = 300.0;
/// Share of a frame in what is learned; the first ones count like any, beside what it began with as some.
constexpr double kLearningShare = 0.05, kBegin = 5.0;
/// Of the assumed variance: what a filter that assumes much leaves of its own errors in its innovations.
constexpr double kOwnShare = 0.02;
constexpr double kLargestStep = 4.0;
constexpr double kFewestRows = 20.0;
constexpr double kShared = 0.5;   // of the variance of what lasts: common to all points
constexpr double kCameras = 2.0;  // err, in a disparity
constexpr double kSteady = 0.2;   // of a parallax, from frame to frame
constexpr Index kTerms = 6;       // of a quadratic in two variables
constexpr std::size_t kFewestForAFit = 4 * kTerms;
constexpr double kFarOff = 3.0;         // of the errors' size: mismatched
constexpr int kFits = 3;                // each: 10 degrees of the rig are settled after them
constexpr Index kBends = 5;             // a rotation, and the direction of the baseline
constexpr double kRounding = 1e-3;      // [px]
constexpr double kPlausibleBend = 0.1;  // [rad], where the points do not tell

/// Of right matches. Of a third that is anywhere the median alone is half as much again.
double size_of(const VectorXd& errors) {
  const VectorXd magnitude = errors.cwiseAbs();
  std::vector<double> sizes(magnitude.begin(), magnitude.end());
  const double far_off = kFarOff * sigma_of_magnitudes(sizes);
  std::erase_if(sizes, [=](double size) { return size > far_off; });
  return sigma_of_magnitudes(std::move(sizes));
}

VectorXd errors_of(const std::vector<StereoBearings>& points, const Pose& rig) {
  VectorXd out(static_cast<Index>(points.size()));
  for (Index k = 0; k < out.size(); ++k) {
    out(k) = detail::epipolar_error(points[static_cast<std::size_t>(k)], rig);
  }
  return out;
}

/// A rig turned by three angles [rad], its baseline by two, about axes that are across it.
class Bend {
 public:
  explicit Bend(const Pose& rig) : rig_(rig) {
    axes_.col(0) = rig.p.unitOrthogonal();
    axes_.col(1) = rig.p.normalized().cross(axes_.col(0));
    by_angles_.topLeftCorner<3, 3>().setIdentity();
    by_angles_.bottomRightCorner<3, 2>() = -skew(rig.p) * axes_;
  }
  [[nodiscard]] Pose rig(const Eigen::Matrix<double, kBends, 1>& angles) const {
    return {so3_exp(angles.head<3>()) * rig_.R, so3_exp(axes_ * angles.tail<2>()) * rig_.p};
  }
  /// Of the epipolar error, by the angles.
  [[nodiscard]] Eigen::Matrix<double, 1, kBends> slope(const StereoBearings& pair) const {
    return detail::epipolar_slope(pair, rig_) * by_angles_;
  }

 private:
  Pose rig_;
  Eigen::Matrix<double, 3, 2> axes_;
  Eigen::Matrix<double, 6, kBends> by_angles_ =
      Eigen::Matrix<double, 6, kBends>::Zero();  // turn, translation
};

/// Of a step of a fit: first an error that is far off counts as one that is just so far (Huber), at last not
/// at all.
VectorXd weights_of(const VectorXd& errors, int fit, double least) {
  const double far_off = std::max(kFarOff * size_of(errors), least);
  return errors.unaryExpr([=](double error) {
    const double size = std::abs(error);
    return size <= far_off ? 1.0 : fit < kFits ? far_off / size : 0.0;
  });
}

/// The rig whose epipolar lines the points are nearest to. What depends on depth in the errors of a rig that
/// is off by degrees would be taken for errors that last as long as the tracks.
Pose nearest_rig(const std::vector<StereoBearings>& points, Pose rig, double pixel) {
  for (int fit = 0; fit < 2 * kFits; ++fit) {
    const Bend bend(rig);
    const VectorXd errors = errors_of(points, rig);
    MatrixXd J(errors.size(), kBends);
    for (Index k = 0; k < errors.size(); ++k) {
      J.row(k) = bend.slope(points[static_cast<std::size_t>(k)]);
    }
    const VectorXd weights = weights_of(errors, fit, kRounding * pixel);
    const MatrixXd WJ = weights.cwiseProduct(detail::lever_weights(J)).asDiagonal() * J;
    MatrixXd A = WJ.transpose() * J;
    A.diagonal().array() += (pixel / kPlausibleBend) * (pixel / kPlausibleBend);
    rig = bend.rig(solve_symmetric(A, VectorXd(-WJ.transpose() * errors)));
  }
  return rig;
}

/// What a quadratic over the image leaves. It is that of right matches: one that mismatches bend is another
/// one in each frame, and what lasts would not be seen.
VectorXd without_quadratic(const std::vector<StereoBearings>& points, const VectorXd& errors, double pixel) {
  MatrixXd A(errors.size(), kTerms);
  for (Index k = 0; k < errors.size(); ++k) {
    const Eigen::Vector3d& d = points[static_cast<std::size_t>(k)].cam1;
    A.row(k) << 1.0, d.x(), d.y(), d.x() * d.x(), d.x() * d.y(), d.y() * d.y();
  }
  VectorXd rest = errors;
  for (int fit = 0; fit < 2 * kFits; ++fit) {
    const MatrixXd WA = weights_of(rest, fit, kRounding * pixel).asDiagonal() * A;
    rest = errors - A * solve_symmetric(WA.transpose() * A, WA.transpose() * errors);
  }
  return rest;
}

}  // namespace

/// Each point's distance from its epipolar line, of the rig that explains the frame best and without what a
/// quadratic over the image explains, in units of the frame's own size; without mismatches.
std::map<std::int64_t, LearnedPixelNoise::SeenPair> LearnedPixelNoise::seen_pairs(
    const StereoFrame& frame, const StereoCalibration& calibration) {
  std::vector<std::int64_t> ids;
  std::vector<StereoBearings> points;
  for (const StereoObservation& o : frame.observations) {
    if (const auto pair = detail::bearings(calibration, o)) {
      ids.push_back(o.track_id);
      points.push_back(*pair);
    }
  }
  std::map<std::int64_t, SeenPair> out;
  if (points.size() < kFewestForAFit) {
    return out;
  }
  const double pixel = 1.0 / calibration.cam1.fu;
  const Pose rig = nearest_rig(points, pose_from_rig(calibration.theta), pixel);
  const VectorXd rest = without_quadratic(points, errors_of(points, rig), pixel);
  const double size = size_of(rest);
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const double error = rest(static_cast<Index>(k));
    if (size > 0.0 && std::abs(error) <= kFarOff * size) {
      out[ids[k]] = {error / size,
                     calibration.cam1.fu * angle_between(rig.R * points[k].cam0, points[k].cam1)};
    }
  }
  return out;
}

LearnedPixelNoise::LearnedPixelNoise(const PixelNoise& begin, const StereoCalibration& calibration)
    : begin_(begin),
      calibration_(calibration),
      products_(kPriorPairs * kPriorCorrelation),
      squares_(kPriorPairs) {}

void LearnedPixelNoise::see(const StereoFrame& frame) {
  std::map<std::int64_t, SeenPair> now = seen_pairs(frame, calibration_);
  for (const auto& [id, pair] : now) {
    ++seen_;
    if (const auto known = before_.find(id); known == before_.end()) {
      ++tracks_;
    } else {
      const SeenPair& before = known->second;
      products_ += pair.error * before.error;
      squares_ += 0.5 * (pair.error * pair.error + before.error * before.error);
      if (std::abs(pair.parallax - before.parallax) <
          kSteady * pair.parallax) {  // no mismatch along the line
        parallaxes_ += pair.parallax;
        squared_parallaxes_ += pair.parallax * pair.parallax;
      }
    }
  }
  before_ = std::move(now);
}

double LearnedPixelNoise::correlation() const { return std::clamp(products_ / squares_, 0.0, 1.0); }

/// Variance of what lasts, over that of a single frame.
double LearnedPixelNoise::lasting() const { return std::min(correlation() / kLasting, 1.0); }

double LearnedPixelNoise::telling_frames() const { return persistence() / lasting(); }

double LearnedPixelNoise::persistence() const {
  const double frames = tracks_ > 0.0 ? std::max(seen_ / tracks_, kFewestFrames) : kFewestFrames;
  const double alike = kLasting * (1.0 - 1.0 / frames);
  return 1.0 - lasting() + lasting() * (1.0 + alike) / (1.0 - alike);
}

double LearnedPixelNoise::length_sigma() const {
  if (!(squared_parallaxes_ > 0.0)) {
    return 0.0;
  }
  return std::sqrt(kCameras * kShared / telling_frames()) * root_mean_square(sigma_px()) * parallaxes_ /
         squared_parallaxes_;
}

PixelNoiseReport LearnedPixelNoise::report() const {
  return {root_mean_square(sigma_px()), correlation(), length_sigma()};
}

void LearnedPixelNoise::learn(double nis, double dof) {
  if (dof < kFewestRows || !(nis >= 0.0)) {
    return;
  }
  const double variance = share_ * share_;
  const double weight = std::max(kLearningShare, 1.0 / (kBegin + updates_++));
  const double seen =
      std::clamp(persistence() * (nis / dof - kOwnShare), 1.0 / kLargestStep, kLargestStep) * variance;
  const double rms = root_mean_square(begin_);
  // Less than where it began only where it is known how alike errors are.
  const double least = squares_ < kPriorPairs + kEnoughPairs ? 1.0 : std::min(kLeast_px / rms, 1.0);
  const double most = std::max(kMost_px / rms, 1.0);
  share_ = std::clamp(std::sqrt(variance + weight * (seen - variance)), least, most);
}

}  // namespace limber
