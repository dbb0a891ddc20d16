// SPDX-License-Identifier: MIT
#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <optional>

#include "arrays.hpp"
#include "bindings.hpp"
#include "docs.hpp"
#include "dtypes.hpp"
#include "frame_source.hpp"
#include "limber/clean/frame_cleaner.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/frontend/stereo_tracker.hpp"
#include "limber/io/parameter_text.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/scenario_presets.hpp"
#include "limber/simulate/simulator.hpp"
#include "open_recording.hpp"

namespace limber::python {
namespace {

namespace fs = std::filesystem;
using SharedRecording = std::shared_ptr<Recording>;

/// Samples of two vectors each, from arrays of times and of vectors.
template <typename Sample>
std::vector<Sample> make_samples(const Integers& t_ns, const Doubles& first, const Doubles& second,
                                 Eigen::Vector3d Sample::*a, Eigen::Vector3d Sample::*b,
                                 const char* names[2]) {
  require_shape(t_ns, {-1}, "t_ns");
  require_shape(first, {t_ns.shape(0), 3}, names[0]);
  require_shape(second, {t_ns.shape(0), 3}, names[1]);
  std::vector<Sample> samples(static_cast<std::size_t>(t_ns.shape(0)));
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k].t_ns = t_ns.data()[k];
    samples[k].*a = Eigen::Vector3d::Map(first.data() + 3 * k);
    samples[k].*b = Eigen::Vector3d::Map(second.data() + 3 * k);
  }
  return samples;
}

SharedRecording make_recording(const StereoCalibration& calibration, const std::vector<StereoFrame*>& frames,
                               const std::string& name) {
  auto recording = std::make_shared<Recording>();
  recording->name = name;
  recording->calibration = calibration;
  for (const StereoFrame* frame : frames) {
    if (!recording->frames.empty() && frame->t_ns <= recording->frames.back().t_ns) {
      throw py::value_error("frames: expected strictly increasing times, found " +
                            std::to_string(frame->t_ns) + " ns behind " +
                            std::to_string(recording->frames.back().t_ns) + " ns");
    }
    recording->frames.push_back(*frame);
  }
  return recording;
}

/// Frames of a recording one after the other, through the front end where it holds images.
struct FrameIterator {
  SharedRecording recording;
  app::ImageFrames source;
  std::size_t next = 0;

  /// A pair that cannot be read is a frame without points and a RuntimeWarning.
  StereoFrame take() {
    const std::size_t damaged_before = damaged();
    StereoFrame frame = [this] {
      const py::gil_scoped_release released;
      return source.frames(next++);
    }();
    if (damaged() > damaged_before) {
      const std::string text =
          "the images of a frame cannot be read, it has no points: " + source.damaged->why.back();
      if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 1) != 0) {
        throw py::error_already_set();
      }
    }
    return frame;
  }

 private:
  [[nodiscard]] std::size_t damaged() const { return source.damaged ? source.damaged->why.size() : 0; }
};

void bind_recording(py::module_& module) {
  py::class_<Recording, SharedRecording>(module, "Recording", DOC(Recording))
      .def(py::init(&make_recording), py::arg("calibration"), py::arg("frames"), py::arg("name") = "memory",
           "A recording from memory: frames of matched points; add inputs with set_imu or set_odometry.")
      .def_readwrite("name", &Recording::name)
      .def_readonly("path", &Recording::path)
      .def_readwrite("calibration", &Recording::calibration, DOC(SensorData_calibration))
      .def_property_readonly(
          "imu",
          [](const py::object& self) {
            return structured_view(self.cast<Recording&>().imu, self, imu_dtype());
          },
          "A view: t_ns, omega [rad/s], accel [m/s^2].")
      .def_property_readonly(
          "odometry",
          [](const py::object& self) {
            return structured_view(self.cast<Recording&>().odometry, self, odometry_dtype());
          },
          "A view: t_ns, v [m/s], omega [rad/s], in the body frame.")
      .def_readwrite("imu_noise", &Recording::imu_noise)
      .def_readwrite("odometry_noise", &Recording::odometry_noise)
      .def_readwrite("pixel_noise", &Recording::pixel_noise,
                     "Standard deviations of (u0, v0, u1, v1) [px], or None.")
      .def_readonly("frames", &Recording::frames, DOC(SensorData_frames))
      .def_property_readonly(
          "images",
          [](const Recording& recording) {
            py::list out;
            for (const ImagePair& pair : recording.images) {
              out.append(py::make_tuple(pair.t_ns, pair.cam0, pair.cam1));
            }
            return out;
          },
          "Stereo pairs on disk: (t_ns, file of cam0, file of cam1).")
      .def_readonly("partial", &Recording::partial, DOC(Recording_partial))
      .def_readonly("notes", &Recording::notes, DOC(Recording_notes))
      .def_property_readonly(
          "landmarks_true", [](const Recording& recording) { return recording.truth.landmarks; },
          DOC(RecordingTruth_landmarks))
      .def("__len__", [](const Recording& recording) { return frame_count(recording); })
      .def("__repr__", [](const Recording& recording) {
        return "<limber.Recording " + recording.name + ": " + std::to_string(frame_count(recording)) +
               " frames, " + std::to_string(recording.imu.size()) + " IMU samples>";
      });
}

void bind_inputs(py::module_& module) {
  auto recording = module.attr("Recording").cast<py::class_<Recording, SharedRecording>>();
  recording
      .def(
          "set_imu",
          [](Recording& self, const Integers& t_ns, const Doubles& omega, const Doubles& accel) {
            static const char* names[] = {"omega", "accel"};
            if (!self.imu.empty()) {
              throw py::value_error("this recording has IMU samples already");
            }
            self.imu = make_samples<ImuSample>(t_ns, omega, accel, &ImuSample::omega_imu,
                                               &ImuSample::accel_imu, names);
          },
          py::arg("t_ns"), py::arg("omega"), py::arg("accel"),
          "IMU samples: (N,) [ns], (N, 3) [rad/s], (N, 3) [m/s^2].")
      .def(
          "set_odometry",
          [](Recording& self, const Integers& t_ns, const Doubles& v, const Doubles& omega) {
            static const char* names[] = {"v", "omega"};
            if (!self.odometry.empty()) {
              throw py::value_error("this recording has odometry already");
            }
            self.odometry = make_samples<OdometrySample>(t_ns, v, omega, &OdometrySample::v_body,
                                                         &OdometrySample::omega_body, names);
          },
          py::arg("t_ns"), py::arg("v"), py::arg("omega"),
          "Odometry in the body frame: (N,) [ns], (N, 3) [m/s], (N, 3) [rad/s].")
      .def(
          "assume_error",
          [](Recording& self, const std::string& error) {
            self.calibration = corrected(self.calibration, parse_calibration_error(error, self.calibration));
          },
          py::arg("error"),
          "Adds an error to the assumed calibration, as --assume-error of the program: "
          "'ax,ay,az,tx,ty,tz' in degrees and metres (5% is of the baseline), 'NAME=VALUE' for others.")
      .def(
          "write",
          [](const Recording& self, const fs::path& folder, bool force) {
            write_track_log(self, folder, force);
          },
          py::arg("folder"), py::arg("force") = false, py::call_guard<py::gil_scoped_release>(),
          DOC(write_track_log));
}

/// Poses of the ground truth, as views.
void bind_truth(py::module_& module) {
  auto recording = module.attr("Recording").cast<py::class_<Recording, SharedRecording>>();
  recording
      .def_property_readonly(
          "truth_t_ns",
          [](const py::object& self) {
            return view(self.cast<Recording&>().truth.motion.states, self,
                        [](const GroundTruthState& s) -> const std::int64_t& { return s.t_ns; });
          },
          "Times of the ground truth [ns], (N,), a view.")
      .def_property_readonly(
          "truth_p",
          [](const py::object& self) {
            return view(self.cast<Recording&>().truth.motion.states, self,
                        [](const GroundTruthState& s) -> const Eigen::Vector3d& { return s.p_world_body; });
          },
          "True positions of the body in the world [m], (N, 3), a view.")
      .def_property_readonly(
          "truth_R",
          [](const py::object& self) {
            return view(self.cast<Recording&>().truth.motion.states, self,
                        [](const GroundTruthState& s) -> const Eigen::Matrix3d& { return s.R_world_body; });
          },
          "True attitudes R_world_body, (N, 3, 3), a view.")
      .def_property_readonly(
          "truth_v",
          [](const py::object& self) -> py::object {
            const auto& it = self.cast<Recording&>();
            if (!it.truth.motion.has_velocity) {
              return py::none();
            }
            return view(it.truth.motion.states, self,
                        [](const GroundTruthState& s) -> const Eigen::Vector3d& { return s.v_world_body; });
          },
          "True velocities in the world [m/s], (N, 3), a view; None if the recording does not have them.");
}

void bind_tracking(py::module_& module) {
  py::class_<FrameIterator>(module, "FrameIterator")
      .def("__iter__", [](const py::object& self) { return self; })
      .def("__len__", [](const FrameIterator& self) { return frame_count(*self.recording) - self.next; })
      .def("__next__", [](FrameIterator& self) {
        if (self.next >= frame_count(*self.recording)) {
          throw py::stop_iteration();
        }
        return self.take();
      });
  module.def(
      "frames",
      [](const SharedRecording& recording) {
        return FrameIterator{recording, app::image_frames(*recording, {.threads = 1})};
      },
      py::arg("recording"),
      "Iterates over the stereo frames of a recording: its matched points, or its images through a "
      "StereoTracker, as limber run sees them before FrameCleaner. A pair of images that cannot be read is a "
      "frame without points, and a RuntimeWarning says when, where and why; where the first ten are all so, "
      "DataError.");

  py::class_<FrameCleaner>(module, "FrameCleaner", DOC(FrameCleaner))
      .def(py::init([](const StereoCalibration& calibration, bool clean, std::size_t max_points) {
             return std::make_unique<FrameCleaner>(
                 calibration,
                 CleaningOptions{.clean = clean, .still_points = clean, .max_points = max_points});
           }),
           py::arg("calibration"), py::arg("clean") = CleaningOptions{}.clean,
           py::arg("max_points") = CleaningOptions{}.max_points)
      .def("clean", &FrameCleaner::clean, py::arg("frame"), DOC(FrameCleaner_clean))
      .def_property_readonly(
          "report", [](const FrameCleaner& cleaner) { return in_words(cleaner.report()); }, DOC(in_words));
}

void bind_simulator(py::module_& module) {
  py::class_<Scenario>(module, "Scenario", DOC(Scenario))
      .def(py::init([](const fs::path& path) { return read_scenario(path); }), py::arg("path"),
           DOC(read_scenario))
      .def_static(
          "parse", [](const std::string& text) { return parse_scenario(text, "scenario.yaml"); },
          py::arg("text"), "The same from YAML text in memory.")
      .def_property_readonly("text", &format_scenario, DOC(format_scenario))
      .def_readwrite("name", &Scenario::name)
      .def_readwrite("duration", &Scenario::duration, DOC(Scenario_duration))
      .def_readwrite("use_imu", &Scenario::use_imu, DOC(Scenario_use_imu))
      .def(
          "set_pixels",
          [](Scenario& scenario, const std::string& preset) {
            if (preset != "white" && preset != "realistic") {
              throw py::value_error("pixels: expected white or realistic, found '" + preset + "'");
            }
            set_pixels(scenario, preset == "white" ? PixelPreset::kWhite : PixelPreset::kRealistic);
          },
          py::arg("preset"), "Errors of pixels: 'white', or 'realistic' as on tracks of real images.")
      .def(
          "add_fault",
          [](Scenario& scenario, const std::string& fault) {
            scenario.faults.push_back(fault_from_string(fault));
          },
          py::arg("fault"), DOC(fault_from_string));
  module.def(
      "simulate_scenario",
      [](const Scenario& scenario, std::uint64_t seed, std::uint64_t run) {
        return std::make_shared<Recording>(simulate(scenario, seed, run));
      },
      py::arg("scenario"), py::arg("seed") = 0, py::arg("run") = 0, py::call_guard<py::gil_scoped_release>(),
      DOC(simulate));
}

GreyImage grey_image(const py::buffer_info& buffer, const char* name) {
  if (buffer.ndim != 2 || buffer.itemsize != 1 || buffer.strides[1] != 1 ||
      buffer.strides[0] < buffer.shape[1]) {
    throw py::value_error(std::string(name) +
                          ": expected a grey image, an array of uint8 and shape (height, width) whose rows "
                          "are contiguous");
  }
  return {static_cast<int>(buffer.shape[1]), static_cast<int>(buffer.shape[0]), buffer.strides[0],
          static_cast<const std::uint8_t*>(buffer.ptr)};
}

void bind_tracker(py::module_& module) {
  using Tracker = Guarded<StereoTracker>;
  const TrackerOptions defaults;
  py::class_<Tracker>(module, "StereoTracker", DOC(StereoTracker))
      .def(py::init([](const StereoCalibration& calibration, int max_tracks, double min_distance_px,
                       double min_corner_strength, double min_ncc, double nearest_baselines,
                       double search_margin_degrees) {
             TrackerOptions options;
             options.max_tracks = max_tracks;
             options.min_distance_px = min_distance_px;
             options.min_corner_strength = min_corner_strength;
             options.min_ncc = min_ncc;
             options.nearest_baselines = nearest_baselines;
             options.search_margin_degrees = search_margin_degrees;
             return std::make_unique<Tracker>(calibration, options);
           }),
           py::arg("calibration"), py::kw_only(), py::arg("max_tracks") = defaults.max_tracks,
           py::arg("min_distance_px") = defaults.min_distance_px,
           py::arg("min_corner_strength") = defaults.min_corner_strength,
           py::arg("min_ncc") = defaults.min_ncc, py::arg("nearest_baselines") = defaults.nearest_baselines,
           py::arg("search_margin_degrees") = defaults.search_margin_degrees)
      .def(
          "process",
          [](Tracker& self, std::int64_t t_ns, const py::array_t<std::uint8_t>& image0,
             const py::array_t<std::uint8_t>& image1) {
            const GreyImage left = grey_image(image0.request(), "image0");
            const GreyImage right = grey_image(image1.request(), "image1");
            return self.with([&](StereoTracker& tracker) { return tracker.process(t_ns, left, right); });
          },
          py::arg("t_ns"), py::arg("image0").noconvert(), py::arg("image1").noconvert(),
          DOC(StereoTracker_process))
      .def(
          "process_files",
          [](Tracker& self, std::int64_t t_ns, const fs::path& image0, const fs::path& image1) {
            return self.with([&](StereoTracker& tracker) { return tracker.process(t_ns, image0, image1); });
          },
          py::arg("t_ns"), py::arg("image0"), py::arg("image1"), "The same from image files.");
}

}  // namespace

void bind_recordings(py::module_& module) {
  bind_recording(module);
  bind_inputs(module);
  bind_truth(module);
  bind_tracking(module);
  bind_tracker(module);
  bind_simulator(module);
  module.def(
      "read_recording",
      [](const fs::path& path, const fs::path& calib, const fs::path& imu, const std::string& images,
         const std::string& topics, std::optional<double> readout_time) {
        if (readout_time && !(std::abs(*readout_time) <= kLongestReadout)) {
          throw std::invalid_argument(fmt::format("readout_time: expected a number from -{0} to {0}, got {1}",
                                                  kLongestReadout, *readout_time));
        }
        try {
          return std::make_shared<Recording>(
              app::open_recording({path, calib, imu, images, topics, readout_time, {}}));
        } catch (const CLI::ValidationError& error) {  // an option that is missing or of no use
          throw std::invalid_argument(error.what());
        }
      },
      py::arg("path"), py::arg("calib") = "", py::arg("imu") = "", py::arg("images") = "",
      py::arg("topics") = "", py::arg("readout_time") = py::none(), py::call_guard<py::gil_scoped_release>(),
      DOC(read_recording));
}

}  // namespace limber::python
