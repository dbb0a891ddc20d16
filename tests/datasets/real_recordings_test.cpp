// SPDX-License-Identifier: MIT
// The readers on real recordings: counts, conventions and units against what is known about them.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "files.hpp"
#include "limber/core/so3.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/datasets/trajectory_files.hpp"
#include "real_data.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

class RealRecording : public ::testing::Test {
 protected:
  void SetUp() override { LIMBER_NEED_DATA(folder, ""); }
  [[nodiscard]] static fs::path path(const char* name) { return testing::real_data_folder() / name; }
  [[nodiscard]] static Recording read(const char* name) { return read_recording(path(name)); }
};

double path_length(const std::vector<GroundTruthState>& states) {
  double length = 0.0;
  for (std::size_t k = 1; k < states.size(); ++k) {
    length += (states[k].p_world_body - states[k - 1].p_world_body).norm();
  }
  return length;
}

std::size_t observations(const Recording& recording) {
  std::size_t count = 0;
  for (const StereoFrame& frame : recording.frames) {
    count += frame.observations.size();
  }
  return count;
}

// Distance [px] between what cam0 and cam1 see of a true landmark and where theta and the truth put it: the
// median.
double median_reprojection_error(const Recording& recording, bool in_cam1) {
  std::vector<double> errors;
  const Pose T_cam1_cam0 = pose_from_rig(recording.calibration.theta);
  for (const StereoFrame& frame : recording.frames) {
    const auto truth = groundtruth_at(recording.truth.motion.states, frame.t_ns);
    if (!truth) {
      continue;
    }
    const Pose T_world_cam0 =
        Pose{truth->R_world_body, truth->p_world_body} * recording.calibration.T_body_cam0;
    for (const StereoObservation& point : frame.observations) {
      const auto landmark = recording.truth.landmarks.find(point.track_id);
      if (landmark == recording.truth.landmarks.end() || !point.in_cam0 || !point.in_cam1) {
        continue;
      }
      const Eigen::Vector3d X_cam0 = T_world_cam0.inverse() * landmark->second;
      const auto projected = in_cam1 ? project(recording.calibration.cam1, T_cam1_cam0 * X_cam0)
                                     : project(recording.calibration.cam0, X_cam0);
      if (projected) {
        errors.push_back((projected->uv - (in_cam1 ? point.uv_cam1 : point.uv_cam0)).norm());
      }
    }
  }
  EXPECT_GT(errors.size(), 1000U);
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                   errors.end());
  return errors[errors.size() / 2];
}

TEST_F(RealRecording, EurocAprilHasTheNumbersOfItsReadme) {
  const Recording r = read("track_logs/euroc_imu_april");
  EXPECT_EQ(r.name, "euroc_imu_april");
  EXPECT_EQ(r.frames.size(), 1416U);  // of 1439; the others saw nothing and have no line
  EXPECT_EQ(observations(r), 179524U);
  EXPECT_EQ(r.frames.front().t_ns, 1404733405732800000);
  EXPECT_EQ(r.frames.back().t_ns, 1404733477632800000);
  EXPECT_EQ(r.imu.size(), 14374U);
  EXPECT_EQ(r.imu.front().t_ns, 1404733405747800064);
  EXPECT_EQ(r.imu.front().accel_imu, Eigen::Vector3d(9.365351, -0.335061, -3.277056));
  EXPECT_EQ(r.imu_noise->gyro_density, 1.6968e-4);
  EXPECT_EQ(r.truth.motion.states.size(), 1415U);
  EXPECT_TRUE(r.truth.motion.has_velocity);
  EXPECT_FALSE(r.truth.motion.has_biases);
  EXPECT_EQ(r.truth.landmarks.size(), 144U);
  EXPECT_NEAR(path_length(r.truth.motion.states), 30.0, 1.0);
  EXPECT_FALSE(r.pixel_noise.has_value());
  ASSERT_EQ(r.notes.size(), 1U);
  EXPECT_NE(r.notes[0].find("sigma_px"), std::string::npos);
}

// T_BS, theta, ground truth and landmarks only fit the pixels if each is turned the right way.
TEST_F(RealRecording, EurocAprilReprojectsItsLandmarksToThePixels) {
  const Recording r = read("track_logs/euroc_imu_april");
  EXPECT_LE(median_reprojection_error(r, false), 0.6);
  EXPECT_LE(median_reprojection_error(r, true), 0.6);
}

TEST_F(RealRecording, StarryNightReprojectsItsLandmarksToThePixels) {
  const Recording r = read("track_logs/starry_night");
  EXPECT_EQ(observations(r), 9410U);
  EXPECT_EQ(r.frames.size(), 1688U);  // of 1900; 212 see nothing and have no line
  EXPECT_EQ(r.odometry.size(), 1900U);
  EXPECT_EQ(r.truth.landmarks.size(), 20U);
  EXPECT_NEAR(r.calibration.baseline(), 0.240, 5e-4);
  EXPECT_NEAR(path_length(r.truth.motion.states), 44.3, 0.1);
  EXPECT_LE(median_reprojection_error(r, false), 12.0);  // the source: variances 38 and 130 px^2
  EXPECT_LE(median_reprojection_error(r, true), 12.0);
}

TEST_F(RealRecording, EurocRigIsElevenCentimetresWideAndAlmostParallel) {
  for (const char* const name : {"track_logs/euroc_imu_april", "euroc_mh01_a", "euroc_v101_imu_gt"}) {
    const StereoCalibration c = read(name).calibration;
    EXPECT_EQ(c.body, BodyFrame::kImu);
    EXPECT_NEAR(c.baseline(), 0.11007, 1e-5) << name;
    EXPECT_NEAR(c.theta[3], -0.110074, 1e-5) << "x of T_cam1_cam0: cam1 stands to the right";
    EXPECT_LE(c.theta.head<3>().norm(), 0.02);
    EXPECT_LE((c.T_body_cam0.p - Eigen::Vector3d(-0.0216401454975, -0.064676986768, 0.00981073058949)).norm(),
              1e-12);
    EXPECT_NEAR(c.T_body_cam0.R(0, 1), -0.999880929698, 1e-9);
    EXPECT_EQ(std::get<RadialTangential>(c.cam0.distortion).k1, -0.28340811);
  }
}

TEST_F(RealRecording, EurocMachineHallHasItsImagesImuAndTruth) {
  const Recording r = read("euroc_mh01_a");
  EXPECT_EQ(r.images.size(), 160U);
  EXPECT_TRUE(r.frames.empty());
  EXPECT_EQ(r.images.front().t_ns, 1403636584763555584);
  EXPECT_TRUE(fs::exists(r.images.back().cam1));
  EXPECT_EQ(r.imu.size(), 1651U);
  EXPECT_EQ(r.truth.motion.states.size(), 1651U);
  EXPECT_TRUE(r.truth.motion.has_velocity);
  EXPECT_TRUE(r.notes.empty());
  // Velocity is the derivative of position, in the same frame.
  const GroundTruthState& a = r.truth.motion.states[500];
  const GroundTruthState& b = r.truth.motion.states[540];
  const double dt = static_cast<double>(b.t_ns - a.t_ns) * 1e-9;
  EXPECT_LE(((b.p_world_body - a.p_world_body) / dt - r.truth.motion.states[520].v_world_body).norm(), 0.03);
  // The world is z up: the mean specific force, turned into the world, points up with about 9.81 m/s^2.
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : r.imu) {
    mean += groundtruth_at(r.truth.motion.states, sample.t_ns)->R_world_body * sample.accel_imu / 1651.0;
  }
  EXPECT_LE((mean - Eigen::Vector3d(0, 0, 9.81)).norm(), 0.3);
}

TEST_F(RealRecording, EurocViconRoomHasBiasesAndJpegs) {
  const Recording r = read("euroc_v101_imu_gt");
  EXPECT_EQ(r.images.size(), 10U);
  EXPECT_EQ(r.images.front().cam0.extension(), ".jpg");
  EXPECT_EQ(r.imu.size(), 29120U);
  EXPECT_EQ(r.truth.motion.states.size(), 2895U);
  EXPECT_TRUE(r.truth.motion.has_biases);
  EXPECT_EQ(r.truth.motion.states.front().bias_gyro, Eigen::Vector3d(-0.00224703, 0.0215352, 0.0770299));
  EXPECT_EQ(r.truth.motion.states.front().bias_accel, Eigen::Vector3d(-0.0180115, 0.0659796, 0.0309774));
  EXPECT_NEAR(path_length(r.truth.motion.states), 58.4, 0.1);
}

TEST_F(RealRecording, KittiImagesAreARectifiedRigThatDrivesAlongX) {
  const Recording r = read("kitti_06_first51");
  EXPECT_EQ(r.images.size(), 51U);
  EXPECT_EQ(r.calibration.body, BodyFrame::kCam0);
  EXPECT_NEAR(r.calibration.baseline(), 0.53715, 1e-4);
  EXPECT_LT(r.calibration.theta[3], 0.0);
  EXPECT_EQ(r.calibration.cam0.fu, 707.0912);
  EXPECT_EQ(r.calibration.cam1.width, 1226);
  EXPECT_EQ(r.calibration.cam1.height, 370);
  EXPECT_EQ(r.images[1].t_ns, 104505500);
  ASSERT_EQ(r.truth.motion.states.size(), 51U);
  EXPECT_NEAR(path_length(r.truth.motion.states), 59.9, 0.1);
  EXPECT_GT(r.truth.motion.states.back().p_world_body.x(), 59.0) << "almost straight ahead, which is x";
  EXPECT_LT(std::abs(r.truth.motion.states.back().p_world_body.z()), 2.0) << "on a road";
  EXPECT_GT((r.truth.motion.states.back().R_world_body * Eigen::Vector3d::UnitZ()).x(), 0.99);
}

TEST_F(RealRecording, KittiTrackLogsHaveTheNumbersOfTheirReadme) {
  struct Drive {
    const char* name;
    std::size_t frames;
    double path_m, points_per_frame;
  };
  for (const Drive& drive : {Drive{"track_logs/kitti_09_26_drive_0001", 108, 107, 97},
                             Drive{"track_logs/kitti_09_26_drive_0005", 154, 69, 90},
                             Drive{"track_logs/kitti_09_26_drive_0036", 250, 179, 70},
                             Drive{"track_logs/kitti_09_26_drive_0095", 150, 138, 90},
                             Drive{"track_logs/kitti_09_30_drive_0020", 1000, 1140, 64.5},
                             Drive{"track_logs/kitti_09_30_drive_0027", 1106, 692, 68}}) {
    const Recording r = read(drive.name);
    EXPECT_EQ(r.frames.size(), drive.frames);
    EXPECT_EQ(r.odometry.size(), drive.frames);
    EXPECT_TRUE(r.imu.empty());
    EXPECT_EQ(r.calibration.body, BodyFrame::kImu);
    EXPECT_NEAR(r.calibration.baseline(), 0.537, 5e-4) << drive.name;
    EXPECT_NEAR(path_length(r.truth.motion.states), drive.path_m, 1.0) << drive.name;
    EXPECT_NEAR(static_cast<double>(observations(r)) / static_cast<double>(drive.frames),
                drive.points_per_frame, 0.6);
    // Body x is forward, in the truth as in the odometry.
    const std::size_t k = drive.frames / 3;
    EXPECT_NEAR((r.truth.motion.states[k].R_world_body.transpose() * r.truth.motion.states[k].v_world_body -
                 r.odometry[k].v_body)
                    .norm(),
                0.0, 0.1 * r.odometry[k].v_body.norm() + 0.2)
        << drive.name;
  }
}

TEST_F(RealRecording, SurvivesARoundTrip) {
  const testing::TemporaryFolder folder;
  const Recording r = read("track_logs/euroc_imu_april");
  write_track_log(r, folder.path());
  const Recording again = read_recording(folder.path());
  ASSERT_EQ(again.frames.size(), r.frames.size());
  std::size_t differences = 0;
  for (std::size_t k = 0; k < r.frames.size(); ++k) {
    ASSERT_EQ(again.frames[k].observations.size(), r.frames[k].observations.size());
    for (std::size_t i = 0; i < r.frames[k].observations.size(); ++i) {
      const StereoObservation& a = r.frames[k].observations[i];
      const StereoObservation& b = again.frames[k].observations[i];
      differences += a.uv_cam0 != b.uv_cam0 || a.uv_cam1 != b.uv_cam1 || a.track_id != b.track_id ? 1 : 0;
    }
  }
  EXPECT_EQ(differences, 0U);
  EXPECT_LE((again.calibration.theta - r.calibration.theta).norm(), 1e-14);
}

TEST_F(RealRecording, TrajectoryFilesAreRecognised) {
  const Trajectory kitti = read_trajectory(path("trajectories/KITTI_00_gt.txt"));
  EXPECT_EQ(kitti.format, TrajectoryFormat::kKittiPoses);
  EXPECT_EQ(kitti.poses.size(), 4541U);
  EXPECT_EQ(read_trajectory(path("trajectories/KITTI_00_ORB.txt")).poses.size(), 4541U);
  const Trajectory gore = read_trajectory(path("trajectories/udel_gore.txt"));
  EXPECT_EQ(gore.format, TrajectoryFormat::kTum);
  EXPECT_EQ(gore.poses.size(), 3445U);
  EXPECT_EQ(gore.poses.front().t_ns, 1521753105031429052);
  EXPECT_EQ(read_trajectory(path("trajectories/tum_corridor1_512_16_okvis.txt")).poses.size(), 5986U);
  const Trajectory euroc = read_trajectory(path("euroc_mh01_a/mav0/state_groundtruth_estimate0/data.csv"));
  EXPECT_EQ(euroc.format, TrajectoryFormat::kEurocGroundTruth);
  EXPECT_EQ(euroc.poses.size(), 1651U);
}

}  // namespace
}  // namespace limber
