// SPDX-License-Identifier: MIT
#include "dtypes.hpp"

#include <cstddef>

#include "limber/sensors/samples.hpp"

namespace limber::python {
namespace {

namespace py = pybind11;

struct Field {
  const char* name;
  const char* format;
  std::size_t offset;
};

py::dtype make(std::initializer_list<Field> fields, std::size_t size) {
  py::list names, formats, offsets;
  for (const Field& field : fields) {
    names.append(field.name);
    formats.append(field.format);
    offsets.append(field.offset);
  }
  return {names, formats, offsets, static_cast<py::ssize_t>(size)};
}

}  // namespace

py::dtype imu_dtype() {
  return make({{"t_ns", "i8", offsetof(ImuSample, t_ns)},
               {"omega", "3f8", offsetof(ImuSample, omega_imu)},
               {"accel", "3f8", offsetof(ImuSample, accel_imu)}},
              sizeof(ImuSample));
}

py::dtype odometry_dtype() {
  return make({{"t_ns", "i8", offsetof(OdometrySample, t_ns)},
               {"v", "3f8", offsetof(OdometrySample, v_body)},
               {"omega", "3f8", offsetof(OdometrySample, omega_body)}},
              sizeof(OdometrySample));
}

py::dtype observation_dtype() {
  return make({{"track_id", "i8", offsetof(StereoObservation, track_id)},
               {"uv_cam0", "2f8", offsetof(StereoObservation, uv_cam0)},
               {"uv_cam1", "2f8", offsetof(StereoObservation, uv_cam1)},
               {"in_cam0", "?", offsetof(StereoObservation, in_cam0)},
               {"in_cam1", "?", offsetof(StereoObservation, in_cam1)}},
              sizeof(StereoObservation));
}

}  // namespace limber::python
