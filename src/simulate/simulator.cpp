// SPDX-License-Identifier: MIT
#include "limber/simulate/simulator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "faults.hpp"
#include "limber/core/random.hpp"
#include "limber/core/so3.hpp"
#include "limber/measure/rig.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/scenario_presets.hpp"
#include "pixel_errors.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;

/// One run of a scenario: what all sensors share.
struct Run {
  const Scenario& scenario;
  SplineTrajectory trajectory;
  std::vector<Vector3d> world;
  Decalibration decalibration;
  std::uint64_t seed, run;

  [[nodiscard]] RandomStream stream(std::string_view name) const { return {seed, run, name}; }
  [[nodiscard]] Kinematics at(std::int64_t t_ns) const {
    return trajectory.at(static_cast<double>(t_ns) / 1e9);
  }
  [[nodiscard]] TrueRig rig_at(std::int64_t t_ns) const {
    return {t_ns, scenario.rig.theta + decalibration.at(t_ns)};
  }
  [[nodiscard]] bool moves(std::size_t id) const {
    const auto& body = scenario.world.moving_body;
    return body && stream("moving_body").uniform(id) < body->share;
  }
  /// p_world_landmark at `t_ns`.
  [[nodiscard]] Vector3d point_at(std::size_t id, std::int64_t t_ns) const {
    return moves(id) ? Vector3d(world[id] + moved(*scenario.world.moving_body, t_ns)) : world[id];
  }
  /// How far the moving body has come.
  [[nodiscard]] Vector3d moved(const MovingBodyScenario& body, std::int64_t t_ns) const {
    const double t = std::max(0.0, static_cast<double>(t_ns) / 1e9 - body.start);
    const double begin = 2.0 * std::numbers::pi * stream("moving_body_phase").uniform(0);
    const double angle = begin + body.speed * t / body.radius;
    return body.radius * Vector3d(std::cos(angle) - std::cos(begin), std::sin(angle) - std::sin(begin), 0.0);
  }
};

/// Poses, velocities and, with IMU, biases: constant plus a random walk.
void fill_groundtruth(const Run& run, Recording& recording) {
  const Scenario& s = run.scenario;
  const RandomStream initial = run.stream("bias"), walk_accel = run.stream("walk_accel");
  const RandomStream walk_gyro = run.stream("walk_gyro");
  const double step = std::sqrt(1.0 / s.imu_rate);
  Vector3d bias_gyro = s.initial.bias_gyro * initial.normal3(0);
  Vector3d bias_accel = s.initial.bias_accel * initial.normal3(1);
  const std::vector<std::int64_t> times = sample_times(s.imu_rate, s.duration);
  for (std::size_t k = 0; k < times.size(); ++k) {
    const Kinematics truth = run.at(times[k]);
    GroundTruthState state{times[k], truth.T_world_body.R, truth.T_world_body.p, truth.v_world_body};
    if (s.use_imu) {
      state.bias_gyro = bias_gyro;
      state.bias_accel = bias_accel;
      bias_gyro += s.noise.gyro_walk * step * walk_gyro.normal3(k);
      bias_accel += s.noise.accel_walk * step * walk_accel.normal3(k);
    }
    recording.truth.motion.states.push_back(state);
  }
  if (s.use_imu) {
    detail::step_biases(s.faults, run.seed, run.run, recording.truth.motion.states);
  }
  recording.truth.motion.has_velocity = true;
  recording.truth.motion.has_biases = s.use_imu;
}

void fill_imu(const Run& run, Recording& recording) {
  const Scenario& s = run.scenario;
  const RandomStream noise_gyro = run.stream("noise_gyro"), noise_accel = run.stream("noise_accel");
  const RandomStream dropout = run.stream("dropout_imu");
  const std::size_t last = recording.truth.motion.states.size() - 1;
  for (std::size_t k = 0; k <= last; ++k) {
    if (k > 0 && k < last && dropout.uniform(k) < s.dropout.imu_samples) {
      continue;
    }
    const GroundTruthState& state = recording.truth.motion.states[k];
    const Kinematics truth = run.at(state.t_ns);
    recording.imu.push_back(
        {state.t_ns, truth.omega_body + state.bias_gyro + s.noise.gyro * noise_gyro.normal3(k),
         specific_force(truth, s.gravity) + state.bias_accel + s.noise.accel * noise_accel.normal3(k)});
  }
  detail::spoil_imu(s.faults, run.seed, run.run, recording.imu);
  if (s.noise.gyro > 0.0 && s.noise.accel > 0.0) {
    const double to_density = std::sqrt(1.0 / s.imu_rate);
    recording.imu_noise = ImuNoise{s.noise.gyro * to_density, s.noise.gyro_walk, s.noise.accel * to_density,
                                   s.noise.accel_walk};
  } else {
    recording.notes.emplace_back("the IMU is simulated without noise: estimators use their defaults");
  }
}

void fill_odometry(const Run& run, const OdometryScenario& odometry, Recording& recording) {
  const RandomStream noise = run.stream("noise_odometry");
  const std::vector<std::int64_t> times = sample_times(odometry.rate, run.scenario.duration);
  for (std::size_t k = 0; k < times.size(); ++k) {
    const Kinematics truth = run.at(times[k]);
    recording.odometry.push_back(
        {times[k],
         truth.T_world_body.R.transpose() * truth.v_world_body + odometry.velocity * noise.normal3(k, 0),
         truth.omega_body + odometry.angular_rate * noise.normal3(k, 1)});
  }
  if (!run.scenario.noise.stated) {
    recording.notes.emplace_back("the noise of odometry is not stated: estimators learn it");
  } else if (odometry.velocity > 0.0 && odometry.angular_rate > 0.0) {
    recording.odometry_noise =
        OdometryNoise{Vector3d::Constant(odometry.velocity), Vector3d::Constant(odometry.angular_rate)};
  } else {
    recording.notes.emplace_back("odometry is simulated without noise: estimators use their defaults");
  }
}

/// Noise-free pixel of a point that the camera can see.
std::optional<Eigen::Vector2d> seen(const Camera& camera, const WorldScenario& world, const Vector3d& X) {
  if (X.z() < world.min_range || X.z() > world.max_range) {
    return std::nullopt;
  }
  const auto projection = project(camera, X);
  if (!projection || !in_image(camera, projection->uv)) {
    return std::nullopt;
  }
  return projection->uv;
}

/// What the cameras see, frame by frame. `j` is the index of the frame.
class FrameMaker {
 public:
  explicit FrameMaker(const Run& run)
      : run_(run),
        nominal_(nominal_calibration(run.scenario)),
        white_(are_white(run.scenario.pixels)),
        errors_(run.scenario, white_ ? 0 : run.world.size(), run.seed, run.run),
        noise_cam0_(run.stream("pixel_cam0")),
        noise_cam1_(run.stream("pixel_cam1")),
        dropout_(run.stream("dropout_right")) {}

  [[nodiscard]] StereoFrame make(std::int64_t t_ns, std::uint32_t j) {
    const WorldScenario& world = run_.scenario.world;
    const std::int64_t right_ns = t_ns - detail::right_delay(run_.scenario.faults, t_ns);
    const Cameras left = cameras_at(t_ns), right = right_ns == t_ns ? left : cameras_at(right_ns);
    errors_.advance_to(j);
    StereoFrame frame{t_ns, {}};
    for (std::size_t id = 0; id < run_.world.size(); ++id) {
      const auto uv_cam0 = seen(nominal_.cam0, world, left.T_cam0_world * run_.point_at(id, t_ns));
      if (!uv_cam0) {
        continue;
      }
      const Vector3d X_cam1 = right.T_cam1_cam0 * (right.T_cam0_world * run_.point_at(id, right_ns));
      const auto uv_cam1 = seen(nominal_.cam1, world, X_cam1);
      if (uv_cam1 || world.left_only) {
        frame.observations.push_back(observe(id, j, *uv_cam0, uv_cam1));
      }
    }
    errors_.mismatch(frame);
    return frame;
  }

 private:
  struct Cameras {
    Pose T_cam0_world, T_cam1_cam0;
  };

  [[nodiscard]] Cameras cameras_at(std::int64_t t_ns) const {
    const TrueRig rig = run_.rig_at(t_ns);
    const Pose T_body_cam0 = body_from_cam0(nominal_, rig);
    return {(run_.at(t_ns).T_world_body * T_body_cam0).inverse(), pose_from_rig(rig.theta)};
  }

  [[nodiscard]] StereoObservation observe(std::size_t id, std::uint32_t j, const Eigen::Vector2d& uv_cam0,
                                          const std::optional<Eigen::Vector2d>& uv_cam1) const {
    const double sigma = run_.scenario.noise.pixel;
    StereoObservation o{.track_id = static_cast<std::int64_t>(id),
                        .uv_cam0 = uv_cam0 + sigma * noise_cam0_.normal2(id, j)};
    o.in_cam1 = uv_cam1 && !(dropout_.uniform(id, j) < run_.scenario.dropout.right_detections);
    if (o.in_cam1) {
      o.uv_cam1 = *uv_cam1 + sigma * noise_cam1_.normal2(id, j);
    }
    if (!white_) {
      o.uv_cam0 += errors_.at(0, id, uv_cam0);
      o.uv_cam1 += o.in_cam1 ? errors_.at(1, id, *uv_cam1) : Eigen::Vector2d::Zero().eval();
    }
    return o;
  }

  const Run& run_;
  StereoCalibration nominal_;
  bool white_;
  detail::PixelErrors errors_;
  RandomStream noise_cam0_, noise_cam1_, dropout_;
};

/// What estimators may know of the pixels' noise.
void state_pixel_noise(const NoiseScenario& noise, Recording& recording) {
  if (!noise.stated) {
    recording.notes.emplace_back("the noise of pixels is not stated: estimators use their default");
  } else if (noise.pixel > 0.0) {
    recording.pixel_noise = PixelNoise::Constant(noise.pixel);
  } else {
    recording.notes.emplace_back("pixels are simulated without noise: estimators use their default");
  }
}

void fill_frames(const Run& run, Recording& recording) {
  const Scenario& s = run.scenario;
  FrameMaker maker(run);
  const RandomStream dropout = run.stream("dropout_frame");
  const std::vector<std::int64_t> times = sample_times(s.stereo_rate, s.duration);
  for (std::size_t j = 0; j < times.size(); ++j) {
    if (j > 0 && dropout.uniform(j) < s.dropout.frames) {
      continue;
    }
    recording.frames.push_back(maker.make(times[j], static_cast<std::uint32_t>(j)));
  }
  detail::spoil_frames(s.faults, recording.frames);
  for (const StereoFrame& frame : recording.frames) {
    for (const StereoObservation& o : frame.observations) {
      const auto id = static_cast<std::size_t>(o.track_id);
      if (!run.moves(id)) {
        recording.truth.landmarks[o.track_id] = run.world[id];
      }
    }
  }
  state_pixel_noise(s.noise, recording);
}

void fill_calibration_truth(const Run& run, Recording& recording) {
  std::vector<std::int64_t> times = run.decalibration.jumps(std::llround(run.scenario.duration * 1e9));
  for (const StereoFrame& frame : recording.frames) {
    times.push_back(frame.t_ns);
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  for (const std::int64_t t_ns : times) {
    recording.truth.rig.push_back(run.rig_at(t_ns));
  }
}

double distance_at(const WorldScenario& w, double u) {
  return w.min_distance + (w.max_distance - w.min_distance) * u;
}

/// From the body to a point, in world axes; u uniform in (0, 1)^3.
Vector3d offset_around(const WorldScenario& w, const Vector3d& u) {
  const double azimuth = 2.0 * std::numbers::pi * u.y();
  const double sin_elevation = (2.0 * u.z() - 1.0) * std::sin(w.max_elevation);
  const double cos_elevation = std::sqrt(1.0 - sin_elevation * sin_elevation);
  return distance_at(w, u.x()) *
         Vector3d(cos_elevation * std::cos(azimuth), cos_elevation * std::sin(azimuth), sin_elevation);
}

/// In the body frame; straight ahead where the camera model ends before the image does.
Vector3d point_in_view(const Scenario& scenario, const Vector3d& u) {
  const StereoCalibration calibration = nominal_calibration(scenario);
  const Camera& camera = calibration.cam0;
  const Eigen::Vector2d uv(u.y() * camera.width, u.z() * camera.height);
  const Vector3d bearing = unproject(camera, uv).value_or(Vector3d::UnitZ());
  const double depth = distance_at(scenario.world, u.x());
  return body_from_cam0(calibration) *
         (bearing.z() > 0.0 ? Vector3d(bearing * (depth / bearing.z())) : bearing);
}

}  // namespace

std::vector<std::int64_t> sample_times(double rate, double duration) {
  std::vector<std::int64_t> times;
  const std::int64_t end_ns = std::llround(duration * 1e9);
  for (std::int64_t k = 0;; ++k) {
    const std::int64_t t_ns = std::llround(static_cast<double>(k) * 1e9 / rate);
    if (t_ns > end_ns) {
      return times;
    }
    times.push_back(t_ns);
  }
}

std::vector<Vector3d> make_world(const Scenario& scenario, const SplineTrajectory& trajectory,
                                 std::uint64_t seed, std::uint64_t run) {
  check_scenario(scenario);
  const RandomStream random(seed, scenario.same_world_in_all_runs ? 0 : run, "world");
  std::vector<Vector3d> points;
  for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(scenario.world.points); ++i) {
    const Pose T_world_body = trajectory.at(scenario.duration * random.uniform(i, 1)).T_world_body;
    const Vector3d u = random.uniform3(i, 0);
    points.push_back(scenario.world.placement == PointPlacement::kInView
                         ? T_world_body * point_in_view(scenario, u)
                         : T_world_body.p + offset_around(scenario.world, u));
  }
  return points;
}

StereoCalibration nominal_calibration(const Scenario& scenario) {
  const RigScenario& rig = scenario.rig;
  StereoCalibration calibration{rig.cam0, rig.cam1, rig.theta, rig.body, rig.T_imu_cam0};
  calibration.T_body_cam0.R = so3_normalized(rig.T_imu_cam0.R);
  // What a track log of cameras alone says when it is read back.
  const bool camera_only = !scenario.use_imu && !scenario.odometry;
  if (camera_only && rig.body == BodyFrame::kImu && rig.T_imu_cam0.R.isIdentity(0.0) &&
      rig.T_imu_cam0.p.isZero(0.0)) {
    calibration.body = BodyFrame::kCam0;
  }
  return calibration;
}

Recording simulate(const Scenario& scenario, std::uint64_t seed, std::uint64_t run) {
  SplineTrajectory trajectory = make_trajectory(scenario, seed, run);
  std::vector<Vector3d> world = make_world(scenario, trajectory, seed, run);
  const Run all{scenario,
                std::move(trajectory),
                std::move(world),
                Decalibration(scenario.decalibration, scenario.duration, seed, run),
                seed,
                run};
  Recording recording;
  recording.name = scenario.name;
  recording.calibration = nominal_calibration(scenario);
  fill_groundtruth(all, recording);
  if (scenario.use_imu) {
    fill_imu(all, recording);
  }
  if (scenario.odometry) {
    fill_odometry(all, *scenario.odometry, recording);
  }
  fill_frames(all, recording);
  fill_calibration_truth(all, recording);
  return recording;
}

}  // namespace limber
