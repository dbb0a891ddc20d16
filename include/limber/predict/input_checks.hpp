// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "limber/predict/input_buffer.hpp"
#include "limber/state/state.hpp"

namespace limber {

/// What can be wrong with a stream of input samples by itself.
enum class InputFault : std::uint8_t {
  kStuck,       ///< the same numbers again and again, from a stream that varied before: left out, a gap
  kSpike,       ///< one sample far from both neighbours: left out
  kSaturated,   ///< numbers at the end of the sensor's range: taken with more noise
  kImpossible,  ///< larger than any sensor can show: left out
  kLate         ///< older than the state: comes too late to be used, except as the newest that is known
};
inline constexpr std::size_t kInputFaults = 5;  ///< kinds of faults

/// Samples with each fault.
struct InputFaultCounts {
  /// by InputFault
  std::array<std::size_t, kInputFaults> count{};

  /// How many with that fault.
  [[nodiscard]] std::size_t operator[](InputFault fault) const {
    return count[static_cast<std::size_t>(fault)];
  }
  /// The same, to change it.
  std::size_t& operator[](InputFault fault) { return count[static_cast<std::size_t>(fault)]; }
  /// Whether there was a fault at all.
  [[nodiscard]] bool any() const;
};

/// What a sensor cannot show, and jumps that are worth a second look; per axis, of the angular and the
/// linear input.
struct InputLimits {
  /// [rad/s]; [m/s^2] of an IMU or [m/s] of odometry
  std::array<double, 2> impossible, jump, doubted_jump, saturation;
  bool rests_at_zero = false;  ///< a sensor without noise at rest, such as encoders of wheels
};
/// [rad/s], [m/s^2]: twice the widest MEMS ranges; jumps of 2 rad/s and 2 g in one sample, of a twentieth of
/// that more noise; nothing saturates below.
inline constexpr InputLimits kImuLimits = {{200.0, 10000.0}, {2.0, 20.0}, {0.1, 1.0}, {0.3, 12.0}};
/// [rad/s], [m/s]; small jumps of speeds are usual
inline constexpr InputLimits kOdometryLimits = {{200.0, 1000.0}, {2.0, 5.0}, {2.0, 5.0}, {0.3, 1.0}, true};

/// Of the samples that drive a motion model.
[[nodiscard]] constexpr const InputLimits& limits_of(MotionModel motion) {
  return motion == MotionModel::kOdometry ? kOdometryLimits : kImuLimits;
}

/// @brief Cheap checks of each sample against its neighbours, before it enters the buffer. Causal: a sample
/// that jumps is held back until the next one says whether it was a spike.
/// @note docs/faults.md
class InputChecks {
 public:
  /// @param limits  of the stream's sensor, see limits_of
  explicit InputChecks(const InputLimits& limits) : limits_(limits) {}

  /// Puts what may be used of the stream so far into the buffer.
  /// @throws std::invalid_argument if the time does not increase or a value is not finite
  void add(const InputSample& sample, InputBuffer& buffer);

  /// All samples so far were taken that much later [ns].
  void shift(std::int64_t by_ns);

  /// Counts since the last call.
  [[nodiscard]] InputFaultCounts take_counts();

 private:
  using Six = Eigen::Matrix<double, 6, 1>;
  using Ends = Eigen::Array<double, 3, 2>;  // of the axes, upwards and downwards
  static inline const Ends kNoPeaks = Ends::Zero();

  [[nodiscard]] bool is_stuck(const Six& value);
  [[nodiscard]] bool counts_steps() const;
  [[nodiscard]] bool jumps(const InputSample& from, const InputSample& to, std::size_t k, double limit) const;
  void doubt_jolt(InputSample& sample, double dt) const;
  void doubt_saturated(InputSample& sample, double dt);
  void accept(InputSample sample, InputBuffer& buffer);

  InputLimits limits_;
  InputFaultCounts counts_;
  std::optional<InputSample> last_, held_;  // accepted; held back
  Six value_ = Six::Constant(-1e300);       // of the newest sample of all
  std::int64_t newest_ns_ = 0;
  std::size_t repeats_ = 0;                // in a row
  std::size_t repeated_ = 0, varied_ = 0;  // samples that were the one before, and that were not
  std::array<double, 2> usual_change_{};   // between samples (mean of the norm)
  std::array<Ends, 2> peaks_{kNoPeaks, kNoPeaks};
  std::array<std::size_t, 2> plateau_{};  // samples in a row
};

}  // namespace limber
