// SPDX-License-Identifier: MIT
#include "limber/bags/messages.hpp"

#include <array>
#include <map>
#include <string_view>

#include "io/numbers.hpp"
#include "message_reader.hpp"

namespace limber {
namespace {

using detail::MessageReader;
using Data = std::span<const std::uint8_t>;

constexpr std::uint32_t kLargestSide = 100'000;  // [px]

const std::map<std::string_view, MessageKind>& kinds() {
  static const std::map<std::string_view, MessageKind> kinds = {
      {"sensor_msgs/Image", MessageKind::kImage},
      {"sensor_msgs/CompressedImage", MessageKind::kCompressedImage},
      {"sensor_msgs/Imu", MessageKind::kImu},
      {"nav_msgs/Odometry", MessageKind::kOdometry},
      {"geometry_msgs/PoseStamped", MessageKind::kPose},
      {"geometry_msgs/PoseWithCovarianceStamped", MessageKind::kPose},
      {"geometry_msgs/TransformStamped", MessageKind::kPose},
      {"geometry_msgs/TwistStamped", MessageKind::kTwist},
      {"geometry_msgs/TwistWithCovarianceStamped", MessageKind::kTwist}};
  return kinds;
}

/// Position, then quaternion x y z w.
std::optional<Pose> read_pose(MessageReader& reader) {
  const Eigen::Vector3d p = reader.vector3();
  const double x = reader.number<double>(), y = reader.number<double>(), z = reader.number<double>();
  const auto R = detail::checked_quaternion({reader.number<double>(), x, y, z});
  if (!reader.good() || !R || !p.allFinite()) {
    return std::nullopt;
  }
  return Pose{*R, p};
}

}  // namespace

MessageKind kind_of(const BagTopic& topic) {
  const auto found = kinds().find(topic.type);
  return found == kinds().end() || topic.serialization == Serialization::kOther ? MessageKind::kOther
                                                                                : found->second;
}

const char* to_string(MessageKind kind) {
  constexpr std::array<const char*, 7> kNames = {
      "image", "compressed image", "imu", "odometry", "pose", "twist", "other"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::optional<std::int64_t> header_stamp(Data data, Serialization serialization) {
  MessageReader reader(data, serialization);
  const std::int64_t t_ns = reader.header();
  return reader.good() ? std::optional(t_ns) : std::nullopt;
}

std::optional<ImageHeader> decode_image_header(Data data, Serialization serialization, MessageKind kind) {
  MessageReader reader(data, serialization);
  ImageHeader out;
  out.t_ns = reader.header();
  (void)reader.text();  // frame
  if (kind == MessageKind::kImage) {
    const auto height = reader.number<std::uint32_t>(), width = reader.number<std::uint32_t>();
    out.image.encoding = reader.text();
    out.image.big_endian = reader.number<std::uint8_t>() != 0;
    out.image.step = reader.number<std::uint32_t>();
    if (height == 0 || width == 0 || height > kLargestSide || width > kLargestSide ||
        out.image.encoding.empty()) {
      return std::nullopt;
    }
    out.image.height = static_cast<int>(height);
    out.image.width = static_cast<int>(width);
  } else {
    out.format = reader.text();
  }
  out.data_size = reader.number<std::uint32_t>();
  out.data_at = reader.at();
  const bool whole = kind != MessageKind::kImage ||
                     out.data_size == out.image.step * static_cast<std::size_t>(out.image.height);
  return reader.good() && whole ? std::optional(out) : std::nullopt;
}

std::optional<EncodedImage> decode_image(Data data, Serialization serialization, MessageKind kind) {
  return take_image({data.begin(), data.end()}, serialization, kind);
}

std::optional<EncodedImage> take_image(std::vector<std::uint8_t> message, Serialization serialization,
                                       MessageKind kind) {
  auto header = decode_image_header(message, serialization, kind);
  if (!header || header->data_size > message.size() - header->data_at) {
    return std::nullopt;
  }
  message.resize(header->data_at + header->data_size);
  message.erase(message.begin(), message.begin() + static_cast<std::ptrdiff_t>(header->data_at));
  header->image.data = std::move(message);
  return std::move(header->image);
}

std::optional<ImuMessage> decode_imu(Data data, Serialization serialization) {
  MessageReader reader(data, serialization);
  ImuMessage out;
  out.sample.t_ns = reader.header();
  (void)reader.text();         // frame
  reader.skip_doubles(4 + 9);  // orientation
  out.sample.omega_imu = reader.vector3();
  out.has_rates = reader.number<double>() != -1.0;
  reader.skip_doubles(8);
  out.sample.accel_imu = reader.vector3();
  out.has_accelerations = reader.number<double>() != -1.0;
  reader.skip_doubles(8);
  const bool finite = out.sample.omega_imu.allFinite() && out.sample.accel_imu.allFinite();
  return reader.good() && finite ? std::optional(out) : std::nullopt;
}

std::optional<OdometryMessage> decode_odometry(Data data, Serialization serialization) {
  MessageReader reader(data, serialization);
  OdometryMessage out;
  out.pose.t_ns = out.twist.t_ns = reader.header();
  (void)reader.text();  // frame
  (void)reader.text();  // child frame
  const auto pose = read_pose(reader);
  reader.skip_doubles(36);
  out.twist.v_body = reader.vector3();
  out.twist.omega_body = reader.vector3();
  reader.skip_doubles(36);
  if (!pose || !reader.good() || !out.twist.v_body.allFinite() || !out.twist.omega_body.allFinite()) {
    return std::nullopt;
  }
  out.pose.T_world_body = *pose;
  return out;
}

std::optional<StampedPose> decode_pose(Data data, const BagTopic& topic) {
  MessageReader reader(data, topic.serialization);
  StampedPose out;
  out.t_ns = reader.header();
  (void)reader.text();  // frame
  if (topic.type == "geometry_msgs/TransformStamped") {
    (void)reader.text();  // child frame
  }
  const auto pose = read_pose(reader);
  if (!pose) {
    return std::nullopt;
  }
  out.T_world_body = *pose;
  return out;
}

std::optional<OdometrySample> decode_twist(Data data, Serialization serialization) {
  MessageReader reader(data, serialization);
  OdometrySample out;
  out.t_ns = reader.header();
  (void)reader.text();  // frame
  out.v_body = reader.vector3();
  out.omega_body = reader.vector3();
  const bool finite = out.v_body.allFinite() && out.omega_body.allFinite();
  return reader.good() && finite ? std::optional(out) : std::nullopt;
}

}  // namespace limber
