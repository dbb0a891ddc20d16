// SPDX-License-Identifier: MIT
#pragma once

#include <limber/bags/diagnostic.hpp>
#include <limber/datasets/trajectory_files.hpp>
#include <limber/frontend/stereo_tracker.hpp>
#include <limber/initialize/sensor_start.hpp>
#include <limber/navigate/frame_report.hpp>
#include <limber/run/run_options.hpp>
#include <limber/sensors/encoded_image.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <variant>

/// @file
/// What a node does, whatever middleware it belongs to.
namespace limber {

/// Who runs an ImageNavigator hears this of it, from within the calls of add_imu, add_odometry
/// and add_image.
class NavigationListener {
 public:
  virtual ~NavigationListener() = default;
  virtual void pose(const TrajectoryRow& row) = 0;  ///< after every frame, once started
  virtual void diagnostic(
      const Diagnostic& diagnostic) = 0;              ///< navigation: every frame; calibration: now and then
  virtual void note(const std::string& text) = 0;     ///< what was chosen, or is worth knowing
  virtual void warning(const std::string& text) = 0;  ///< what should not be
};

/// What a user chooses; the rest is as in `limber run`.
struct ImageNavigatorOptions {
  RunOptions run;
  TrackerOptions tracker;
  bool uses_odometry = false;    ///< velocities of the body drive the prediction, in the place of an IMU
  double pair_within_s = 0.005;  ///< stamps of a left and a right image that belong together
  int bits = 16;                 ///< that cameras with pixels of 16 bits use
};

/// @brief Images and IMU, or odometry, in as they come, poses and diagnostics out: what `limber run` does
/// with a recording, on default options with the same bits from the frame after the start on (the frames
/// before are smoothed there by what came later).
///
/// Starts from the sensors. A frame waits until IMU or odometry has reached it, or twenty more wait behind
/// it. A clock that jumps back by more than a second, and a filter that diverges, mean a new start. One
/// thread.
class ImageNavigator {
 public:
  /// @param calibration  a width of 0 is taken from the first image. With body kCam0 the IMU is not used:
  ///                     nothing says where it sits. Odometry is that of this body
  ImageNavigator(StereoCalibration calibration, std::optional<ImuNoise> imu_noise,
                 ImageNavigatorOptions options, NavigationListener& listener);
  ~ImageNavigator();
  ImageNavigator(const ImageNavigator&) = delete;
  ImageNavigator& operator=(const ImageNavigator&) = delete;

  /// Samples that are not finite, or not later than the one before, are left out with a warning; those that
  /// the options do not ask for, without.
  void add_imu(const ImuSample& sample);
  void add_odometry(const OdometrySample& sample);
  /// @param camera  0 left, 1 right. Images that cannot be used are left out with a warning.
  void add_image(std::size_t camera, std::int64_t t_ns, EncodedImage image);

 private:
  struct Session;
  struct Stamped {
    std::int64_t t_ns;
    EncodedImage image;
  };
  using Pair = std::array<Stamped, 2>;
  using Input = std::variant<ImuSample, OdometrySample>;

  void add_input(const Input& input, const char* what);
  void pair_up();
  void advance();  ///< processes the frames that need not wait any more
  [[nodiscard]] bool is_covered(std::int64_t t_ns) const;
  void process(const Pair& pair);
  void begin_session(const Pair& pair);
  void navigate(const StereoFrame& frame);
  void tell_start(std::int64_t t_ns, const StartReport& report);
  void tell_frame(const FrameReport& report);
  void tell_state();
  void begin_anew(const std::string& why);
  /// Whether a stamp may follow the one before; a jump back means a new start.
  [[nodiscard]] bool follows(std::int64_t t_ns, std::optional<std::int64_t>& last_ns, const char* what);

  StereoCalibration calibration_;
  std::optional<ImuNoise> imu_noise_;
  ImageNavigatorOptions options_;
  NavigationListener& listener_;
  MotionModel motion_;
  std::array<std::deque<Stamped>, 2> waiting_;  ///< images without a partner yet
  std::deque<Pair> pairs_;                      ///< not processed yet
  std::array<std::optional<std::int64_t>, 2> last_image_ns_;
  std::deque<Input> inputs_;  ///< that no frame has asked for yet
  std::optional<std::int64_t> last_input_ns_;
  std::unique_ptr<Session> session_;  ///< since the last start
};

}  // namespace limber
