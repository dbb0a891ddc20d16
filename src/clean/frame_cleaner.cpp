// SPDX-License-Identifier: MIT
#include "limber/clean/frame_cleaner.hpp"

#include <stdexcept>
#include <utility>

#include "clean/exchanged_pictures.hpp"
#include "clean/late_right_images.hpp"
#include "clean/leaping_matches.hpp"
#include "clean/row_times.hpp"
#include "clean/stale_tracks.hpp"
#include "clean/still_points.hpp"
#include "clean/thin_points.hpp"

namespace limber {

namespace {

void leave_left_alone(StereoFrame& frame) {
  std::erase_if(frame.observations, [](StereoObservation& point) {
    point.in_cam1 = false;
    return !point.in_cam0;
  });
}

}  // namespace

struct FrameCleaner::Steps {
  detail::ExchangedPictures exchanged;
  detail::StaleTracks stale;
  detail::LateRightImages late;
  detail::LeapingMatches leaping;
  detail::StillPoints still;
  detail::PointThinner thinner;
  detail::RowTimes rows;
};

FrameCleaner::FrameCleaner(const StereoCalibration& assumed, const CleaningOptions& options)
    : options_(options),
      steps_(new Steps{{},
                       {},
                       {},
                       detail::LeapingMatches(assumed),
                       detail::StillPoints(assumed),
                       detail::PointThinner(assumed, options.max_points),
                       detail::RowTimes(assumed)}) {
  if (options.max_points == 0) {
    throw std::invalid_argument("cleaning: expected at least one point a frame");
  }
}

FrameCleaner::~FrameCleaner() = default;

StereoFrame FrameCleaner::clean(StereoFrame frame) {
  ++report_.frames;
  report_.put_back_frames += frame.put_back ? 1 : 0;
  if (options_.clean) {
    if (steps_->exchanged.is_exchanged(frame)) {
      ++report_.exchanged_frames;
      return {frame.t_ns, {}};
    }
    const std::size_t stale = steps_->stale.end(frame);
    report_.stale_frames += stale > 0 ? 1 : 0;
    report_.stale_points += stale;
    if (steps_->late.lag(frame) > 0) {
      ++report_.late_frames;
      leave_left_alone(frame);
    }
    const auto leaps = steps_->leaping.end(frame);
    report_.leapt_matches += leaps.lost;
    report_.rig_jumps += leaps.rig_jumped ? 1 : 0;
  }
  if (options_.still_points) {
    frame.withdrawn = steps_->still.end(frame);
    report_.still_tracks += frame.withdrawn.size();
  }
  const std::size_t thinned = steps_->thinner.thin(frame);
  report_.thinned_frames += thinned > 0 ? 1 : 0;
  report_.thinned_points += thinned;
  if (options_.refer_to_stamp) {
    report_.waiting_points += steps_->rows.refer_to_stamp(frame);
  }
  return frame;
}

std::vector<std::string> in_words(const CleaningReport& report) {
  const std::string of_frames = " of " + std::to_string(report.frames) + " frames";
  std::vector<std::string> out;
  if (report.exchanged_frames > 0) {
    out.push_back("in " + std::to_string(report.exchanged_frames) + of_frames +
                  " the left and the right image are exchanged: their points are not used");
  }
  if (report.put_back_frames > 0) {
    out.push_back("in " + std::to_string(report.put_back_frames) + of_frames +
                  " the left and the right image were exchanged: put back");
  }
  if (report.stale_points > 0) {
    out.push_back("in " + std::to_string(report.stale_frames) + of_frames +
                  " the old points stand on the pixels of the frame before, to the last digit: " +
                  std::to_string(report.stale_points) + " points are taken for new ones from there on");
  }
  if (report.late_frames > 0) {
    out.push_back(
        "in " + std::to_string(report.late_frames) + of_frames +
        " the right image is that of an earlier frame, or may be: its points lie where the left ones "
        "were by then, and are not used");
  }
  if (report.still_tracks > 0) {
    out.push_back(std::to_string(report.still_tracks) +
                  " points stand still in the left image while the view turns (dirt on the lens, the vehicle "
                  "itself): they are not used");
  }
  if (report.leapt_matches > 0) {
    out.push_back(
        "the right pixels of " + std::to_string(report.leapt_matches) +
        " points leap, most of a frame at once, by more than depth can change from one frame to the "
        "next: they are not used until they are back, within half a second");
  }
  if (report.rig_jumps > 0) {
    out.push_back("in " + std::to_string(report.rig_jumps) + of_frames +
                  " the right pixels leap as one jump of the rig would have them: nothing was removed");
  }
  if (report.thinned_points > 0) {
    out.push_back(std::to_string(report.thinned_frames) + of_frames +
                  " hold more points than --max-points: " + std::to_string(report.thinned_points) +
                  " sightings are left out, evenly over the image");
  }
  return out;
}

}  // namespace limber
