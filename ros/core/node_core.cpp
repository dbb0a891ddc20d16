// SPDX-License-Identifier: MIT
#include "node_core.hpp"

#include <limber/bags/write_results.hpp>
#include <limber/navigate/method.hpp>
#include <limber/rig_files/rig_file.hpp>
#include <limber/run/parse_tolerance.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>
#include <stdexcept>

#include "image_navigator.hpp"

namespace limber_node {
namespace {

/// What the navigator tells, in plain types.
class Listener final : public limber::NavigationListener {
 public:
  explicit Listener(Output& output) : output_(output) {}

  void pose(const limber::TrajectoryRow& row) override {
    const limber::Pose& T = row.T_world_body;
    const Eigen::Quaterniond q(T.R);
    const Eigen::Matrix<double, 6, 6> P = limber::ros_pose_covariance(row);
    Odometry out;
    out.t_ns = row.t_ns;
    out.position = {T.p.x(), T.p.y(), T.p.z()};
    out.orientation = {q.x(), q.y(), q.z(), q.w()};
    std::copy(P.data(), P.data() + P.size(), out.covariance.begin());  // symmetric
    if (row.v_world_body) {
      const Eigen::Vector3d v = T.R.transpose() * *row.v_world_body;
      out.velocity = {v.x(), v.y(), v.z()};
    }
    output_.odometry(out);
  }
  void diagnostic(const limber::Diagnostic& d) override {
    output_.status({d.t_ns, static_cast<std::uint8_t>(d.level), d.name, d.message, d.values});
  }
  void note(const std::string& text) override { output_.note(text); }
  void warning(const std::string& text) override { output_.warning(text); }

 private:
  Output& output_;
};

limber::RigFile rig_of(const Parameters& parameters) {
  if (parameters.calib.empty()) {
    throw std::invalid_argument(
        "parameter calib is missing: the calibration, a file or folder as limber run --calib takes it");
  }
  std::optional<limber::ImageKind> images;
  if (parameters.images == "raw" || parameters.images == "rectified") {
    images = parameters.images == "raw" ? limber::ImageKind::kRaw : limber::ImageKind::kRectified;
  } else if (!parameters.images.empty()) {
    throw std::invalid_argument("parameter images: expected raw or rectified, found '" + parameters.images +
                                "'");
  }
  return limber::read_rig_file(parameters.calib, images);
}

limber::ImageNavigatorOptions options_of(const Parameters& parameters) {
  limber::ImageNavigatorOptions options;
  options.run.method = limber::method_from_string(parameters.method);
  if (options.run.method == limber::Method::kOracle) {
    throw std::invalid_argument("parameter method: oracle needs the true calibration, which a node has not");
  }
  if (!parameters.tolerance.empty()) {
    options.run.tolerance = limber::parse_tolerance(parameters.tolerance);
  }
  if (parameters.bits < 8 || parameters.bits > 16) {
    throw std::invalid_argument("parameter bits: expected 8 to 16, found " + std::to_string(parameters.bits));
  }
  options.uses_odometry = parameters.inputs == "odometry" || parameters.inputs == "twist" ||
                          parameters.inputs == "twist_with_covariance";
  if (!options.uses_odometry && parameters.inputs != "imu") {
    throw std::invalid_argument(
        "parameter inputs: expected imu, odometry, twist or twist_with_covariance, found '" +
        parameters.inputs + "'");
  }
  options.tracker.max_tracks = parameters.max_tracks;
  options.pair_within_s = parameters.pair_within;
  options.bits = parameters.bits;
  return options;
}

}  // namespace

struct Core::Parts {
  Parts(const Parameters& parameters, const limber::RigFile& rig,
        const std::optional<limber::ImuNoise>& noise, Output& output)
      : listener(output), navigator(rig.calibration, noise, options_of(parameters), listener) {}
  Listener listener;
  limber::ImageNavigator navigator;
};

Core::Core(const Parameters& parameters, Output& output) {
  const limber::RigFile rig = rig_of(parameters);
  for (const std::string& note : rig.notes) {
    output.note(note);
  }
  const std::optional<limber::ImuNoise> noise =
      parameters.imu_noise.empty() ? rig.imu_noise : limber::read_kalibr_imu(parameters.imu_noise);
  parts_ = std::make_unique<Parts>(parameters, rig, noise, output);
}

Core::~Core() = default;

void Core::add_imu(std::int64_t t_ns, const std::array<double, 3>& rate, const std::array<double, 3>& force) {
  parts_->navigator.add_imu({t_ns, {rate[0], rate[1], rate[2]}, {force[0], force[1], force[2]}});
}

void Core::add_odometry(std::int64_t t_ns, const std::array<double, 3>& velocity,
                        const std::array<double, 3>& rate) {
  parts_->navigator.add_odometry(
      {t_ns, {velocity[0], velocity[1], velocity[2]}, {rate[0], rate[1], rate[2]}});
}

void Core::add_image(std::size_t camera, std::int64_t t_ns, Image image) {
  limber::EncodedImage out;
  out.encoding = std::move(image.encoding);
  out.width = image.width;
  out.height = image.height;
  out.step = image.step;
  out.big_endian = image.big_endian;
  out.data = std::move(image.data);
  parts_->navigator.add_image(camera, t_ns, std::move(out));
}

}  // namespace limber_node
