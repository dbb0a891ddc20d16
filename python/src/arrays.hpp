// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

/// NumPy arrays that look at C++ memory, and back. Views are read-only and keep their owner alive.
namespace limber::python {

namespace py = pybind11;

/// Rows of numbers as pybind11 takes them from whatever NumPy can turn into doubles.
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Integers = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

[[nodiscard]] inline py::array read_only(py::array array) {
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// Shape and strides of one member of a row: a number, a vector or a matrix (column by column in memory).
template <typename Value>
void add_member_shape(std::vector<py::ssize_t>& shape, std::vector<py::ssize_t>& strides) {
  if constexpr (!std::is_arithmetic_v<Value>) {
    constexpr py::ssize_t kNumber = sizeof(typename Value::Scalar);
    shape.push_back(Value::RowsAtCompileTime);
    strides.push_back(kNumber);
    if constexpr (Value::ColsAtCompileTime != 1) {
      shape.push_back(Value::ColsAtCompileTime);
      strides.push_back(kNumber * Value::RowsAtCompileTime);
    }
  }
}

template <typename Value>
struct ScalarOf {
  using Type = typename Value::Scalar;
};
template <typename Value>
requires std::is_arithmetic_v<Value>
struct ScalarOf<Value> {
  using Type = Value;
};

/// @brief A view of one member of all rows.
/// @param member  from a row to a reference of the member
template <typename Row, typename Member>
[[nodiscard]] py::array view(const std::vector<Row>& rows, const py::handle& owner, Member member) {
  using Value = std::remove_cvref_t<std::invoke_result_t<Member, const Row&>>;
  std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(rows.size())}, strides = {sizeof(Row)};
  add_member_shape<Value>(shape, strides);
  const auto dtype = py::dtype::of<typename ScalarOf<Value>::Type>();
  return rows.empty() ? py::array(dtype, shape)
                      : read_only(py::array(dtype, shape, strides, &member(rows.front()), owner));
}

/// The same of a member that some rows may not have; then a copy, with NaN where there is none.
template <typename Row, typename Member>
[[nodiscard]] py::array view_of_optional(const std::vector<Row>& rows, const py::handle& owner,
                                         Member member) {
  using Value = typename std::remove_cvref_t<std::invoke_result_t<Member, const Row&>>::value_type;
  bool all = true;
  for (const Row& row : rows) {
    all = all && member(row).has_value();
  }
  if (all) {
    return view(rows, owner, [member](const Row& row) -> const Value& { return *member(row); });
  }
  constexpr py::ssize_t kSize = Value::SizeAtCompileTime;
  std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(rows.size())}, strides = {kSize * 8};
  add_member_shape<Value>(shape, strides);
  py::array out(py::dtype::of<double>(), shape, strides);
  auto* values = static_cast<double*>(out.mutable_data());
  for (const Row& row : rows) {
    Eigen::Map<Value, Eigen::Unaligned> target(values);
    target = member(row).value_or(Value::Constant(std::numeric_limits<double>::quiet_NaN()));
    values += kSize;
  }
  return out;
}

/// All rows as a structured array.
template <typename Row>
[[nodiscard]] py::array structured_view(const std::vector<Row>& rows, const py::handle& owner,
                                        const py::dtype& dtype) {
  const std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(rows.size())};
  return rows.empty() ? py::array(dtype, shape)
                      : read_only(py::array(dtype, shape, {sizeof(Row)}, rows.data(), owner));
}

/// @throws ValueError unless `array` has that shape; -1: any length
inline void require_shape(const py::array& array, const std::vector<py::ssize_t>& shape, const char* name) {
  bool fits = array.ndim() == static_cast<py::ssize_t>(shape.size());
  std::string expected, found;
  for (std::size_t k = 0; k < shape.size(); ++k) {
    fits = fits && (shape[k] < 0 || array.shape(static_cast<py::ssize_t>(k)) == shape[k]);
    expected += (k > 0 ? ", " : "") + (shape[k] < 0 ? std::string("N") : std::to_string(shape[k]));
  }
  for (py::ssize_t k = 0; k < array.ndim(); ++k) {
    found += (k > 0 ? ", " : "") + std::to_string(array.shape(k));
  }
  if (!fits) {
    throw py::value_error(std::string(name) + ": expected shape (" + expected + "), found (" + found + ")");
  }
}

}  // namespace limber::python
