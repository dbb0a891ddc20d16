// SPDX-License-Identifier: MIT
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <Eigen/Geometry>

#include "arrays.hpp"
#include "bindings.hpp"
#include "docs.hpp"
#include "dtypes.hpp"
#include "limber/core/nearest_word.hpp"
#include "limber/initialize/online_navigator.hpp"
#include "limber/initialize/sensor_start.hpp"
#include "limber/navigate/navigator.hpp"
#include "limber/state/initial_state.hpp"

namespace limber::python {
namespace {

/// What is known of the body at a time.
struct State {
  NavigationState nav;
  Eigen::MatrixXd covariance;
};

Eigen::MatrixXd body_covariance(const Estimate& estimate) {
  const Eigen::Index size = estimate.layout().body_size();
  return estimate.P.block(0, 0, size, size);
}

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
                              bool learn_pixel_noise, bool learn_odometry_noise,
                              std::optional<double> false_alarms_per_hour) {
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
  options.imu_noise = imu_noise;
  options.odometry_noise = odometry_noise;
  options.gravity = gravity;
  options.theta_sigma = theta_sigma;
  options.gate = gate;
  options.map.max_landmarks = max_landmarks;
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
      .def(py::init(&make_options), py::kw_only(), py::arg("method") = "lcekf",
           py::arg("constraints") = "full", py::arg("motion") = "imu",
           py::arg("estimated") = std::map<std::string, double>{},
           py::arg("softened") = std::map<std::string, double>{}, py::arg("sigma_px") = 0.5,
           py::arg("imu_noise") = ImuNoise{}, py::arg("odometry_noise") = OdometryNoise{},
           py::arg("gravity") = defaults.gravity, py::arg("theta_sigma") = defaults.theta_sigma,
           py::arg("gate") = defaults.gate, py::arg("max_landmarks") = defaults.map.max_landmarks,
           py::arg("learn_pixel_noise") = defaults.learn_pixel_noise,
           py::arg("learn_odometry_noise") = defaults.learn_odometry_noise,
           py::arg("false_alarms_per_hour") = defaults.health->false_alarms_per_hour,
           "method: ekf, ekf-full, lcekf, soft, consider, adaptive, mono-left or oracle\n"
           "constraints: lcekf: full, rotation, rotation+direction, or a list such as 'ax,ay,dt1'\n"
           "motion: imu, odometry or constant-velocity\n"
           "estimated, softened: {parameter or group: standard deviation [rad, m, px, s]}\n"
           "sigma_px: pixel noise, one number or (u0, v0, u1, v1)\n"
           "learn_pixel_noise: sigma_px is but where to begin, as in limber.run where a recording states "
           "none\n"
           "learn_odometry_noise: the same of odometry_noise\n"
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
      .def_readonly("reset", &FrameReport::reset, DOC(FrameReport_reset))
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

/// Rows of a structured array where they lie, to be read without Python.
template <typename Sample>
class Rows {
 public:
  Rows(const py::array& rows, const py::dtype& expected) {
    if (rows.ndim() != 1 || !rows.dtype().equal(expected)) {
      throw py::value_error("samples: expected rows of " + std::string(py::str(py::object(expected))) +
                            ", found " + std::string(py::str(py::object(rows.dtype()))));
    }
    first_ = static_cast<const char*>(rows.data());
    size_ = rows.shape(0);
    stride_ = rows.strides(0);
  }

  template <typename Use>
  void for_each(Use use) const {
    for (py::ssize_t k = 0; k < size_; ++k) {
      use(*reinterpret_cast<const Sample*>(first_ + k * stride_));
    }
  }

 private:
  const char* first_;
  py::ssize_t size_, stride_;
};

/// add_imu and add_odometry, one sample or many, of whatever takes them.
template <typename Class>
void bind_inputs(Class& bound) {
  using Owner = typename Class::type;
  bound
      .def(
          "add_imu",
          [](Owner& self, std::int64_t t_ns, const Eigen::Vector3d& omega, const Eigen::Vector3d& accel) {
            self.with([&](auto& value) { value.add_imu({t_ns, omega, accel}); });
          },
          py::arg("t_ns"), py::arg("omega"), py::arg("accel"), DOC(StereoFilter_add_imu))
      .def(
          "add_imu",
          [](Owner& self, const py::array& samples) {
            const Rows<ImuSample> rows(samples, imu_dtype());
            self.with(
                [&](auto& value) { rows.for_each([&](const ImuSample& sample) { value.add_imu(sample); }); });
          },
          py::arg("samples"), "Many at once: rows of Recording.imu.")
      .def(
          "add_odometry",
          [](Owner& self, std::int64_t t_ns, const Eigen::Vector3d& v, const Eigen::Vector3d& omega) {
            self.with([&](auto& value) { value.add_odometry({t_ns, v, omega}); });
          },
          py::arg("t_ns"), py::arg("v"), py::arg("omega"),
          "Velocity [m/s] and angular rate [rad/s] in the body frame.")
      .def(
          "add_odometry",
          [](Owner& self, const py::array& samples) {
            const Rows<OdometrySample> rows(samples, odometry_dtype());
            self.with([&](auto& value) {
              rows.for_each([&](const OdometrySample& sample) { value.add_odometry(sample); });
            });
          },
          py::arg("samples"), "Many at once: rows of Recording.odometry.");
}

template <typename T>
py::tuple landmarks_of(Guarded<T>& self) {
  auto [ids, positions] = self.with([](const T& navigator) {
    const Estimate& estimate = navigator.estimate();
    std::vector<std::int64_t> track_ids;
    for (const Landmark& landmark : estimate.landmarks()) {
      track_ids.push_back(landmark.track_id);
    }
    return std::pair(track_ids, estimate.landmark_positions());
  });
  py::array_t<double> p({static_cast<py::ssize_t>(positions.size()), py::ssize_t{3}});
  for (std::size_t k = 0; k < positions.size(); ++k) {
    Eigen::Vector3d::Map(p.mutable_data() + 3 * k) = positions[k];
  }
  return py::make_tuple(py::array_t<std::int64_t>(static_cast<py::ssize_t>(ids.size()), ids.data()), p);
}

template <typename T>
py::dict calibration_estimate_of(Guarded<T>& self) {
  const CalibrationEstimate estimate =
      self.with([](const T& navigator) { return navigator.calibration_estimate(); });
  py::dict out;
  for (std::size_t k = 0; k < estimate.parameters.size(); ++k) {
    if (estimate.parameters.test(k)) {
      const auto i = static_cast<Eigen::Index>(k);
      out[py::str(std::string(kParameterNames[k]))] = py::make_tuple(estimate.error(i), estimate.sigma(i));
    }
  }
  return out;
}

/// What may be asked of a navigator, however it was started.
template <typename T>
void bind_state_of(py::class_<Guarded<T>>& bound) {
  using Owner = Guarded<T>;
  bound
      .def(
          "predict",
          [](Owner& self, std::int64_t t_ns) {
            return self.with([&](const T& navigator) {
              const PredictedState predicted = navigator.predict(t_ns);
              return State{predicted.nav, predicted.body_covariance};
            });
          },
          py::arg("t_ns"), DOC(Navigator_predict))
      .def(
          "estimate",
          [](Owner& self) {
            return self.with([](const T& navigator) {
              const Estimate& estimate = navigator.estimate();
              return State{estimate.nav, body_covariance(estimate)};
            });
          },
          "The body after the last frame, with its covariance.")
      .def("landmarks", &landmarks_of<T>, "The map: track ids (N,), positions in the world (N, 3) [m].")
      .def(
          "assume_theta",
          [](Owner& self, const RigParameters& theta) {
            self.with([&](T& navigator) { navigator.assume_theta(theta); });
          },
          py::arg("theta"), DOC(Navigator_assume_theta))
      .def("calibration_estimate", &calibration_estimate_of<T>,
           "What was learned of the given calibration: {parameter: (true minus given, its sigma)}, of those "
           "that are estimated.")
      .def_property_readonly(
          "calibration",
          [](Owner& self) {
            return self.with([](const T& navigator) -> StereoCalibration { return navigator.calibration(); });
          },
          DOC(Navigator_calibration))
      .def_property_readonly(
          "health",
          [](Owner& self) {
            return self.with(
                [](const T& navigator) -> std::optional<HealthReport> { return navigator.health(); });
          },
          DOC(Navigator_health));
}

void bind_navigator(py::module_& module) {
  using Bound = Guarded<Navigator>;
  py::class_<Bound> bound(module, "Navigator", DOC(Navigator));
  bound.def(py::init([](const StereoCalibration& calibration, const InitialState& initial,
                        const NavigatorOptions& options) {
              return std::make_unique<Bound>(options, calibration, initial);
            }),
            py::arg("calibration"), py::arg("initial"), py::arg("options"), DOC(Navigator_Navigator));
  bind_inputs(bound);
  bound
      .def(
          "process",
          [](Bound& self, const StereoFrame& frame) {
            return self.with([&](Navigator& navigator) { return navigator.process(frame); });
          },
          py::arg("frame"), DOC(StereoFilter_process))
      .def(
          "reset",
          [](Bound& self, const InitialState& initial) {
            self.with([&](Navigator& navigator) { navigator.reset(initial); });
          },
          py::arg("initial"), DOC(Navigator_reset));
  bind_state_of(bound);
}

std::string to_string(StartStatus status) {
  switch (status) {
    case StartStatus::kWaiting:
      return "waiting";
    case StartStatus::kReady:
      return "ready";
    case StartStatus::kTimedOut:
      break;
  }
  return "timed out";
}

StartOptions start_options(double longest_s, double longest_moving_s, double shortest_s) {
  StartOptions out;
  out.longest_s = longest_s;
  out.longest_moving_s = longest_moving_s;
  out.shortest_s = shortest_s;
  return out;
}

/// A constructor from calibration, options and what of StartOptions one may choose.
template <typename T>
void bind_start_of(py::class_<Guarded<T>>& bound) {
  const StartOptions defaults;
  bound.def(py::init([](const StereoCalibration& calibration, const NavigatorOptions& options,
                        double longest_s, double longest_moving_s, double shortest_s) {
              return std::make_unique<Guarded<T>>(options, calibration,
                                                  start_options(longest_s, longest_moving_s, shortest_s));
            }),
            py::arg("calibration"), py::arg("options"), py::arg("longest_s") = defaults.longest_s,
            py::arg("longest_moving_s") = defaults.longest_moving_s,
            py::arg("shortest_s") = defaults.shortest_s, DOC(StartOptions));
}

void bind_start(py::module_& module) {
  py::class_<StartReport>(module, "StartReport", DOC(StartReport))
      .def_property_readonly(
          "status", [](const StartReport& report) { return to_string(report.status); },
          "'waiting', 'ready' or 'timed out' (ready as well, but `missing` is not known).")
      .def_readonly("waited_s", &StartReport::waited_s, DOC(StartReport_waited_s))
      .def_readonly("tilt_sigma", &StartReport::tilt_sigma, DOC(StartReport_tilt_sigma))
      .def_readonly("scale_sigma", &StartReport::scale_sigma, DOC(StartReport_scale_sigma))
      .def_readonly("missing", &StartReport::missing, DOC(StartReport_missing));
  using BoundStart = Guarded<SensorStart>;
  py::class_<BoundStart> bound(module, "SensorStart", DOC(SensorStart));
  bind_start_of(bound);
  bind_inputs(bound);
  bound
      .def(
          "add_frame",
          [](BoundStart& self, const StereoFrame& frame) {
            return self.with([&](SensorStart& it) { return it.add_frame(frame); });
          },
          py::arg("frame"), DOC(SensorStart_add_frame))
      .def(
          "result",
          [](BoundStart& self) { return self.with([](SensorStart& it) { return it.result().initial; }); },
          "The state at the last frame that was used, with a first map, to start a Navigator from; whatever "
          "the\n"
          "status. Raises ValueError if there was no frame yet")
      .def(
          "unused",
          [](BoundStart& self) { return self.with([](SensorStart& it) { return it.result().unused; }); },
          DOC(SensorStartResult_unused));
}

void bind_online_navigator(py::module_& module) {
  py::class_<OnlineReport>(module, "OnlineReport", DOC(OnlineReport))
      .def_readonly("t_ns", &OnlineReport::t_ns)
      .def_readonly("start", &OnlineReport::start, DOC(OnlineReport_start))
      .def_readonly("frame", &OnlineReport::frame, DOC(OnlineReport_frame));
  using Bound = Guarded<OnlineNavigator>;
  py::class_<Bound> bound(module, "OnlineNavigator", DOC(OnlineNavigator));
  bind_start_of(bound);
  bind_inputs(bound);
  bound
      .def(
          "process",
          [](Bound& self, const StereoFrame& frame) {
            return self.with([&](OnlineNavigator& navigator) { return navigator.process(frame); });
          },
          py::arg("frame"), DOC(OnlineNavigator_process))
      .def(
          "reset",
          [](Bound& self, const std::optional<InitialState>& initial) {
            self.with(
                [&](OnlineNavigator& navigator) { initial ? navigator.reset(*initial) : navigator.reset(); });
          },
          py::arg("initial") = py::none(), DOC(OnlineNavigator_reset))
      .def_property_readonly(
          "started",
          [](Bound& self) {
            return self.with([](const OnlineNavigator& navigator) { return navigator.started(); });
          },
          "Whether there is a state; before, what asks for it raises RuntimeError.");
  bind_state_of(bound);
}

}  // namespace

void bind_navigation(py::module_& module) {
  bind_options(module);
  bind_states(module);
  bind_health_report(module);
  bind_frame_report(module);
  bind_navigator(module);
  bind_start(module);
  bind_online_navigator(module);
}

}  // namespace limber::python
