// SPDX-License-Identifier: MIT
#pragma once

/// Definitions of ROS 2 messages, as MCAP files carry them (encoding "ros2msg").
namespace limber::detail::ros2 {

#define LIMBER_SEPARATOR "================================================================================\n"
#define LIMBER_HEADER \
  LIMBER_SEPARATOR "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
#define LIMBER_VECTOR3 LIMBER_SEPARATOR "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
#define LIMBER_QUATERNION \
  LIMBER_SEPARATOR "MSG: geometry_msgs/Quaternion\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"
#define LIMBER_TWIST \
  LIMBER_SEPARATOR "MSG: geometry_msgs/Twist\ngeometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"

inline constexpr const char* kImage =
    "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\n"
    "uint8[] data\n" LIMBER_HEADER;

inline constexpr const char* kCompressedImage =
    "std_msgs/Header header\nstring format\nuint8[] data\n" LIMBER_HEADER;

inline constexpr const char* kImu =
    "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
    "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
    "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n" LIMBER_HEADER
        LIMBER_QUATERNION LIMBER_VECTOR3;

inline constexpr const char* kTwistStamped =
    "std_msgs/Header header\ngeometry_msgs/Twist twist\n" LIMBER_HEADER LIMBER_TWIST LIMBER_VECTOR3;

inline constexpr const char* kOdometry =
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
    "geometry_msgs/TwistWithCovariance twist\n" LIMBER_HEADER LIMBER_SEPARATOR
    "MSG: geometry_msgs/PoseWithCovariance\ngeometry_msgs/Pose pose\nfloat64[36] "
    "covariance\n" LIMBER_SEPARATOR
    "MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion "
    "orientation\n" LIMBER_SEPARATOR
    "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n" LIMBER_QUATERNION LIMBER_SEPARATOR
    "MSG: geometry_msgs/TwistWithCovariance\ngeometry_msgs/Twist twist\nfloat64[36] covariance\n" LIMBER_TWIST
        LIMBER_VECTOR3;

#undef LIMBER_SEPARATOR
#undef LIMBER_HEADER
#undef LIMBER_VECTOR3
#undef LIMBER_QUATERNION
#undef LIMBER_TWIST

}  // namespace limber::detail::ros2
