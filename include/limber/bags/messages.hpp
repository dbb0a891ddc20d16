// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "limber/bags/bag_file.hpp"
#include "limber/core/pose.hpp"
#include "limber/sensors/encoded_image.hpp"
#include "limber/sensors/samples.hpp"

/// Messages of ROS, as ROS 1 and CDR serialise them. Times are the stamps of their headers.
namespace limber {

/// What a message holds.
enum class MessageKind { kImage, kCompressedImage, kImu, kOdometry, kPose, kTwist, kOther };

/// What limber can make of a topic: kOther for types, or serialisations, that it does not read.
[[nodiscard]] MessageKind kind_of(const BagTopic& topic);
/// "image", "imu", ...
[[nodiscard]] const char* to_string(MessageKind kind);

/// Stamp of the header that a message begins with; nothing if it is too short, or its nanoseconds are no
/// fraction of a second.
[[nodiscard]] std::optional<std::int64_t> header_stamp(std::span<const std::uint8_t> data,
                                                       Serialization serialization);

/// sensor_msgs/Image or sensor_msgs/CompressedImage without its pixels.
struct ImageHeader {
  /// stamp of the header [ns]
  std::int64_t t_ns = 0;
  EncodedImage image;         ///< of an Image; data is empty
  std::string format;         ///< of a CompressedImage
  std::size_t data_at = 0;    ///< byte in the message where the pixels begin
  std::size_t data_size = 0;  ///< [bytes]
};

// All decoders: nothing if the bytes are no such message, or hold numbers that are not finite.

/// @param data  at least the part before the pixels
[[nodiscard]] std::optional<ImageHeader> decode_image_header(std::span<const std::uint8_t> data,
                                                             Serialization serialization, MessageKind kind);
/// The whole image. Its rows must be there: height x step bytes.
[[nodiscard]] std::optional<EncodedImage> decode_image(std::span<const std::uint8_t> data,
                                                       Serialization serialization, MessageKind kind);

/// The same in the memory of the message, which is not copied.
[[nodiscard]] std::optional<EncodedImage> take_image(std::vector<std::uint8_t> message,
                                                     Serialization serialization, MessageKind kind);

/// sensor_msgs/Imu.
struct ImuMessage {
  /// t_ns is the header's stamp
  ImuSample sample;
  bool has_rates = true, has_accelerations = true;  ///< false: the first covariance is -1
};
/// Rates and accelerations; the orientation is left alone.
[[nodiscard]] std::optional<ImuMessage> decode_imu(std::span<const std::uint8_t> data,
                                                   Serialization serialization);

/// nav_msgs/Odometry: pose of the child frame, and its velocities in the child frame.
struct OdometryMessage {
  /// T_world_body, stamped by the header
  StampedPose pose;
  /// velocities in the frame of the body
  OdometrySample twist;
};
/// Pose and velocities; covariances are left alone.
[[nodiscard]] std::optional<OdometryMessage> decode_odometry(std::span<const std::uint8_t> data,
                                                             Serialization serialization);

/// geometry_msgs PoseStamped, PoseWithCovarianceStamped or TransformStamped.
[[nodiscard]] std::optional<StampedPose> decode_pose(std::span<const std::uint8_t> data,
                                                     const BagTopic& topic);

/// geometry_msgs/TwistStamped, or TwistWithCovarianceStamped.
[[nodiscard]] std::optional<OdometrySample> decode_twist(std::span<const std::uint8_t> data,
                                                         Serialization serialization);

}  // namespace limber
