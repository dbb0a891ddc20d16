// SPDX-License-Identifier: MIT
#include "bindings.hpp"
#include "docs.hpp"
#include "limber/core/divergence_error.hpp"
#include "limber/core/errors.hpp"

namespace limber::python {

// DataError keeps its file and line; everything else is pybind11's translation of the standard exceptions.
void bind_errors(py::module_& module) {
  static py::handle data_error = py::exception<DataError>(module, "DataError", PyExc_RuntimeError).release();
  data_error.attr("__doc__") = DOC(DataError);
  py::register_exception<DivergenceError>(module, "DivergenceError", PyExc_RuntimeError).doc() =
      DOC(DivergenceError);
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      std::rethrow_exception(pointer);
    } catch (const DataError& error) {
      py::object raised = data_error(error.what());
      raised.attr("file") = error.file();
      raised.attr("line") = error.line();
      PyErr_SetObject(data_error.ptr(), raised.ptr());
    }
  });
}

}  // namespace limber::python

PYBIND11_MODULE(_limber, module) {
  using namespace limber::python;
  module.doc() = "The C++ library limber; import limber instead.";
  module.attr("__version__") = LIMBER_VERSION;
  bind_errors(module);
  bind_sensors(module);
  bind_recordings(module);
  bind_navigation(module);
  bind_runs(module);
  bind_studies(module);
}
