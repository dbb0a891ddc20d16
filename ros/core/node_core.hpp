// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

/// @file
/// What a node does, whatever middleware it belongs to. Plain C++17, of the standard library alone: ROS 1's
/// messages do not compile as C++20, and ROS 2 Humble is C++17.
namespace limber_node {

/// Parameters, by the names that a user gives them.
struct Parameters {
  std::string calib;      ///< file or folder, as `limber run --calib` takes it
  std::string imu_noise;  ///< Kalibr imu.yaml; empty: the calibration's, or limber's default
  std::string images;     ///< raw or rectified, where the calibration holds both; else empty
  /// What drives the prediction beside the images: imu; or odometry, twist and
  /// twist_with_covariance, messages of the same content.
  std::string inputs = "imu";
  std::string method = "lcekf";
  std::string tolerance;       ///< as `limber run --tolerance`; empty: its default
  int max_tracks = 120;        ///< points followed at a time
  double pair_within = 0.005;  ///< [s] between the stamps of a left and a right image that belong together
  int bits = 16;               ///< that cameras with pixels of 16 bits use
};

/// The body in the world, as nav_msgs/Odometry has it.
struct Odometry {
  std::int64_t t_ns = 0;
  std::array<double, 3> position{};
  std::array<double, 4> orientation{};  ///< x y z w
  std::array<double, 36> covariance{};  ///< of position and rotation about the axes of the world
  std::array<double, 3> velocity{};     ///< in the body frame [m/s]; zero where it is not known
};

/// As diagnostic_msgs/DiagnosticStatus.
struct Status {
  std::int64_t t_ns = 0;
  std::uint8_t level = 0;  ///< 0 ok, 1 warning, 2 error, 3 stale: not known
  std::string name, message;
  std::vector<std::pair<std::string, std::string>> values;
};

/// As sensor_msgs/Image; or the bytes of a PNG or JPEG file in `data`, and nothing else.
struct Image {
  std::string encoding;
  int width = 0, height = 0;
  std::size_t step = 0;
  bool big_endian = false;
  std::vector<std::uint8_t> data;
};

/// What comes out, from within the calls of Core.
class Output {
 public:
  virtual ~Output() = default;
  virtual void odometry(const Odometry& odometry) = 0;  ///< after every frame, once started
  virtual void status(const Status& status) = 0;      ///< navigation: every frame; calibration: every window
  virtual void note(const std::string& text) = 0;     ///< what was chosen, or is worth knowing
  virtual void warning(const std::string& text) = 0;  ///< what should not be
};

/// Messages in, messages out: an ImageNavigator. One thread.
class Core {
 public:
  /// @throws std::exception for parameters or files that cannot be used, in words for the user
  Core(const Parameters& parameters, Output& output);
  ~Core();
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;

  /// @param rate   [rad/s]
  /// @param force  [m/s²], +9.81 upwards at rest
  void add_imu(std::int64_t t_ns, const std::array<double, 3>& rate, const std::array<double, 3>& force);
  /// With parameter inputs: any but imu. The body is the one that the calibration speaks of.
  /// @param velocity  of the body, in its frame [m/s]
  /// @param rate      the same [rad/s]
  void add_odometry(std::int64_t t_ns, const std::array<double, 3>& velocity,
                    const std::array<double, 3>& rate);
  /// @param camera  0 left, 1 right
  void add_image(std::size_t camera, std::int64_t t_ns, Image image);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace limber_node
