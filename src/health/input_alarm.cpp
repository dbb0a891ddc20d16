// SPDX-License-Identifier: MIT
#include "limber/health/input_alarm.hpp"

#include <algorithm>
#include <cmath>

#include "limber/core/chi_square.hpp"
#include "limber/core/time.hpp"

namespace limber {
namespace {

/// How much larger the variance of the fading mean is than of white corrections. Two thirds of a real pixel
/// error's variance stay the same while its track lives (docs/evidence/realistic-pixels.md), some 15 frames:
/// a correlation r of 0.93 from frame to frame, and 1/3 + 2/3 (1 + 0.9 r) / (1 - 0.9 r) = 8: the mean keeps
/// 0.9 of itself.
constexpr double kPersistence = 8.0;
/// Variance of real inputs over what their data sheets say, which is no fault yet.
constexpr double kStatedNoise = 2.0;
constexpr double kDoubtful = 22.46;  // 0.999 quantile of chi-square with 6 degrees of freedom

}  // namespace

bool InputAlarm::judge(const PoseCorrection& c, const StepFit& fit, InputContradiction& found) {
  if (!corrections_.add(c)) {
    return false;
  }
  const bool is_open = contradicted(c.t_ns);
  const double noise = corrections_.noise(), lasting_noise = corrections_.lasting_noise(),
               square = corrections_.last().squaredNorm(), square_of_mean = corrections_.mean().squaredNorm();
  const double now = square / (kStatedNoise * noise),
               lasting = square_of_mean / (kPersistence * corrections_.expected_square() * lasting_noise),
               by_steps = std::max(fit.explained / std::max(kPersistence, fit.factor),
                                   fit.explained_by_clock / std::max(kStatedNoise, fit.factor)),
               step = is_open ? 0.0 : by_steps / lasting_noise;
  statistic_ = std::max({now, lasting, step});
  doubtful_ = statistic_ > kDoubtful;
  static const double threshold = chi_square_quantile(1.0 - kFalseAlarms, 6.0);
  if (corrections_.are_of_a_start() || statistic_ <= threshold) {
    return false;
  }
  const bool is_sudden = now > threshold;
  const double share = is_sudden ? 1.0 : std::min(std::sqrt(square_of_mean / square), 1.0);
  found = {share * c.dx.tail<3>().norm(),
           share * c.dx.head<3>().norm(),
           c.dt,
           statistic_,
           std::nullopt,
           std::nullopt,
           std::nullopt};
  if (!is_sudden && !is_open &&
      fit.explained > std::max(kStatedNoise, fit.factor) * lasting_noise * threshold) {
    found.step = fit.size;
  }
  corrections_.restart_mean();
  last_ns_ = c.t_ns;
  return true;
}

/// A test rejected less than kCalm ago.
bool InputAlarm::contradicted(std::int64_t t_ns) const {
  return last_ns_ != std::numeric_limits<std::int64_t>::min() && seconds_between(last_ns_, t_ns) < kCalm;
}

bool InputAlarm::active(std::int64_t t_ns) const { return doubtful_ || contradicted(t_ns); }

}  // namespace limber
