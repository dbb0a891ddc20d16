// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "limber/navigate/frame_report.hpp"
#include "limber/navigate/navigator_options.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/state/initial_state.hpp"

namespace limber {

class Navigator;

namespace detail {
struct StartWindow;
}

/// When a start from the sensors is good enough, and how long it may take.
struct StartOptions {
  double longest_s = 8.0;  ///< then it goes on with what is known, as it is known
  /// The same while the body moves and no acceleration tells how far: a filter that linearises each frame
  /// once would soon be sure of a scale that nobody knows.
  double longest_moving_s = 30.0;
  /// A rest, or a pure rotation, does not count where the method leaves the length of the baseline open and
  /// an IMU will tell the scale as soon as the body moves: its last seconds are kept, and where the body was
  /// before is known by then. No start takes longer than that in all.
  double longest_still_s = 300.0;
  double shortest_s = 1.0;    ///< no start before
  double tilt_sigma = 0.02;   ///< [rad], asked for; recordings with an IMU
  double scale_sigma = 0.05;  ///< [-], of the logarithm of the map's scale, asked for
  /// The same where the method distrusts the length of the baseline: its filter, which linearises each frame
  /// once, learns the rest of the scale badly, the window well.
  double open_scale_sigma = 0.02;
  /// A start that could be used waits on for this where the scale is open: what the window learns it smooths
  /// over all of its frames, what the filter learns says nothing of those before.
  double fine_scale_sigma = 0.005;
  /// No longer than that since the first frame, and no longer than the scale gets better by a tenth from one
  /// solution to the next. At most shortest_s: it never waits on.
  double longest_fine_s = 16.0;
};

/// Whether a start may be used.
enum class StartStatus : std::uint8_t {
  kWaiting,  ///< for what StartReport::missing says
  kReady,    ///< what was asked for is known
  kTimedOut  ///< the time is over: ready as well, but `missing` is not known and the covariance says so
};

/// How far a start has come. What is known is that by the last solution; there are fewer and fewer of them.
struct StartReport {
  /// whether it may be used
  StartStatus status = StartStatus::kWaiting;
  double waited_s = 0.0;     ///< since the first frame
  double tilt_sigma = 0.0;   ///< [rad], the worse axis; infinite before the first solution, 0 without gravity
  double scale_sigma = 0.0;  ///< [-]; infinite before the first solution
  std::string missing;       ///< in plain words; empty once ready
  InputReport inputs;        ///< since the frame before
};

/// A state of the window with the covariance of its pose (position, attitude), and of what the motion model
/// adds, in the order of StateLayout (IMU 9×9, constant velocity 6×6, odometry: none).
struct SmoothedState {
  /// at the time of its frame
  NavigationState nav;
  /// position in the world [m], local attitude [rad]
  Eigen::Matrix<double, 6, 6> pose_covariance = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::MatrixXd motion_covariance;  ///< velocity and biases [m/s, rad/s, m/s^2]; may be empty
};

/// The stamps of an IMU that are off, or jumped while a start waited.
struct StampJump {
  /// Of stamps that are off by the same all the time: before any frame.
  static constexpr std::int64_t kAllAlong = std::numeric_limits<std::int64_t>::min();

  /// the frames between which they jumped, by the cameras' clock [ns]
  std::int64_t after_ns = kAllAlong, before_ns = kAllAlong;
  std::int64_t offset_ns = 0;         ///< how much later than taken the samples since then are stamped [ns]
  std::int64_t offset_before_ns = 0;  ///< and those until then [ns]

  /// Not off by the same all the time.
  [[nodiscard]] bool jumps() const { return before_ns != kAllAlong; }

  /// When a sample with that stamp was taken [ns]; nothing for those around the jump, of which nobody knows.
  [[nodiscard]] std::optional<std::int64_t> corrected(std::int64_t stamp_ns) const {
    const std::int64_t before_jump_ns = stamp_ns - offset_before_ns;
    if (before_jump_ns <= after_ns) {
      return before_jump_ns;
    }
    const std::int64_t taken_ns = stamp_ns - offset_ns;
    return before_jump_ns > before_ns && taken_ns > before_ns ? std::optional(taken_ns) : std::nullopt;
  }
};

/// When a sample with that stamp was taken, by a clock that may have jumped: StampJump::corrected.
[[nodiscard]] inline std::optional<std::int64_t> taken_at(std::int64_t stamp_ns,
                                                          const std::optional<StampJump>& jump) {
  return jump ? jump->corrected(stamp_ns) : stamp_ns;
}

/// Where the filter goes on, and where the body was until then.
struct SensorStartResult {
  StartReport report;                     ///< what is known by the last frame
  InitialState initial;                   ///< at the last frame that was used, with a first map
  std::vector<SmoothedState> trajectory;  ///< at every frame that was used; origin: the first
  /// Where the rig is trusted after all (may_trust_rig): the same states without that trust. Else none.
  std::vector<SmoothedState> distrusting;
  /// The frames of the last of these states, but for a rest that was forgotten.
  std::vector<StereoFrame> used;
  /// Where images and inputs had agreed and then did not any more (an input that failed) the start ends
  /// before that. These came after it: the navigator's next frames.
  std::vector<StereoFrame> unused;
  std::optional<std::int64_t> bias_step_ns;  ///< the IMU's biases stepped just before that frame
  /// The IMU's clock stepped: later samples, too, have to be given to the navigator by corrected(). Of one
  /// that is off by the same all the time a navigator knows from `initial`.
  std::optional<StampJump> clock_step;
  bool solved = true;  ///< false: images and inputs agree upon no motion, and nothing of them was used
};

/// @brief Shows a navigator the frames that its start has used up: the verdict on the calibration begins with
/// them. Before its first frame. With odometry, or if the calibration is not watched, nothing is done.
/// @return what is known of the calibration after each of `start.used`
std::vector<std::shared_ptr<const CalibrationReport>> show_start(const SensorStartResult& start,
                                                                 Navigator& navigator);

/// @brief Whether a start leaves the rig open, and the method takes it for exact after all where nothing
/// contradicts that: `adaptive`, and an `ekf` that has to learn what its pixels are worth.
[[nodiscard]] bool may_trust_rig(const NavigatorOptions& options);

/// @brief Whether one start serves both, from the same frames and inputs: what they ask of the rig (which of
/// theta is free, whether the right pixels are used), rig and noises agree. What each begins with:
/// SensorStart::result_for.
[[nodiscard]] bool same_start(const NavigatorOptions& a, const StereoCalibration& rig_of_a,
                              const NavigatorOptions& b, const StereoCalibration& rig_of_b);

/// @brief A start from sensors alone, as good as they allow: all frames and inputs since the first one in one
/// least-squares problem, in which the rig is as free as the method takes it to be.
///
/// Inputs may fail meanwhile: samples that cannot be right are left out, gaps are noise, biases may step
/// once, and so may the clock of an IMU (by 0.3 s at most). What else makes the misfit grow ends the start
/// where images and inputs agreed last.
///
/// Feed inputs up to (or beyond) a frame's time, then the frame, until the status is no longer kWaiting. Then
/// a navigator that starts from the result goes on with `unused` and the next frame; those before are spent.
/// Methods that trust the rig (ekf) take its right pixels as they are. All others let theta go free in every
/// frame, in the directions that are constrained, so that they learn nothing from a rig that they distrust.
/// `adaptive` does that, too, and then trusts the rig if nothing in the window contradicts it.
/// With odometry nothing is unknown, and the first frame is the start.
/// @note docs/derivations/start.md
class SensorStart {
 public:
  /// @throws std::invalid_argument as check_calibration
  SensorStart(const NavigatorOptions& options, const StereoCalibration& calibration,
              const StartOptions& start = {});
  /// The other one may then only be destroyed or assigned to.
  SensorStart(SensorStart&&) noexcept;
  /// The other one may then only be destroyed or assigned to.
  SensorStart& operator=(SensorStart&&) noexcept;
  ~SensorStart();

  /// Samples that cannot be right are left out or doubted (InputChecks).
  /// @throws std::invalid_argument if time does not increase or a value is not finite
  void add_imu(const ImuSample& sample);
  /// As add_imu, in the place of an IMU.
  void add_odometry(const OdometrySample& sample);
  /// Once the start is ready, more frames change nothing but what result() says of the frames so far.
  /// @throws std::invalid_argument if time does not increase, a pixel is not finite or a million pixels away
  StartReport add_frame(const StereoFrame& frame);

  /// How much later than taken an IMU's samples are stamped, as far as the start knows [ns]. Feed them as far
  /// beyond a frame.
  [[nodiscard]] std::int64_t clock_offset_ns() const;

  /// What is known by now, whatever the status.
  /// @throws std::invalid_argument if there was no frame yet
  [[nodiscard]] SensorStartResult result();
  /// @brief The same for another method that this start serves (same_start): some may trust the rig
  /// after all where the others do not.
  /// @throws std::invalid_argument as result()
  [[nodiscard]] SensorStartResult result_for(Method method);

 private:
  std::unique_ptr<detail::StartWindow> window_;
};

}  // namespace limber
