// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "limber/bags/bag_contents.hpp"

namespace limber {

/// Which topic of a bag is what. Empty: none, or not said.
struct BagTopics {
  std::string left, right;  ///< images
  /// angular rates and specific forces of the body
  std::string imu;
  std::string odometry;  ///< velocities of the body
  std::string truth;     ///< poses of the body, for evaluation only

  /// Whether every role has the same topic.
  bool operator==(const BagTopics&) const = default;
};

/// @brief "left=/cam0/image_raw,right=/cam1/image_raw,imu=/imu0", also odometry= and truth=.
/// @throws std::invalid_argument that says what was expected
[[nodiscard]] BagTopics parse_bag_topics(std::string_view text);

/// The same as text, without what is empty.
[[nodiscard]] std::string format_bag_topics(const BagTopics& topics);

/// Topics as their names and types suggest them.
struct TopicProposal {
  BagTopics topics;                ///< empty where nothing fits
  std::vector<std::string> notes;  ///< where there was a choice, in plain words
};

/// @brief Left and right by names that differ in left/right, 0/1 or 1/2 (raw images before compressed ones,
/// depth never), the IMU with rates and accelerations, poses named truth, gt, vicon, mocap or the like; body
/// velocities only where there is no IMU.
[[nodiscard]] TopicProposal propose_topics(const BagContents& contents);

}  // namespace limber
