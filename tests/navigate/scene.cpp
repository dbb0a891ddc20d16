// SPDX-License-Identifier: MIT
#include "navigate/scene.hpp"

#include <cmath>
#include <utility>

#include "check_covariance.hpp"
#include "limber/core/so3.hpp"

namespace limber::testing {
namespace {

/// Rate and, in the body frame without gravity, velocity (odometry) at time t.
Eigen::Vector3d sway_rate(double t) {
  return {0.2 * std::cos(1.1 * t), -0.25 * std::cos(0.9 * t + 0.5), 0.3 * std::cos(0.7 * t)};
}
Eigen::Vector3d sway_velocity(double t) {
  return {0.5 * std::cos(0.6 * t), 0.9 * std::cos(1.2 * t), 0.5 * std::cos(1.5 * t + 0.4)};
}
Eigen::Vector3d sway_acceleration(double t) {
  return {-0.3 * std::sin(0.6 * t), -1.08 * std::sin(1.2 * t), -0.75 * std::sin(1.5 * t + 0.4)};
}

/// Advances the truth over one interval between noise-free samples, as the filter does.
void advance(NavigationState& state, MotionModel motion, const InputSample& a, const InputSample& b,
             double dt) {
  const Eigen::Vector3d angular = 0.5 * (a.angular + b.angular);
  const Eigen::Vector3d linear = 0.5 * (a.linear + b.linear);
  switch (motion) {
    case MotionModel::kImu:
      (void)predict_imu(state, angular, linear, dt, {}, 9.81);
      break;
    case MotionModel::kConstantVelocity:
      (void)predict_constant_velocity(state, dt, {});
      break;
    case MotionModel::kOdometry:
      (void)predict_odometry(state, linear, angular, dt, {});
      break;
  }
}

class SceneMaker {
 public:
  explicit SceneMaker(const SceneOptions& options) : o_(options), generator_(options.seed) {
    scene_.made_of = options;
    scene_.calibration = scene_rig();
  }

  Scene make() {
    set_noise();
    set_start();
    set_landmarks();
    integrate();
    return scene_;
  }

 private:
  Eigen::VectorXd normal(Eigen::Index n) { return random_normal(generator_, n); }

  void set_noise() {
    NavigatorOptions& options = scene_.options;
    options.motion = o_.motion;
    options.sigma_px.setConstant(o_.sigma_px);
    options.imu_noise = {1e-3, 1e-5, 1e-2, 1e-4};
    options.odometry_noise.sigma_v.setConstant(0.05);
    options.odometry_noise.sigma_omega.setConstant(0.01);
    options.constant_velocity_noise = {0.05, 0.02};
  }

  /// The estimate starts beside the truth, by an error drawn from its covariance.
  void set_start() {
    const Eigen::Index n = StateLayout{o_.motion, false}.body_size();
    Eigen::VectorXd sigma(n);
    sigma.head<6>() << Eigen::Vector3d::Constant(0.01), Eigen::Vector3d::Constant(2e-3);
    if (n > 6) {
      sigma.segment<3>(6).setConstant(0.02);
      sigma.tail(n - 9).setConstant(1e-3);
    }
    if (n == 15) {
      sigma.tail<3>().setConstant(0.02);
    }
    const Eigen::VectorXd e =
        o_.noise ? Eigen::VectorXd(sigma.cwiseProduct(normal(n))) : Eigen::VectorXd::Zero(n);
    scene_.initial.body_covariance = sigma.cwiseAbs2().asDiagonal();

    const Eigen::Matrix3d turn = so3_exp(Eigen::Vector3d(0.0, 0.0, o_.yaw));
    NavigationState truth;
    truth.T_world_body = {turn, o_.shift};
    truth.v_world_body = turn * (o_.motion == MotionModel::kConstantVelocity ? Eigen::Vector3d(0.3, -0.4, 0.1)
                                                                             : sway_velocity(0.0));
    if (o_.motion == MotionModel::kConstantVelocity) {
      truth.omega_body << 0.05, -0.08, 0.1;
    }
    truth_ = truth;
    NavigationState& nav = scene_.initial.nav;
    nav = truth;
    nav.T_world_body.p -= turn * e.segment<3>(0);
    nav.T_world_body.R = nav.T_world_body.R * so3_exp(-e.segment<3>(3));
    if (n > 6) {
      nav.v_world_body -= turn * e.segment<3>(6);
    }
    if (o_.motion == MotionModel::kConstantVelocity) {
      nav.omega_body -= e.segment<3>(9);
    }
    if (o_.motion == MotionModel::kImu) {
      truth_.bias_gyro = e.segment<3>(9);
      truth_.bias_accel = e.segment<3>(12);
    }
  }

  void set_landmarks() {
    const Pose world{so3_exp(Eigen::Vector3d(0.0, 0.0, o_.yaw)), o_.shift};
    for (int k = 0; k < o_.points; ++k) {
      const double x = 2.5 * std::pow(8.0, random_scalar(generator_, 0.0, 1.0));
      const double z = x * random_scalar(generator_, -0.6, 0.6);
      scene_.landmarks.push_back(world * Eigen::Vector3d(x, x * random_scalar(generator_, -0.8, 0.8), z));
    }
  }

  /// What the sensors would say of the truth now, without noise.
  [[nodiscard]] InputSample clean_sample(std::int64_t t_ns) const {
    const double t = 1e-9 * static_cast<double>(t_ns);
    if (o_.motion == MotionModel::kOdometry) {
      return {t_ns, sway_rate(t), sway_velocity(t)};
    }
    const Eigen::Vector3d g(0.0, 0.0, 9.81);
    const Eigen::Matrix3d turn = so3_exp(Eigen::Vector3d(0.0, 0.0, o_.yaw));
    return {t_ns, sway_rate(t) + truth_.bias_gyro,
            truth_.T_world_body.R.transpose() * (turn * sway_acceleration(t) + g) + truth_.bias_accel};
  }

  [[nodiscard]] InputSample noisy(InputSample sample) {
    if (!o_.noise) {
      return sample;
    }
    const double root_rate = 1.0 / std::sqrt(1e-3 * static_cast<double>(o_.input_ms));
    const NavigatorOptions& options = scene_.options;
    if (o_.motion == MotionModel::kOdometry) {
      sample.linear += options.odometry_noise.sigma_v.cwiseProduct(normal(3));
      sample.angular += options.odometry_noise.sigma_omega.cwiseProduct(normal(3));
    } else {
      sample.angular += root_rate * options.imu_noise.gyro_density * normal(3);
      sample.linear += root_rate * options.imu_noise.accel_density * normal(3);
    }
    return sample;
  }

  void shoot(std::int64_t t_ns) {
    StereoCalibration rig = scene_.calibration;
    rig.theta += o_.theta_error(1e-9 * static_cast<double>(t_ns));
    scene_.theta_true.push_back(rig.theta);
    scene_.truth.push_back(truth_);
    scene_.truth.back().t_ns = t_ns;
    const MountedRig cameras = mount(rig);
    StereoFrame frame;
    frame.t_ns = t_ns;
    for (std::size_t k = 0; k < scene_.landmarks.size(); ++k) {
      const Eigen::Vector3d X_body = truth_.T_world_body.inverse() * scene_.landmarks[k];
      StereoObservation observation;
      observation.track_id = static_cast<std::int64_t>(k);
      const auto see = [&](const MountedCamera& camera, Eigen::Vector2d& uv) {
        const auto projection = project(camera.camera, camera.T_cam_body * X_body);
        if (!projection || !in_image(camera.camera, projection->uv)) {
          return false;
        }
        uv = projection->uv;
        if (o_.noise) {
          uv += o_.sigma_px * normal(2);
        }
        return true;
      };
      observation.in_cam0 = see(cameras[0], observation.uv_cam0);
      observation.in_cam1 = see(cameras[1], observation.uv_cam1);
      if (observation.in_cam0 || observation.in_cam1) {
        frame.observations.push_back(observation);
      }
    }
    scene_.frames.push_back(frame);
  }

  /// Runs the truth from event to event: input samples and frames, on one millisecond grid.
  void integrate() {
    const auto end_ms = static_cast<std::int64_t>(1e3 * o_.duration_s);
    InputSample from = clean_sample(0);
    scene_.inputs.push_back(noisy(from));
    for (std::int64_t t = 0; t < end_ms; t += o_.input_ms) {
      // The attitude at the next sample decides its specific force: find it first.
      NavigationState ahead = truth_;
      InputSample rate_only = clean_sample((t + o_.input_ms) * kMs);
      const double dt = 1e-3 * static_cast<double>(o_.input_ms);
      advance(ahead, o_.motion, from, rate_only, dt);
      std::swap(ahead.T_world_body.R, truth_.T_world_body.R);
      const InputSample to = clean_sample((t + o_.input_ms) * kMs);
      std::swap(ahead.T_world_body.R, truth_.T_world_body.R);
      scene_.inputs.push_back(noisy(to));
      const std::int64_t into = (t - o_.frame_offset_ms) % o_.frame_ms;
      const std::int64_t wait = into <= 0 ? -into : o_.frame_ms - into;
      if (wait < o_.input_ms) {
        const double s = static_cast<double>(wait) / static_cast<double>(o_.input_ms);
        const InputSample middle{0, (1.0 - s) * from.angular + s * to.angular,
                                 (1.0 - s) * from.linear + s * to.linear};
        if (wait > 0) {
          advance(truth_, o_.motion, from, middle, s * dt);
        }
        shoot((t + wait) * kMs);
        advance(truth_, o_.motion, middle, to, (1.0 - s) * dt);
      } else {
        advance(truth_, o_.motion, from, to, dt);
      }
      from = to;
    }
  }

  SceneOptions o_;
  Generator generator_;
  Scene scene_;
  NavigationState truth_;
};

}  // namespace

StereoCalibration scene_rig() {
  StereoCalibration out;
  out.cam0 = {455.0, 450.0, 376.0, 240.0, 752, 480, NoDistortion{}};
  out.cam1 = {460.0, 458.0, 370.0, 245.0, 752, 480, NoDistortion{}};
  out.theta << 0.01, -0.02, 0.005, -0.3, 0.003, -0.006;
  out.body = BodyFrame::kImu;
  // Camera z is body x (forward), camera x is body −y, camera y is body −z.
  out.T_body_cam0.R << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  out.T_body_cam0.p << 0.05, 0.15, 0.02;
  return out;
}

Scene make_scene(const SceneOptions& options) { return SceneMaker(options).make(); }

RigParameters scene_theta_error() {
  return (RigParameters() << 0.004, -0.008, 0.008, 0.03, -0.01, 0.008).finished();
}

SceneOptions wrong_rig(std::uint64_t seed) {
  SceneOptions options;
  options.seed = seed;
  options.theta_error = [](double) { return scene_theta_error(); };
  return options;
}

Feeder::Feeder(const Scene& scene, const NavigatorOptions& options)
    : navigator(options, scene.calibration, scene.initial), scene_(scene) {}

void Feeder::feed_inputs(std::int64_t t_ns) {
  while (next_ < scene_.inputs.size() && (next_ == 0 || scene_.inputs[next_ - 1].t_ns < t_ns)) {
    const InputSample& sample = scene_.inputs[next_++];
    if (scene_.made_of.motion == MotionModel::kImu) {
      navigator.add_imu({sample.t_ns, sample.angular, sample.linear});
    } else if (scene_.made_of.motion == MotionModel::kOdometry) {
      navigator.add_odometry({sample.t_ns, sample.linear, sample.angular});
    }
  }
}

FrameReport Feeder::process(const StereoFrame& frame) {
  feed_inputs(frame.t_ns);
  return navigator.process(frame);
}

void run(const Scene& scene, const NavigatorOptions& options,
         const std::function<void(StereoFilter&, std::size_t, const FrameReport&)>& after,
         const std::function<void(StereoFilter&, std::size_t)>& before) {
  Feeder feeder(scene, options);
  for (std::size_t k = 0; k < scene.frames.size(); ++k) {
    if (before) {
      before(feeder.navigator, k);
    }
    const FrameReport report = feeder.process(scene.frames[k]);
    after(feeder.navigator, k, report);
  }
}

NavigatorOptions with_method(const Scene& scene, Method method, LandmarkKind kind) {
  NavigatorOptions options = scene.options;
  options.method = method;
  options.landmarks = kind;
  return options;
}

Eigen::Matrix<double, 6, 1> pose_error(const StereoFilter& navigator, const NavigationState& truth) {
  const Pose& estimate = navigator.estimate().nav().T_world_body;
  Eigen::Matrix<double, 6, 1> out;
  out << truth.T_world_body.p - estimate.p, so3_log(estimate.R.transpose() * truth.T_world_body.R);
  return out;
}

double position_error(const StereoFilter& navigator, const NavigationState& truth) {
  return pose_error(navigator, truth).head<3>().norm();
}

}  // namespace limber::testing
