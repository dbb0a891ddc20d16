// SPDX-License-Identifier: MIT
// What goes into a navigator and comes out of it: options, states, reports.
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <Eigen/Geometry>

#include "arrays.hpp"
#include "bindings.hpp"
#include "body_state.hpp"
#include "docs.hpp"
#include "dtypes.hpp"
#include "limber/core/nearest_word.hpp"
#include "limber/navigate/navigator.hpp"
#include "limber/state/initial_state.hpp"

namespace limber::python {
namespace {

MotionModel motion_from_string(const std::string& name) {
  if (name == "imu") {
    return MotionModel::kImu;
  }
  if (name == "odometry") {
    return MotionModel::kOdometry;
  }
  if (name == "constant-velocity") {
    return MotionModel::kConstantVelocity;
  }
  throw py::value_error("motion: expected imu, odometry or constant-velocity, found '" + name + "'");
}

ParameterVector sigmas_of(const std::map<std::string, double>& sigmas, const char* what) {
  ParameterVector out = ParameterVector::Zero();
  for (const auto& [name, sigma] : sigmas) {
    const auto named = parameters_named(name);
    if (!named) {
      throw py::value_error(std::string(what) + ": expected names of parameters or groups, found '" + name +
                            "'" + did_you_mean(name, parameter_words()));
    }
    for (std::size_t k = 0; k < named->size(); ++k) {
      if (named->test(k)) {
        out(static_cast<Eigen::Index>(k)) = sigma;
      }
    }
  }
  return out;
}

NavigatorOptions make_options(const std::string& method, const std::string& constraints,
                              const std::string& motion, const std::map<std::string, double>& estimated,
                              const std::map<std::string, double>& softened,
                              const std::variant<double, PixelNoise>& sigma_px, const ImuNoise& imu_noise,
                              const OdometryNoise& odometry_noise, double gravity,
                              const RigParameters& theta_sigma, bool gate, std::size_t max_landmarks,
                              std::optional<std::size_t> points_per_update, bool learn_pixel_noise,
                              bool learn_odometry_noise, bool learn_imu_noise, bool learn_imu_clock,
                              bool learn_motion_noise, bool doubt_odometry_mount, double odometry_scale,
                              bool carries_scale, std::optional<double> false_alarms_per_hour) {
  NavigatorOptions options;
  options.method = method_from_string(method);
  options.constraints = constraint_set_from_string(constraints);
  options.motion = motion_from_string(motion);
  options.estimated = sigmas_of(estimated, "estimated");
  options.softened = sigmas_of(softened, "softened");
  if (const auto* sigma = std::get_if<double>(&sigma_px)) {
    options.sigma_px.setConstant(*sigma);
  } else {
    options.sigma_px = std::get<PixelNoise>(sigma_px);
  }
  options.learn_pixel_noise = learn_pixel_noise;
  options.learn_odometry_noise = learn_odometry_noise;
  options.learn_imu_noise = learn_imu_noise;
  options.learn_imu_clock = learn_imu_clock;
  options.learn_motion_noise = learn_motion_noise;
  options.doubt_odometry_mount = doubt_odometry_mount;
  options.odometry_scale = odometry_scale;
  options.carries_scale = carries_scale;
  options.imu_noise = imu_noise;
  options.odometry_noise = odometry_noise;
  options.gravity = gravity;
  options.theta_sigma = theta_sigma;
  options.gate = gate;
  options.map.max_landmarks = max_landmarks;
  options.map.points_per_update = points_per_update.value_or(options.map.points_per_update);
  options.health.reset();
  if (false_alarms_per_hour) {
    options.health = HealthOptions{};
    options.health->false_alarms_per_hour = *false_alarms_per_hour;
  }
  return options;
}

void bind_options(py::module_& module) {
  const NavigatorOptions defaults;
  py::class_<NavigatorOptions>(module, "NavigatorOptions", DOC(NavigatorOptions))
      .def(
          py::init(&make_options), py::kw_only(), py::arg("method") = "lcekf",
          py::arg("constraints") = "full", py::arg("motion") = "imu",
          py::arg("estimated") = std::map<std::string, double>{},
          py::arg("softened") = std::map<std::string, double>{}, py::arg("sigma_px") = 0.5,
          py::arg("imu_noise") = ImuNoise{}, py::arg("odometry_noise") = OdometryNoise{},
          py::arg("gravity") = defaults.gravity, py::arg("theta_sigma") = defaults.theta_sigma,
          py::arg("gate") = defaults.gate, py::arg("max_landmarks") = defaults.map.max_landmarks,
          py::arg("points_per_update") = py::none(),
          py::arg("learn_pixel_noise") = defaults.learn_pixel_noise,
          py::arg("learn_odometry_noise") = defaults.learn_odometry_noise,
          py::arg("learn_imu_noise") = defaults.learn_imu_noise,
          py::arg("learn_imu_clock") = defaults.learn_imu_clock,
          py::arg("learn_motion_noise") = defaults.learn_motion_noise,
          py::arg("doubt_odometry_mount") = defaults.doubt_odometry_mount,
          py::arg("odometry_scale") = defaults.odometry_scale,
          py::arg("carries_scale") = defaults.carries_scale,
          py::arg("false_alarms_per_hour") = defaults.health->false_alarms_per_hour,
          "method: ekf, ekf-full, lcekf, soft, consider, adaptive, mono-left or oracle\n"
          "constraints: lcekf: full, rotation, rotation+direction, or a list such as 'ax,ay,dt1'\n"
          "motion: imu, odometry or constant-velocity\n"
          "estimated, softened: {parameter or group: standard deviation [rad, m, px, s]}\n"
          "sigma_px: pixel noise, one number or (u0, v0, u1, v1)\n"
          "learn_pixel_noise: sigma_px is but where to begin, as in limber.run where a recording states "
          "none\n"
          "learn_odometry_noise: the same of odometry_noise\n"
          "learn_imu_noise: imu_noise is the least, as in limber.run: as much more as images ask for is "
          "learned\n"
          "learn_imu_clock: a start from the sensors finds how much later than taken samples are stamped, as "
          "in limber.run\n"
          "learn_motion_noise: the same of accelerations where the motion is constant-velocity\n"
          "doubt_odometry_mount: the odometer may be turned against the camera by 0.5 deg, otherwise a third "
          "of a second later; as in limber.run where a recording states no noise of odometry\n"
          "odometry_scale: by what share its speeds may be long or short all the time, 1 sigma\n"
          "carries_scale: False is the paper's filter, too sure of its scale with some hundred points\n"
          "false_alarms_per_hour: of the calibration monitor; None switches it off")
      .def_property_readonly("method",
                             [](const NavigatorOptions& options) { return to_string(options.method); })
      .def_property_readonly("motion",
                             [](const NavigatorOptions& options) {
                               switch (options.motion) {
                                 case MotionModel::kImu:
                                   return "imu";
                                 case MotionModel::kOdometry:
                                   return "odometry";
                                 case MotionModel::kConstantVelocity:
                                   break;
                               }
                               return "constant-velocity";
                             })
      .def_readonly("sigma_px", &NavigatorOptions::sigma_px)
      .def_readonly("gravity", &NavigatorOptions::gravity);
}

void bind_states(py::module_& module) {
  py::class_<State>(module, "State", "The body at a time: mean, and covariance of its error state.")
      .def_property_readonly("t_ns", [](const State& s) { return s.nav.t_ns; })
      .def_property_readonly("T_world_body", [](const State& s) { return s.nav.T_world_body; })
      .def_property_readonly(
          "p", [](const State& s) { return s.nav.T_world_body.p; }, "Position in the world [m].")
      .def_property_readonly(
          "R", [](const State& s) { return s.nav.T_world_body.R; }, "R_world_body.")
      .def_property_readonly(
          "q_wxyz",
          [](const State& s) {
            const Eigen::Quaterniond q(s.nav.T_world_body.R);
            return Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
          },
          "The attitude as a quaternion (w, x, y, z).")
      .def_property_readonly(
          "v", [](const State& s) { return s.nav.v_world_body; }, DOC(NavigationState_v_world_body))
      .def_property_readonly(
          "omega", [](const State& s) { return s.nav.omega_body; }, DOC(NavigationState_omega_body))
      .def_property_readonly(
          "bias_gyro", [](const State& s) { return s.nav.bias_gyro; }, DOC(NavigationState_bias_gyro))
      .def_property_readonly(
          "bias_accel", [](const State& s) { return s.nav.bias_accel; }, DOC(NavigationState_bias_accel))
      .def_readonly("covariance", &State::covariance,
                    "Of position [m], attitude error (body frame) [rad], and what the motion model adds: "
                    "velocity, gyro and accelerometer bias (imu, 15x15), velocity and rate (12x12), nothing "
                    "(odometry, 6x6).");

  const InitialSigma sigma;
  py::class_<InitialState>(module, "InitialState", DOC(InitialState))
      .def(py::init([](const std::string& motion, std::int64_t t_ns, const Eigen::Vector3d& p,
                       const Eigen::Matrix3d& R, const Eigen::Vector3d& v, const Eigen::Vector3d& bias_gyro,
                       const Eigen::Vector3d& bias_accel, double sigma_p, double sigma_R, double sigma_v,
                       double sigma_bias_gyro, double sigma_bias_accel) {
             NavigationState nav;
             nav.t_ns = t_ns;
             nav.T_world_body = {R, p};
             nav.v_world_body = v;
             nav.bias_gyro = bias_gyro;
             nav.bias_accel = bias_accel;
             InitialSigma sigmas;
             sigmas.position = sigma_p;
             sigmas.attitude = sigma_R;
             sigmas.velocity = sigma_v;
             sigmas.bias_gyro = sigma_bias_gyro;
             sigmas.bias_accel = sigma_bias_accel;
             return make_initial_state(nav, motion_from_string(motion), sigmas);
           }),
           py::arg("motion") = "imu", py::kw_only(), py::arg("t_ns") = 0,
           py::arg("p") = Eigen::Vector3d(Eigen::Vector3d::Zero()),
           py::arg("R") = Eigen::Matrix3d(Eigen::Matrix3d::Identity()),
           py::arg("v") = Eigen::Vector3d(Eigen::Vector3d::Zero()),
           py::arg("bias_gyro") = Eigen::Vector3d(Eigen::Vector3d::Zero()),
           py::arg("bias_accel") = Eigen::Vector3d(Eigen::Vector3d::Zero()),
           py::arg("sigma_p") = sigma.position, py::arg("sigma_R") = sigma.attitude,
           py::arg("sigma_v") = sigma.velocity, py::arg("sigma_bias_gyro") = sigma.bias_gyro,
           py::arg("sigma_bias_accel") = sigma.bias_accel,
           "A known start: means in the world, and standard deviations per axis [m, rad, m/s, rad/s, m/s^2].")
      .def_property_readonly("state", [](const InitialState& initial) {
        return State{initial.nav, initial.body_covariance};
      });
}

void bind_health_report(py::module_& module) {
  py::class_<HealthReport>(module, "HealthReport", DOC(HealthReport))
      .def_readonly("t_ns", &HealthReport::t_ns)
      .def_property_readonly(
          "verdict", [](const HealthReport& report) { return to_string(report.verdict); },
          "'ok', 'suspect', 'decalibrated' or 'cannot tell'.")
      .def_property_readonly(
          "axes",
          [](const HealthReport& report) {
            py::dict out;
            for (std::size_t k = 0; k < report.axes.size(); ++k) {
              out[py::str(std::string(kParameterNames[k]))] = to_string(report.axes[k]);
            }
            return out;
          },
          "The verdict of each of ax, ay, az, tx, ty, tz.")
      .def_readonly("delta", &HealthReport::delta, DOC(HealthReport_delta))
      .def_readonly("sigma", &HealthReport::sigma, DOC(HealthReport_sigma))
      .def_readonly("gathered_delta", &HealthReport::gathered_delta, DOC(HealthReport_gathered_delta))
      .def_readonly("gathered_sigma", &HealthReport::gathered_sigma, DOC(HealthReport_gathered_sigma))
      .def_readonly("gathered_since_ns", &HealthReport::gathered_since_ns)
      .def_readonly("p_value", &HealthReport::p_value, DOC(HealthReport_p_value))
      .def_readonly("gathered_p_value", &HealthReport::gathered_p_value, DOC(HealthReport_gathered_p_value))
      .def_readonly("alarm", &HealthReport::alarm, DOC(HealthReport_alarm))
      .def_readonly("changed_ns", &HealthReport::changed_ns, DOC(HealthReport_changed_ns));
}

void bind_frame_report(py::module_& module) {
  py::class_<Refusal>(module, "Refusal", DOC(Refusal))
      .def_readonly("track_id", &Refusal::track_id)
      .def_property_readonly("reason",
                             [](const Refusal& refusal) {
                               return refusal.reason == RefusalReason::kGate ? "gate" : "not projectable";
                             })
      .def_readonly("distance", &Refusal::distance, DOC(Refusal_distance))
      .def_readonly("threshold", &Refusal::threshold, DOC(Refusal_threshold));
  py::class_<FrameReport>(module, "FrameReport", DOC(FrameReport))
      .def_readonly("t_ns", &FrameReport::t_ns)
      .def_property_readonly(
          "status", [](const FrameReport& report) { return to_string(report.status); },
          "'updated', 'no points' or 'singular': unless updated, the frame corrected nothing.")
      .def_property_readonly(
          "inputs", [](const FrameReport& report) { return to_string(report.inputs.status); },
          "What the prediction rested on: 'sound', 'faulty', 'gap', 'contradicted', 'none' or 'not needed'.")
      .def_property_readonly(
          "gap_s", [](const FrameReport& report) { return report.inputs.gap_s; }, DOC(InputReport_gap_s))
      .def_property_readonly(
          "imu_noise",
          [](const FrameReport& report) { return std::pair(report.imu_noise.gyro, report.imu_noise.accel); },
          DOC(FrameReport_imu_noise))
      .def_property_readonly(
          "inputs_chi2", [](const FrameReport& report) { return report.inputs.chi2; }, DOC(InputReport_chi2))
      .def_readonly("reset", &FrameReport::reset, DOC(FrameReport_reset))
      .def_readonly("sigma_px", &FrameReport::sigma_px, DOC(FrameReport_sigma_px))
      .def_readonly("nis", &FrameReport::nis, DOC(FrameReport_nis))
      .def_readonly("dof", &FrameReport::dof, DOC(FrameReport_dof))
      .def_readonly("rank", &FrameReport::rank, DOC(FrameReport_rank))
      .def_readonly("observed", &FrameReport::observed)
      .def_readonly("used", &FrameReport::used, DOC(FrameReport_used))
      .def_readonly("initialized", &FrameReport::initialized, DOC(FrameReport_initialized))
      .def_readonly("removed", &FrameReport::removed)
      .def_readonly("refused", &FrameReport::refused)
      .def_readonly("health", &FrameReport::health, DOC(FrameReport_health));
  bind_sequence<FrameReport>(module, "FrameReports", "Reports of the frames of a run, a read-only sequence.");
}

}  // namespace

void bind_navigator_data(py::module_& module) {
  bind_options(module);
  bind_states(module);
  bind_health_report(module);
  bind_frame_report(module);
}

}  // namespace limber::python
