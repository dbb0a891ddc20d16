// SPDX-License-Identifier: MIT
#include "limber/initialize/background_navigator.hpp"

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>
#include <variant>

namespace limber {

struct BackgroundNavigator::Worker {
  struct QueuedFrame {
    StereoFrame frame;
    std::promise<BackgroundReport> done;
  };
  using Queued = std::variant<ImuSample, OdometrySample, QueuedFrame>;

  Worker(const NavigatorOptions& options, const StereoCalibration& calibration, const StartOptions& start)
      : navigator(options, calibration, start), thread([this](const std::stop_token& stop) { work(stop); }) {}

  void put(Queued item) {
    {
      const std::lock_guard lock(mutex);
      frames += std::holds_alternative<QueuedFrame>(item) ? 1 : 0;
      queue.push_back(std::move(item));
    }
    filled.notify_one();
  }

  void work(const std::stop_token& stop) {
    while (std::optional<Queued> item = next(stop)) {
      std::visit([this](auto& what) { take(what); }, *item);
    }
  }

  std::optional<Queued> next(const std::stop_token& stop) {
    std::unique_lock lock(mutex);
    if (!filled.wait(lock, stop, [this] { return !queue.empty(); }) || stop.stop_requested()) {
      return std::nullopt;
    }
    Queued item = std::move(queue.front());
    queue.pop_front();
    return item;
  }

  void take(const ImuSample& sample) {
    keep_refusal([&] { navigator.add_imu(sample); });
  }
  void take(const OdometrySample& sample) {
    keep_refusal([&] { navigator.add_odometry(sample); });
  }
  void take(QueuedFrame& queued) {
    BackgroundReport out;
    keep_refusal([&] {
      out.online = navigator.process(queued.frame);
      if (navigator.started()) {
        out.state = navigator.predict(queued.frame.t_ns);
      }
    });
    {
      const std::lock_guard lock(mutex);
      --frames;
    }
    if (refused) {
      queued.done.set_exception(std::exchange(refused, nullptr));
    } else {
      queued.done.set_value(std::move(out));
    }
  }

  /// The first of them counts.
  template <typename Action>
  void keep_refusal(const Action& action) {
    try {
      action();
    } catch (...) {
      refused = refused ? refused : std::current_exception();
    }
  }

  mutable std::mutex mutex;  // of queue and frames
  std::condition_variable_any filled;
  std::deque<Queued> queue;
  std::size_t frames = 0;
  OnlineNavigator navigator;   // the thread's own, as is the next
  std::exception_ptr refused;  // since the last frame
  std::jthread thread;         // last: it ends before what it works with
};

BackgroundNavigator::BackgroundNavigator(const NavigatorOptions& options,
                                         const StereoCalibration& calibration, const StartOptions& start)
    : worker_(std::make_unique<Worker>(options, calibration, start)) {}

BackgroundNavigator::~BackgroundNavigator() = default;

void BackgroundNavigator::add_imu(const ImuSample& sample) { worker_->put(sample); }

void BackgroundNavigator::add_odometry(const OdometrySample& sample) { worker_->put(sample); }

std::future<BackgroundReport> BackgroundNavigator::process(StereoFrame frame) {
  Worker::QueuedFrame queued{std::move(frame), {}};
  std::future<BackgroundReport> out = queued.done.get_future();
  worker_->put(std::move(queued));
  return out;
}

std::size_t BackgroundNavigator::waiting() const {
  const std::lock_guard lock(worker_->mutex);
  return worker_->frames;
}

}  // namespace limber
