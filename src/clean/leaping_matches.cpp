// SPDX-License-Identifier: MIT
#include "clean/leaping_matches.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "limber/core/angle.hpp"
#include "limber/core/factors.hpp"
#include "limber/core/median.hpp"
#include "limber/core/so3.hpp"
#include "limber/core/time.hpp"

namespace limber::detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr std::size_t kFewestLeaping = 5;  // points that leap together by no chance
constexpr double kLargestRatio = 1.5;      // of the parallax in two successive frames
constexpr double kLongestStep = 0.5;       // [s], after a longer time anything may have come near
constexpr double kNoise = 5e-3;            // [rad], about 3 px: a smaller change may be noise
constexpr double kPixel = 1.5e-3;          // [rad], about 1 px: how well a jump of the rig has to fit
constexpr double kExplained = 0.95;        // share of the points that a jump of the rig moves as it must
constexpr double kSpread = 4.0;            // medians that hardly a misfit of mere noise exceeds
constexpr double kDepthChange = 0.15;      // from frame to frame, relative, of most points
constexpr int kIterations = 10;
// What a jump may be: beyond it the fit is held by a prior, in rotation [rad] and in baselines.
constexpr double kRotationSigma = 0.05, kTranslationSigma = 0.2;
constexpr double kLargestTranslation =
    0.8;  // [baselines]: 25 % short to 25 % long is 2/3; what doubles is no rig

double ratio(double a, double b) { return std::max(a, b) / std::min(a, b); }

bool leaps(double before, double after) { return ratio(before, after) > kLargestRatio; }

/// Tracks that leap between two frames, if most of those that both hold do so by more than noise; else none.
/// @param is_back  whether a track is where it was before it leapt by mistake
template <typename IsBack>
std::vector<std::int64_t> leaping(const StereoSights& before, const StereoSights& after,
                                  const IsBack& is_back) {
  std::vector<std::int64_t> out;
  std::size_t shared = 0, beyond_noise = 0;
  for (const auto& [track, sight] : after) {
    const auto it = before.find(track);
    if (it == before.end()) {
      continue;
    }
    ++shared;
    const double was = it->second.parallax;
    if (leaps(was, sight.parallax) && !is_back(track, sight)) {
      out.push_back(track);
      beyond_noise += std::abs(was - sight.parallax) > kNoise ? 1 : 0;
    }
  }
  if (beyond_noise < kFewestLeaping || 2 * beyond_noise <= shared) {
    out.clear();
  }
  return out;
}

/// One point's say on the change of the rig: residual across and along its epipolar line [rad] with rows of
/// the Jacobian with respect to (rotation, translation), and the deviation that is no change of the rig.
struct Say {
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, 6> J;
  Eigen::Vector2d sigma;
};

/// The bearing in cam1 at parallax p is proportional to turned + s t, for a scale s that p fixes.
std::optional<Say> say_of(const StereoSight& before, const StereoSight& after, const Vector3d& t) {
  const Vector3d towards = t.normalized();
  const Vector3d normal = towards.cross(after.turned);
  if (normal.norm() < 1e-3) {
    return std::nullopt;  // the point lies on the baseline
  }
  const Vector3d across = normal.normalized();
  // Right bearing that the parallax of before predicts: turned by it towards the epipole.
  const Vector3d predicted = Eigen::AngleAxisd(before.parallax, across * -1.0) * after.turned;
  const Vector3d other_way = Eigen::AngleAxisd(before.parallax, across) * after.turned;
  const Vector3d expected = predicted.dot(towards) > other_way.dot(towards) ? predicted : other_way;
  const Vector3d along = across.cross(expected);
  const Vector3d moved = after.right - expected;
  Say out;
  out.residual = {across.dot(moved), along.dot(moved)};
  // A rotation w moves the bearing by w x expected, a translation dt by its part across the ray over the
  // depth.
  const double inverse_depth = std::sin(before.parallax) / t.norm();
  Eigen::Matrix<double, 3, 6> J;
  J.leftCols<3>() = -skew(expected);
  J.rightCols<3>() = inverse_depth * (Matrix3d::Identity() - expected * expected.transpose());
  out.J.row(0) = across.transpose() * J;
  out.J.row(1) = along.transpose() * J;
  out.sigma = {kPixel, kPixel + kDepthChange * before.parallax};
  return out;
}

/// Cauchy-weighted least squares with a prior on the size of the jump.
Vector6d fit(const std::vector<Say>& says, double baseline) {
  Vector6d prior;
  prior << Vector3d::Constant(kRotationSigma), Vector3d::Constant(kTranslationSigma * baseline);
  Vector6d x = Vector6d::Zero();
  for (int k = 0; k < kIterations; ++k) {
    Eigen::Matrix<double, 6, 6> A = prior.cwiseAbs2().cwiseInverse().asDiagonal();
    Vector6d b = Vector6d::Zero();
    for (const Say& say : says) {
      const Eigen::Vector2d error = (say.residual - say.J * x).cwiseQuotient(say.sigma);
      const double weight = 1.0 / (1.0 + error.squaredNorm());
      const Eigen::Matrix<double, 2, 6> J = say.sigma.cwiseInverse().asDiagonal() * say.J;
      A += weight * J.transpose() * J;
      b += weight * J.transpose() * say.residual.cwiseQuotient(say.sigma);
    }
    x = solve_symmetric(A, b);
  }
  return x;
}

/// How far each point is from where the best change of the rig moves it, in sigmas; none if points are too
/// few or no rig changes so much.
std::vector<double> misfits(const StereoSights& before, const StereoSights& after, const Pose& T_cam1_cam0) {
  std::vector<Say> says;
  for (const auto& [track, sight] : after) {
    if (const auto it = before.find(track); it != before.end()) {
      if (const auto say = say_of(it->second, sight, T_cam1_cam0.p)) {
        says.push_back(*say);
      }
    }
  }
  if (says.size() < kFewestLeaping) {
    return {};
  }
  const Vector6d x = fit(says, T_cam1_cam0.p.norm());
  if (x.tail<3>().norm() > kLargestTranslation * T_cam1_cam0.p.norm()) {
    return {};
  }
  std::vector<double> out;
  for (const Say& say : says) {
    out.push_back((say.residual - say.J * x).cwiseQuotient(say.sigma).cwiseAbs().maxCoeff());
  }
  return out;
}

}  // namespace

double rig_misfit(const StereoSights& before, const StereoSights& after, const Pose& T_cam1_cam0) {
  std::vector<double> misfit = misfits(before, after, T_cam1_cam0);
  return misfit.empty() ? 0.0 : upper_median(std::move(misfit));
}

bool one_rig_explains(const StereoSights& before, const StereoSights& after, const Pose& T_cam1_cam0,
                      double usual_misfit) {
  const std::vector<double> misfit = misfits(before, after, T_cam1_cam0);
  const double tolerance = std::max(1.0, kSpread * usual_misfit);
  const auto explained = std::count_if(misfit.begin(), misfit.end(), [&](double m) { return m < tolerance; });
  return !misfit.empty() && static_cast<double>(explained) >= kExplained * static_cast<double>(misfit.size());
}

LeapingMatches::LeapingMatches(const StereoCalibration& assumed)
    : assumed_(assumed), T_cam1_cam0_(pose_from_rig(assumed.theta)) {}

StereoSights LeapingMatches::sights_of(const StereoFrame& frame) const {
  StereoSights out;
  for (const StereoObservation& point : frame.observations) {
    if (!point.in_cam0 || !point.in_cam1) {
      continue;
    }
    const auto d0 = unproject(assumed_.cam0, point.uv_cam0);
    const auto d1 = unproject(assumed_.cam1, point.uv_cam1);
    if (d0 && d1) {
      const Vector3d turned = T_cam1_cam0_.R * *d0;
      out[point.track_id] = {turned, *d1, angle_between(turned, *d1)};
    }
  }
  return out;
}

/// Whether a lost track is where it was before it leapt.
bool LeapingMatches::has_returned(std::int64_t track, const StereoSight& sight, std::int64_t t_ns) const {
  const auto it = lost_.find(track);
  return it != lost_.end() && seconds_between(it->second.since_ns, t_ns) <= kLongestStep &&
         !leaps(it->second.parallax, sight.parallax);
}

LeapingMatches::Outcome LeapingMatches::end(StereoFrame& frame) {
  Outcome out;
  StereoSights now = sights_of(frame);
  const auto is_back = [&](std::int64_t track, const StereoSight& sight) {
    const auto it = earlier_.find(track);
    return (it != earlier_.end() && !leaps(it->second.parallax, sight.parallax)) ||
           has_returned(track, sight, frame.t_ns);
  };
  if (seconds_between(before_ns_, frame.t_ns) <= kLongestStep) {
    const std::vector<std::int64_t> leapt = leaping(before_, now, is_back);
    if (!leapt.empty() && !leapt_before_) {
      usual_misfit_ = rig_misfit(earlier_, before_, T_cam1_cam0_);
    }
    leapt_before_ = !leapt.empty();
    out.rig_jumped = leapt_before_ && one_rig_explains(before_, now, T_cam1_cam0_, usual_misfit_);
    for (const std::int64_t track : leapt) {
      const Lost was{before_.at(track).parallax, frame.t_ns};
      out.lost += !out.rig_jumped && lost_.emplace(track, was).second ? 1 : 0;
    }
  }
  for (const auto& [track, sight] : now) {
    if (has_returned(track, sight, frame.t_ns)) {
      lost_.erase(track);
    }
  }
  for (StereoObservation& point : frame.observations) {
    if (point.in_cam0 && lost_.contains(point.track_id)) {
      point.in_cam1 = false;
    }
  }
  earlier_ = std::exchange(before_, std::move(now));
  before_ns_ = frame.t_ns;
  return out;
}

}  // namespace limber::detail
