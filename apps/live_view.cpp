// SPDX-License-Identifier: MIT
#include "live_view.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <thread>
#include <unordered_set>

#include "interrupt.hpp"
#include "limber/core/time.hpp"
#include "limber/frontend/encode_jpeg.hpp"
#include "limber/view/view_server.hpp"
#include "messages.hpp"
#include "pair_reader.hpp"
#include "validators.hpp"

namespace limber::app {
namespace {

using namespace std::chrono_literals;

constexpr int kJpegQuality = 75, kMostWidth = 1000;

ViewRun run_of(const Recording& recording, const RunOptions& options) {
  return {recording.name, std::string(to_string(options.method)), frame_count(recording),
          set_up_run(recording, options).calibration, watch_options(options)};
}

std::int64_t last_frame_ns(const Recording& recording) {
  return recording.images.empty() ? recording.frames.back().t_ns : recording.images.back().t_ns;
}

/// Reads pairs again for who looks at them, which the front end has let go.
std::function<ViewImages(std::size_t)> images_of(const Recording& recording) {
  if (recording.images.empty()) return {};
  struct Shared {
    explicit Shared(const Recording& of) : reader(of) {}
    std::mutex mutex;
    PairReader reader;
  };
  auto shared = std::make_shared<Shared>(recording);
  return [shared](std::size_t pair) {
    const std::lock_guard lock(shared->mutex);
    const auto images = shared->reader.read(pair);
    return ViewImages{encode_jpeg(images[0].view(), kJpegQuality, kMostWidth),
                      encode_jpeg(images[1].view(), kJpegQuality, kMostWidth)};
  };
}

std::vector<ViewPoint> points_of(const ObservedFrame& frame) {
  std::unordered_set<std::int64_t> refused;
  for (const Refusal& refusal : frame.report.refused) {
    refused.insert(refusal.track_id);
  }
  const bool updated = frame.report.status == UpdateStatus::kUpdated;
  const Estimate& estimate = frame.navigator->estimate();
  std::vector<ViewPoint> out;
  for (const StereoObservation& seen : frame.frame->observations) {
    ViewPointFate fate = ViewPointFate::kOther;
    if (refused.contains(seen.track_id)) {
      fate = ViewPointFate::kRefused;
    } else if (updated && estimate.find(seen.track_id) != nullptr) {
      fate = ViewPointFate::kUsed;
    }
    out.push_back({seen, fate});
  }
  return out;
}

std::vector<ViewLandmark> map_of(const Estimate& estimate) {
  const std::vector<Eigen::Vector3d> positions = estimate.landmark_positions();
  std::vector<ViewLandmark> out;
  for (std::size_t k = 0; k < positions.size(); ++k) {
    if (positions[k].allFinite()) {  // not the points at infinity
      out.push_back({estimate.landmarks()[k].track_id, positions[k]});
    }
  }
  return out;
}

std::string status_of(const ObservedFrame& frame) {
  if (frame.navigator == nullptr) return "used up by the start";
  std::string text = to_string(frame.report.status);
  if (frame.report.inputs.status != InputStatus::kNotNeeded) {
    text += ", inputs " + to_string(frame.report.inputs.status);
  }
  return frame.report.reset ? text + ", began anew" : text;
}

/// Leaves every frame on a board that a server shows to pages.
class ServedView : public LiveView {
 public:
  ServedView(const ViewArguments& arguments, const Recording& recording, const RunOptions& options,
             std::shared_ptr<const FrontendRecord> frontend, std::function<bool()> stop);
  ~ServedView() override;

  void show(const ObservedFrame& frame) override;
  [[nodiscard]] double held_s() const override { return board_.held_s(); }
  void finish(const std::string& message) override;
  void stay() override;

 private:
  [[nodiscard]] ViewFrame view_of(const ObservedFrame& frame) const;
  [[nodiscard]] std::vector<ViewStage> stages_of(const ObservedFrame& frame) const;
  void keep_health(const FrameReport& report);

  const ViewArguments arguments_;
  const Recording& recording_;
  std::shared_ptr<const FrontendRecord> frontend_;
  std::function<bool()> stop_;
  std::function<ViewImages(std::size_t)> images_;  // of a pair; empty if there are none
  std::vector<FrameReport> windows_;               // the first frame, then one per report of the calibration
  std::size_t count_ = 0;
  std::int64_t begin_ns_ = 0;
  bool finished_ = false;
  ViewBoard board_;
  ViewServer server_;
};

ServedView::ServedView(const ViewArguments& arguments, const Recording& recording, const RunOptions& options,
                       std::shared_ptr<const FrontendRecord> frontend, std::function<bool()> stop)
    : arguments_(arguments),
      recording_(recording),
      frontend_(std::move(frontend)),
      stop_(std::move(stop)),
      images_(images_of(recording)),
      board_(run_of(recording, options), arguments.paused),
      server_(board_, arguments.port) {
  print_note("live view: " + server_.url());
}

void ServedView::keep_health(const FrameReport& report) {
  if (windows_.empty() || (report.calibration && report.calibration != windows_.back().calibration)) {
    FrameReport window;
    window.t_ns = report.t_ns;
    window.calibration = report.calibration;
    windows_.push_back(std::move(window));
  }
}

std::vector<ViewStage> ServedView::stages_of(const ObservedFrame& frame) const {
  std::vector<ViewStage> out;
  if (frontend_) {
    const auto& times = frontend_->t_ns;
    const auto at = std::lower_bound(times.begin(), times.end(), frame.row.t_ns);
    if (at != times.end() && *at == frame.row.t_ns) {
      const auto k = static_cast<std::size_t>(at - times.begin());
      out.push_back({"read images", frontend_->decode_ms[k]});
      out.push_back({"track points", frontend_->track_ms[k]});
    }
  }
  out.push_back({"filter", frame.filter_ms});
  return out;
}

ViewFrame ServedView::view_of(const ObservedFrame& frame) const {
  const std::int64_t t_ns = frame.row.t_ns;
  ViewFrame out;
  out.number = count_;
  out.t_s = seconds_between(begin_ns_, t_ns);
  out.T_world_body = frame.row.T_world_body;
  out.v_world_body = frame.row.v_world_body;
  if (frame.row.covariance) {
    out.sigma = frame.row.covariance->diagonal().cwiseMax(0.0).cwiseSqrt();
  }
  out.status = status_of(frame);
  out.stages = stages_of(frame);
  out.health = summarize_health(windows_);
  if (frame.navigator != nullptr) {
    out.points = points_of(frame);
    out.map = map_of(frame.navigator->estimate());
  }
  if (images_) {
    const auto& pairs = recording_.images;
    const auto pair = std::lower_bound(pairs.begin(), pairs.end(), t_ns,
                                       [](const ImagePair& a, std::int64_t t) { return a.t_ns < t; });
    if (pair != pairs.end() && pair->t_ns == t_ns) {
      out.images = [images = images_, n = static_cast<std::size_t>(pair - pairs.begin())] {
        return images(n);
      };
    }
  }
  return out;
}

void ServedView::show(const ObservedFrame& frame) {
  if (count_++ == 0) {
    begin_ns_ = frame.row.t_ns;
  }
  const double t_s = seconds_between(begin_ns_, frame.row.t_ns);
  board_.note(t_s, frame.row.T_world_body.p);
  keep_health(frame.report);
  bool published = false;
  const auto publish = [&] {
    if (!published) board_.publish(view_of(frame));
    published = true;
  };
  if (board_.due() || frame.row.t_ns == last_frame_ns(recording_)) publish();
  board_.hold(t_s, stop_, publish);
}

void ServedView::finish(const std::string& message) {
  finished_ = true;
  board_.finish(message);
}

void ServedView::stay() {
  const bool on_terminal = isatty(fileno(stderr)) == 1;
  if (arguments_.exit_at_end || (!on_terminal && board_.viewers() == 0)) return;
  print_note(fmt::format("the live view stays at {} until {}", server_.url(),
                         on_terminal ? "Ctrl-C" : "nobody looks at it"));
  constexpr auto kReload = 3s;  // a page that is loaded again is gone for a moment
  const Interrupt interrupt;
  auto seen = std::chrono::steady_clock::now();
  while (!Interrupt::asked() && !board_.dismissed() &&
         (on_terminal || std::chrono::steady_clock::now() - seen < kReload)) {
    if (board_.viewers() > 0) seen = std::chrono::steady_clock::now();
    std::this_thread::sleep_for(50ms);
  }
}

ServedView::~ServedView() {
  for (int k = 0; k < 20 && finished_ && !board_.told_all(); ++k) {
    std::this_thread::sleep_for(50ms);
  }
}

}  // namespace

void add_view_options(CLI::App& command, ViewArguments& arguments) {
  CLI::Option* view = command.add_flag(
      "--view", arguments.live, "Serve a page, on this computer alone, that shows the run while it works");
  command.add_option("--view-port", arguments.port, "Port of the page; 0: any that is free")
      ->check(whole_number(0, 65535))
      ->capture_default_str()
      ->needs(view);
  command
      .add_flag("--view-paused", arguments.paused,
                "Stop after the first frame, until the page says run or step")
      ->needs(view);
  command
      .add_flag(
          "--view-exit", arguments.exit_at_end,
          "End with the run; default: the page stays, on a terminal until Ctrl-C, else while it is open")
      ->needs(view);
}

std::unique_ptr<LiveView> open_live_view(const ViewArguments& arguments, const Recording& recording,
                                         const RunOptions& options,
                                         std::shared_ptr<const FrontendRecord> frontend,
                                         std::function<bool()> stop) {
  if (!arguments.live) return nullptr;
  return std::make_unique<ServedView>(arguments, recording, options, std::move(frontend), std::move(stop));
}

}  // namespace limber::app
