// SPDX-License-Identifier: MIT
// StereoFilter's corrections from where nothing is linear any more: they are not made.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

#include "limber/navigate/stereo_filter.hpp"
#include "parameter_roles.hpp"

namespace limber {

using detail::has_more;
using Eigen::Index;

namespace {

constexpr double kFarOff = 3.0;           // sigmas of a pixel, rms: a correction that has much to mend
constexpr double kLargeTurn = 0.1;        // [rad]: is it linear?
constexpr std::size_t kEnoughToTell = 6;  // points

/// How far points are from where the left camera sees them; the right one's rows may hold an error of theta.
struct LeftMisfit {
  double rms = 0.0;  ///< in sigmas of a pixel
  std::size_t points = 0;
};

/// @param counted  by point
LeftMisfit left_misfit(const StackedFrame& stacked, const std::vector<bool>& counted) {
  LeftMisfit out;
  const LinearMeasurement& rows = stacked.measurement;
  for (std::size_t g = 0; g < stacked.track_ids.size(); ++g) {
    const Index row = rows.groups[g].row;
    if (counted[g] && rows.D.block<2, kBlockSize>(row, 0).isZero(0.0)) {
      out.rms += rows.residual.segment<2>(row).cwiseQuotient(rows.sigma.segment<2>(row)).squaredNorm();
      ++out.points;
    }
  }
  out.rms = out.points > 0 ? std::sqrt(0.5 * out.rms / static_cast<double>(out.points)) : 0.0;
  return out;
}

/// For each point of `stacked` its flag among those of `ids`.
std::vector<bool> flags_of(const StackedFrame& stacked, const std::vector<std::int64_t>& ids,
                           const std::vector<bool>& flags) {
  std::set<std::int64_t> flagged;
  for (std::size_t g = 0; g < ids.size(); ++g) {
    if (flags[g]) {
      flagged.insert(ids[g]);
    }
  }
  std::vector<bool> out;
  for (const std::int64_t id : stacked.track_ids) {
    out.push_back(flagged.contains(id));
  }
  return out;
}

}  // namespace

/// Would the points be farther from where they are seen after the correction than before? It is a step from
/// where nothing is linear any more: the next one would be larger. Leaves the correction in `attempt` where
/// it had to be worked out.
bool StereoFilter::leads_astray(const StereoFrame& frame, const ParameterErrorModel& model,
                                Attempt& attempt) const {
  const LeftMisfit before = left_misfit(attempt.stacked, attempt.accepted);
  if (before.points < kEnoughToTell || before.rms < kFarOff) {
    return false;
  }
  Correction& correction = attempt.correction.emplace(Correction{estimate_.P(), {}});
  correction.report = update(correction.P, compressed(std::move(attempt.seen), attempt.accepted), model);
  if (correction.report.status != UpdateStatus::kUpdated ||
      correction.report.dx.segment<3>(StateLayout::kAttitude).norm() < kLargeTurn) {
    return false;
  }
  Estimate corrected = estimate_;
  corrected.mutable_P() = correction.P;
  corrected.retract(correction.report.dx, estimate_.scale_shares());
  MountedRig rig = attempt.at.rig;
  if (has_more(options_)) {  // of the mount, too
    rig[0] = mounted(calibration_of(corrected))[0];
  }
  std::vector<Refusal> behind;
  const StackedFrame stacked = stack_frame(corrected, frame, rig, sigma_px(), attempt.new_landmarks, behind);
  const LeftMisfit after =
      left_misfit(stacked, flags_of(stacked, attempt.stacked.track_ids, attempt.accepted));
  return after.rms > before.rms || 2 * after.points < before.points;
}

}  // namespace limber
