// SPDX-License-Identifier: MIT
#include "limber/diagnose/scale_check.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "limber/core/divergence_error.hpp"
#include "limber/core/median.hpp"
#include "limber/core/time.hpp"
#include "limber/diagnose/run_summary.hpp"
#include "limber/run/trusted_axes.hpp"
#include "run/samples_as_taken.hpp"

namespace limber {
namespace {

constexpr std::size_t kFewestRows = 20;
constexpr double kDisagrees = 2.0;       // squared, over the variance
constexpr std::size_t kMostPoints = 60;  // a frame: enough, and what it costs is bounded

/// What is needed of the recording to go through the frames that were kept.
Recording stretch_of(const Recording& recording, const RunRecord& record) {
  Recording out;
  out.name = recording.name;
  out.calibration = recording.calibration;
  out.imu_noise = recording.imu_noise;
  out.pixel_noise = recording.pixel_noise;
  out.imu = detail::samples_as_taken(recording, record, record.last_frames.front().t_ns);
  for (const StereoFrame& frame : record.last_frames) {
    if (recording.images.empty()) {
      out.frames.push_back(frame);
    } else {
      out.images.push_back({frame.t_ns, {}, {}});
    }
  }
  return out;
}

/// The frames are clean, and at their stamps.
RunOptions without_trust(RunOptions options) {
  options.method = Method::kLcekf;
  options.constraints.reset();
  options.start = StartMode::kAuto;
  options.cleaning.clean = options.cleaning.still_points = options.cleaning.refer_to_stamp = false;
  options.cleaning.max_points = std::min(options.cleaning.max_points, kMostPoints);
  options.watch = false;
  options.learn_imu_clock = false;  // samples are as taken
  options.stop_when_lost = true;
  return options;
}

/// The same frame in both runs.
struct TwoRows {
  const TrajectoryRow *trusting, *blind;
};

std::vector<TwoRows> common_rows(const std::vector<TrajectoryRow>& trusting,
                                 const std::vector<TrajectoryRow>& blind) {
  std::vector<TwoRows> out;
  auto row = trusting.begin();
  for (const TrajectoryRow& other : blind) {
    row = std::find_if(row, trusting.end(), [&](const TrajectoryRow& r) { return r.t_ns >= other.t_ns; });
    if (row != trusting.end() && row->t_ns == other.t_ns) {
      out.push_back({&*row, &other});
    }
  }
  return out;
}

/// As the body sees it.
Eigen::Vector3d velocity_in(const TrajectoryRow& row) {
  return row.T_world_body.R.transpose() * *row.v_world_body;
}

/// How much faster the trusting run is, as a share; nothing where there are too few rows. Its place would not
/// do: while the length of a long way behind is corrected, it goes by more than the speed.
std::optional<double> too_fast(const std::vector<TwoRows>& rows) {
  double product = 0.0, square = 0.0;
  for (const TwoRows& row : rows) {
    const Eigen::Vector3d blind = velocity_in(*row.blind);
    product += blind.dot(velocity_in(*row.trusting));
    square += blind.squaredNorm();
  }
  return rows.size() < kFewestRows || !(square > 0.0) ? std::nullopt : std::optional(product / square - 1.0);
}

/// Of the speed, as a share of it, over all rows.
double scale_sigma(const std::vector<TwoRows>& rows) {
  double squared = 0.0, variance = 0.0;
  for (const TwoRows& row : rows) {
    const Eigen::Vector3d& v = *row.blind->v_world_body;
    squared += v.squaredNorm();
    variance += v.stableNormalized().cwiseProduct(*row.blind->sigma_v).squaredNorm();
  }
  return std::hypot(std::sqrt(variance / squared), kLeastScale);
}

/// The last frames once more, by a filter that asks the IMU alone; nothing where it does not go through.
std::optional<RunRecord> run_without_trust(const Recording& recording, const RunOptions& options,
                                           const RunRecord& record) {
  if (record.last_frames.size() < kFewestRows) {
    return std::nullopt;
  }
  try {
    RunRecord blind = run_recording(stretch_of(recording, record), without_trust(options),
                                    [&](std::size_t n) { return record.last_frames[n]; });
    return summarize_inputs(blind.frames).lost_since_ns ? std::nullopt : std::optional(std::move(blind));
  } catch (const DivergenceError&) {
    return std::nullopt;
  } catch (const std::invalid_argument&) {  // no frame to start from
    return std::nullopt;
  }
}

/// Squared difference of the velocities, as the body sees them, over the variance of both.
double disagreement(const TwoRows& rows) {
  const Eigen::Vector3d off = velocity_in(*rows.trusting) - velocity_in(*rows.blind);
  return off.squaredNorm() / (rows.trusting->sigma_v->squaredNorm() + rows.blind->sigma_v->squaredNorm());
}

}  // namespace

std::optional<ScaleCheck> check_scale(const Recording& recording, const RunOptions& options,
                                      const RunRecord& record) {
  const std::optional<RunRecord> blind = run_without_trust(recording, options, record);
  if (!blind) {
    return std::nullopt;
  }
  const std::vector<TwoRows> rows = common_rows(record.trajectory, blind->trajectory);
  const std::optional<double> share = too_fast(rows);
  if (!share) {
    return std::nullopt;
  }
  const double sigma = scale_sigma(rows);
  if (!(sigma < TrajectoryScale{}.sigma)) {  // at rest, say
    return std::nullopt;
  }
  return ScaleCheck{rows.front().blind->t_ns, rows.back().blind->t_ns, {*share, sigma}};
}

std::optional<bool> agrees_with_lcekf(const Recording& recording, const RunOptions& options,
                                      const RunRecord& record, std::int64_t since_ns) {
  const std::optional<RunRecord> blind = run_without_trust(recording, options, record);
  std::vector<double> off;
  for (const TwoRows& rows :
       blind ? common_rows(record.trajectory, blind->trajectory) : std::vector<TwoRows>{}) {
    if (rows.trusting->t_ns >= since_ns) {
      off.push_back(disagreement(rows));
    }
  }
  return off.size() < kFewestRows ? std::nullopt : std::optional(upper_median(std::move(off)) < kDisagrees);
}

void add_scale_check(const Recording& recording, const RunOptions& options, const RunRecord& record,
                     RunSummary& summary) {
  summary.rests_on_length =
      record.motion != MotionModel::kOdometry && trusts_length(options, record.motion, record.theta_assumed);
  if (!summary.health || !summary.rests_on_length || record.motion != MotionModel::kImu ||
      summary.inputs.lost_since_ns) {
    return;
  }
  summary.scale_check = check_scale(recording, options, record);
  const auto judged = [&](const CalibrationState& state) {
    const bool seen = summary.scale_check && summary.scale_check->from_ns < state.to_ns;
    return with_scale(state, seen ? summary.scale_check->scale : TrajectoryScale{}, record.theta_assumed,
                      options.tolerance);
  };
  HealthSummary& rig = *summary.health;
  std::ranges::transform(rig.past, rig.past.begin(), judged);
  rig.present = judged(rig.present);
  rig.verdict = rig.by_states();
}

}  // namespace limber
