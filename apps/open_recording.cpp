// SPDX-License-Identifier: MIT
#include "open_recording.hpp"

#include <CLI/CLI.hpp>
#include <optional>
#include <stdexcept>

#include "limber/bags/read_bag.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/datasets/replace_calibration.hpp"

namespace limber::app {
namespace {

std::optional<ImageKind> images_said(const RecordingFiles& files) {
  if (files.images.empty()) {
    return std::nullopt;
  }
  return files.images == "raw" ? ImageKind::kRaw : ImageKind::kRectified;
}

/// A bag, whose calibration comes from a file.
Recording open_bag_recording(const RecordingFiles& files) {
  if (files.calibration.empty()) {
    throw CLI::ValidationError("--calib",
                               "a bag needs it: the calibration, for example Kalibr's camchain.yaml");
  }
  const RigFile rig = read_rig_file(files.calibration, images_said(files));
  const BagTopics topics = files.topics.empty() ? BagTopics{} : parse_bag_topics(files.topics);
  Recording recording = limber::read_bag(files.dataset, rig.calibration, rig.imu_noise, topics);
  recording.notes.insert(recording.notes.end(), rig.notes.begin(), rig.notes.end());
  return recording;
}

}  // namespace

Recording open_recording(const RecordingFiles& files) {
  const bool bag = is_bag(files.dataset);
  if (!bag && !files.topics.empty()) {
    throw CLI::ValidationError("--topics", "bags have topics, " + files.dataset.string() + " is none");
  }
  Recording recording = bag ? open_bag_recording(files) : limber::read_recording(files.dataset);
  if (!bag && !files.calibration.empty()) {
    const std::optional<ImageKind> said = images_said(files);
    const RigFile rig = read_rig_file(files.calibration, said.value_or(image_kind(recording.calibration)));
    try {
      replace_calibration(recording, rig, said);
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(files.calibration.string() + ": " + error.what());
    }
  }
  if (!files.imu.empty()) {
    recording.imu_noise = read_kalibr_imu(files.imu);
  }
  if (files.readout_time) {
    recording.calibration.readout_time_s.fill(*files.readout_time);
  }
  return recording;
}

}  // namespace limber::app
