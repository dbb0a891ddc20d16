// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "limber/view/view_frame.hpp"

namespace limber {

namespace detail {
struct EncodedFrame;
class ThinnedPath;
}  // namespace detail

/// What a page can ask of a run.
enum class ViewCommand : std::uint8_t {
  kPause,
  kStep,       ///< one frame, then pause
  kRun,        ///< as fast as it goes
  kRunInTime,  ///< not faster than the recording, as long as a page looks on
  kDismiss     ///< the page is not needed any more
};

/// @brief Between a run, which leaves its latest frame, and pages, which take it. Threads on both sides.
///
/// Holds one frame and a path of a few thousand places, however long the run. Nobody waits for a page: what
/// comes while a page is busy with two frames is left out for that page.
class ViewBoard {
 public:
  /// @param paused  the run stops after its first frame, until a page says otherwise
  explicit ViewBoard(ViewRun run, bool paused = false);
  ~ViewBoard();
  ViewBoard(const ViewBoard&) = delete;
  ViewBoard& operator=(const ViewBoard&) = delete;

  // The run's side.

  /// Every frame: where it was.
  void note(double t_s, const Eigen::Vector3d& p_world_body);
  /// Whether a frame should be published now: at most 25 a second, and 2 if no page can take them.
  [[nodiscard]] bool due() const;
  /// The latest frame, for the pages that are ready for one.
  void publish(ViewFrame frame);
  /// @brief Waits as long as a page has paused the run, or it would get ahead of the recording's time.
  /// @param stop     asked ten times a second: true ends the wait; may be empty
  /// @param publish_now  called before a pause begins, so that the page shows where the run stands
  void hold(double t_s, const std::function<bool()>& stop, const std::function<void()>& publish_now);
  /// The run is over; `message` says how.
  void finish(const std::string& message);
  /// Time spent in hold [s].
  [[nodiscard]] double held_s() const;
  /// Pages that look on.
  [[nodiscard]] std::size_t viewers() const;
  /// A page has asked for the end.
  [[nodiscard]] bool dismissed() const;
  /// Every page knows that the run is over.
  [[nodiscard]] bool told_all() const;

  // The pages' side.

  /// @param acknowledges  the page says when it has shown a frame
  /// @return the page's name here; 0 if there are too many
  [[nodiscard]] std::uint64_t enter(bool acknowledges);
  /// The page does not look on any more.
  void leave(std::uint64_t viewer);
  /// What to send the page next, as server-sent events: `hello` first, then `frame`, `control` and `end`.
  /// Waits a second at most; then, and after close(), it is a comment.
  [[nodiscard]] std::string next(std::uint64_t viewer);
  /// The page has shown a frame and is ready for another.
  /// @param frame  its ViewFrame::number
  void acknowledge(std::uint64_t viewer, std::uint64_t frame);
  /// What a page asks of the run; the last word counts.
  void command(ViewCommand command);
  /// Ends every wait.
  void close();
  /// Nothing will be sent any more.
  [[nodiscard]] bool closed() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Viewer {
    bool acknowledges = false, greeted = false, saw_end = false;
    std::uint64_t sent = 0, shown = 0;  // sequence numbers of frames
    std::uint64_t control = 0;          // version
  };

  [[nodiscard]] bool takes_frames(const Viewer& viewer) const;
  [[nodiscard]] bool must_hold(double t_s);
  [[nodiscard]] std::string hello(std::uint64_t name) const;
  [[nodiscard]] std::string control_event() const;
  [[nodiscard]] std::string end_event() const;

  const ViewRun run_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::unique_ptr<detail::ThinnedPath> path_;
  std::shared_ptr<detail::EncodedFrame> latest_;
  std::uint64_t sequence_ = 0;
  Clock::time_point last_published_{};
  std::map<std::uint64_t, Viewer> viewers_;
  std::uint64_t next_viewer_ = 1;
  std::uint64_t control_version_ = 1;
  bool paused_, in_time_ = false, closed_ = false, finished_ = false, dismissed_ = false;
  std::size_t steps_ = 0;
  // Where recording's and wall clock's time were set equal.
  std::optional<std::pair<double, Clock::time_point>> anchor_;
  Clock::duration held_{};
  std::string end_message_;
};

}  // namespace limber
