// SPDX-License-Identifier: MIT
#include "limber/diagnose/trusted_rig.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "diagnose/run_events.hpp"
#include "limber/core/angle.hpp"
#include "limber/core/chi_square.hpp"
#include "limber/run/trusted_axes.hpp"

namespace limber {
namespace {

constexpr double kOnceInRuns = 1e-3;  // remarks of runs whose rig is exact
constexpr double kDegrees = 24.0;     // of freedom, see docs/derivations/health.md
constexpr std::size_t kMostNamed = 3;

/// How sure it is that one part is off in one stretch.
struct PartOff {
  double p = 1.0, error = 0.0, sigma = 0.0;
  const TrustedPart* part = nullptr;

  [[nodiscard]] std::string in_words() const {
    const double unit = part->is_angle ? kToDegrees : 1e3;
    return fmt::format("{} {:+.2g} ± {:.2g} {}", part->name, unit * error, unit * sigma,
                       part->is_angle ? "deg" : "mm");
  }
};

/// The surest first.
std::vector<PartOff> parts_off(const CalibrationState& state, const std::vector<TrustedPart>& parts) {
  std::vector<PartOff> out;
  if (state.tracks < kFewestTracks || state.deep_tracks < kFewestTracks) {
    return out;
  }
  for (const TrustedPart& part : parts) {
    const double error = part.along.dot(state.estimate.delta);
    const double sigma = std::sqrt(part.along.dot(state.estimate.covariance * part.along));
    if (sigma > 0.0) {
      out.push_back({student_survival(error / sigma, kDegrees), error, sigma, &part});
    }
  }
  std::ranges::sort(out, {}, &PartOff::p);
  return out;
}

std::string note_on(const TrustedRigOff& off, const RunOptions& options, const HealthSummary& rig) {
  return fmt::format(
      "sigmas of {} take the rig for exact, and from {:.1f} s to {:.1f} s it is off, at the end by {}{}: "
      "they are "
      "too small. --method lcekf and adaptive do not rely on it",
      to_string(options.method), rig.seconds(off.from_ns), rig.seconds(off.to_ns), off.in_words,
      rig.verdict == HealthVerdict::kOk ? ", within the tolerance" : "");
}

std::string note_on(const ScaleCheck& check, const RunOptions& options, const RunRecord& record,
                    const HealthSummary& rig) {
  const bool is_long = check.scale.too_long > 0.0;
  return fmt::format(
      "sigmas of {} take the rig for exact, and beside what the IMU shows from {:.1f} s to {:.1f} s its "
      "trajectory is {:.2g} ± {:.2g} % too {}, as of a baseline that is {} than the assumed {:.3g} m by as "
      "much: they are too small. --method lcekf and adaptive do not rely on it",
      to_string(options.method), rig.seconds(check.from_ns), rig.seconds(check.to_ns),
      100.0 * std::abs(check.scale.too_long), 100.0 * check.scale.sigma, is_long ? "long" : "short",
      is_long ? "shorter" : "longer", record.theta_assumed.tail<3>().norm());
}

}  // namespace

bool is_off(const TrajectoryScale& scale) {
  const double sigmas = scale.too_long / scale.sigma;
  return chi_square_survival(sigmas * sigmas, 1.0) < kOnceInRuns;
}

std::vector<TrustedPart> trusted_parts(const RunOptions& options, MotionModel motion,
                                       const RigParameters& theta) {
  std::vector<TrustedPart> out;
  for (std::size_t axis = 0; axis < 6; ++axis) {
    if (trusts_axis(options, motion, axis)) {
      out.push_back({std::string(kParameterNames[axis]), RigParameters::Unit(static_cast<Eigen::Index>(axis)),
                     axis < 3});
    }
  }
  if (trusts_length_alone(options, motion) && has_scale(motion)) {
    TrustedPart length{"baseline"};
    length.along.tail<3>() = theta.tail<3>().normalized();
    out.push_back(std::move(length));
  }
  return out;
}

std::optional<TrustedRigOff> trusted_rig_off(const HealthSummary& rig, const std::vector<TrustedPart>& parts,
                                             double share_of_runs) {
  std::vector<CalibrationState> stretches = rig.past;
  stretches.push_back(rig.present);
  double least =
      share_of_runs / static_cast<double>(stretches.size() * std::max<std::size_t>(parts.size(), 1));
  const double limit = least;
  std::optional<TrustedRigOff> out;
  for (const CalibrationState& state : stretches) {
    const std::vector<PartOff> off = parts_off(state, parts);
    if (off.empty() || !(off.front().p < least)) {
      continue;
    }
    least = off.front().p;
    std::vector<std::string> words;
    for (const PartOff& part : off) {
      if (part.p < limit && words.size() < kMostNamed) {
        words.push_back(part.in_words());
      }
    }
    out = TrustedRigOff{state.from_ns, state.to_ns, fmt::format("{}", fmt::join(words, ", "))};
  }
  return out;
}

void add_trusted_rig(const RunOptions& options, RunRecord& record, RunSummary& summary) {
  if (!summary.health || summary.inputs.lost_since_ns || summary.readout_contradicted) {
    return;
  }
  const auto off =
      trusted_rig_off(*summary.health, trusted_parts(options, record.motion, record.theta_assumed));
  if (off) {
    record.notes.push_back(note_on(*off, options, *summary.health));
    detail::add_event({RunEventKind::kTrustedRigOff, off->from_ns, off->to_ns}, record, summary.inputs);
  }
  if (const auto& check = summary.scale_check; check && is_off(check->scale)) {
    record.notes.push_back(note_on(*check, options, record, *summary.health));
    detail::add_event({RunEventKind::kTrustedScaleOff, check->from_ns, check->to_ns}, record, summary.inputs);
  }
}

}  // namespace limber
