// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "limber/bags/bag_topics.hpp"
#include "limber/datasets/recording.hpp"

namespace limber {

/// One stream of a recording: a topic of a bag, or a sensor's folder.
struct StreamInfo {
  /// name: topic or folder; type: of its messages or files
  std::string name, type;
  std::string role;     ///< left, right, imu, odometry, truth, tracks; empty for what is not used
  Timing timing;        ///< of the headers' stamps
  bool stamped = true;  ///< false: times of recording
  std::optional<double> median_delay_s;  ///< time of recording minus stamp
  /// unreadable: those of them that are not what their type says; unstamped: as in BagStream
  std::size_t messages = 0, unreadable = 0, unstamped = 0;
  std::size_t other_images = 0;  ///< of a topic of images, as in BagStream
  std::string images;            ///< "752 x 480 mono8", "png"; empty for other streams
};

/// How left and right images go together.
struct StereoInfo {
  /// images by how they found partners, see pair_times
  std::size_t pairs = 0, left_alone = 0, right_alone = 0;
  double median_difference_s = 0.0, spread_s = 0.0;  ///< of the stamps, right minus left
  /// Same stamps but for 1 ms: the cameras are triggered together.
  [[nodiscard]] bool synchronised() const { return pairs > 0 && spread_s < 1e-3; }
};

/// What is in a recording, and what it is good for.
struct RecordingInfo {
  /// as it was given
  std::filesystem::path path;
  /// BagContents::format, "track log" or what kind of folder it is
  std::string format;
  /// the recording's own; bags never bring one
  std::optional<StereoCalibration> calibration;
  /// in the order of the file, or of the folder
  std::vector<StreamInfo> streams;
  /// nothing unless there are left and right images
  std::optional<StereoInfo> stereo;
  BagTopics topics;                          ///< proposal; empty for folders
  std::shared_ptr<const ImageStore> images;  ///< the stereo pairs, to look at; null where there are none
  std::vector<std::string> possible;         ///< what can be done, as commands
  std::vector<std::string> missing;          ///< what cannot, and why
  /// what is strange, in plain words
  std::vector<std::string> notes;
};

/// @brief Looks through a bag, or a folder that read_recording takes.
/// @throws DataError as open_bag and read_recording
[[nodiscard]] RecordingInfo inspect(const std::filesystem::path& path,
                                    const std::function<void(std::size_t)>& progress = {});

}  // namespace limber
