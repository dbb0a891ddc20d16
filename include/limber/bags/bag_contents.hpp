// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "limber/bags/bag_file.hpp"
#include "limber/bags/messages.hpp"
#include "limber/core/time.hpp"

namespace limber {

/// One topic of a bag, all but its pixels. The vectors are in the order of the file, one entry a readable
/// message with a stamp.
struct BagStream {
  /// as the bag describes it
  BagTopic topic;
  /// what its type says it holds
  MessageKind kind = MessageKind::kOther;
  std::size_t messages = 0;               ///< readable or not
  std::size_t unreadable = 0;             ///< not what their type says, or with numbers that are not finite
  std::size_t unstamped = 0;              ///< of time 0 between others: their driver has not stamped them
  std::vector<std::int64_t> recorded_ns;  ///< bag times
  std::vector<std::int64_t> stamps_ns;    ///< of the headers; bag times where `stamped` is false
  bool stamped = true;  ///< false: of a type that limber does not read, or all stamps are zero

  // By kind; the other ones are empty.
  /// of images: the first one, or the first of another form if most are of that
  std::optional<ImageHeader> first_image;
  std::size_t other_images = 0;  ///< of another size or encoding than it
  std::vector<BagPlace> places;  ///< of images
  /// kImu
  std::vector<ImuMessage> imu;
  /// kPose and kOdometry: T_world_body
  std::vector<StampedPose> poses;
  /// kTwist and kOdometry: velocities in the frame of the body
  std::vector<OdometrySample> twists;
};

/// What a scan of a bag found.
struct BagContents {
  /// as BagFile::format
  std::string format;
  /// in the order of their first appearance
  std::vector<BagStream> streams;
  std::vector<std::string> damages;  ///< what could not be read, and where
  bool whole = true;                 ///< nothing of what was written is missing, see BagFile::is_whole
};

/// @brief Walks through a bag once and takes everything but the pixels.
/// @param wanted  topics that are taken; the others are counted only. Empty: all
/// @param progress  told the messages so far, now and then; may be empty
[[nodiscard]] BagContents scan_bag(BagFile& bag, const std::function<bool(const BagTopic&)>& wanted = {},
                                   const std::function<void(std::size_t)>& progress = {});

/// What the times of a stream say.
struct Timing {
  /// times
  std::size_t count = 0;
  std::int64_t first_ns = 0, last_ns = 0;  ///< smallest and largest
  double median_interval_s = 0.0;          ///< 0 for fewer than two
  std::size_t gaps = 0;                    ///< intervals longer than 1.5 medians
  double longest_gap_s = 0.0;              ///< the longest interval
  std::int64_t longest_gap_at_ns = 0;      ///< where it begins
  std::size_t backward = 0;                ///< times that lie before an earlier one
  /// from one time to the next in the file [s]; 0: none
  double largest_step_back_s = 0.0;
  std::int64_t stepped_back_at_ns = 0;  ///< the time before that step
  std::size_t repeated = 0;             ///< the same time again

  /// From the smallest to the largest time [s].
  [[nodiscard]] double duration_s() const { return seconds_between(first_ns, last_ns); }
  /// One over the median interval [Hz]; 0 for fewer than two times.
  [[nodiscard]] double rate_hz() const { return median_interval_s > 0.0 ? 1.0 / median_interval_s : 0.0; }
};
/// Of times in the order of the file.
[[nodiscard]] Timing timing_of(const std::vector<std::int64_t>& t_ns);

/// Left and right images that belong together: indices into two lists of times.
struct PairedTimes {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;  ///< in order of time
  double median_difference_s = 0.0;                        ///< right minus left
  double spread_s = 0.0;  ///< largest distance of a difference from the median
};
/// @brief Each left time with the nearest right one, at most a third of the left's interval (and 20 ms) away.
/// @param left,right  increasing
[[nodiscard]] PairedTimes pair_times(const std::vector<std::int64_t>& left,
                                     const std::vector<std::int64_t>& right);

}  // namespace limber
