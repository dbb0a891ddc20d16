// SPDX-License-Identifier: MIT
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <Eigen/Geometry>

#include "arrays.hpp"
#include "bindings.hpp"
#include "body_state.hpp"
#include "docs.hpp"
#include "dtypes.hpp"
#include "limber/initialize/online_navigator.hpp"
#include "limber/initialize/sensor_start.hpp"
#include "limber/navigate/navigator.hpp"
#include "limber/state/initial_state.hpp"

namespace limber::python {
namespace {

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
      .def_property_readonly(
          "clock_offset_ns",
          [](Owner& self) {
            return self.with([](const T& navigator) { return navigator.clock_offset_ns(); });
          },
          DOC(Navigator_clock_offset_ns))
      .def(
          "estimate",
          [](Owner& self) {
            return self.with([](const T& navigator) {
              const PredictedState now = navigator.predict(navigator.estimate().nav().t_ns);
              return State{now.nav, now.body_covariance};
            });
          },
          "The body after the last frame, with its covariance.")
      .def("landmarks", &landmarks_of<T>, "The map: track ids (N,), positions in the world (N, 3) [m].")
      .def(
          "show_true_rig",
          [](Owner& self, const RigParameters& theta) {
            self.with([&](T& navigator) {
              navigator.show_true_rig({navigator.estimate().nav().t_ns, theta});
            });
          },
          py::arg("theta"), DOC(Navigator_show_true_rig))
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

StartOptions start_options(double longest_s, double longest_moving_s, double longest_still_s,
                           double shortest_s, double longest_fine_s) {
  StartOptions out;
  out.longest_s = longest_s;
  out.longest_moving_s = longest_moving_s;
  out.longest_still_s = longest_still_s;
  out.shortest_s = shortest_s;
  out.longest_fine_s = longest_fine_s;
  return out;
}

/// A constructor from calibration, options and what of StartOptions one may choose.
template <typename T>
void bind_start_of(py::class_<Guarded<T>>& bound) {
  const StartOptions defaults;
  bound.def(
      py::init([](const StereoCalibration& calibration, const NavigatorOptions& options, double longest_s,
                  double longest_moving_s, double longest_still_s, double shortest_s, double longest_fine_s) {
        return std::make_unique<Guarded<T>>(
            options, calibration,
            start_options(longest_s, longest_moving_s, longest_still_s, shortest_s, longest_fine_s));
      }),
      py::arg("calibration"), py::arg("options"), py::arg("longest_s") = defaults.longest_s,
      py::arg("longest_moving_s") = defaults.longest_moving_s,
      py::arg("longest_still_s") = defaults.longest_still_s, py::arg("shortest_s") = defaults.shortest_s,
      py::arg("longest_fine_s") = defaults.longest_fine_s, DOC(StartOptions));
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
      .def_property_readonly(
          "clock_offset_ns",
          [](BoundStart& self) { return self.with([](SensorStart& it) { return it.clock_offset_ns(); }); },
          DOC(SensorStart_clock_offset_ns))
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
  bind_navigator_data(module);
  bind_navigator(module);
  bind_start(module);
  bind_online_navigator(module);
}

}  // namespace limber::python
