// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <unordered_set>
#include <vector>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

/// What stands between a front end and the navigator: the same for every source of frames.
namespace limber {

/// What a cleaner looks for, and the most points that it leaves in a frame.
struct CleaningOptions {
  /// Exchanged and late images are not used, nor matches that leapt; tracks that were not tracked are ended.
  /// What a jump of the rig explains never is.
  bool clean = true;
  /// Points that go with the camera are ended. Apart, as mistakes are looked for in frames that are else as
  /// they came.
  bool still_points = true;
  /// Points of a frame beyond that many are left out, evenly over the image: the cost of a frame grows with
  /// the cube of their number. >= 1
  std::size_t max_points = 500;
  /// Pixels are moved to where they were at the stamp, as readout_time_s of the calibration says. false: they
  /// are there already.
  bool refer_to_stamp = true;
};

/// What was taken out of the frames so far.
struct CleaningReport {
  /// that went through
  std::size_t frames = 0;
  std::size_t exchanged_frames = 0;                ///< whose points are not used
  std::size_t put_back_frames = 0;                 ///< whose images the front end has put back
  std::size_t stale_frames = 0, stale_points = 0;  ///< see FrameCleaner
  std::size_t late_frames = 0;    ///< whose right image is, or may be, an earlier one: not used
  std::size_t still_tracks = 0;   ///< that go with the camera
  std::size_t leapt_matches = 0;  ///< tracks whose right pixels leapt, and were not used then
  std::size_t rig_jumps = 0;  ///< frames that leap as one change of the rig has them leap: left as they are
  /// crowded frames, and what was left out of them
  std::size_t thinned_frames = 0, thinned_points = 0;
  std::size_t waiting_points =
      0;  ///< sightings left out: the first of a track whose rows have times of their own
};

/// Each thing that was done, as a sentence with numbers; none if nothing was.
[[nodiscard]] std::vector<std::string> in_words(const CleaningReport& report);

/// @brief Cleans one frame after another.
///
/// - Exchanged images: where the left pixels go on from the right ones of the last frame that was not
///   exchanged, and these from the left ones, the frame loses its points; for a second at most. Any rig.
/// - Stale tracks: where every point that a frame shares with the one before stands on the very same pixels,
///   noise and all, the front end has handed out the old positions once more; what it follows from there on
///   is other texture. Such points are taken out of that frame and get new ids afterwards. Not while at least
///   half of the frames so far are so: a rig that stands still in a world without noise.
/// - Late right images: where the right pixels of most points stand where the left ones of one of the last
///   three frames would have them, to twice their usual scatter, and not where those of this frame do, by
///   four times that, the right image is of the earlier frame. The frame loses its right pixels, and so do
///   the next ones until they fit again. Where a jump of the rig would have them there, too, they wait until
///   the image moves on otherwise, which tells, or for five seconds: then it was a jump. Images that are all
///   late, from the first on, do not show; nor do frames that hardly differ.
/// - Still points: dirt on the lens, the vehicle itself. A track that stays within 2.5 px in the left image,
///   while the turn of the view, as the other points have it, would have taken its bearing by 25 px or more,
///   and still does when that has grown by half, ends, and is withdrawn from the frames before
///   (StereoFrame::withdrawn). Of the world such are points on the axis of a circle about them alone, and
///   things that go with the rig, which help no more.
/// - Leaping matches: from one frame to the next the parallax between the cameras changes as the depth does,
///   by a fraction. Where that of more than half of the points grows or shrinks by more than a factor of 1.5
///   within half a second, the front end has lost the right image, and the points that leapt go on in the
///   left one alone until they are back where they were, within half a second; unless one change of theta
///   explains the leap of (nearly) all points: then the rig has jumped, which is the health monitor's
///   business, and nothing is removed.
/// - Thinning: of more than max_points those that were kept before stay, and the free places go to the
///   emptiest cells of a grid over the left image (the right one for points that the left does not see).
/// - Rows that are exposed one after the other (readout_time_s): a pixel goes to where its point was at the
///   stamp, on the parabola through its last three views, each at the time of its own row; on a line through
///   two. The first view of a track says nothing of its motion and is left out. A right pixel that is new
///   moves as the left one does, and the reverse.
class FrameCleaner {
 public:
  /// @throws std::invalid_argument unless a frame may have a point.
  /// @param assumed  the rig as it is believed to be
  FrameCleaner(const StereoCalibration& assumed, const CleaningOptions& options);
  ~FrameCleaner();
  FrameCleaner(const FrameCleaner&) = delete;
  FrameCleaner& operator=(const FrameCleaner&) = delete;

  /// @param frame  the next one in time
  [[nodiscard]] StereoFrame clean(StereoFrame frame);
  /// Counts since the construction.
  [[nodiscard]] const CleaningReport& report() const { return report_; }

 private:
  struct Steps;
  CleaningOptions options_;
  CleaningReport report_;
  std::unique_ptr<Steps> steps_;
};

}  // namespace limber
