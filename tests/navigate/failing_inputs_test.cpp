// SPDX-License-Identifier: MIT
// What a filter makes of inputs that fail. The table of all of it: docs/faults.md.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "limber/navigate/navigator.hpp"
#include "limber/navigate/stereo_filter.hpp"
#include "message_of.hpp"
#include "scene.hpp"

namespace limber {
namespace {

using testing::Feeder;
using testing::kMs;
using testing::make_scene;
using testing::Scene;
using testing::SceneOptions;
using testing::with_method;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

Scene scene_of(double seconds, MotionModel motion = MotionModel::kImu, std::uint64_t seed = 1) {
  SceneOptions options;
  options.duration_s = seconds;
  options.motion = motion;
  options.seed = seed;
  return make_scene(options);
}

/// Position sigma of the filter [m].
double sigma(const StereoFilter& filter) {
  return std::sqrt(filter.estimate().P().diagonal_block<3>(0).trace());
}

TEST(FailingInputs, AStateWithoutATimeTakesThatOfTheFirstSample) {
  const std::int64_t epoch = 1'400'000'000'000'000'000;  // as a recording of 2014 has it
  StereoCalibration rig = testing::scene_rig();
  Navigator navigator({}, rig, make_initial_state({}, MotionModel::kImu, {}));
  for (std::int64_t t = 0; t <= 1000; t += 5) {
    navigator.add_imu({epoch + t * kMs, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}});
    if (t % 50 == 0) {
      (void)navigator.process({epoch + t * kMs, {}});
    }
  }
  EXPECT_LE(navigator.estimate().nav().T_world_body.p.norm(), 0.05);
  EXPECT_EQ(navigator.estimate().nav().t_ns, epoch + 1000 * kMs);
}

TEST(FailingInputs, ATimeHoursAheadIsRefused) {
  const Scene scene = scene_of(0.5);
  Feeder feeder(scene, scene.options);
  (void)feeder.process(scene.frames[0]);
  StereoFrame frame = scene.frames[1];
  frame.t_ns += 5'000'000'000'000;
  EXPECT_NE(testing::message_of([&] { (void)feeder.navigator.process(frame); }).find("another clock"),
            std::string::npos);
  EXPECT_NE(testing::message_of([&] {
              feeder.navigator.add_imu({5'000'000'000'000, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
            }).find("another clock"),
            std::string::npos);
}

TEST(FailingInputs, TheSameFrameTwiceIsRefused) {
  const Scene scene = scene_of(0.5);
  Feeder feeder(scene, scene.options);
  (void)feeder.process(scene.frames[1]);
  EXPECT_NE(testing::message_of([&] { (void)feeder.navigator.process(scene.frames[1]); }).find("not later"),
            std::string::npos);
}

/// Standing still with a millimetre of sigma was the answer to an IMU that never came.
TEST(FailingInputs, WithoutAnyImuSampleTheCovarianceGrows) {
  const Scene scene = scene_of(1.0);
  StereoFilter filter(scene.options, scene.calibration, scene.initial);
  FrameReport report;
  for (const StereoFrame& frame : scene.frames) {
    report = filter.process({frame.t_ns, {}});
  }
  EXPECT_EQ(report.inputs.status, InputStatus::kNone);
  EXPECT_EQ(report.status, UpdateStatus::kEmpty);
  const double error = (filter.estimate().nav().T_world_body.p - scene.truth.back().T_world_body.p).norm();
  EXPECT_GE(sigma(filter), 0.3);
  EXPECT_LE(error, 3.0 * sigma(filter));
}

TEST(FailingInputs, ImagesCarryTheStateWithoutAnyImuSample) {
  const Scene scene = scene_of(2.0);
  NavigatorOptions options = with_method(scene, Method::kEkf);
  StereoFilter filter(options, scene.calibration, scene.initial);
  for (const StereoFrame& frame : scene.frames) {
    const FrameReport report = filter.process(frame);
    if (frame.t_ns > 0) {
      EXPECT_EQ(report.inputs.status, InputStatus::kNone);
    }
  }
  EXPECT_LE(testing::position_error(filter, scene.truth.back()), 0.1);
}

/// Runs through a gap in the inputs from 1 s on, with or without images meanwhile.
void run_through_gap(MotionModel motion, double gap_s, bool images, std::uint64_t seed) {
  const Scene scene = scene_of(1.5 + gap_s, motion, seed);
  StereoFilter filter(with_method(scene, Method::kEkf), scene.calibration, scene.initial);
  const std::int64_t from = 1000 * kMs, to = from + static_cast<std::int64_t>(gap_s * 1e9);
  std::size_t next = 0;
  bool reported = false;
  for (std::size_t k = 0; k < scene.frames.size(); ++k) {
    for (; next < scene.inputs.size() && scene.inputs[next].t_ns <= scene.frames[k].t_ns; ++next) {
      const InputSample& s = scene.inputs[next];
      if (s.t_ns > from && s.t_ns < to) {
        continue;
      }
      if (motion == MotionModel::kImu) {
        filter.add_imu({s.t_ns, s.angular, s.linear});
      } else {
        filter.add_odometry({s.t_ns, s.linear, s.angular});
      }
    }
    const bool blind = !images && scene.frames[k].t_ns > from && scene.frames[k].t_ns <= to;
    const FrameReport report =
        filter.process(blind ? StereoFrame{scene.frames[k].t_ns, {}} : scene.frames[k]);
    reported = reported || report.inputs.status == InputStatus::kGap;
    const double error = testing::position_error(filter, scene.truth[k]);
    EXPECT_LE(error, 4.0 * sigma(filter) + 0.01)
        << "at " << scene.frames[k].t_ns << ", gap of " << gap_s << ", seed " << seed << ", motion "
        << static_cast<int>(motion) << (images ? ", with images" : ", without");
  }
  EXPECT_TRUE(reported);
}

TEST(FailingInputs, AGapIsReportedAndNeverMadeUpFor) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    for (const double gap_s : {0.1, 1.0}) {
      run_through_gap(MotionModel::kImu, gap_s, true, seed);
      run_through_gap(MotionModel::kOdometry, gap_s, true, seed);
      run_through_gap(MotionModel::kOdometry, gap_s, false, seed);
    }
    // A second without IMU and images at once is beyond what the model covers: docs/faults.md.
    run_through_gap(MotionModel::kImu, 0.1, false, seed);
  }
}

/// Samples that arrive after the frame they belong to used to be ignored in silence: 70 mm off at a sigma of
/// 5 mm.
TEST(FailingInputs, LateSamplesAreCountedAndTheirTimeIsAGap) {
  const Scene scene = scene_of(2.0);
  StereoFilter filter(with_method(scene, Method::kEkf), scene.calibration, scene.initial);
  std::size_t next = 0, late = 0;
  for (std::size_t k = 0; k < scene.frames.size(); ++k) {
    const std::int64_t available = scene.frames[k].t_ns - 100 * kMs;
    for (; next < scene.inputs.size() && scene.inputs[next].t_ns <= available; ++next) {
      filter.add_imu({scene.inputs[next].t_ns, scene.inputs[next].angular, scene.inputs[next].linear});
    }
    const FrameReport report = filter.process({scene.frames[k].t_ns, {}});
    late += report.inputs.faults[InputFault::kLate];
    if (k > 3) {
      EXPECT_EQ(report.inputs.status, InputStatus::kGap);
    }
    EXPECT_LE(testing::position_error(filter, scene.truth[k]), 4.0 * sigma(filter) + 0.01) << k;
  }
  EXPECT_GE(late, 300U);
}

/// A run feeds a filter all samples since the recording began, which its start has already judged.
TEST(FailingInputs, BeforeTheStateAreTheStartsToSay) {
  const Scene scene = scene_of(2.0);
  InitialState initial = scene.initial;
  initial.nav.t_ns = 1000 * kMs;
  StereoFilter filter(with_method(scene, Method::kEkf), scene.calibration, initial);
  for (const InputSample& sample : scene.inputs) {
    const bool stuck = sample.t_ns > 500 * kMs && sample.t_ns < 800 * kMs;
    filter.add_imu({sample.t_ns, stuck ? Eigen::Vector3d::Zero() : sample.angular,
                    stuck ? Eigen::Vector3d::Zero() : sample.linear});
  }
  const InputReport inputs = filter.process({1500 * kMs, {}}).inputs;
  EXPECT_FALSE(inputs.faults.any());
  EXPECT_EQ(inputs.status, InputStatus::kSound);
}

TEST(FailingInputs, AFiniteSampleThatIsImpossibleIsLeftOut) {
  const Scene scene = scene_of(2.0);
  StereoFilter filter(with_method(scene, Method::kEkf), scene.calibration, scene.initial);
  std::size_t next = 0, left_out = 0;
  for (std::size_t k = 0; k < scene.frames.size(); ++k) {
    for (; next < scene.inputs.size() && scene.inputs[next].t_ns <= scene.frames[k].t_ns; ++next) {
      const Eigen::Vector3d accel =
          next == 203 ? Eigen::Vector3d(Eigen::Vector3d::Constant(1e300)) : scene.inputs[next].linear;
      filter.add_imu({scene.inputs[next].t_ns, scene.inputs[next].angular, accel});
    }
    left_out += filter.process(scene.frames[k]).inputs.faults[InputFault::kImpossible];
  }
  EXPECT_EQ(left_out, 1U);
  EXPECT_LE(testing::position_error(filter, scene.truth.back()), 0.1);
}

TEST(FailingInputs, OptionsThatAreNoNumbersAreRefused) {
  const Scene scene = scene_of(0.1);
  const std::vector<std::function<void(NavigatorOptions&)>> bad = {
      [](NavigatorOptions& o) { o.gravity = kNan; },
      [](NavigatorOptions& o) { o.sigma_px.z() = kInf; },
      [](NavigatorOptions& o) { o.sigma_px.x() = 0.0; },
      [](NavigatorOptions& o) { o.imu_noise.gyro_density = -1e-3; },
      [](NavigatorOptions& o) { o.imu_noise.accel_walk = kNan; },
      [](NavigatorOptions& o) { o.odometry_noise.sigma_v.y() = kInf; },
      [](NavigatorOptions& o) { o.constant_velocity_noise.acceleration_density = -1.0; },
      [](NavigatorOptions& o) { o.theta_sigma[2] = -1.0; },
      [](NavigatorOptions& o) { o.theta_walk = RigParameters::Constant(kNan); },
  };
  for (std::size_t k = 0; k < bad.size(); ++k) {
    NavigatorOptions options = scene.options;
    bad[k](options);
    EXPECT_THROW(StereoFilter(options, scene.calibration, scene.initial), std::invalid_argument) << k;
  }
  InitialState initial = scene.initial;
  initial.body_covariance(3, 3) = kInf;
  EXPECT_THROW(StereoFilter(scene.options, scene.calibration, initial), std::invalid_argument);
  initial = scene.initial;
  initial.nav.v_world_body.x() = kNan;
  EXPECT_THROW(StereoFilter(scene.options, scene.calibration, initial), std::invalid_argument);
}

TEST(FailingInputs, TheDefaultWalkOfThetaGoesWithTheBaseline) {
  EXPECT_DOUBLE_EQ(default_theta_walk(2.0)[3], 1e-4);
  EXPECT_DOUBLE_EQ(default_theta_walk(0.2)[3], 1e-6);
  EXPECT_DOUBLE_EQ(default_theta_walk(0.2)[0], 1e-4);
  const Scene scene = scene_of(1.0);
  NavigatorOptions given = with_method(scene, Method::kEkfFull), left_out = given;
  given.theta_walk = default_theta_walk(scene.calibration.baseline());
  Feeder a(scene, given), b(scene, left_out);
  for (const StereoFrame& frame : scene.frames) {
    (void)a.process(frame);
    (void)b.process(frame);
  }
  EXPECT_EQ(a.navigator.estimate().P().dense(), b.navigator.estimate().P().dense());
}

TEST(FailingInputs, APredictionChangesNothingAndAgreesWithTheOneThatDoes) {
  for (const MotionModel motion :
       {MotionModel::kImu, MotionModel::kOdometry, MotionModel::kConstantVelocity}) {
    Scene scene = scene_of(1.0, motion);
    scene.options.odometry_scale = 0.1;  // of odometry alone
    Feeder feeder(scene, scene.options);
    for (std::size_t k = 0; k < 10; ++k) {
      (void)feeder.process(scene.frames[k]);
    }
    feeder.feed_inputs(scene.frames[10].t_ns);
    const Eigen::MatrixXd before = feeder.navigator.estimate().P().dense();
    const std::int64_t middle = scene.frames[9].t_ns + 23 * kMs;
    const PredictedState state = feeder.navigator.predict(middle);
    EXPECT_EQ(feeder.navigator.estimate().P().dense(), before);
    EXPECT_EQ(feeder.navigator.estimate().nav().t_ns, scene.frames[9].t_ns);
    EXPECT_EQ(feeder.navigator.predict(scene.frames[9].t_ns).nav.T_world_body.p,
              feeder.navigator.estimate().nav().T_world_body.p);
    feeder.navigator.predict_to(middle);
    EXPECT_EQ(state.nav.t_ns, middle);
    EXPECT_EQ(state.nav.T_world_body.p, feeder.navigator.estimate().nav().T_world_body.p);
    const Eigen::Index k = feeder.navigator.estimate().layout().body_size();
    EXPECT_LE((state.body_covariance - feeder.navigator.estimate().P().block(0, 0, k, k)).norm(),
              1e-12 * state.body_covariance.norm());
  }
}

TEST(FailingInputs, APointOfAFrameThatUpdatedNothingIsNotUsed) {
  const Scene scene = scene_of(1.0);
  Feeder feeder(scene, with_method(scene, Method::kEkf));
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_EQ(feeder.process(scene.frames[k]).used > 0, k > 0);
  }
  // A covariance that nobody could have made: S is not positive definite.
  const_cast<Estimate&>(feeder.navigator.estimate())
      .mutable_P()
      .set_diagonal_block(0, -1e6 * Eigen::Matrix3d::Identity());
  const FrameReport broken = feeder.process(scene.frames[5]);
  EXPECT_EQ(broken.status, UpdateStatus::kSingularInnovation);
  EXPECT_EQ(broken.used, 0U);
  EXPECT_TRUE(broken.reset);
  // It begins anew, with time and pose, and goes on.
  FrameReport report;
  for (std::size_t k = 6; k < scene.frames.size(); ++k) {
    report = feeder.process(scene.frames[k]);
    EXPECT_FALSE(report.reset);
  }
  EXPECT_EQ(report.status, UpdateStatus::kUpdated);
  EXPECT_EQ(feeder.navigator.estimate().nav().t_ns, scene.frames.back().t_ns);
  EXPECT_LE(testing::position_error(feeder.navigator, scene.truth.back()), 3.0 * sigma(feeder.navigator));
}

/// What else is no covariance is found out in the midst of a frame: here that of the witness.
TEST(FailingInputs, ACovarianceThatIsNoneIsBegunAnew) {
  const Scene scene = scene_of(1.0);
  Feeder feeder(scene, with_method(scene, Method::kLcekf));
  for (std::size_t k = 0; k < 5; ++k) (void)feeder.process(scene.frames[k]);
  auto& estimate = const_cast<Estimate&>(feeder.navigator.estimate());
  ASSERT_TRUE(estimate.layout().has_witness);
  const Eigen::MatrixXd none = -1e6 * Eigen::Matrix<double, 6, 6>::Identity();
  estimate.mutable_P().set_diagonal_block(estimate.layout().witness(), none);
  const FrameReport broken = feeder.process(scene.frames[5]);
  EXPECT_EQ(broken.status, UpdateStatus::kSingularInnovation);
  EXPECT_EQ(broken.used, 0U);
  EXPECT_TRUE(broken.reset);
  EXPECT_EQ(feeder.navigator.estimate().nav().t_ns, scene.frames[5].t_ns);
  FrameReport report;
  for (std::size_t k = 6; k < scene.frames.size(); ++k) report = feeder.process(scene.frames[k]);
  EXPECT_EQ(report.status, UpdateStatus::kUpdated);
  EXPECT_LE(testing::position_error(feeder.navigator, scene.truth.back()), 3.0 * sigma(feeder.navigator));
}

/// Steps of both biases along x at 2 s: [rad/s], [m/s^2].
struct BiasSteps {
  double gyro = 0.0, accel = 0.0;
};

/// The mean distance to the truth with an IMU whose biases step; and what was said.
struct Stepped {
  double rmse = 0.0;
  std::size_t contradicted = 0;
  std::size_t alarms = 0;  ///< of the rig; `ekf` takes them back when it sees that it was the inputs
};
Stepped fly_with(const BiasSteps& steps, Method method, std::uint64_t seed) {
  const Scene scene = scene_of(6.0, MotionModel::kImu, seed);
  NavigatorOptions options = with_method(scene, method);
  Navigator navigator(options, scene.calibration, scene.initial);
  Stepped out;
  std::size_t next = 0;
  for (std::size_t k = 0; k < scene.frames.size(); ++k) {
    for (; next < scene.inputs.size() && scene.inputs[next].t_ns <= scene.frames[k].t_ns; ++next) {
      const InputSample& s = scene.inputs[next];
      const Eigen::Vector3d by = (s.t_ns > 2000 * kMs ? 1.0 : 0.0) * Eigen::Vector3d::UnitX();
      navigator.add_imu({s.t_ns, s.angular + steps.gyro * by, s.linear + steps.accel * by});
    }
    const FrameReport report = navigator.process(scene.frames[k]);
    if (report.inputs.contradiction) {
      ++out.contradicted;
      out.alarms = method == Method::kEkf ? 0 : out.alarms;
    }
    out.alarms += report.health && report.health->verdict == HealthVerdict::kDecalibrated ? 1 : 0;
    out.rmse += (navigator.estimate().nav().T_world_body.p - scene.truth[k].T_world_body.p).squaredNorm();
  }
  out.rmse = std::sqrt(out.rmse / static_cast<double>(scene.frames.size()));
  return out;
}

TEST(FailingInputs, ABiasThatStepsIsNoticedAndTheRigIsNotBlamed) {
  for (const Method method : {Method::kEkf, Method::kLcekf, Method::kAdaptive}) {
    for (const std::uint64_t seed : {1U, 2U}) {
      const Stepped sound = fly_with({}, method, seed);
      EXPECT_EQ(sound.contradicted, 0U);
      EXPECT_EQ(sound.alarms, 0U);
      for (const BiasSteps& steps : {BiasSteps{0.05, 0.0}, BiasSteps{0.0, 0.5}}) {
        const Stepped stepped = fly_with(steps, method, seed);
        EXPECT_EQ(stepped.alarms, 0U) << to_string(method);
        EXPECT_GE(stepped.contradicted, 1U) << to_string(method);
        EXPECT_LE(stepped.rmse, 3.0 * sound.rmse) << to_string(method) << ", " << steps.gyro;
      }
    }
  }
}

/// Twenty minutes of samples and frames: what is kept to go back in time stays some seconds of them.
TEST(FailingInputs, MemoryIsBoundedOverTwentyMinutes) {
  NavigatorOptions options;
  options.method = Method::kAdaptive;
  Navigator navigator(options, testing::scene_rig(), make_initial_state({}, MotionModel::kImu, {}));
  std::size_t most = 0;
  for (std::int64_t t = 0; t <= 20 * 60 * 1000; t += 10) {
    navigator.add_imu(
        {t * kMs, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81 + 1e-3 * std::sin(0.1 * static_cast<double>(t))}});
    if (t % 100 == 0) {
      (void)navigator.process({t * kMs, {}});
    }
    most = std::max(most, navigator.events_kept());
  }
  EXPECT_LE(most, 2U * 11U * 110U);  // two checkpoints, the older up to ten seconds old; 110 events a second
}

}  // namespace
}  // namespace limber
