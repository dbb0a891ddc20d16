// SPDX-License-Identifier: MIT
#include "limber/health/input_alarm.hpp"

#include <algorithm>
#include <cmath>

#include "limber/core/chi_square.hpp"
#include "limber/core/time.hpp"

namespace limber {
namespace {

constexpr double kShare = 0.1;  // of one frame in the fading mean
/// How much larger the variance of the fading mean is than of white corrections. Two thirds of a real pixel
/// error's variance stay the same while its track lives (docs/evidence/realistic-pixels.md), some 15 frames:
/// a correlation r of 0.93 from frame to frame, and 1/3 + 2/3 (1 + r (1 - kShare)) / (1 - r (1 - kShare))
/// = 8.
constexpr double kPersistence = 8.0;
/// Variance of real inputs over what their data sheets say, which is no fault yet.
constexpr double kStatedNoise = 2.0;
constexpr double kNoiseShare = 0.05;
constexpr double kDoubtful = 22.46;  // 0.999 quantile of chi-square with 6 degrees of freedom
constexpr int kYoung = 10;           // frames: the first ones are corrected by what the start did not know

}  // namespace

bool InputAlarm::judge(const PoseCorrection& c, InputContradiction& found) {
  if (!c.dx.allFinite() || !c.covariance.allFinite() || c.dof <= 0.0) {
    return false;
  }
  const PoseCorrection::Vector6 z = whitened(c);
  const double rest = scatter_beside(c, z);
  noise_ += kNoiseShare * (rest - noise_);
  const double noise = std::max({noise_, rest, 1.0});
  mean_ = (1.0 - kShare) * mean_ + kShare * z;
  weight_ = (1.0 - kShare) * (1.0 - kShare) * weight_ + kShare * kShare;
  static const double threshold = chi_square_quantile(1.0 - kFalseAlarms, 6.0);
  const double now = z.squaredNorm() / (kStatedNoise * noise),
               lasting = mean_.squaredNorm() / (kPersistence * weight_ * noise);
  statistic_ = std::max(now, lasting);
  doubtful_ = statistic_ > kDoubtful;
  if (++frames_ <= kYoung || statistic_ <= threshold) {
    return false;
  }
  const double share =
      now > threshold ? 1.0 : std::min(std::sqrt(mean_.squaredNorm() / z.squaredNorm()), 1.0);
  found = {share * c.dx.tail<3>().norm(), share * c.dx.head<3>().norm(), c.dt, statistic_};
  mean_.setZero();
  weight_ = 0.0;
  last_ns_ = c.t_ns;
  return true;
}

bool InputAlarm::active(std::int64_t t_ns) const {
  return doubtful_ ||
         (last_ns_ != std::numeric_limits<std::int64_t>::min() && seconds_between(last_ns_, t_ns) < kCalm);
}

}  // namespace limber
