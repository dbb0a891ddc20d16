// SPDX-License-Identifier: MIT
#include "limber/health/calibration_change.hpp"

#include <algorithm>

namespace limber {
namespace {

/// The same estimate, against another assumed theta and in plausible errors of that.
BetaEstimate against(const RigRecord& record, const RigParameters& theta) {
  const RigParameters from = plausible_error(record.theta.tail<3>().norm());
  const RigParameters to = plausible_error(theta.tail<3>().norm());
  NormalEquations::Vector unit = NormalEquations::Vector::Ones();
  unit.head<6>() = from.cwiseQuotient(to);
  BetaEstimate out = record.estimate;
  out.beta = unit.cwiseProduct(out.beta);
  out.beta.head<6>() += (record.theta - theta).cwiseQuotient(to);
  out.covariance = unit.asDiagonal() * out.covariance * unit.asDiagonal();
  return out;
}

}  // namespace

RigRecord rig_record(const CalibrationState& state, const RigParameters& theta, bool metric) {
  return {theta,        metric,       state.from_ns, state.to_ns,       state.windows,
          state.tracks, state.points, state.deep,    state.deep_tracks, state.whole};
}

CalibrationState change_between(const RigRecord& before, const RigRecord& now, const Tolerance& tolerance) {
  const BetaEstimate then = against(before, now.theta);
  BetaEstimate step = now.estimate;
  step.beta -= then.beta;
  step.covariance += then.covariance;
  CalibrationState out;
  out.from_ns = before.to_ns;
  out.to_ns = now.from_ns;
  out.windows = std::min(before.windows, now.windows);
  out.tracks = std::min(before.tracks, now.tracks);
  out.points = std::min(before.points, now.points);
  out.deep = std::min(before.deep, now.deep);
  out.deep_tracks = std::min(before.deep_tracks, now.deep_tracks);
  judge_estimate(step, now.theta, before.metric && now.metric, tolerance, out);
  return out;
}

}  // namespace limber
