// SPDX-License-Identifier: MIT
#include "limber/view/view_board.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "encode.hpp"
#include "io/base64.hpp"
#include "io/json_text.hpp"
#include "thinned_path.hpp"

namespace limber {
namespace {

using Json = nlohmann::ordered_json;
using namespace std::chrono_literals;

constexpr std::size_t kMostViewers = 8;
constexpr std::uint64_t kUnanswered = 2;  // frames that a page may be busy with
constexpr auto kWatchedPeriod = 40ms, kUnwatchedPeriod = 500ms;

}  // namespace

ViewBoard::ViewBoard(ViewRun run, bool paused)
    : run_(std::move(run)), path_(std::make_unique<detail::ThinnedPath>()), paused_(paused) {}

ViewBoard::~ViewBoard() = default;

void ViewBoard::note(double t_s, const Eigen::Vector3d& p_world_body) {
  const std::lock_guard lock(mutex_);
  path_->add(t_s, p_world_body);
}

bool ViewBoard::takes_frames(const Viewer& viewer) const {
  return !viewer.acknowledges || viewer.sent < viewer.shown + kUnanswered;
}

bool ViewBoard::due() const {
  const std::lock_guard lock(mutex_);
  const bool awaited = std::any_of(viewers_.begin(), viewers_.end(),
                                   [this](const auto& viewer) { return takes_frames(viewer.second); });
  return paused_ || Clock::now() - last_published_ >= (awaited ? kWatchedPeriod : kUnwatchedPeriod);
}

void ViewBoard::publish(ViewFrame frame) {
  auto encoded = std::make_shared<detail::EncodedFrame>();
  encoded->frame = std::move(frame);
  {
    const std::lock_guard lock(mutex_);
    encoded->sequence = ++sequence_;
    latest_ = std::move(encoded);
    last_published_ = Clock::now();
  }
  changed_.notify_all();
}

bool ViewBoard::must_hold(double t_s) {
  if (closed_) return false;
  if (paused_) {
    if (steps_ == 0) return true;
    --steps_;
    return false;
  }
  if (!in_time_ || viewers_.empty()) {
    anchor_.reset();
    return false;
  }
  if (!anchor_) {
    anchor_.emplace(t_s, Clock::now());
  }
  return Clock::now() - anchor_->second < std::chrono::duration<double>(t_s - anchor_->first);
}

void ViewBoard::hold(double t_s, const std::function<bool()>& stop,
                     const std::function<void()>& publish_now) {
  std::unique_lock lock(mutex_);
  if (!must_hold(t_s)) return;
  const auto begin = Clock::now();
  bool published = false;
  do {
    if (paused_ && !published && publish_now) {
      lock.unlock();
      publish_now();
      lock.lock();
      published = true;
      continue;  // what was asked meanwhile
    }
    if (stop && stop()) break;
    changed_.wait_for(lock, paused_ ? 100ms : 5ms);
  } while (must_hold(t_s));
  held_ += Clock::now() - begin;
}

void ViewBoard::finish(const std::string& message) {
  {
    const std::lock_guard lock(mutex_);
    finished_ = true;
    end_message_ = message;
  }
  changed_.notify_all();
}

double ViewBoard::held_s() const {
  const std::lock_guard lock(mutex_);
  return std::chrono::duration<double>(held_).count();
}

std::size_t ViewBoard::viewers() const {
  const std::lock_guard lock(mutex_);
  return viewers_.size();
}

bool ViewBoard::dismissed() const {
  const std::lock_guard lock(mutex_);
  return dismissed_;
}

bool ViewBoard::told_all() const {
  const std::lock_guard lock(mutex_);
  return std::all_of(viewers_.begin(), viewers_.end(),
                     [](const auto& viewer) { return viewer.second.saw_end; });
}

std::uint64_t ViewBoard::enter(bool acknowledges) {
  const std::lock_guard lock(mutex_);
  if (viewers_.size() >= kMostViewers) return 0;
  Viewer viewer;
  viewer.acknowledges = acknowledges;
  viewers_.emplace(next_viewer_, viewer);
  return next_viewer_++;
}

void ViewBoard::leave(std::uint64_t viewer) {
  const std::lock_guard lock(mutex_);
  viewers_.erase(viewer);
}

std::string ViewBoard::next(std::uint64_t name) {
  std::unique_lock lock(mutex_);
  Viewer& viewer = viewers_.at(name);
  if (!viewer.greeted) {
    viewer.greeted = true;
    viewer.control = control_version_;
    viewer.sent = viewer.shown = latest_ ? latest_->sequence - 1 : 0;
    return hello(name);
  }
  const auto has_frame = [&] {
    return latest_ && latest_->sequence > viewer.sent && (takes_frames(viewer) || finished_);
  };
  const auto has_news = [&] {
    return closed_ || viewer.control != control_version_ || has_frame() || (finished_ && !viewer.saw_end);
  };
  changed_.wait_for(lock, 1s, has_news);
  if (viewer.control != control_version_) {
    viewer.control = control_version_;
    return control_event();
  }
  if (has_frame()) {
    const std::shared_ptr<detail::EncodedFrame> frame = latest_;
    viewer.sent = frame->sequence;
    lock.unlock();
    return frame->event(run_.watch);
  }
  if (finished_ && !viewer.saw_end) {
    viewer.saw_end = true;
    return end_event();
  }
  return ":\n\n";
}

void ViewBoard::acknowledge(std::uint64_t name, std::uint64_t frame) {
  {
    const std::lock_guard lock(mutex_);
    const auto viewer = viewers_.find(name);
    if (viewer == viewers_.end()) return;
    viewer->second.shown = std::clamp(frame, viewer->second.shown, viewer->second.sent);
  }
  changed_.notify_all();
}

void ViewBoard::command(ViewCommand command) {
  {
    const std::lock_guard lock(mutex_);
    ++control_version_;
    anchor_.reset();
    switch (command) {
      case ViewCommand::kDismiss:
        dismissed_ = true;
        break;
      case ViewCommand::kStep:
        ++steps_;
        paused_ = true;
        break;
      default:
        steps_ = 0;
        paused_ = command == ViewCommand::kPause;
        in_time_ = command == ViewCommand::kRunInTime || (paused_ && in_time_);
    }
  }
  changed_.notify_all();
}

void ViewBoard::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  changed_.notify_all();
}

bool ViewBoard::closed() const {
  const std::lock_guard lock(mutex_);
  return closed_;
}

std::string ViewBoard::hello(std::uint64_t name) const {
  return detail::server_sent_event(
      "hello", detail::json_text(Json{{"viewer", name},
                                      {"run", Json::parse(detail::to_json(run_))},
                                      {"path", detail::to_base64(std::span<const float>(path_->values()))},
                                      {"paused", paused_},
                                      {"in_time", in_time_}}));
}

std::string ViewBoard::control_event() const {
  return detail::server_sent_event("control",
                                   detail::json_text(Json{{"paused", paused_}, {"in_time", in_time_}}));
}

std::string ViewBoard::end_event() const {
  return detail::server_sent_event(
      "end", detail::json_text(Json{{"message", end_message_},
                                    {"path", detail::to_base64(std::span<const float>(path_->values()))}}));
}

}  // namespace limber
