// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>
#include <string>

#include "limber/navigate/stereo_filter.hpp"
#include "message_of.hpp"
#include "small_scene.hpp"

/// What a filter refuses before it has seen a frame: options, states and inputs that make no sense.
namespace limber {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using testing::message_of;
using testing::Scene;
using testing::small_scene;
using testing::with_method;

TEST(StereoFilterRefusals, OptionsThatMakeNoSenseAreRefused) {
  const Scene scene = small_scene();
  const auto expect_refusal = [&](const std::string& says, const std::function<void(NavigatorOptions&)>& o,
                                  const std::function<void(StereoCalibration&)>& c = {},
                                  const std::function<void(InitialState&)>& i = {}) {
    NavigatorOptions options = scene.options;
    StereoCalibration calibration = scene.calibration;
    InitialState initial = scene.initial;
    if (o) o(options);
    if (c) c(calibration);
    if (i) i(initial);
    const std::string message =
        message_of([&] { const StereoFilter navigator(options, calibration, initial); });
    EXPECT_NE(message.find(says), std::string::npos) << says << ": " << message;
  };
  expect_refusal("sigma_px", [](NavigatorOptions& o) { o.sigma_px(2) = 0.0; });
  expect_refusal("sigma_px", [](NavigatorOptions& o) { o.sigma_px(1) = std::nan(""); });
  expect_refusal("gate_probability", [](NavigatorOptions& o) { o.gate_probability = 1.0; });
  expect_refusal("gate_probability", [](NavigatorOptions& o) { o.gate_probability = 0.0; });
  expect_refusal("12x12", {}, {}, [](InitialState& i) { i.body_covariance = MatrixXd::Identity(12, 12); });
  expect_refusal("fu of cam0", {}, [](StereoCalibration& c) { c.cam0.fu = -400.0; });
  expect_refusal("baseline", {}, [](StereoCalibration& c) { c.theta.tail<3>().setZero(); });
}

TEST(StereoFilterRefusals, AnInitialStateThatIsNoneIsRefused) {
  const Scene scene = small_scene();
  const auto expect_refusal = [&](const std::string& says, const std::function<void(InitialState&)>& spoil) {
    InitialState initial = scene.initial;
    spoil(initial);
    const std::string message =
        message_of([&] { const StereoFilter filter(scene.options, scene.calibration, initial); });
    EXPECT_NE(message.find(says), std::string::npos) << says << ": " << message;
  };
  expect_refusal("attitude", [](InitialState& i) { i.nav.T_world_body.R.setZero(); });
  expect_refusal("attitude", [](InitialState& i) { i.nav.T_world_body.R.col(0) *= -1.0; });
  expect_refusal("attitude", [](InitialState& i) { i.nav.T_world_body.R(1, 1) = std::nan(""); });
  expect_refusal("position", [](InitialState& i) { i.nav.T_world_body.p.z() = std::nan(""); });
  expect_refusal("accelerometer bias", [](InitialState& i) { i.nav.bias_accel.x() = std::nan(""); });
  expect_refusal("covariance", [](InitialState& i) { i.body_covariance(0, 4) = std::nan(""); });
  expect_refusal("variance", [](InitialState& i) { i.body_covariance(2, 2) = -1.0; });
  expect_refusal("symmetric",
                 [](InitialState& i) { i.body_covariance(0, 1) = 0.5 * i.body_covariance(0, 0); });
  expect_refusal("positive semidefinite", [](InitialState& i) {
    i.body_covariance(0, 1) = i.body_covariance(1, 0) = 2.0 * i.body_covariance(0, 0);
  });
  expect_refusal("landmark 7", [](InitialState& i) {
    i.landmarks.resize(1);
    i.landmarks.front().track_id = 7;
    i.landmarks.front().value.setConstant(std::nan(""));
  });
}

TEST(StereoFilterRefusals, AStateWithoutATimeKeepsItWhereTheFirstFrameIsRefused) {
  const Scene scene = small_scene();
  StereoFilter filter(scene.options, scene.calibration, scene.initial);
  ASSERT_EQ(filter.estimate().nav().t_ns, 0);
  StereoFrame frame = scene.frames[0];
  frame.t_ns = 1'000'000'000'000;
  frame.observations[0].uv_cam0.setConstant(std::nan(""));
  EXPECT_THROW((void)filter.process(frame), std::invalid_argument);
  EXPECT_THROW(filter.add_imu({frame.t_ns, Vector3d::Constant(std::nan("")), Vector3d::Zero()}),
               std::invalid_argument);
  EXPECT_EQ(filter.estimate().nav().t_ns, 0);
}

TEST(StereoFilterRefusals, InputsOfAnotherMotionModelAreRefused) {
  const Scene scene = small_scene();
  StereoFilter imu(scene.options, scene.calibration, scene.initial);
  EXPECT_THROW(imu.add_odometry({}), std::invalid_argument);
  const Vector3d zero = Vector3d::Zero();
  imu.add_imu({10, zero, zero});
  EXPECT_THROW(imu.add_imu({10, zero, zero}), std::invalid_argument);
  EXPECT_THROW(imu.add_imu({11, Vector3d::Constant(std::nan("")), zero}), std::invalid_argument);
}

TEST(StereoFilterRefusals, ShowsTheTrueRigToTheOracleAlone) {
  const Scene scene = small_scene();
  for (const Method method : kAllMethods) {
    StereoFilter navigator(with_method(scene, method), scene.calibration, scene.initial);
    RigParameters theta = scene.calibration.theta;
    theta(3) *= 1.1;
    if (method != Method::kOracle) {
      EXPECT_THROW(navigator.show_true_rig({0, theta}), std::logic_error);
      EXPECT_EQ(navigator.estimate().theta(), scene.calibration.theta);
    } else {
      navigator.show_true_rig({0, theta});
      EXPECT_EQ(navigator.estimate().theta(), theta);
      EXPECT_THROW(navigator.show_true_rig({0, RigParameters::Constant(std::nan(""))}),
                   std::invalid_argument);
      EXPECT_EQ(navigator.calibration().theta, theta);
    }
  }
}

TEST(StereoFilterRefusals, ParametersThatContradictEachOtherAreRefused) {
  const Scene scene = small_scene();
  const auto refusal = [&](Method method, const std::string& constraints, const std::string& estimated,
                           const std::string& softened, BodyFrame body = BodyFrame::kImu) {
    NavigatorOptions options = with_method(scene, method);
    options.constraints = constraint_set_from_string(constraints);
    const auto set = [](const std::string& name, ParameterVector& sigma) {
      const std::optional<ParameterSet> named = parameters_named(name);
      for (std::size_t k = 0; named && k < named->size(); ++k) {
        sigma(static_cast<Eigen::Index>(k)) = (*named)[k] ? 1e-3 : 0.0;
      }
    };
    set(estimated, options.estimated);
    set(softened, options.softened);
    StereoCalibration calibration = scene.calibration;
    calibration.body = body;
    try {
      const StereoFilter navigator(options, calibration, scene.initial);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_EQ(refusal(Method::kLcekf, "full,dt1", "dt0", "cu1"), "none");
  EXPECT_EQ(refusal(Method::kLcekf, "rotation", "tx", ""), "none");
  EXPECT_EQ(refusal(Method::kEkf, "full", "tx", "ax"), "none");
  EXPECT_NE(refusal(Method::kLcekf, "full,dt1", "dt1", "").find("dt1 cannot be constrained and estimated"),
            std::string::npos);
  EXPECT_NE(refusal(Method::kLcekf, "tx", "", "tx").find("tx cannot be constrained and softened"),
            std::string::npos);
  EXPECT_NE(refusal(Method::kEkfFull, "full", "ay", "").find("ay of ekf-full is in the state already"),
            std::string::npos);
  EXPECT_NE(refusal(Method::kSoft, "full", "", "ay").find("ay is softened by soft already"),
            std::string::npos);
  EXPECT_NE(refusal(Method::kMonoLeft, "full", "fu1", "").find("fu1 cannot be seen without the right camera"),
            std::string::npos);
  EXPECT_NE(refusal(Method::kEkf, "full", "imu-tx", "", BodyFrame::kCam0).find("body is not an IMU"),
            std::string::npos);
  NavigatorOptions negative = with_method(scene, Method::kEkf);
  negative.estimated(7) = -1.0;
  EXPECT_THROW(StereoFilter(negative, scene.calibration, scene.initial), std::invalid_argument);
}

}  // namespace
}  // namespace limber
