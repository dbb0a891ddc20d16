// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/numpy.h>

/// What samples look like as rows of a structured NumPy array.
namespace limber::python {

[[nodiscard]] pybind11::dtype imu_dtype();          ///< t_ns, omega, accel
[[nodiscard]] pybind11::dtype odometry_dtype();     ///< t_ns, v, omega
[[nodiscard]] pybind11::dtype observation_dtype();  ///< track_id, uv_cam0, uv_cam1, in_cam0, in_cam1

}  // namespace limber::python
