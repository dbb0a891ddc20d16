// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "limber/datasets/recording.hpp"
#include "limber/simulate/decalibration.hpp"

namespace limber {

/// The rig of a recording as it would be if its right camera moved after the recording was calibrated. What
/// bends is the rig that took the recording: truth.rig where that is known, else the calibration.
class BentRig {
 public:
  /// What of the signals is applied.
  enum class Parts {
    kAll,      ///< theta + delta(t)
    kRotation  ///< the right camera turns about its own centre, so that its images show it: ax, ay, az +
               ///< delta, and t_s = -R_s c with c its centre in cam0
  };

  /// @param recording  must outlive this; times of the signals start at its first frame
  /// @param seed       of random signals
  /// @throws std::invalid_argument as Decalibration, or if there is no frame
  BentRig(const Recording& recording, std::vector<DecalibrationSignal> signals, std::uint64_t seed,
          Parts parts);

  [[nodiscard]] RigParameters before(std::int64_t t_ns) const;  ///< the rig that took the recording
  [[nodiscard]] RigParameters after(std::int64_t t_ns) const;   ///< the bent one

  /// R with d_after = R d_before for the bearings of a point at infinity in cam1.
  [[nodiscard]] Eigen::Matrix3d turn_of_cam1(std::int64_t t_ns) const;

  /// The bent rig at every frame, at every jump between the first and the last one, and where it was known.
  [[nodiscard]] std::vector<TrueRig> truth() const;

 private:
  [[nodiscard]] RigParameters delta(std::int64_t t_ns) const;

  const Recording& recording_;
  Parts parts_;
  std::vector<std::int64_t> times_;  ///< of the frames
  Decalibration decalibration_;
};

/// Times of the stereo frames of a recording, matched points or images.
[[nodiscard]] std::vector<std::int64_t> frame_times(const Recording& recording);

}  // namespace limber
