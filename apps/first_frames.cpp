// SPDX-License-Identifier: MIT
#include "first_frames.hpp"

#include <limits>
#include <utility>

#include "limber/clean/frame_cleaner.hpp"
#include "limber/diagnose/calibration_mistakes.hpp"
#include "limber/diagnose/imu_mistakes.hpp"

namespace limber::app {
namespace {

constexpr std::size_t kFirstLook = 100;  // frames

}  // namespace

std::vector<StereoFrame> at_stamps(std::vector<StereoFrame> frames, const StereoCalibration& assumed) {
  FrameCleaner rows(assumed, {.clean = false, .max_points = std::numeric_limits<std::size_t>::max()});
  std::vector<StereoFrame> out;
  for (StereoFrame& frame : frames) {
    StereoFrame next = rows.clean(std::move(frame));
    withdraw_from(out, next);
    out.push_back(std::move(next));
  }
  return out;
}

FirstFrames::FirstFrames(const Recording& recording, StereoCalibration assumed, double gravity,
                         FrameSource source, Say say)
    : recording_(recording),
      assumed_(std::move(assumed)),
      gravity_(gravity),
      source_(std::move(source)),
      say_(std::move(say)) {}

std::string FirstFrames::in_words(const std::string& mistake) {
  return "looks like a mistake: " + mistake + ". Mend it and run again";
}

StereoFrame FirstFrames::operator()(std::size_t n) {
  StereoFrame frame = source_(n);
  if (!over_) {
    seen_.push_back(frame);
    if (seen_.size() == kFirstLook) look(at_stamps(seen_, assumed_));
    if (seen_.size() == kLastLook) look_again();
  }
  return frame;
}

void FirstFrames::say(const std::vector<std::string>& found) {
  for (const std::string& mistake : found) {
    mistakes_.push_back(in_words(mistake));
    say_(mistakes_.back());
  }
  over_ = over_ || !found.empty();
}

void FirstFrames::look(const std::vector<StereoFrame>& frames) {
  std::vector<std::string> found = imu_mistakes(assumed_, frames, recording_.imu, gravity_);
  if (const auto misplaced = placement_mistake(assumed_, frames)) {
    found.insert(found.begin(), *misplaced);
  }
  gross_.insert(gross_.end(), found.begin(), found.end());
  say(found);
}

void FirstFrames::look_again() {
  if (over_) return;
  const std::vector<StereoFrame> frames = at_stamps(std::exchange(seen_, {}), assumed_);
  look(frames);
  if (!over_) {
    offsets_ = sensor_offsets(assumed_, frames, recording_.imu);
    SensorOffsets but_clock_of_imu = offsets_;
    but_clock_of_imu.cameras.reset();
    say(offset_mistakes(but_clock_of_imu));
  }
  over_ = true;
}

void FirstFrames::finish(const RunRecord* record) {
  look_again();
  if (std::exchange(finished_, true)) return;
  offsets_.corrected_cameras = record != nullptr ? corrected_clock(*record) : 0.0;
  if (const auto mistake = imu_clock_mistake(offsets_)) {
    say({*mistake});
  }
}

}  // namespace limber::app
