// SPDX-License-Identifier: MIT
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>

#include "arrays.hpp"
#include "bindings.hpp"
#include "docs.hpp"
#include "limber/study/run_study.hpp"
#include "limber/study/study_database.hpp"
#include "limber/study/study_table.hpp"

namespace limber::python {
namespace {

namespace fs = std::filesystem;

StudyDatabase study(const std::vector<Scenario>& scenarios, const std::string& methods, std::uint64_t runs,
                    std::uint64_t seed, const std::string& init, const fs::path& database, int threads) {
  StudyPlan plan;
  plan.seed = seed;
  for (const Scenario& scenario : scenarios) {
    plan.cases.push_back(
        {scenario, method_variants_from_string(methods), runs, start_mode_from_string(init)});
  }
  StudyOptions options;
  options.threads = threads;
  bool interrupted = false;
  options.stop = [&interrupted] {
    const py::gil_scoped_acquire acquired;
    if (PyErr_CheckSignals() != 0) {
      PyErr_Clear();
      interrupted = true;
    }
    return interrupted;
  };
  run_study(plan, database, options);
  if (interrupted) {
    const py::gil_scoped_acquire acquired;
    PyErr_SetNone(PyExc_KeyboardInterrupt);
    throw py::error_already_set();
  }
  return StudyDatabase(database);
}

py::dict to_dict(const std::string& study_case, const MethodSummary& s) {
  py::dict out;
  out["case"] = study_case;
  out["method"] = s.label;
  out["runs"] = s.runs;
  out["diverged"] = s.diverged;
  out["position_rmse_m"] = s.position_rmse_m;
  out["attitude_rmse_deg"] = s.attitude_rmse_deg;
  out["ate_se3_m"] = s.ate_se3_m;
  out["landmark_rmse_m"] = s.landmark_rmse_m;
  out["position_rmse_worst_m"] = s.position_rmse_worst_m;
  out["position_final_m"] = s.position_final_m;
  out["anees"] = s.anees;
  out["anees_position"] = s.anees_position;
  out["anees_attitude"] = s.anees_attitude;
  out["share_within_interval"] = s.share_within_interval;
  out["nis_per_dof"] = s.nis_per_dof;
  out["scale"] = s.scale;
  out["ms_per_frame"] = s.ms_per_frame;
  return out;
}

py::list table_of(const StudyDatabase& database) {
  py::list out;
  const auto& cases = database.info().cases;
  for (std::size_t k = 0; k < cases.size(); ++k) {
    for (const MethodSummary& summary : summarize_case(database, k)) {
      out.append(to_dict(cases[k].name, summary));
    }
  }
  return out;
}

/// Indices of a case and of one of its methods.
std::pair<std::size_t, std::size_t> find(const StudyInfo& info, const std::string& study_case,
                                         const std::string& method) {
  for (std::size_t k = 0; k < info.cases.size(); ++k) {
    if (info.cases[k].name == study_case) {
      const auto& labels = info.cases[k].labels;
      const auto label = std::find(labels.begin(), labels.end(), method);
      if (label == labels.end()) {
        throw py::key_error("no method '" + method + "' in case '" + study_case + "'");
      }
      return {k, static_cast<std::size_t>(label - labels.begin())};
    }
  }
  throw py::key_error("no case '" + study_case + "'");
}

py::object curve_of(const StudyDatabase& database, const std::string& study_case, const std::string& method,
                    const std::string& quantity) {
  const auto [k, m] = find(database.info(), study_case, method);
  const auto curve = database.curve(k, m, quantity_from_name(quantity));
  if (!curve) {
    return py::none();
  }
  return py::make_tuple(py::array(py::cast(database.info().cases[k].frame_times)),
                        py::array(py::cast(curve->mean)), py::array(py::cast(curve->count)));
}

py::list runs_of(const StudyDatabase& database, const std::string& study_case, const std::string& method) {
  const auto [k, m] = find(database.info(), study_case, method);
  py::list out;
  for (const StudyRun& run : database.runs(k, m)) {
    py::dict row;
    row["run"] = run.run;
    row["diverged"] = run.diverged ? py::object(py::str(run.diverged->reason)) : py::none();
    row["position_rmse_m"] = run.figures.position_rmse_m;
    row["attitude_rmse_deg"] = run.figures.attitude_rmse_deg;
    row["position_final_m"] = run.figures.position_final_m;
    row["landmark_rmse_m"] = run.figures.landmark_rmse_m;
    row["anees"] = run.figures.anees;
    row["scale"] = run.figures.scale;
    out.append(row);
  }
  return out;
}

}  // namespace

void bind_studies(py::module_& module) {
  py::class_<StudyDatabase>(module, "Study", DOC(StudyDatabase))
      .def(py::init<const fs::path&>(), py::arg("database"))
      .def_property_readonly(
          "cases",
          [](const StudyDatabase& database) {
            py::dict out;
            for (const StudyCaseInfo& info : database.info().cases) {
              out[py::str(info.name)] = info.labels;
            }
            return out;
          },
          "{case: its methods}")
      .def("table", &table_of, "One dictionary a case and method: pandas.DataFrame(study.table()).")
      .def("runs", &runs_of, py::arg("case"), py::arg("method"), "One dictionary a finished run.")
      .def("curve", &curve_of, py::arg("case"), py::arg("method"), py::arg("quantity"),
           "Mean over runs at every frame: times [s], means, runs that enter; None where it is not defined.\n"
           "quantity: position_squared_error, position_variance, attitude_squared_error, "
           "attitude_variance, pose_nees, ...")
      .def("__str__", &format_study_table);
  module.def("run_study", &study, py::arg("scenarios"), py::arg("methods"), py::arg("runs"), py::arg("seed"),
             py::arg("init"), py::arg("database"), py::arg("threads") = 0,
             py::call_guard<py::gil_scoped_release>(), DOC(run_study));
}

}  // namespace limber::python
