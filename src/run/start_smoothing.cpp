// SPDX-License-Identifier: MIT
#include "start_smoothing.hpp"

#include <utility>

namespace limber::detail {
namespace {

constexpr std::int64_t kSmoothedNs = 4'000'000'000;  // from the start's first frame on [ns]

}  // namespace

StartSmoothing::StartSmoothing(SensorStart start, InputFeed feed, MotionModel motion, std::int64_t begin_ns)
    : start_(std::move(start)), feed_(feed), motion_(motion), begin_ns_(begin_ns), last_ns_(begin_ns) {}

void StartSmoothing::add(const StereoFrame& frame) {
  if (complete_ || frame.t_ns <= last_ns_) {
    return;
  }
  if (frame.t_ns - begin_ns_ > kSmoothedNs) {
    complete_ = true;
    return;
  }
  feed_.feed(start_, motion_, frame.t_ns + start_.clock_offset_ns());
  (void)start_.add_frame(frame);
  last_ns_ = frame.t_ns;
}

void StartSmoothing::begin(Method method, std::size_t frames, std::launch how) {
  if (states_.valid()) {
    states_.wait();  // of a run that failed meanwhile
  }
  states_ = std::async(how, [this, method, frames] {
    SensorStartResult result = start_.result_for(method);
    if (!result.solved || result.trajectory.size() < frames) {
      return std::vector<SmoothedState>{};
    }
    result.trajectory.resize(frames);
    return std::move(result.trajectory);
  });
}

WindowSmoother::WindowSmoother(StartSmoothing* smoothing, Method method, std::size_t frames, int threads)
    : smoothing_(smoothing),
      method_(method),
      frames_(frames),
      how_(threads > 1 ? std::launch::async : std::launch::deferred) {}

void WindowSmoother::begin() {
  smoothing_->begin(method_, frames_, how_);
  has_begun_ = true;
}

void WindowSmoother::add(const StereoFrame& frame) {
  if (smoothing_ == nullptr || has_begun_) {
    return;
  }
  smoothing_->add(frame);
  if (smoothing_->complete()) {
    begin();
  }
}

std::vector<SmoothedState> WindowSmoother::states() {
  if (smoothing_ == nullptr) {
    return {};
  }
  if (!has_begun_) {
    begin();
  }
  return std::exchange(smoothing_, nullptr)->states();
}

}  // namespace limber::detail
