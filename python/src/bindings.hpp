// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "limber/navigate/frame_report.hpp"
#include "limber/sensors/samples.hpp"

PYBIND11_MAKE_OPAQUE(std::vector<limber::StereoFrame>)
PYBIND11_MAKE_OPAQUE(std::vector<limber::FrameReport>)

/// One function per file: each adds its classes and functions to the module.
namespace limber::python {

namespace py = pybind11;

void bind_errors(py::module_& module);
void bind_sensors(py::module_& module);
void bind_recordings(py::module_& module);
void bind_navigator_data(py::module_& module);
void bind_navigation(py::module_& module);
void bind_evaluation(py::module_& module);
void bind_runs(py::module_& module);
void bind_studies(py::module_& module);

/// An object that works without the GIL, and one thread at a time.
template <typename T>
class Guarded {
 public:
  template <typename... Arguments>
  explicit Guarded(Arguments&&... arguments) : value_(std::forward<Arguments>(arguments)...) {}

  /// Calls `work(value)`, which must not touch Python.
  template <typename Work>
  auto with(Work work) {
    const py::gil_scoped_release released;
    const std::lock_guard lock(mutex_);
    return work(value_);
  }

 private:
  T value_;
  std::mutex mutex_;
};

/// Ctrl-C becomes KeyboardInterrupt. For callbacks of long work, which run without the GIL.
inline void check_signals() {
  const py::gil_scoped_acquire acquired;
  if (PyErr_CheckSignals() != 0) {
    throw py::error_already_set();
  }
}

/// A vector as a read-only Python sequence whose members live as long as it does.
template <typename Row>
void bind_sequence(py::module_& module, const char* name, const char* doc) {
  using Rows = std::vector<Row>;
  py::class_<Rows>(module, name, doc)
      .def("__len__", [](const Rows& rows) { return rows.size(); })
      .def(
          "__getitem__",
          [](const Rows& rows, py::ssize_t k) -> const Row& {
            const auto size = static_cast<py::ssize_t>(rows.size());
            if (k < -size || k >= size) {
              throw py::index_error();
            }
            return rows[static_cast<std::size_t>(k < 0 ? k + size : k)];
          },
          py::arg("index"), py::return_value_policy::reference_internal)
      .def(
          "__iter__", [](const Rows& rows) { return py::make_iterator(rows.begin(), rows.end()); },
          py::keep_alive<0, 1>());
}

}  // namespace limber::python
