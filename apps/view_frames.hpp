// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "limber/run/run_recording.hpp"
#include "limber/view/view_frame.hpp"

namespace limber::app {

/// What a page shows of a recording's run at all.
[[nodiscard]] ViewRun view_run_of(const Recording& recording, const RunOptions& options);

/// How a page gets its images.
struct ViewImageSize {
  int most_width = 1000;  ///< [px]
  int jpeg_quality = 75;
};

/// Turns what a run reports into what a page shows.
class ViewFrames {
 public:
  /// @param recording  must outlive this
  /// @param frontend   what is known of the front end so far; null for matched points
  ViewFrames(const Recording& recording, std::shared_ptr<const FrontendRecord> frontend);

  /// Every frame, in order, before anything else is asked of it.
  void take(const ObservedFrame& frame);

  /// Of the frame taken last: how many there were with it, its time since the first [s], whether the
  /// recording ends with it.
  [[nodiscard]] std::size_t number() const { return count_; }
  [[nodiscard]] double t_s() const { return t_s_; }
  [[nodiscard]] bool is_last() const { return is_last_; }
  /// The frame taken last. Its images are read again when they are asked for, since the front end has let
  /// them go.
  [[nodiscard]] ViewFrame view_of(const ObservedFrame& frame, const ViewImageSize& size) const;

  /// While a start from the sensors waits; its frames need not be taken.
  [[nodiscard]] ViewFrame view_of(const WaitingFrame& frame, const ViewImageSize& size) const;

 private:
  using PairOfImages = std::function<ViewImages(std::size_t, const ViewImageSize&)>;

  [[nodiscard]] std::vector<ViewStage> stages_of(std::int64_t t_ns) const;
  [[nodiscard]] std::function<ViewImages()> images_at(std::int64_t t_ns, const ViewImageSize& size) const;
  void keep_health(const FrameReport& report);

  const Recording& recording_;
  std::shared_ptr<const FrontendRecord> frontend_;
  PairOfImages images_;               // empty if there are none
  std::vector<FrameReport> windows_;  // the first frame, then one per report of the calibration
  std::size_t count_ = 0;
  std::int64_t begin_ns_ = 0;
  double t_s_ = 0.0;
  bool is_last_ = false;
};

}  // namespace limber::app
