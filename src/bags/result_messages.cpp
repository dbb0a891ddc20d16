// SPDX-License-Identifier: MIT
#include "result_messages.hpp"

#include "message_writer.hpp"

namespace limber::detail {
namespace {

constexpr const char *kWorld = "world", *kBody = "body";

}  // namespace

MessageBytes path_message(const std::vector<StampedPose>& poses, Serialization serialization) {
  MessageWriter out(serialization);
  out.header(poses.front().t_ns, kWorld);
  out.size(poses.size());
  for (const StampedPose& pose : poses) {
    out.header(pose.t_ns, kWorld);
    out.pose(pose.T_world_body);
  }
  return out.take();
}

MessageBytes pose_message(const StampedPose& pose, Serialization serialization) {
  MessageWriter out(serialization);
  out.header(pose.t_ns, kWorld);
  out.pose(pose.T_world_body);
  return out.take();
}

MessageBytes transform_message(const TrajectoryRow& row, Serialization serialization) {
  MessageWriter out(serialization);
  out.size(1);
  out.header(row.t_ns, kWorld);
  out.text(kBody);
  out.pose(row.T_world_body);
  return out.take();
}

MessageBytes odometry_message(const TrajectoryRow& row, Serialization serialization) {
  const Eigen::Matrix3d& R = row.T_world_body.R;
  MessageWriter out(serialization);
  out.header(row.t_ns, kWorld);
  out.text(kBody);
  out.pose(row.T_world_body);
  const Eigen::Matrix<double, 6, 6, Eigen::RowMajor> covariance = ros_pose_covariance(row);
  for (const double value : covariance.reshaped<Eigen::RowMajor>()) {
    out.number(value);
  }
  out.vector3(row.v_world_body ? Eigen::Vector3d(R.transpose() * *row.v_world_body)
                               : Eigen::Vector3d(Eigen::Vector3d::Zero()));
  out.vector3(Eigen::Vector3d::Zero());  // rates
  out.unknown_covariance(36);
  return out.take();
}

MessageBytes vector_message(std::int64_t t_ns, const Eigen::Vector3d& v, Serialization serialization) {
  MessageWriter out(serialization);
  out.header(t_ns, kBody);
  out.vector3(v);
  return out.take();
}

MessageBytes map_message(std::int64_t t_ns, const std::map<std::int64_t, Eigen::Vector3d>& landmarks,
                         Serialization serialization) {
  constexpr std::uint8_t kFloat32 = 7;
  constexpr std::uint32_t kPointSize = 3 * sizeof(float);
  MessageWriter out(serialization);
  out.header(t_ns, kWorld);
  out.number(std::uint32_t{1});  // height
  out.size(landmarks.size());    // width
  out.size(3);
  std::uint32_t offset = 0;
  for (const char* const axis : {"x", "y", "z"}) {
    out.text(axis);
    out.number(offset);
    out.number(kFloat32);
    out.number(std::uint32_t{1});  // count
    offset += sizeof(float);
  }
  out.flag(false);  // big-endian
  out.number(kPointSize);
  out.size(kPointSize * landmarks.size());  // of a row
  out.size(kPointSize * landmarks.size());  // of the data
  for (const auto& [id, point] : landmarks) {
    for (const double value : point) {
      out.number(static_cast<float>(value));
    }
  }
  out.flag(true);  // dense
  return out.take();
}

MessageBytes diagnostic_message(const Diagnostic& diagnostic, Serialization serialization) {
  MessageWriter out(serialization);
  out.header(diagnostic.t_ns, "");
  out.size(1);
  out.number(static_cast<std::uint8_t>(diagnostic.level));
  out.text(diagnostic.name);
  out.text(diagnostic.message);
  out.text("");  // hardware
  out.size(diagnostic.values.size());
  for (const auto& [key, value] : diagnostic.values) {
    out.text(key);
    out.text(value);
  }
  return out.take();
}

}  // namespace limber::detail
