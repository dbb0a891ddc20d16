// SPDX-License-Identifier: MIT
#include "frame_by_frame.hpp"

#include <fmt/format.h>

#include <exception>

#include "limber/core/divergence_error.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/run/trajectory_row.hpp"

namespace limber::detail {
namespace {

TrajectoryRow row_of(const Navigator& navigator) {
  const Estimate& estimate = navigator.estimate();
  constexpr Eigen::Index kPose = StateLayout::kPoseSize;
  const PredictedState body = navigator.predict(estimate.nav().t_ns);
  const Eigen::Index rest = body.body_covariance.rows() - kPose;
  return trajectory_row(body.nav, estimate.layout().motion,
                        body.body_covariance.topLeftCorner<kPose, kPose>(),
                        body.body_covariance.bottomRightCorner(rest, rest));
}

void keep_calibration(const Navigator& navigator, RunRecord& record) {
  const CalibrationEstimate estimate = navigator.calibration_estimate();
  if (estimate.parameters.any()) {
    record.calibration.push_back({navigator.estimate().nav().t_ns, estimate});
  }
}

bool is_sane(const TrajectoryRow& row) {
  return row.T_world_body.p.allFinite() && row.T_world_body.R.allFinite() && row.v_world_body->allFinite() &&
         row.covariance->allFinite();
}

}  // namespace

FrameByFrame::FrameByFrame(const Recording& recording, const RunOptions& options, const RunSetup& setup,
                           const RunCallbacks& callbacks, std::size_t first, const PointCount& points,
                           Navigator& navigator, RunRecord& record)
    : recording_(recording),
      options_(options),
      setup_(setup),
      callbacks_(callbacks),
      first_(first),
      navigator_(navigator),
      record_(record),
      points_(points),
      feed_(recording, record.clock_step_of_start) {
  for (std::size_t row = 0; row < record.frames.size(); ++row) {
    show(row, nullptr);
  }
}

bool FrameByFrame::is_stopped() {
  record_.stopped = record_.stopped || (callbacks_.stop && callbacks_.stop());
  return record_.stopped;
}

void FrameByFrame::take(const ReadFrame& read, WindowSmoother& smoother) {
  const StereoFrame& frame = read.frame;
  const auto begin_filter = Clock::now();
  record_.source_ms.push_back(read.ms);
  points_.add(frame);
  feed_.feed(navigator_, record_.motion, frame.t_ns + navigator_.clock_offset_ns());
  if (options_.method == Method::kOracle) {
    navigator_.show_true_rig(true_rig_at(recording_.truth.rig, frame.t_ns));
  }
  process(frame);
  record_.trajectory.push_back(row_of(navigator_));
  keep_calibration(navigator_, record_);
  record_.frame_ms.push_back(milliseconds(begin_filter, Clock::now()));
  require_sane(frame.t_ns);
  if (next() == frame_count(recording_)) {  // nothing comes any more that the rest could wait for
    record_.frames.back().calibration = navigator_.calibration_report();
  }
  smoother.add(frame);
  show(record_.frames.size() - 1, &frame);
}

void FrameByFrame::process(const StereoFrame& frame) {
  try {
    record_.frames.push_back(navigator_.process(frame));
  } catch (const DivergenceError& error) {
    fail(next(), frame.t_ns, error.what());
  } catch (const std::exception& error) {
    if (!is_sane(row_of(navigator_))) {  // whatever trips over such numbers is their fault
      fail(next(), frame.t_ns, error.what());
    }
    throw;
  }
}

void FrameByFrame::require_sane(std::int64_t t_ns) const {
  const FrameReport& report = record_.frames.back();
  if (!is_sane(record_.trajectory.back())) {
    fail(next() - 1, t_ns, "the state is not finite");
  }
  if (report.reset && options_.stop_when_lost) {
    fail(next() - 1, t_ns,
         report.status == UpdateStatus::kSingularInnovation
             ? "what points may say of the state is no covariance"
             : "the state left what a body can do");
  }
}

void FrameByFrame::fail(std::size_t n, std::int64_t t_ns, const std::string& what) const {
  std::string message =
      fmt::format("{} diverged at frame {}, {} ns: {}", to_string(options_.method), n, t_ns, what);
  for (const std::string& remark : remarks_on_input(recording_, record_.motion, setup_.navigator.gravity)) {
    message += "; " + remark;
  }
  throw DivergenceError(message);
}

void FrameByFrame::show(std::size_t row, const StereoFrame* frame) const {
  if (callbacks_.observe) {
    callbacks_.observe({record_.trajectory[row], record_.frames[row], frame ? &navigator_ : nullptr, frame,
                        frame ? record_.frame_ms.back() : 0.0});
  }
  if (callbacks_.progress) {
    callbacks_.progress(first_ + row + 1);
  }
}

}  // namespace limber::detail
