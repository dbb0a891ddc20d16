// SPDX-License-Identifier: MIT
#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.hpp"
#include "bindings.hpp"
#include "comparison_text.hpp"
#include "docs.hpp"
#include "evaluation_report.hpp"
#include "limber/datasets/trajectory_files.hpp"
#include "replaceable.hpp"
#include "trajectory_input.hpp"

namespace limber::python {
namespace {

namespace fs = std::filesystem;

/// A trajectory in memory, to be evaluated or written.
app::TrajectoryInput make_trajectory(const Integers& t_ns, const Doubles& p, const Doubles& R,
                                     const std::optional<Doubles>& covariance, const std::string& name) {
  require_shape(t_ns, {-1}, "t_ns");
  require_shape(p, {t_ns.shape(0), 3}, "p");
  require_shape(R, {t_ns.shape(0), 3, 3}, "R");
  app::TrajectoryInput out{name, true, {}, {}, {}};
  for (py::ssize_t k = 0; k < t_ns.shape(0); ++k) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(R.data() + 9 * k);
    out.poses.push_back({t_ns.data()[k], {rotation, Eigen::Vector3d::Map(p.data() + 3 * k)}});
  }
  if (out.poses.empty()) {
    throw py::value_error("expected one pose at least, found none");
  }
  if (covariance) {
    require_shape(*covariance, {t_ns.shape(0), 6, 6}, "covariance");
    for (py::ssize_t k = 0; k < t_ns.shape(0); ++k) {
      out.covariances.emplace_back(PoseCovariance::Map(covariance->data() + 36 * k));
    }
  }
  return out;
}

std::string evaluate(const app::TrajectoryInput& estimate, const app::TrajectoryInput& truth,
                     double max_time_difference, double rpe_distance) {
  RelativeErrorSettings settings;
  settings.distance = rpe_distance;
  return app::json_text(to_json(app::evaluate(estimate, truth, max_time_difference, settings)));
}

}  // namespace

void bind_evaluation(py::module_& module) {
  using app::TrajectoryInput;
  py::class_<TrajectoryInput>(module, "Trajectory", "Poses T_world_body in time; of a file, or from memory.")
      .def(py::init(&make_trajectory), py::arg("t_ns"), py::arg("p"), py::arg("R"),
           py::arg("covariance") = py::none(), py::arg("name") = "memory",
           "t_ns: (N,), p: (N, 3) [m], R: (N, 3, 3) R_world_body, covariance: (N, 6, 6) of position and "
           "attitude error")
      .def_property_readonly(
          "has_time", [](const TrajectoryInput& input) { return input.has_time; },
          "False for files without times (KITTI): t_ns counts poses.")
      .def_property_readonly("t_ns",
                             [](const py::object& self) {
                               return view(
                                   self.cast<const TrajectoryInput&>().poses, self,
                                   [](const StampedPose& pose) -> const std::int64_t& { return pose.t_ns; });
                             })
      .def_property_readonly("p",
                             [](const py::object& self) {
                               return view(
                                   self.cast<const TrajectoryInput&>().poses, self, [
                                   ](const StampedPose& pose) -> const auto& { return pose.T_world_body.p; });
                             })
      .def_property_readonly("R",
                             [](const py::object& self) {
                               return view(
                                   self.cast<const TrajectoryInput&>().poses, self, [
                                   ](const StampedPose& pose) -> const auto& { return pose.T_world_body.R; });
                             })
      .def("__len__", [](const TrajectoryInput& input) { return input.poses.size(); })
      .def(
          "write_tum",
          [](const TrajectoryInput& input, const fs::path& path, bool force) {
            app::require_replaceable(path, app::kNoMark, force, {input.path});
            write_tum(path, input.poses);
          },
          py::arg("path"), py::arg("force") = false, "Writes a TUM file. force: replace a file of that name");
  module.def("read_trajectory", &app::load_trajectory, py::arg("path"), py::arg("topic") = "",
             py::call_guard<py::gil_scoped_release>(), DOC(read_trajectory));
  module.def(
      "compare_folders",
      [](const std::vector<fs::path>& paths, std::optional<double> piece, bool across_assumptions) {
        const RunComparison comparison = compare_runs(run_folders(paths), {piece, across_assumptions});
        return std::pair(app::to_json(comparison), app::to_text(comparison));
      },
      py::arg("paths"), py::arg("piece"), py::arg("across_assumptions"),
      py::call_guard<py::gil_scoped_release>());
  module.def("evaluate_json", &evaluate, py::arg("estimate"), py::arg("truth"),
             py::arg("max_time_difference"), py::arg("rpe_distance"),
             py::call_guard<py::gil_scoped_release>());
}

}  // namespace limber::python
