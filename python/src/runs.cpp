// SPDX-License-Identifier: MIT
#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>

#include "arrays.hpp"
#include "bindings.hpp"
#include "diagnose_recording.hpp"
#include "docs.hpp"
#include "frame_source.hpp"
#include "health_since.hpp"
#include "limber/diagnose/run_summary.hpp"
#include "limber/io/parameter_text.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/run_files/run_output.hpp"
#include "replaceable.hpp"
#include "watched_frames.hpp"
#ifdef LIMBER_WITH_SMOOTHER
#include "limber/run/smooth_recording.hpp"
#include "recalibration.hpp"
#include "recalibration_text.hpp"
#endif

namespace limber::python {
namespace {

namespace fs = std::filesystem;

/// A run with what it was made of.
struct Run {
  std::shared_ptr<Recording> recording;
  RunOptions options;
  RunRecord record;
  RunSummary summary;
};

using Observer = std::function<void(const FrameReport&)>;

LandmarkKind landmarks_from_string(const std::string& name) {
  if (name != "inverse-depth" && name != "cartesian") {
    throw py::value_error("landmarks: expected inverse-depth or cartesian, found '" + name + "'");
  }
  return name == "cartesian" ? LandmarkKind::kCartesian : LandmarkKind::kInverseDepth;
}

/// The options of `limber run`, under their names there.
RunOptions make_options(const Recording& recording, const std::string& method,
                        const std::optional<std::string>& constraints, const std::string& assume_error,
                        const std::string& estimate, const std::string& soften,
                        std::optional<double> sigma_px, bool learn_imu_noise, bool learn_imu_clock,
                        const std::string& init, const std::string& landmarks, bool gate,
                        std::size_t max_landmarks, std::optional<std::size_t> points_per_update, bool clean,
                        std::size_t max_points, double gravity, double false_alarms, std::uint64_t seed,
                        std::uint64_t run) {
  RunOptions options;
  options.method = method_from_string(method);
  if (constraints) {
    if (options.method != Method::kLcekf) {
      throw py::value_error("constraints: lcekf alone has constraints, not " + method);
    }
    options.constraints = constraint_set_from_string(*constraints);
  }
  if (!assume_error.empty()) {
    options.assume_error = parse_calibration_error(assume_error, recording.calibration);
  }
  if (!estimate.empty()) {
    options.estimated = parse_parameter_sigmas(estimate, recording.calibration);
  }
  if (!soften.empty()) {
    options.softened = parse_parameter_sigmas(soften, recording.calibration);
  }
  options.sigma_px = sigma_px;
  options.learn_imu_noise = learn_imu_noise;
  options.learn_imu_clock = learn_imu_clock;
  options.start = start_mode_from_string(init);
  options.landmarks = landmarks_from_string(landmarks);
  options.gate = gate;
  options.max_landmarks = max_landmarks;
  options.points_per_update = points_per_update;
  options.cleaning = {.clean = clean, .still_points = clean, .max_points = max_points};
  options.gravity = gravity;
  options.false_alarms_per_hour = false_alarms;
  options.seed = seed;
  options.run = run;
  return options;
}

void bind_run_options(py::module_& module) {
  const RunOptions defaults;
  py::class_<RunOptions>(module, "RunOptions", DOC(RunOptions))
      .def(py::init(&make_options), py::arg("recording"), py::arg("method") = "lcekf", py::kw_only(),
           py::arg("constraints") = py::none(), py::arg("assume_error") = "", py::arg("estimate") = "",
           py::arg("soften") = "", py::arg("sigma_px") = py::none(),
           py::arg("learn_imu_noise") = defaults.learn_imu_noise,
           py::arg("learn_imu_clock") = defaults.learn_imu_clock, py::arg("init") = "auto",
           py::arg("landmarks") = "inverse-depth", py::arg("gate") = defaults.gate,
           py::arg("max_landmarks") = defaults.max_landmarks, py::arg("points_per_update") = py::none(),
           py::arg("clean") = defaults.cleaning.clean, py::arg("max_points") = defaults.cleaning.max_points,
           py::arg("gravity") = defaults.gravity, py::arg("false_alarms") = defaults.false_alarms_per_hour,
           py::arg("seed") = defaults.seed, py::arg("run") = defaults.run)
      .def_property_readonly("method", [](const RunOptions& options) { return to_string(options.method); });
  module.def(
      "set_up",
      [](const Recording& recording, const RunOptions& options) {
        RunSetup setup = set_up_run(recording, options);
        return py::make_tuple(setup.navigator, setup.calibration, setup.notes);
      },
      py::arg("recording"), py::arg("options"), DOC(set_up_run));
}

app::ImageFrames frames_of(const Recording& recording) { return app::image_frames(recording, {}); }

Run run(const std::shared_ptr<Recording>& recording, const RunOptions& options, const Observer& observe) {
  RunCallbacks callbacks;
  callbacks.stop = [] {
    check_signals();
    return false;
  };
  if (observe) {
    callbacks.observe = [&observe](const ObservedFrame& frame) {
      const py::gil_scoped_acquire acquired;
      observe(frame.report);
    };
  }
  const app::ImageFrames images = frames_of(*recording);
  app::WatchedFrames watched(*recording, options, images, [](const std::string& /*mistake: a note, too*/) {});
  RunRecord record = run_recording(*recording, options, watched.frames(), callbacks);
  watched.complete(record);
  RunSummary summary = watched.judge(record);
  return {recording, options, std::move(record), std::move(summary)};
}

#ifdef LIMBER_WITH_SMOOTHER
Run smooth(const std::shared_ptr<Recording>& recording, const RunOptions& run_options,
           const std::string& theta, std::optional<double> causal_window_s, int threads) {
  SmoothOptions options;
  options.run = run_options;
  const RigModelText model = rig_model_from_string(theta);
  options.rig = model.rig;
  options.piece_s = model.piece_s;
  options.causal_window_s = causal_window_s;
  options.threads = threads;
  const app::ImageFrames images = frames_of(*recording);
  RunRecord record =
      smooth_recording(*recording, options, images.frames, [](std::size_t) { check_signals(); });
  app::add_damaged(images, record);
  RunSummary summary = summarize(*recording, options.run, record);
  summary.method = to_string(options);
  return {recording, options.run, std::move(record), std::move(summary)};
}

/// What limber recalibrate finds, and of which recording.
struct Recalibrated {
  std::shared_ptr<Recording> recording;
  app::RecalibrationOutcome outcome;
};

void bind_recalibration(py::module_& module) {
  py::class_<Recalibrated>(module, "Recalibrated")
      .def_property_readonly("calibration",
                             [](const Recalibrated& found) { return found.outcome.found.fitted; })
      .def_property_readonly("notes", [](const Recalibrated& found) { return found.outcome.notes; })
      .def_property_readonly("json",
                             [](const Recalibrated& found) {
                               return app::to_json(found.outcome.found, found.recording->name,
                                                   found.outcome.ate, {});
                             })
      .def_property_readonly("text",
                             [](const Recalibrated& found) {
                               return app::to_text(found.outcome.found, found.recording->name,
                                                   found.outcome.ate, "");
                             })
      .def(
          "write",
          [](const Recalibrated& found, const fs::path& folder, bool force) {
            app::require_replaceable_recalibration(folder, force, {found.recording->path});
            app::write_recalibration(folder, found.outcome, *found.recording, true);
          },
          py::arg("folder"), py::arg("force") = false, py::call_guard<py::gil_scoped_release>());
  module.def(
      "recalibrate_recording",
      [](const std::shared_ptr<Recording>& recording, const RunOptions& run) {
        RecalibrateOptions options;
        options.run = run;
        return Recalibrated{recording, app::recalibrate(*recording, options, frames_of,
                                                        [](std::size_t) { check_signals(); })};
      },
      py::arg("recording"), py::arg("options"), py::call_guard<py::gil_scoped_release>(),
      DOC(recalibrate_recording));
}
#endif

/// {"names", "t_ns", "error", "sigma"} of what was estimated of the calibration; None if nothing was.
py::object calibration_of(const Run& run) {
  const auto& rows = run.record.calibration;
  if (rows.empty()) {
    return py::none();
  }
  std::vector<std::size_t> members;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < kParameterNames.size(); ++k) {
    if (rows.back().estimate.parameters.test(k)) {
      members.push_back(k);
      names.emplace_back(kParameterNames[k]);
    }
  }
  const std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(rows.size()),
                                          static_cast<py::ssize_t>(members.size())};
  py::array_t<double> error(shape), sigma(shape);
  py::array_t<std::int64_t> t_ns(shape[0]);
  for (py::ssize_t n = 0; n < shape[0]; ++n) {
    const CalibrationRow& row = rows[static_cast<std::size_t>(n)];
    t_ns.mutable_at(n) = row.t_ns;
    for (py::ssize_t k = 0; k < shape[1]; ++k) {
      const auto member = static_cast<Eigen::Index>(members[static_cast<std::size_t>(k)]);
      error.mutable_at(n, k) = row.estimate.error(member);
      sigma.mutable_at(n, k) = row.estimate.sigma(member);
    }
  }
  py::dict out;
  out["names"] = names;
  out["t_ns"] = t_ns;
  out["error"] = error;
  out["sigma"] = sigma;
  return out;
}

const std::vector<TrajectoryRow>& rows_of(const py::object& self) {
  return self.cast<const Run&>().record.trajectory;
}

const std::vector<StampedPose>& truth_of(const py::object& self) {
  return self.cast<const Run&>().summary.truth;
}

void bind_run(py::module_& module) {
  py::class_<Run>(module, "Run", "What a run over a recording leaves behind: a row per frame, as views.")
      .def_property_readonly(
          "t_ns",
          [](const py::object& self) {
            return view(rows_of(self), self,
                        [](const TrajectoryRow& row) -> const std::int64_t& { return row.t_ns; });
          },
          "Times of the frames [ns], (N,).")
      .def_property_readonly(
          "p",
          [](const py::object& self) {
            return view(
                rows_of(self), self,
                [](const TrajectoryRow& row) -> const auto& { return row.T_world_body.p; });
          },
          "Positions of the body in the world [m], (N, 3).")
      .def_property_readonly(
          "R",
          [](const py::object& self) {
            return view(
                rows_of(self), self,
                [](const TrajectoryRow& row) -> const auto& { return row.T_world_body.R; });
          },
          "Attitudes R_world_body, (N, 3, 3).")
      .def_property_readonly(
          "v",
          [](const py::object& self) {
            return view_of_optional(
                rows_of(self), self,
                [](const TrajectoryRow& row) -> const auto& { return row.v_world_body; });
          },
          "Velocities in the world [m/s], (N, 3).")
      .def_property_readonly(
          "bias_gyro",
          [](const py::object& self) {
            return view_of_optional(
                rows_of(self), self, [](const TrajectoryRow& row) -> const auto& { return row.bias_gyro; });
          },
          "[rad/s], (N, 3); NaN without an IMU.")
      .def_property_readonly(
          "bias_accel",
          [](const py::object& self) {
            return view_of_optional(
                rows_of(self), self, [](const TrajectoryRow& row) -> const auto& { return row.bias_accel; });
          },
          "[m/s^2], (N, 3); NaN without an IMU.")
      .def_property_readonly(
          "covariance",
          [](const py::object& self) {
            return view_of_optional(
                rows_of(self), self, [](const TrajectoryRow& row) -> const auto& { return row.covariance; });
          },
          "Of position [m] and attitude error (body frame) [rad], (N, 6, 6).")
      .def_property_readonly(
          "truth_t_ns",
          [](const py::object& self) {
            return view(truth_of(self), self,
                        [](const StampedPose& pose) -> const std::int64_t& { return pose.t_ns; });
          },
          "Times of the frames that have a truth [ns], (M,).")
      .def_property_readonly(
          "truth_p",
          [](const py::object& self) {
            return view(
                truth_of(self), self,
                [](const StampedPose& pose) -> const auto& { return pose.T_world_body.p; });
          },
          "True positions, in the world of the estimate [m], (M, 3).")
      .def_property_readonly(
          "truth_R",
          [](const py::object& self) {
            return view(
                truth_of(self), self,
                [](const StampedPose& pose) -> const auto& { return pose.T_world_body.R; });
          },
          "True attitudes, in the world of the estimate, (M, 3, 3).")
      .def_property_readonly(
          "frames", [](const Run& run) -> const auto& { return run.record.frames; }, "Their FrameReports.")
      .def_property_readonly(
          "frame_ms", [](const Run& run) { return py::array(py::cast(run.record.frame_ms)); },
          DOC(RunRecord_frame_ms))
      .def_property_readonly(
          "landmarks", [](const Run& run) { return run.record.landmarks; }, DOC(RunRecord_landmarks))
      .def_property_readonly(
          "theta", [](const Run& run) { return run.record.theta; }, DOC(RunRecord_theta))
      .def_property_readonly("calibration", &calibration_of,
                             "What was estimated of the calibration, per frame: {names, t_ns, error: true "
                             "minus assumed (N, k), sigma}; None if nothing was.")
      .def_property_readonly(
          "notes", [](const Run& run) { return run.record.notes; }, DOC(RunRecord_notes))
      .def_property_readonly("method", [](const Run& run) { return run.summary.method; })
      .def_property_readonly("recording", [](const Run& run) { return run.recording; })
      .def_property_readonly(
          "lost", [](const Run& run) { return run.summary.inputs.lost_since_ns.has_value(); },
          "No sigma is true from some time on, summary['lost_since_s'], and notes say why: the "
          "filter "
          "began anew, or an input, the points or a bias misled it. limber run ends with exit code 1.")
      .def_property_readonly(
          "summary_json", [](const Run& run) { return summary_json(run.options, run.record, run.summary); })
      .def(
          "write",
          [](const Run& run, const fs::path& folder, bool force) {
            app::require_replaceable_run(folder, force);
            write_run_output(folder, run.options, run.record, run.summary);
          },
          py::arg("folder"), py::arg("force") = false, py::call_guard<py::gil_scoped_release>(),
          "Writes the files of limber run, byte for byte, into a folder; limber report makes a page of it.\n"
          "force: replace earlier results, and other files of their names");
}

void bind_running(py::module_& module) {
  module.def("run_recording", &run, py::arg("recording"), py::arg("options"), py::arg("observe") = Observer{},
             py::call_guard<py::gil_scoped_release>(), DOC(run_recording));
#ifdef LIMBER_WITH_SMOOTHER
  module.def("smooth_recording", &smooth, py::arg("recording"), py::arg("options"), py::arg("theta") = "free",
             py::arg("causal_window_s") = py::none(), py::arg("threads") = 1,
             py::call_guard<py::gil_scoped_release>(), DOC(smooth_recording));
#endif
  module.def(
      "diagnose_recording",
      [](const Recording& recording, const RunOptions& options, const std::string& before) {
        std::optional<HealthState> earlier;
        if (!before.empty()) {
          earlier = parse_health_state(before, "since");
          app::require_same_cameras(*earlier, corrected(recording.calibration, options.assume_error),
                                    "since");
        }
        app::Diagnosis diagnosis = app::diagnose_recording(recording, options, frames_of(recording),
                                                           [](std::size_t) { check_signals(); });
        diagnosis.since = app::since_then(earlier, diagnosis);
        return std::tuple(to_json(diagnosis), to_text(diagnosis),
                          diagnosis.state ? to_json(*diagnosis.state) : std::string());
      },
      py::arg("recording"), py::arg("options"), py::arg("since") = "",
      py::call_guard<py::gil_scoped_release>(), "JSON, text and state of limber health.");
}

}  // namespace

void bind_runs(py::module_& module) {
  bind_run_options(module);
  bind_run(module);
  bind_running(module);
#ifdef LIMBER_WITH_SMOOTHER
  bind_recalibration(module);
#endif
  bind_evaluation(module);
}

}  // namespace limber::python
