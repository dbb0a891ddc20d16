// SPDX-License-Identifier: MIT
#include "limber/bags/write_results.hpp"

#include <limits>
#include <stdexcept>

#include "message_sink.hpp"
#include "result_messages.hpp"

namespace limber {
namespace {

using detail::MessageSink;
using detail::MessageType;
namespace types = detail::types;

/// Results in the order of time.
class ResultsWriter {
 public:
  ResultsWriter(const RunResults& results, MessageSink& sink) : results_(results), sink_(sink) {}

  void write() {
    write_whole();
    for (const TrajectoryRow& row : results_.trajectory) {
      others_up_to(row.t_ns);
      write_row(row);
    }
    others_up_to(std::numeric_limits<std::int64_t>::max());
    sink_.close();
  }

 private:
  /// What is there from the beginning.
  void write_whole() {
    const std::vector<StampedPose> path = poses_of(results_.trajectory);
    const std::int64_t begin_ns = path.front().t_ns;
    put(begin_ns, "/limber/path", types::kPath, detail::path_message(path, sink_.serialization()), true);
    if (!results_.truth.empty()) {
      put(begin_ns, "/groundtruth/path", types::kPath,
          detail::path_message(results_.truth, sink_.serialization()), true);
    }
    if (!results_.landmarks.empty()) {
      put(begin_ns, "/limber/map", types::kPointCloud2,
          detail::map_message(begin_ns, results_.landmarks, sink_.serialization()), true);
    }
  }

  void write_row(const TrajectoryRow& row) {
    const Serialization serialization = sink_.serialization();
    put(row.t_ns, "/tf", types::kTfMessage, detail::transform_message(row, serialization));
    put(row.t_ns, kOdometryOfRun.data(), types::kOdometry, detail::odometry_message(row, serialization));
    if (row.bias_gyro) {
      put(row.t_ns, "/limber/bias/gyro", types::kVector3Stamped,
          detail::vector_message(row.t_ns, *row.bias_gyro, serialization));
    }
    if (row.bias_accel) {
      put(row.t_ns, "/limber/bias/accel", types::kVector3Stamped,
          detail::vector_message(row.t_ns, *row.bias_accel, serialization));
    }
  }

  void others_up_to(std::int64_t t_ns) {
    for (; truth_ < results_.truth.size() && results_.truth[truth_].t_ns <= t_ns; ++truth_) {
      const StampedPose& pose = results_.truth[truth_];
      put(pose.t_ns, "/groundtruth", types::kPoseStamped, detail::pose_message(pose, sink_.serialization()));
    }
    const auto& diagnostics = results_.diagnostics;
    for (; diagnostic_ < diagnostics.size() && diagnostics[diagnostic_].t_ns <= t_ns; ++diagnostic_) {
      const Diagnostic& diagnostic = diagnostics[diagnostic_];
      put(diagnostic.t_ns, "/diagnostics", types::kDiagnosticArray,
          detail::diagnostic_message(diagnostic, sink_.serialization()));
    }
  }

  void put(std::int64_t t_ns, const char* topic, const MessageType& type,
           const std::vector<std::uint8_t>& message, bool is_latched = false) {
    sink_.message(sink_.channel(topic, type, is_latched), t_ns, message);
  }

  const RunResults& results_;
  MessageSink& sink_;
  std::size_t truth_ = 0, diagnostic_ = 0;
};

}  // namespace

Eigen::Matrix<double, 6, 6> ros_pose_covariance(const TrajectoryRow& row) {
  if (!row.covariance) {
    return Eigen::Matrix<double, 6, 6>::Zero();
  }
  Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Identity();
  J.bottomRightCorner<3, 3>() = row.T_world_body.R;  // R_est Exp(dtheta) = Exp(R_est dtheta) R_est
  return J * *row.covariance * J.transpose();
}

void write_results(const RunResults& results, const BagOutput& output) {
  if (results.trajectory.empty()) {
    throw std::invalid_argument("write_results: no pose");
  }
  const auto sink = detail::open_sink(output);
  ResultsWriter(results, *sink).write();
}

}  // namespace limber
