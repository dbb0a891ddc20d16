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
#include "simulate/scenarios.hpp"
#include "source_folder.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using testing::brief;
using testing::observation_count;
using testing::same;
using testing::shipped;

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

// ---- truth

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
