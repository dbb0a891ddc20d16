// SPDX-License-Identifier: MIT
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "arrays.hpp"
#include "bindings.hpp"
#include "docs.hpp"
#include "dtypes.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/parameters.hpp"

namespace limber::python {
namespace {

void bind_rational(py::module_& module) {
  py::class_<Rational>(module, "Rational", DOC(Rational))
      .def(py::init([](double k1, double k2, double p1, double p2, double k3, double k4, double k5,
                       double k6) { return Rational{k1, k2, p1, p2, k3, k4, k5, k6}; }),
           py::arg("k1") = 0.0, py::arg("k2") = 0.0, py::arg("p1") = 0.0, py::arg("p2") = 0.0,
           py::arg("k3") = 0.0, py::arg("k4") = 0.0, py::arg("k5") = 0.0, py::arg("k6") = 0.0)
      .def_readwrite("k1", &Rational::k1)
      .def_readwrite("k2", &Rational::k2)
      .def_readwrite("p1", &Rational::p1)
      .def_readwrite("p2", &Rational::p2)
      .def_readwrite("k3", &Rational::k3)
      .def_readwrite("k4", &Rational::k4)
      .def_readwrite("k5", &Rational::k5)
      .def_readwrite("k6", &Rational::k6);
}

void bind_omni(py::module_& module) {
  py::class_<Omni>(module, "Omni", DOC(Omni))
      .def(py::init([](double xi, double k1, double k2, double p1, double p2) {
             return Omni{xi, k1, k2, p1, p2};
           }),
           py::arg("xi") = 0.0, py::arg("k1") = 0.0, py::arg("k2") = 0.0, py::arg("p1") = 0.0,
           py::arg("p2") = 0.0)
      .def_readwrite("xi", &Omni::xi)
      .def_readwrite("k1", &Omni::k1)
      .def_readwrite("k2", &Omni::k2)
      .def_readwrite("p1", &Omni::p1)
      .def_readwrite("p2", &Omni::p2);
}

void bind_cameras(py::module_& module) {
  bind_rational(module);
  bind_omni(module);
  py::class_<NoDistortion>(module, "NoDistortion", DOC(NoDistortion)).def(py::init<>());
  py::class_<RadialTangential>(module, "RadialTangential", DOC(RadialTangential))
      .def(py::init([](double k1, double k2, double p1, double p2) {
             return RadialTangential{k1, k2, p1, p2};
           }),
           py::arg("k1") = 0.0, py::arg("k2") = 0.0, py::arg("p1") = 0.0, py::arg("p2") = 0.0)
      .def_readwrite("k1", &RadialTangential::k1)
      .def_readwrite("k2", &RadialTangential::k2)
      .def_readwrite("p1", &RadialTangential::p1)
      .def_readwrite("p2", &RadialTangential::p2);
  py::class_<Equidistant>(module, "Equidistant", DOC(Equidistant))
      .def(py::init([](double k1, double k2, double k3, double k4) {
             return Equidistant{k1, k2, k3, k4};
           }),
           py::arg("k1") = 0.0, py::arg("k2") = 0.0, py::arg("k3") = 0.0, py::arg("k4") = 0.0)
      .def_readwrite("k1", &Equidistant::k1)
      .def_readwrite("k2", &Equidistant::k2)
      .def_readwrite("k3", &Equidistant::k3)
      .def_readwrite("k4", &Equidistant::k4);
  py::class_<Camera>(module, "Camera", DOC(Camera))
      .def(py::init([](double fu, double fv, double cu, double cv, int width, int height,
                       const Distortion& distortion) {
             return Camera{fu, fv, cu, cv, width, height, distortion};
           }),
           py::arg("fu"), py::arg("fv"), py::arg("cu"), py::arg("cv"), py::arg("width"), py::arg("height"),
           py::arg("distortion") = Distortion(NoDistortion{}))
      .def_readwrite("fu", &Camera::fu)
      .def_readwrite("fv", &Camera::fv)
      .def_readwrite("cu", &Camera::cu)
      .def_readwrite("cv", &Camera::cv)
      .def_readwrite("width", &Camera::width)
      .def_readwrite("height", &Camera::height)
      .def_readwrite("distortion", &Camera::distortion)
      .def(
          "project",
          [](const Camera& camera, const Eigen::Vector3d& X) {
            const auto projection = project(camera, X);
            return projection ? std::optional(projection->uv) : std::nullopt;
          },
          py::arg("X"), "Raw pixel of a point (camera frame); None where the model is not valid.")
      .def("unproject", &unproject, py::arg("uv"), DOC(unproject));
}

void bind_rig(py::module_& module) {
  py::enum_<BodyFrame>(module, "BodyFrame", DOC(BodyFrame))
      .value("IMU", BodyFrame::kImu)
      .value("CAM0", BodyFrame::kCam0)
      .value("MIDDLE_OF_BASELINE", BodyFrame::kMiddleOfBaseline);
  py::class_<Pose>(module, "Pose", DOC(Pose))
      .def(py::init([](const Eigen::Matrix3d& R, const Eigen::Vector3d& p) {
             return Pose{R, p};
           }),
           py::arg("R") = Eigen::Matrix3d(Eigen::Matrix3d::Identity()),
           py::arg("p") = Eigen::Vector3d(Eigen::Vector3d::Zero()))
      .def_readwrite("R", &Pose::R, DOC(Pose_R))
      .def_readwrite("p", &Pose::p, DOC(Pose_p))
      .def("inverse", &Pose::inverse)
      .def(
          "__matmul__", [](const Pose& a, const Pose& b) { return a * b; }, py::arg("other"));
  py::class_<StereoCalibration>(module, "StereoCalibration", DOC(StereoCalibration))
      .def(py::init([](const Camera& cam0, const Camera& cam1, const RigParameters& theta, BodyFrame body,
                       const Pose& T_body_cam0, std::array<double, 2> time_offset_s,
                       std::array<double, 2> readout_time_s) {
             return StereoCalibration{cam0, cam1, theta, body, T_body_cam0, time_offset_s, readout_time_s};
           }),
           py::arg("cam0"), py::arg("cam1"), py::arg("theta"), py::arg("body") = BodyFrame::kImu,
           py::arg("T_body_cam0") = Pose{}, py::arg("time_offset_s") = std::array<double, 2>{},
           py::arg("readout_time_s") = std::array<double, 2>{})
      .def_readwrite("cam0", &StereoCalibration::cam0)
      .def_readwrite("cam1", &StereoCalibration::cam1)
      .def_readwrite("theta", &StereoCalibration::theta,
                     "The rig: (ax, ay, az [rad], tx, ty, tz [m]), X_cam1 = R_s X_cam0 + t_s.")
      .def_readwrite("body", &StereoCalibration::body)
      .def_readwrite("T_body_cam0", &StereoCalibration::T_body_cam0, DOC(StereoCalibration_T_body_cam0))
      .def_readwrite("time_offset_s", &StereoCalibration::time_offset_s)
      .def_readwrite("readout_time_s", &StereoCalibration::readout_time_s,
                     DOC(StereoCalibration_readout_time_s))
      .def_property_readonly("baseline", &StereoCalibration::baseline, DOC(StereoCalibration_baseline));
  module.def("pose_from_rig", &pose_from_rig, py::arg("theta"), "T_cam1_cam0 of theta.");
  module.def("rig_from_pose", &rig_from_pose, py::arg("T_cam1_cam0"), "theta of T_cam1_cam0.");
}

void bind_noise(py::module_& module) {
  const ImuNoise imu;
  py::class_<ImuNoise>(module, "ImuNoise", DOC(ImuNoise))
      .def(py::init([](double gyro_density, double gyro_walk, double accel_density, double accel_walk) {
             return ImuNoise{gyro_density, gyro_walk, accel_density, accel_walk};
           }),
           py::arg("gyro_density") = imu.gyro_density, py::arg("gyro_walk") = imu.gyro_walk,
           py::arg("accel_density") = imu.accel_density, py::arg("accel_walk") = imu.accel_walk)
      .def_readwrite("gyro_density", &ImuNoise::gyro_density, DOC(ImuNoise_gyro_density))
      .def_readwrite("gyro_walk", &ImuNoise::gyro_walk, DOC(ImuNoise_gyro_walk))
      .def_readwrite("accel_density", &ImuNoise::accel_density, DOC(ImuNoise_accel_density))
      .def_readwrite("accel_walk", &ImuNoise::accel_walk, DOC(ImuNoise_accel_walk));
  const OdometryNoise odometry;
  py::class_<OdometryNoise>(module, "OdometryNoise", DOC(OdometryNoise))
      .def(py::init([](const Eigen::Vector3d& sigma_v, const Eigen::Vector3d& sigma_omega) {
             return OdometryNoise{sigma_v, sigma_omega};
           }),
           py::arg("sigma_v") = odometry.sigma_v, py::arg("sigma_omega") = odometry.sigma_omega)
      .def_readwrite("sigma_v", &OdometryNoise::sigma_v)
      .def_readwrite("sigma_omega", &OdometryNoise::sigma_omega);
}

bool is_seen(const Eigen::Vector2d& uv) { return !uv.hasNaN(); }

StereoFrame make_frame(std::int64_t t_ns, const Integers& ids, const Doubles& uv0, const Doubles& uv1) {
  require_shape(ids, {-1}, "track_id");
  require_shape(uv0, {ids.shape(0), 2}, "uv_cam0");
  require_shape(uv1, {ids.shape(0), 2}, "uv_cam1");
  StereoFrame frame{t_ns, {}};
  frame.observations.resize(static_cast<std::size_t>(ids.shape(0)));
  const Eigen::Map<const Eigen::Matrix<double, 2, Eigen::Dynamic>> left(uv0.data(), 2, ids.shape(0));
  const Eigen::Map<const Eigen::Matrix<double, 2, Eigen::Dynamic>> right(uv1.data(), 2, ids.shape(0));
  for (py::ssize_t k = 0; k < ids.shape(0); ++k) {
    StereoObservation& point = frame.observations[static_cast<std::size_t>(k)];
    point.track_id = ids.data()[k];
    point.in_cam0 = is_seen(left.col(k));
    point.in_cam1 = is_seen(right.col(k));
    if (!point.in_cam0 && !point.in_cam1) {
      throw py::value_error("point " + std::to_string(point.track_id) +
                            ": expected a pixel in one camera at least, found NaN in both");
    }
    if (point.in_cam0) {
      point.uv_cam0 = left.col(k);
    }
    if (point.in_cam1) {
      point.uv_cam1 = right.col(k);
    }
  }
  return frame;
}

void bind_frames(py::module_& module) {
  py::class_<StereoFrame>(module, "StereoFrame", DOC(StereoFrame))
      .def(py::init(&make_frame), py::arg("t_ns"), py::arg("track_id"), py::arg("uv_cam0"),
           py::arg("uv_cam1"),
           "Points of one stereo frame in raw (distorted) pixels.\n"
           "track_id: (N,), each at most once\n"
           "uv_cam0, uv_cam1: (N, 2), NaN where a camera has not seen the point")
      .def_readonly("t_ns", &StereoFrame::t_ns)
      .def_property_readonly(
          "observations",
          [](const py::object& self) {
            return structured_view(self.cast<const StereoFrame&>().observations, self, observation_dtype());
          },
          "A view: track_id, uv_cam0, uv_cam1, in_cam0, in_cam1. A pixel counts only if seen there.")
      .def("__len__", [](const StereoFrame& frame) { return frame.observations.size(); });
  bind_sequence<StereoFrame>(module, "StereoFrames", "Stereo frames of a recording, a read-only sequence.");
}

}  // namespace

void bind_sensors(py::module_& module) {
  bind_cameras(module);
  bind_rig(module);
  bind_noise(module);
  bind_frames(module);
  std::vector<std::string> names;
  for (const auto name : kParameterNames) {
    names.emplace_back(name);
  }
  module.attr("PARAMETER_NAMES") = py::tuple(py::cast(names));
}

}  // namespace limber::python
