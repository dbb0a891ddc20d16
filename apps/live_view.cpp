// SPDX-License-Identifier: MIT
#include "live_view.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <optional>
#include <thread>

#include "interrupt.hpp"
#include "limber/view/view_recorder.hpp"
#include "limber/view/view_server.hpp"
#include "messages.hpp"
#include "validators.hpp"
#include "view_frames.hpp"

namespace limber::app {
namespace {

using namespace std::chrono_literals;

constexpr ViewImageSize kLiveImages{}, kRecordedImages{.most_width = 480, .jpeg_quality = 60};

/// Leaves every frame on a board that a server shows to pages, and some with a recorder.
class ServedView : public LiveView {
 public:
  ServedView(const ViewArguments& arguments, const Recording& recording, const RunOptions& options,
             std::shared_ptr<const FrontendRecord> frontend, std::function<bool()> stop);
  ~ServedView() override;

  void show(const ObservedFrame& frame) override;
  void show(const WaitingFrame& frame) override;
  [[nodiscard]] double held_s() const override { return board_.held_s(); }
  void finish(const std::string& message) override;
  void stay() override;

 private:
  template <typename Frame>
  void serve(const Frame& frame, double t_s, bool is_last);

  const ViewArguments arguments_;
  std::function<bool()> stop_;
  ViewFrames frames_;
  bool finished_ = false;
  ViewBoard board_;
  std::optional<ViewServer> server_;
  std::optional<ViewRecorder> recorder_;
};

ServedView::ServedView(const ViewArguments& arguments, const Recording& recording, const RunOptions& options,
                       std::shared_ptr<const FrontendRecord> frontend, std::function<bool()> stop)
    : arguments_(arguments),
      stop_(std::move(stop)),
      frames_(recording, std::move(frontend)),
      board_(view_run_of(recording, options), arguments.paused) {
  if (arguments.live) {
    server_.emplace(board_, arguments.port);
    print_note("live view: " + server_->url());
  }
  if (!arguments.page.empty()) recorder_.emplace(view_run_of(recording, options));
}

void ServedView::show(const ObservedFrame& frame) {
  frames_.take(frame);
  const Eigen::Vector3d& p = frame.row.T_world_body.p;
  if (recorder_) {
    recorder_->note(frames_.t_s(), p);
    if (recorder_->wants(frames_.number()) || frames_.is_last())
      recorder_->add(frames_.view_of(frame, kRecordedImages));
  }
  if (!server_) return;
  board_.note(frames_.t_s(), p);
  serve(frame, frames_.t_s(), frames_.is_last());
}

void ServedView::show(const WaitingFrame& frame) {
  if (server_) serve(frame, frame.report.waited_s, false);
}

template <typename Frame>
void ServedView::serve(const Frame& frame, double t_s, bool is_last) {
  bool published = false;
  const auto publish = [&] {
    if (!published) board_.publish(frames_.view_of(frame, kLiveImages));
    published = true;
  };
  if (board_.due() || is_last) publish();
  board_.hold(t_s, stop_, publish);
}

void ServedView::finish(const std::string& message) {
  finished_ = true;
  board_.finish(message);
  if (recorder_) {
    recorder_->write(arguments_.page, message);
    print_note("written: " + arguments_.page.string());
  }
}

void ServedView::stay() {
  const bool on_terminal = isatty(fileno(stderr)) == 1;
  if (!server_ || arguments_.exit_at_end || (!on_terminal && board_.viewers() == 0)) return;
  print_note(fmt::format("the live view stays at {} until {}", server_->url(),
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
  for (int k = 0; k < 20 && server_ && finished_ && !board_.told_all(); ++k) {
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
  command
      .add_option("--view-out", arguments.page,
                  "Write such a page, HTML, with up to 240 frames in it: it plays without a server")
      ->check(not_empty());
}

std::unique_ptr<LiveView> open_live_view(const ViewArguments& arguments, const Recording& recording,
                                         const RunOptions& options,
                                         std::shared_ptr<const FrontendRecord> frontend,
                                         std::function<bool()> stop) {
  if (!arguments.live && arguments.page.empty()) return nullptr;
  return std::make_unique<ServedView>(arguments, recording, options, std::move(frontend), std::move(stop));
}

}  // namespace limber::app
