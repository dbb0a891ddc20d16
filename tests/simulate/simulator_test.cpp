// SPDX-License-Identifier: MIT
#include "limber/simulate/simulator.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "limber/core/errors.hpp"
#include "limber/core/so3.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/measure/rig.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "real_data.hpp"
#include "simulate/recordings.hpp"
#include "source_folder.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using testing::same;

Scenario shipped(const std::string& name) {
  return read_scenario(testing::source_folder() / "scenarios" / (name + ".yaml"));
}

/// A few seconds of the paper's case (i).
Scenario brief(double duration = 3.0) {
  Scenario s;
  s.duration = duration;
  return s;
}

std::size_t observation_count(const Recording& recording) {
  std::size_t n = 0;
  for (const StereoFrame& frame : recording.frames) {
    n += frame.observations.size();
  }
  return n;
}

// ---- one seed, one answer

TEST(Simulate, GivesTheSameBitsForTheSameSeedAndRun) {
  for (const char* name : {"paper_iv", "drone_square", "walk"}) {
    const Scenario s = shipped(name);
    const Recording a = simulate(s, 3, 5), b = simulate(s, 3, 5);
    EXPECT_TRUE(same(a.imu, b.imu)) << name;
    EXPECT_TRUE(same(a.odometry, b.odometry)) << name;
    EXPECT_TRUE(same(a.frames, b.frames)) << name;
    EXPECT_TRUE(same(a.truth.motion.states, b.truth.motion.states)) << name;
    EXPECT_TRUE(same(a.truth.rig, b.truth.rig)) << name;
    EXPECT_EQ(a.truth.landmarks, b.truth.landmarks) << name;
  }
}

TEST(Simulate, GivesOtherDrawsForAnotherSeedOrRun) {
  const Recording a = simulate(brief(), 1, 0);
  for (const Recording& b : {simulate(brief(), 2, 0), simulate(brief(), 1, 1)}) {
    EXPECT_NE(a.imu[7].omega_imu, b.imu[7].omega_imu);
    EXPECT_NE(a.truth.motion.states[7].p_world_body, b.truth.motion.states[7].p_world_body);
    EXPECT_NE(a.truth.motion.states[7].bias_gyro, b.truth.motion.states[7].bias_gyro);
    EXPECT_NE(a.truth.landmarks, b.truth.landmarks);
  }
}

TEST(Simulate, KeepsTrajectoryAndWorldInAllRunsWhenAskedTo) {
  Scenario s = brief();
  s.same_world_in_all_runs = true;
  const Recording a = simulate(s, 1, 0), b = simulate(s, 1, 1);
  EXPECT_EQ(a.truth.motion.states.back().p_world_body, b.truth.motion.states.back().p_world_body);
  EXPECT_EQ(a.truth.landmarks.begin()->second, b.truth.landmarks.begin()->second);
  EXPECT_NE(a.imu[7].omega_imu, b.imu[7].omega_imu);
  EXPECT_NE(a.frames[0].observations[0].uv_cam0, b.frames[0].observations[0].uv_cam0);
}

// ---- switching one thing off leaves the rest as it is

/// Pixel noise by (frame, track).
std::map<std::pair<std::int64_t, std::int64_t>, Vector4d> pixel_noise(const Recording& recording) {
  std::map<std::pair<std::int64_t, std::int64_t>, Vector4d> noise;
  testing::visit_residuals(recording,
                           [&](const StereoFrame& frame, const StereoObservation& o, const Vector4d& r) {
                             noise[{frame.t_ns, o.track_id}] = r;
                           });
  return noise;
}

TEST(RandomStreams, AreNotMovedByADecalibration) {
  const Recording exact = simulate(shipped("paper_i"), 1), bent = simulate(shipped("paper_v_strong"), 1);
  EXPECT_TRUE(same(exact.truth.motion.states, bent.truth.motion.states));
  EXPECT_TRUE(same(exact.imu, bent.imu));
  const auto noise_exact = pixel_noise(exact), noise_bent = pixel_noise(bent);
  std::size_t common = 0;
  for (const auto& [key, noise] : noise_bent) {
    if (const auto it = noise_exact.find(key); it != noise_exact.end()) {
      ASSERT_LT((it->second - noise).norm(), 1e-9);
      ++common;
    }
  }
  EXPECT_GT(common, noise_exact.size() * 9 / 10);
  EXPECT_NE(observation_count(exact), observation_count(bent));  // points at the edge come and go
}

TEST(RandomStreams, AreNotMovedByLeavingOutTheImu) {
  Scenario s = brief();
  const Recording with = simulate(s, 1);
  s.use_imu = false;
  const Recording without = simulate(s, 1);
  EXPECT_TRUE(same(with.frames, without.frames));
  EXPECT_EQ(with.truth.motion.states.back().R_world_body, without.truth.motion.states.back().R_world_body);
}

TEST(RandomStreams, AreNotMovedByAnOdometerOrByPixelNoise) {
  Scenario s = brief();
  const Recording plain = simulate(s, 1);
  s.odometry = OdometryScenario{};
  s.noise.pixel = 2.0;
  const Recording other = simulate(s, 1);
  EXPECT_TRUE(same(plain.imu, other.imu));
  EXPECT_TRUE(same(plain.truth.motion.states, other.truth.motion.states));
  EXPECT_EQ(plain.truth.landmarks, other.truth.landmarks);
  const auto noise_plain = pixel_noise(plain);
  for (const auto& [key, noise] : pixel_noise(other)) {
    ASSERT_LT((noise - 4.0 * noise_plain.at(key)).norm(), 1e-9);
  }
}

TEST(RandomStreams, AreNotMovedByDropouts) {
  Scenario s = brief();
  const Recording whole = simulate(s, 1);
  s.dropout = {.right_detections = 0.3, .frames = 0.2, .imu_samples = 0.1};
  const Recording part = simulate(s, 1);
  std::size_t k = 0;
  for (const ImuSample& sample : part.imu) {
    while (whole.imu.at(k).t_ns < sample.t_ns) {
      ++k;
    }
    ASSERT_TRUE(same(whole.imu[k], sample));
  }
  const auto noise_whole = pixel_noise(whole);
  for (const auto& [key, noise] : pixel_noise(part)) {
    ASSERT_EQ(noise.head<2>(), noise_whole.at(key).head<2>());
    ASSERT_TRUE(std::isnan(noise[2]) || noise.tail<2>() == noise_whole.at(key).tail<2>());
  }
}

// ---- pixels

// About 43000 points of the paper, four numbers each: bounds of five standard deviations.
TEST(SimulatedPixels, AreTheProjectedTruthPlusWhiteNoise) {
  for (const char* name : {"paper_iii", "paper_v_strong", "drone_step"}) {
    const Recording recording = simulate(shipped(name), 1);
    Vector4d mean = Vector4d::Zero();
    Eigen::Matrix4d second = Eigen::Matrix4d::Zero();
    const double n = static_cast<double>(observation_count(recording));
    testing::visit_residuals(recording, [&](const StereoFrame&, const StereoObservation&, const Vector4d& r) {
      mean += r / n;
      second += r * r.transpose() / n;
      ASSERT_LT(r.cwiseAbs().maxCoeff(), 0.5 * 6.0);
    });
    EXPECT_GT(n, 20000.0);
    EXPECT_LT(mean.cwiseAbs().maxCoeff(), 0.5 * 5.0 / std::sqrt(n)) << name;
    EXPECT_LT((second - 0.25 * Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff(),
              0.25 * 5.0 * std::sqrt(2.0 / n))
        << name << "\n"
        << second;
  }
}

TEST(SimulatedPixels, AreTheProjectedTruthThroughDistortedAndDifferingCameras) {
  Scenario s = shipped("walk");
  s.noise.pixel = 0.0;
  s.duration = 3.0;
  std::size_t n = 0;
  testing::visit_residuals(simulate(s, 1),
                           [&](const StereoFrame&, const StereoObservation& o, const Vector4d& r) {
                             ASSERT_LT(r.head<2>().norm(), 1e-9);
                             ASSERT_TRUE(!o.in_cam1 || r.tail<2>().norm() < 1e-9);
                             ++n;
                           });
  EXPECT_GT(n, 1000u);
}

TEST(SimulatedPixels, DisagreeWithTheAssumedRigByWhatTheDecalibrationDoes) {
  Scenario s = shipped("paper_ii");
  s.duration = 2.0;
  s.noise.pixel = 0.0;
  Recording recording = simulate(s, 1);
  EXPECT_EQ(recording.calibration.theta, s.rig.theta);
  recording.truth.rig = {{0, s.rig.theta}};
  double left = 0.0, right = 0.0;
  testing::visit_residuals(recording, [&](const StereoFrame&, const StereoObservation&, const Vector4d& r) {
    left = std::max(left, r.head<2>().norm());
    right = std::max(right, r.tail<2>().norm());
  });
  EXPECT_LT(left, 1e-9);
  EXPECT_GT(right, 1.0);
}

TEST(SimulatedPixels, MoveInBothCamerasWhenTheBodyIsTheMiddleOfTheBaseline) {
  Scenario s = brief(1.0);
  s.rig.body = BodyFrame::kMiddleOfBaseline;
  s.noise.pixel = 0.0;
  s.decalibration = {{paper_decalibration(), ConstantShape{}}};
  const Recording recording = simulate(s, 1);
  EXPECT_EQ(recording.calibration.body, BodyFrame::kMiddleOfBaseline);
  StereoCalibration calibration_true = recording.calibration;
  calibration_true.theta = recording.truth.rig.front().theta;
  const MountedRig exact = mount(calibration_true), assumed = mount(recording.calibration);
  double worst_exact = 0.0, least_assumed = HUGE_VAL;
  for (const StereoFrame& frame : recording.frames) {
    const GroundTruthState state = groundtruth_at(recording.truth.motion.states, frame.t_ns).value();
    const Pose T_body_world = Pose{state.R_world_body, state.p_world_body}.inverse();
    double frame_error = 0.0;
    for (const StereoObservation& o : frame.observations) {
      const Vector3d X_body = T_body_world * recording.truth.landmarks.at(o.track_id);
      const auto error = [&](const MountedRig& rig, std::size_t camera, const Eigen::Vector2d& uv) {
        return (project(rig[camera].camera, rig[camera].T_cam_body * X_body).value().uv - uv).norm();
      };
      worst_exact = std::max({worst_exact, error(exact, 0, o.uv_cam0), error(exact, 1, o.uv_cam1)});
      frame_error = std::max(frame_error, error(assumed, 0, o.uv_cam0));
    }
    least_assumed = std::min(least_assumed, frame_error);
  }
  EXPECT_LT(worst_exact, 1e-9);
  EXPECT_GT(least_assumed, 0.1);
}

TEST(SimulatedPoints, AreAsManyAsThePaperLikeScenarioPromises) {
  double per_frame = 0.0, distinct = 0.0;
  constexpr int kRuns = 20;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Recording recording = simulate(Scenario{}, 1, run);
    EXPECT_EQ(recording.frames.size(), 701u);
    EXPECT_EQ(recording.imu.size(), 3501u);
    per_frame += static_cast<double>(observation_count(recording)) / 701.0 / kRuns;
    distinct += static_cast<double>(recording.truth.landmarks.size()) / kRuns;
    for (const StereoFrame& frame : recording.frames) {
      EXPECT_GE(frame.observations.size(), 15u);
    }
  }
  EXPECT_NEAR(per_frame, 60.0, 5.0);
  EXPECT_GE(distinct, 250.0);
  EXPECT_LE(distinct, 400.0);
}

TEST(SimulatedPoints, AreAsManyAsTheDronePromises) {
  double per_frame = 0.0;
  constexpr int kRuns = 10;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Recording recording = simulate(shipped("drone_none"), 1, run);
    EXPECT_EQ(recording.frames.size(), 601u);
    EXPECT_EQ(recording.imu.size(), 6001u);
    per_frame += static_cast<double>(observation_count(recording)) / 601.0 / kRuns;
    for (const StereoFrame& frame : recording.frames) {
      EXPECT_GE(frame.observations.size(), 8u);
    }
  }
  EXPECT_GE(per_frame, 30.0);
  EXPECT_LE(per_frame, 60.0);
}

TEST(SimulatedPoints, AreSeenByBothCamerasWithinTheRangeAndInTheImage) {
  Scenario s = brief(10.0);
  s.world.min_range = 15.0;
  s.world.max_range = 40.0;
  s.noise.pixel = 0.0;
  const Recording recording = simulate(s, 1);
  EXPECT_GT(observation_count(recording), 1000u);
  for (const StereoFrame& frame : recording.frames) {
    const GroundTruthState state = groundtruth_at(recording.truth.motion.states, frame.t_ns).value();
    for (const StereoObservation& o : frame.observations) {
      const double z =
          (Pose{state.R_world_body, state.p_world_body}.inverse() * recording.truth.landmarks.at(o.track_id))
              .z();
      ASSERT_TRUE(o.in_cam0 && o.in_cam1);
      ASSERT_TRUE(z >= 15.0 && z <= 40.0);
      ASSERT_TRUE(in_image(s.rig.cam0, o.uv_cam0) && in_image(s.rig.cam1, o.uv_cam1));
    }
  }
}

TEST(SimulatedPoints, MayBeSeenByTheLeftCameraAlone) {
  Scenario s = brief();
  const Recording both = simulate(s, 1);
  s.world.left_only = true;
  const Recording any = simulate(s, 1);
  EXPECT_GT(observation_count(any), observation_count(both));
  for (std::size_t j = 0; j < any.frames.size(); ++j) {
    StereoFrame paired{any.frames[j].t_ns, {}};
    for (const StereoObservation& o : any.frames[j].observations) {
      EXPECT_TRUE(o.in_cam0);
      if (o.in_cam1) {
        paired.observations.push_back(o);
      }
    }
    ASSERT_TRUE(same(paired, both.frames[j]));
  }
}

TEST(MakeWorld, PutsPointsAroundTheTrajectoryAtTheAskedDistances) {
  Scenario s;
  s.world.min_distance = 10.0;
  s.world.max_distance = 20.0;
  s.world.max_elevation = 0.5;
  s.trajectory = RandomSplineTrajectory{.half_extent = Vector3d::Zero()};  // stays at the origin
  const std::vector<Vector3d> points = make_world(s, make_trajectory(s, 1), 1);
  ASSERT_EQ(points.size(), 380u);
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) {
    ASSERT_TRUE(p.norm() >= 10.0 && p.norm() <= 20.0);
    ASSERT_LE(std::abs(std::asin(p.z() / p.norm())), 0.5);
    mean += p / 380.0;
  }
  EXPECT_LT(mean.norm(), 15.0 * 5.0 / std::sqrt(380.0));  // on all sides
}

TEST(MakeWorld, PutsPointsIntoTheViewOfTheLeftCamera) {
  Scenario s = shipped("drone_none");
  s.trajectory = RandomSplineTrajectory{.half_extent = Vector3d::Zero(), .max_angles = Vector3d::Zero()};
  const Pose T_body_world = make_trajectory(s, 1).at(0.0).T_world_body.inverse();
  for (const Vector3d& p : make_world(s, make_trajectory(s, 1), 1)) {
    const Vector3d X_cam0 = s.rig.T_imu_cam0.inverse() * (T_body_world * p);
    ASSERT_TRUE(X_cam0.z() >= 2.0 - 1e-9 && X_cam0.z() <= 25.0 + 1e-9);
    ASSERT_TRUE(in_image(s.rig.cam0, project(s.rig.cam0, X_cam0).value().uv));
  }
}

// ---- IMU, odometry, truth

TEST(SimulatedImu, AddsBiasAndWhiteNoiseOfTheStatedSizeToTheIdealReading) {
  Scenario s;
  const Recording noisy = simulate(s, 1);
  s.noise.accel = s.noise.gyro = 0.0;
  s.initial.bias_accel = s.initial.bias_gyro = 0.0;
  const Recording ideal = simulate(s, 1);
  Vector3d mean_gyro = Vector3d::Zero(), mean_accel = Vector3d::Zero();
  double square_gyro = 0.0, square_accel = 0.0;
  const double n = static_cast<double>(noisy.imu.size());
  for (std::size_t k = 0; k < noisy.imu.size(); ++k) {
    const Vector3d gyro =
        noisy.imu[k].omega_imu - ideal.imu[k].omega_imu - noisy.truth.motion.states[k].bias_gyro;
    const Vector3d accel =
        noisy.imu[k].accel_imu - ideal.imu[k].accel_imu - noisy.truth.motion.states[k].bias_accel;
    mean_gyro += gyro / n;
    mean_accel += accel / n;
    square_gyro += gyro.squaredNorm() / (3.0 * n);
    square_accel += accel.squaredNorm() / (3.0 * n);
  }
  const double gyro = 0.5 * M_PI / 180.0, accel = 0.1;  // per sample, 100 Hz
  EXPECT_LT(mean_gyro.cwiseAbs().maxCoeff(), 5.0 * gyro / std::sqrt(n));
  EXPECT_LT(mean_accel.cwiseAbs().maxCoeff(), 5.0 * accel / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(square_gyro), gyro, 5.0 * gyro / std::sqrt(6.0 * n));
  EXPECT_NEAR(std::sqrt(square_accel), accel, 5.0 * accel / std::sqrt(6.0 * n));
  ASSERT_TRUE(noisy.imu_noise.has_value());
  EXPECT_NEAR(noisy.imu_noise->gyro_density, gyro / 10.0, 1e-15);
  EXPECT_NEAR(noisy.imu_noise->accel_density, accel / 10.0, 1e-15);
  EXPECT_FALSE(ideal.imu_noise.has_value());
  EXPECT_EQ(ideal.notes.size(), 1u);
}

// The trapezoidal rule on samples of 1 kHz.
TEST(SimulatedImu, LeadsBackToTheGroundTruthWhenItIsFreeOfNoise) {
  Scenario s = shipped("drone_none");
  s.imu_rate = 1000.0;
  s.noise.accel = s.noise.gyro = 0.0;
  s.initial.bias_accel = s.initial.bias_gyro = 0.0;
  s.duration = 20.0;
  const Recording recording = simulate(s, 1);
  GroundTruthState state = recording.truth.motion.states.front();
  for (std::size_t k = 1; k < recording.imu.size(); ++k) {
    const ImuSample &a = recording.imu[k - 1], &b = recording.imu[k];
    const double dt = static_cast<double>(b.t_ns - a.t_ns) * 1e-9;
    const Eigen::Matrix3d R_next = state.R_world_body * so3_exp(0.5 * dt * (a.omega_imu + b.omega_imu));
    const Vector3d acceleration =
        0.5 * (state.R_world_body * a.accel_imu + R_next * b.accel_imu) - 9.81 * Vector3d::UnitZ();
    state.p_world_body += dt * state.v_world_body + 0.5 * dt * dt * acceleration;
    state.v_world_body += dt * acceleration;
    state.R_world_body = R_next;
  }
  const GroundTruthState& truth = recording.truth.motion.states.back();
  EXPECT_LT((state.p_world_body - truth.p_world_body).norm(), 1e-3);
  EXPECT_LT((state.v_world_body - truth.v_world_body).norm(), 1e-4);
  EXPECT_LT(so3_log(state.R_world_body.transpose() * truth.R_world_body).norm(), 1e-5);
}

// 200 runs: five standard deviations of an estimated variance.
TEST(SimulatedBiases, AreDrawnFromTheInitialSigmasAndWalkAsStated) {
  Scenario s = brief(1.0);
  s.world.points = 0;
  s.noise.accel_walk = 0.2;
  s.noise.gyro_walk = 0.1;
  double start_gyro = 0.0, start_accel = 0.0, walk_gyro = 0.0, walk_accel = 0.0;
  constexpr int kRuns = 200, kValues = 3 * kRuns;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Recording recording = simulate(s, 1, run);
    const GroundTruthState &first = recording.truth.motion.states.front(),
                           &last = recording.truth.motion.states.back();
    start_gyro += first.bias_gyro.squaredNorm() / kValues;
    start_accel += first.bias_accel.squaredNorm() / kValues;
    walk_gyro += (last.bias_gyro - first.bias_gyro).squaredNorm() / kValues;
    walk_accel += (last.bias_accel - first.bias_accel).squaredNorm() / kValues;
  }
  const double relative = 5.0 * std::sqrt(2.0 / kValues);
  EXPECT_NEAR(start_gyro / 1e-6, 1.0, relative);
  EXPECT_NEAR(start_accel / 1e-4, 1.0, relative);
  EXPECT_NEAR(walk_gyro / 0.01, 1.0, relative);
  EXPECT_NEAR(walk_accel / 0.04, 1.0, relative);
}

TEST(SimulatedOdometry, IsVelocityAndRateOfTheBodyPlusNoise) {
  Scenario s = shipped("drone_none");
  s.odometry = OdometryScenario{.rate = 40.0, .velocity = 0.05, .angular_rate = 0.01};
  const Recording recording = simulate(s, 1);
  const SplineTrajectory trajectory = make_trajectory(s, 1);
  ASSERT_EQ(recording.odometry.size(), 1201u);
  double velocity = 0.0, rate = 0.0;
  for (const OdometrySample& sample : recording.odometry) {
    const Kinematics truth = trajectory.at(static_cast<double>(sample.t_ns) * 1e-9);
    velocity +=
        (sample.v_body - truth.T_world_body.R.transpose() * truth.v_world_body).squaredNorm() / 3603.0;
    rate += (sample.omega_body - truth.omega_body).squaredNorm() / 3603.0;
  }
  EXPECT_NEAR(std::sqrt(velocity), 0.05, 0.05 * 5.0 / std::sqrt(2.0 * 3603.0));
  EXPECT_NEAR(std::sqrt(rate), 0.01, 0.01 * 5.0 / std::sqrt(2.0 * 3603.0));
  EXPECT_EQ(recording.odometry_noise.value().sigma_v, Vector3d::Constant(0.05));
}

TEST(SimulateWithoutImu, DeliversVisionAlone) {
  Scenario s = brief();
  s.use_imu = false;
  const Recording recording = simulate(s, 1);
  EXPECT_TRUE(recording.imu.empty());
  EXPECT_FALSE(recording.imu_noise.has_value());
  EXPECT_FALSE(recording.truth.motion.has_biases);
  EXPECT_TRUE(recording.truth.motion.has_velocity);
  EXPECT_EQ(recording.calibration.body, BodyFrame::kCam0);
  EXPECT_EQ(recording.frames.size(), 61u);
}

TEST(SimulatedTruth, HoldsTheRigAtEveryFrameAndAtEveryJump) {
  Scenario s = shipped("paper_iv");
  s.decalibration[0].shape = StepsShape{{{10.01, 1.0}, {20.0, -1.0}}};
  const Recording recording = simulate(s, 1);
  EXPECT_EQ(recording.truth.rig.size(), 702u);  // 10.01 s lies between frames
  EXPECT_EQ(true_rig_at(recording.truth.rig, 10'009'999'999).theta, s.rig.theta);
  EXPECT_TRUE(true_rig_at(recording.truth.rig, 10'010'000'000)
                  .theta.isApprox(s.rig.theta + paper_decalibration(), 1e-15));
  EXPECT_TRUE(true_rig_at(recording.truth.rig, 20'000'000'000)
                  .theta.isApprox(s.rig.theta - paper_decalibration(), 1e-15));
}

// ---- faults

TEST(Dropouts, LoseWhatTheyAreAskedToLose) {
  Scenario s = shipped("paper_i");
  s.dropout = {.right_detections = 0.25, .frames = 0.1, .imu_samples = 0.05};
  const Recording recording = simulate(s, 1);
  const auto expect_share = [](double lost, double all, double share) {
    EXPECT_NEAR(lost / all, share, 5.0 * std::sqrt(share * (1.0 - share) / all));
  };
  expect_share(701.0 - static_cast<double>(recording.frames.size()), 700.0, 0.1);
  expect_share(3501.0 - static_cast<double>(recording.imu.size()), 3499.0, 0.05);
  EXPECT_EQ(recording.frames.front().t_ns, 0);
  EXPECT_EQ(recording.imu.front().t_ns, 0);
  EXPECT_EQ(recording.imu.back().t_ns, 35'000'000'000);
  double left_only = 0.0;
  for (const StereoFrame& frame : recording.frames) {
    for (const StereoObservation& o : frame.observations) {
      left_only += o.in_cam1 ? 0.0 : 1.0;
    }
  }
  expect_share(left_only, static_cast<double>(observation_count(recording)), 0.25);
}

TEST(Dropouts, MayLoseEverythingButTheFirstFrame) {
  Scenario s = brief();
  s.dropout = {.right_detections = 1.0, .frames = 1.0, .imu_samples = 1.0};
  const Recording recording = simulate(s, 1);
  ASSERT_EQ(recording.frames.size(), 1u);
  EXPECT_EQ(recording.imu.size(), 2u);
  for (const StereoObservation& o : recording.frames[0].observations) {
    EXPECT_FALSE(o.in_cam1);
  }
}

TEST(Simulate, MakesFramesWithoutPointsInAnEmptyWorld) {
  Scenario s = brief();
  s.world.points = 0;
  const Recording recording = simulate(s, 1);
  EXPECT_EQ(recording.frames.size(), 61u);
  EXPECT_EQ(observation_count(recording), 0u);
}

TEST(Simulate, RefusesAScenarioOutOfItsRanges) {
  Scenario s;
  s.noise.pixel = -1.0;
  EXPECT_THROW((void)simulate(s, 1), std::invalid_argument);
  s = Scenario{};
  s.duration = HUGE_VAL;
  EXPECT_THROW((void)simulate(s, 1), std::invalid_argument);
}

TEST(Simulate, NamesATrajectoryFileThatIsMissingOrTooShort) {
  Scenario s = shipped("walk");
  s.duration = 21.0;
  try {
    (void)simulate(s, 1);
    FAIL();
  } catch (const DataError& e) {
    EXPECT_NE(std::string(e.what()).find("walk.tum: expected poses over 21.5 s, found 21 s"),
              std::string::npos)
        << e.what();
  }
  std::get<FileTrajectory>(s.trajectory).path = "nowhere.tum";
  EXPECT_THROW((void)simulate(s, 1), DataError);
}

// ---- files

TEST(SimulatedRecording, ComesBackFromATrackLog) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("limber_simulated_" + std::to_string(::getpid()));
  Scenario s = shipped("walk");
  s.duration = 5.0;
  const Recording written = simulate(s, 1);
  write_track_log(written, folder);
  const Recording read = read_recording(folder);
  std::filesystem::remove_all(folder);
  EXPECT_TRUE(same(written.imu, read.imu));
  EXPECT_TRUE(same(written.odometry, read.odometry));
  EXPECT_TRUE(same(written.frames, read.frames));
  EXPECT_EQ(written.truth.landmarks, read.truth.landmarks);
  EXPECT_EQ(written.truth.rig.size(), read.truth.rig.size());
  EXPECT_EQ(written.pixel_noise, read.pixel_noise);
  EXPECT_EQ(written.calibration.body, read.calibration.body);
  EXPECT_LT((written.calibration.theta - read.calibration.theta).norm(), 1e-12);
  EXPECT_TRUE(read.truth.motion.has_velocity && read.truth.motion.has_biases);
}

TEST(SimulatedRecording, FollowsARealHandHeldTrajectory) {
  LIMBER_NEED_DATA(folder, "trajectories");
  for (const char* name : {"udel_gore.txt", "tum_corridor1_512_16_okvis.txt"}) {
    Scenario s = shipped("drone_none");
    s.world.placement = PointPlacement::kInView;
    s.trajectory = FileTrajectory{folder / name, 10.0, 0.1};
    const Recording recording = simulate(s, 1);
    double fastest = 0.0;
    for (const GroundTruthState& state : recording.truth.motion.states) {
      fastest = std::max(fastest, state.v_world_body.norm());
    }
    EXPECT_GT(fastest, 0.5) << name;  // somebody walks
    EXPECT_LT(fastest, 5.0) << name;
    double mean_force = 0.0;
    for (const ImuSample& sample : recording.imu) {
      mean_force += sample.accel_imu.norm() / static_cast<double>(recording.imu.size());
    }
    EXPECT_NEAR(mean_force, 9.81, 1.5) << name;
    EXPECT_GT(observation_count(recording), 601u * 20u) << name;
  }
}

}  // namespace
}  // namespace limber
