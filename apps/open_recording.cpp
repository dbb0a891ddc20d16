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

/// What `act` finds wrong is said of the calibration's file.
template <typename Act>
void of_calibration(const RecordingFiles& files, const Act& act) {
  try {
    act();
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(files.calibration.string() + ": " + error.what());
  }
}

/// A bag, whose calibration comes from a file.
Recording open_bag_recording(const RecordingFiles& files) {
  if (files.calibration.empty()) {
    throw CLI::ValidationError("--calib",
                               "a bag needs it: the calibration, for example Kalibr's camchain.yaml");
  }
  const std::optional<ImageKind> said = images_said(files);
  const RigFile rig = read_rig_file(files.calibration, said);
  if (said) {
    of_calibration(files, [&] { require_calibration_of(rig, *said, WhoSays::kUser); });
  }
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
    of_calibration(files, [&] { replace_calibration(recording, rig, said); });
  }
  if (!files.imu.empty()) {
    if (recording.imu.empty()) {
      const std::string name = files.dataset.string();
      throw CLI::ValidationError(
          "--imu",
          name + (!bag ? " has no IMU"
                  : recording.calibration.body == BodyFrame::kCam0
                      ? ": the calibration does not place the cameras on an IMU (T_cam_imu), so that "
                        "none is used"
                      : ": no IMU is taken from it, limber info " + name + " lists its topics"));
    }
    recording.imu_noise = read_kalibr_imu(files.imu);
  }
  if (!files.for_images.empty() && recording.images.empty()) {
    throw CLI::ValidationError(files.for_images, files.dataset.string() + " holds matched points, no images");
  }
  if (files.readout_time) {
    recording.calibration.readout_time_s.fill(*files.readout_time);
  }
  return recording;
}

}  // namespace limber::app
