// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber {

/// How long the left camera takes from the first row of an image to its last.
struct ReadoutTime {
  /// from the first row to the last [s], and its standard deviation
  double seconds = 0.0, sigma = 0.0;
  double explains = 0.0;  ///< share of the squared residuals with the assumed one that it explains, up to 1
};

/// @brief Watches the left camera's points for rows that are exposed one after the other.
///
/// A fifth of a second apart, two views of a rigid world fit one motion, whatever the depths. With rows of
/// their own times they do not where the camera turns faster in one view than in the other: each point is off
/// by its velocity times the delay of its row. The readout time is estimated beside the motion, pair by pair,
/// and then by all pairs together with Huber weights; sigma is the jackknife's over seconds of the recording.
/// Neither IMU, rig nor filter take part (stereo only gives depths to start from), so a rig that bends is no
/// readout. Translation alone says nothing: it moves points along their epipolar lines.
/// Velocities are as noisy as the pixels, which makes the readout time too small: by a sixth with white noise
/// of 0.5 px and slow turns, by 2 % with what a tracker gives.
class ReadoutWatch {
 public:
  /// @param assumed  the rig as it is believed to be
  explicit ReadoutWatch(const StereoCalibration& assumed);
  ~ReadoutWatch();
  /// The other one may then only be destroyed or assigned to.
  ReadoutWatch(ReadoutWatch&&) noexcept;
  /// The other one may then only be destroyed or assigned to.
  ReadoutWatch& operator=(ReadoutWatch&&) noexcept;

  /// @param frame  as the front end gives it, the next in time
  void add(const StereoFrame& frame);

  /// @return nothing with fewer than 50 pairs of frames in eight seconds that tell
  [[nodiscard]] std::optional<ReadoutTime> estimate() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Whether an estimate says that another readout time was assumed: 6 sigma and 2 ms off, and a hundredth of
/// the residuals explained by it.
[[nodiscard]] bool contradicts(const ReadoutTime& found, const StereoCalibration& assumed);

/// One sentence: how long, how sure, and what to do.
[[nodiscard]] std::string in_words(const ReadoutTime& found, const StereoCalibration& assumed);

}  // namespace limber
