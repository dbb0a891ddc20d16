// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "limber/initialize/inertial_evidence.hpp"
#include "limber/run/run_recording.hpp"

/// @file
/// Whether images and IMU contradict what is taken for exact between them: by the last 30 s of a run.
namespace limber {

/// A clock between cameras and IMU that is off by less is not mentioned [s]: all else is asked beside one.
inline constexpr double kLeastClock = 3e-3;

/// One factor's offset, if it is that factor and such a clock alone.
struct InertialOffset {
  /// whose
  InertialFactor of = InertialFactor::kMountTurn;
  /// True minus assumed, in body axes, without what the motion hardly tells; of scales and clocks x alone.
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  double sigma = 0.0;  ///< of its length
  /// How much better it explains the inputs: chi-square over degrees of freedom, in the noise that they show
  /// beside all offsets. Where there are several stretches, without the one that says most of it.
  double sureness = 0.0;
};

/// What the stretches of a run say.
struct InertialCheck {
  std::size_t stretches = 0;    ///< that told something
  std::size_t unexplained = 0;  ///< of which no motion near the run's fits images and inputs
  bool contradicted = false;  ///< in each of them the run found that images and inputs contradict each other
  ImuNoiseFactors learned{};  ///< how noisy the run took the IMU for, over what was stated
  std::vector<InertialOffset> offsets{};  ///< of each factor; none where no stretch tells
};

/// @brief Asks stretches of five seconds (inertial_evidence), from the states that the run found; those in
/// which images and inputs contradicted each other only if that is so in all.
/// @return nothing without an IMU, or without frames that were kept (RunRecord::last_frames)
[[nodiscard]] std::optional<InertialCheck> check_inertial(const Recording& recording,
                                                          const RunOptions& options, const RunRecord& record);

}  // namespace limber
