// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "limber/sensors/samples.hpp"
#include "limber/simulate/scenario.hpp"

/// What faults (fault.hpp) make of samples and frames.
namespace limber::detail {

/// The biases of `truth` with the steps of `faults`; directions are random. An IMU sample holds its bias.
void step_biases(const std::vector<Fault>& faults, std::uint64_t seed, std::uint64_t run,
                 std::vector<GroundTruthState>& truth);

/// What the IMU delivers instead of `samples`, which hold the bias steps already.
void spoil_imu(const std::vector<Fault>& faults, std::uint64_t seed, std::uint64_t run,
               std::vector<ImuSample>& samples);

/// How much older than the left image the right one at `t_ns` is [ns].
[[nodiscard]] std::int64_t right_delay(const std::vector<Fault>& faults, std::int64_t t_ns);

/// Frames that are repeated or missing.
void spoil_frames(const std::vector<Fault>& faults, std::vector<StereoFrame>& frames);

}  // namespace limber::detail
