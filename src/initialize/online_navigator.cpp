// SPDX-License-Identifier: MIT
#include "limber/initialize/online_navigator.hpp"

#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "limber/core/time.hpp"
#include "limber/state/initial_state.hpp"
#include "navigate/check_inputs.hpp"

namespace limber {
namespace {

constexpr double kKept = 60.0;     // [s] of samples: what the filter learns of them fades in 20 s
constexpr double kReaching = 1.0;  // [s]: the newest sample may be that much older than the first frame
constexpr double kUnsolved = std::numeric_limits<double>::infinity();

template <typename Receiver>
void give(Receiver& receiver, const ImuSample& sample) {
  receiver.add_imu(sample);
}

template <typename Receiver>
void give(Receiver& receiver, const OdometrySample& sample) {
  receiver.add_odometry(sample);
}

template <typename Receiver, typename Inputs>
void give_all(Receiver& receiver, const Inputs& inputs) {
  for (const auto& input : inputs) {
    std::visit([&](const auto& sample) { give(receiver, sample); }, input);
  }
}

template <typename Input>
std::int64_t time_of(const Input& input) {
  return std::visit([](const auto& sample) { return sample.t_ns; }, input);
}

/// Inputs with the times at which they were taken.
template <typename Inputs>
Inputs by_clock(const Inputs& inputs, const StampJump& clock) {
  Inputs out;
  for (auto input : inputs) {
    if (const auto taken_ns = clock.corrected(time_of(input))) {
      std::visit([&](auto& sample) { sample.t_ns = *taken_ns; }, input);
      out.push_back(input);
    }
  }
  return out;
}

InputSample input_of(const ImuSample& sample) { return {sample.t_ns, sample.omega_imu, sample.accel_imu}; }
InputSample input_of(const OdometrySample& sample) { return {sample.t_ns, sample.omega_body, sample.v_body}; }

MotionModel motion_of(const ImuSample&) { return MotionModel::kImu; }
MotionModel motion_of(const OdometrySample&) { return MotionModel::kOdometry; }

}  // namespace

OnlineNavigator::OnlineNavigator(const NavigatorOptions& options, const StereoCalibration& calibration,
                                 const StartOptions& start)
    : options_(options), calibration_(calibration), start_options_(start) {
  (void)Navigator(options, calibration, make_initial_state({}, options.motion, {}));  // throws now, not later
}

/// What a navigator would refuse, as long as there is none.
void OnlineNavigator::check(const Input& input) const {
  const std::string what = "input sample at " + std::to_string(time_of(input)) + " ns ";
  if (std::visit([](const auto& sample) { return motion_of(sample); }, input) != options_.motion) {
    throw std::invalid_argument(what + "is not what the motion model takes");
  }
  require_next(std::visit([](const auto& sample) { return input_of(sample); }, input),
               inputs_.empty() ? std::nullopt : std::optional(time_of(inputs_.back())));
  if (last_frame_ns_ && seconds_between(*last_frame_ns_, time_of(input)) > detail::kLongestJump) {
    throw std::invalid_argument(what + "is hours ahead of the frames: is that another clock?");
  }
}

template <typename Sample>
void OnlineNavigator::add(const Sample& given) {
  Sample sample = given;
  if (navigator_) {
    const auto taken_ns = taken_at(given.t_ns, clock_step_);
    if (!taken_ns) {
      return;
    }
    sample.t_ns = *taken_ns;
    give(*navigator_, sample);
  } else {
    check(sample);
    if (start_) {
      give(*start_, sample);
    }
  }
  inputs_.push_back(sample);
  while (!start_ && seconds_between(time_of(inputs_.front()), sample.t_ns) > kKept) {
    inputs_.pop_front();
  }
}

void OnlineNavigator::add_imu(const ImuSample& sample) { add(sample); }

void OnlineNavigator::add_odometry(const OdometrySample& sample) { add(sample); }

/// Whether there are inputs for a start from that time on.
bool OnlineNavigator::reaches(std::int64_t t_ns) const {
  return options_.motion == MotionModel::kConstantVelocity ||
         (!inputs_.empty() && time_of(inputs_.front()) <= t_ns &&
          seconds_between(time_of(inputs_.back()), t_ns) <= kReaching);
}

StartReport OnlineNavigator::continue_start(const StereoFrame& frame) {
  detail::check_frame(frame, last_frame_ns_.value_or(frame.t_ns),
                      last_frame_ns_.value_or(std::numeric_limits<std::int64_t>::min()));
  if (!start_) {
    if (!reaches(frame.t_ns)) {
      return {StartStatus::kWaiting,
              0.0,
              kUnsolved,
              kUnsolved,
              std::string(options_.motion == MotionModel::kImu ? "IMU" : "odometry") +
                  " samples at the time of the frames",
              {}};
    }
    SensorStart start(options_, calibration_, start_options_);
    give_all(start, inputs_);
    start_.emplace(std::move(start));
  }
  const StartReport report = start_->add_frame(frame);
  last_frame_ns_ = frame.t_ns;
  return report;
}

/// A navigator that has had the inputs, those around its start among them.
void OnlineNavigator::hand_over(const InitialState& initial, std::deque<Input> inputs) {
  Navigator navigator(options_, calibration_, initial);
  give_all(navigator, inputs);
  navigator_.emplace(std::move(navigator));
  inputs_ = std::move(inputs);
  start_.reset();
}

OnlineReport OnlineNavigator::process(const StereoFrame& frame) {
  OnlineReport out;
  out.t_ns = frame.t_ns;
  if (!navigator_) {
    out.start = continue_start(frame);
    if (out.start->status == StartStatus::kWaiting) {
      return out;
    }
    const SensorStartResult found = start_->result();
    clock_step_ = found.clock_step;
    hand_over(found.initial, clock_step_ ? by_clock(inputs_, *clock_step_) : inputs_);
    (void)show_start(found, *navigator_);
    for (const StereoFrame& unused : found.unused) {  // this one is the last
      out.frame = navigator_->process(unused);
    }
    if (options_.motion != MotionModel::kOdometry) {
      return out;  // the start has used it up, or the filter has it
    }
  }
  out.frame = navigator_->process(frame);
  return out;
}

void OnlineNavigator::reset() {
  inputs_.clear();
  last_frame_ns_.reset();
  start_.reset();
  navigator_.reset();
  clock_step_.reset();
}

void OnlineNavigator::reset(const InitialState& initial) {
  const bool count_on = !inputs_.empty() && time_of(inputs_.front()) <= initial.nav.t_ns;
  hand_over(initial, count_on ? inputs_ : std::deque<Input>{});
}

void OnlineNavigator::show_true_rig(const TrueRig& truth) {
  (void)navigator();
  navigator_->show_true_rig(truth);
}

const Navigator& OnlineNavigator::navigator() const {
  if (!navigator_) {
    throw std::logic_error("navigator: no start yet; what it waits for is in the report of each frame");
  }
  return *navigator_;
}

std::int64_t OnlineNavigator::clock_offset_ns() const {
  if (!navigator_) {
    return start_ ? start_->clock_offset_ns() : 0;
  }
  return navigator_->clock_offset_ns() + (clock_step_ ? clock_step_->offset_ns : 0);
}

std::optional<HealthReport> OnlineNavigator::health() const {
  return navigator_ ? navigator_->health() : std::nullopt;
}

std::shared_ptr<const CalibrationReport> OnlineNavigator::calibration_report() const {
  return navigator_ ? navigator_->calibration_report() : nullptr;
}

const StereoCalibration& OnlineNavigator::calibration() const {
  return navigator_ ? navigator_->calibration() : calibration_;
}

CalibrationEstimate OnlineNavigator::calibration_estimate() const {
  return navigator_ ? navigator_->calibration_estimate() : CalibrationEstimate{};
}

}  // namespace limber
