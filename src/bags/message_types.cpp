// SPDX-License-Identifier: MIT
#include "message_types.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "limber/core/split.hpp"

namespace limber::detail {
namespace {

struct Definition {
  std::string_view name, fields;
};

// clang-format off
constexpr Definition kRos1Header{"std_msgs/Header", "uint32 seq\ntime stamp\nstring frame_id\n"};
constexpr Definition kRos2Header{"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"};

constexpr std::array kDefinitions = {
    Definition{"diagnostic_msgs/DiagnosticArray",
               "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n"},
    Definition{"diagnostic_msgs/DiagnosticStatus",
               "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\n"
               "string hardware_id\ndiagnostic_msgs/KeyValue[] values\n"},
    Definition{"diagnostic_msgs/KeyValue", "string key\nstring value\n"},
    Definition{"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
    Definition{"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
    Definition{"geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"},
    Definition{"geometry_msgs/Pose",
               "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"},
    Definition{"geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n"},
    Definition{"geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"},
    Definition{"geometry_msgs/Transform",
               "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"},
    Definition{"geometry_msgs/TransformStamped",
               "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"},
    Definition{"geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"},
    Definition{"geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"},
    Definition{"geometry_msgs/TwistStamped", "std_msgs/Header header\ngeometry_msgs/Twist twist\n"},
    Definition{"geometry_msgs/Vector3Stamped", "std_msgs/Header header\ngeometry_msgs/Vector3 vector\n"},
    Definition{"nav_msgs/Path", "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n"},
    Definition{"tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"},
    Definition{"sensor_msgs/PointField",
               "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\n"
               "uint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n"},
    Definition{"sensor_msgs/PointCloud2",
               "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n"
               "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n"},
    Definition{"nav_msgs/Odometry",
               "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
               "geometry_msgs/TwistWithCovariance twist\n"},
    Definition{"sensor_msgs/Image",
               "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\n"
               "uint32 step\nuint8[] data\n"},
    Definition{"sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"},
    Definition{"sensor_msgs/Imu",
               "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n"
               "float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n"
               "float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n"
               "float64[9] linear_acceleration_covariance\n"}};
// clang-format on

const Definition* find_definition(std::string_view name, Serialization serialization) {
  if (name == kRos1Header.name) {
    return serialization == Serialization::kRos1 ? &kRos1Header : &kRos2Header;
  }
  const auto* const found = std::find_if(kDefinitions.begin(), kDefinitions.end(),
                                         [&](const Definition& d) { return d.name == name; });
  return found == kDefinitions.end() ? nullptr : found;
}

/// Types that a definition is made of, and what these are made of, each once, in the order of their
/// appearance.
void collect_parts(const Definition& definition, Serialization serialization,
                   std::vector<const Definition*>& parts) {
  for (const std::string_view field : split(definition.fields, '\n')) {
    const std::string_view type = field.substr(0, field.find_first_of(" ["));
    const Definition* const part = find_definition(type, serialization);
    if (part != nullptr && std::find(parts.begin(), parts.end(), part) == parts.end()) {
      parts.push_back(part);
      collect_parts(*part, serialization, parts);
    }
  }
}

}  // namespace

std::string definition_of(const MessageType& type, Serialization serialization) {
  const Definition& definition = *find_definition(type.name, serialization);
  std::vector<const Definition*> parts;
  collect_parts(definition, serialization, parts);
  std::string out(definition.fields);
  for (const Definition* const part : parts) {
    out += std::string(80, '=') + "\nMSG: ";
    out.append(part->name).append("\n").append(part->fields);
  }
  return out;
}

std::string full_name(const MessageType& type, Serialization serialization) {
  std::string out(type.name);
  if (serialization == Serialization::kCdr) {
    out.insert(out.find('/'), "/msg");
  }
  return out;
}

}  // namespace limber::detail
