// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <map>

#include "limber/datasets/read_recording.hpp"
#include "limber/frontend/stereo_tracker.hpp"
#include "percentile.hpp"
#include "real_data.hpp"

namespace limber {
namespace {

using testing::percentile;

/// What is worth knowing of a tracked recording.
struct Summary {
  double tracks = 0.0;                   ///< per frame
  double right_fraction = 0.0;           ///< of the points that have a right match
  double length = 0.0;                   ///< frames per track
  double offset_px = 0.0;                ///< median distance below the epipolar line of the given calibration
  double median_px = 0.0, p95_px = 0.0;  ///< of the distance's size
};

/// How far below its epipolar line the right pixel lies [px].
double below_epipolar_line(const StereoCalibration& rig, const StereoObservation& point) {
  const Pose T_cam1_cam0 = pose_from_rig(rig.theta);
  const Eigen::Vector3d bearing1 = unproject(rig.cam1, point.uv_cam1).value();
  const Eigen::Vector3d normal =
      T_cam1_cam0.p.cross(T_cam1_cam0.R * unproject(rig.cam0, point.uv_cam0).value()).normalized();
  return std::copysign(1.0, normal.y()) * std::asin(normal.dot(bearing1)) * rig.cam1.fu;
}

Summary follow(const Recording& recording, const StereoCalibration& assumed, std::size_t frames) {
  StereoTracker tracker(assumed);
  std::map<std::int64_t, int> lengths;
  std::vector<double> distances, sizes;
  double points = 0.0;
  frames = std::min(frames, recording.images.size());
  for (std::size_t k = 0; k < frames; ++k) {
    const ImagePair& pair = recording.images[k];
    for (const StereoObservation& point : tracker.process(pair.t_ns, pair.cam0, pair.cam1).observations) {
      ++points;
      ++lengths[point.track_id];
      if (!point.in_cam1) continue;
      distances.push_back(below_epipolar_line(recording.calibration, point));
      sizes.push_back(std::abs(distances.back()));
    }
  }
  return {points / static_cast<double>(frames),
          static_cast<double>(sizes.size()) / points,
          points / static_cast<double>(lengths.size()),
          percentile(distances, 0.5),
          percentile(sizes, 0.5),
          percentile(sizes, 0.95)};
}

/// One degree about each axis, and a fifth of the baseline.
StereoCalibration misjudged(StereoCalibration rig) {
  rig.theta.head<3>() += Eigen::Vector3d(0.0175, -0.0175, 0.0175);
  rig.theta[3] *= 1.2;
  return rig;
}

TEST(RealImages, OfEurocAreTrackedToAFewTenthsOfAPixel) {
  LIMBER_NEED_DATA(folder, "euroc_mh01_a");
  const Recording recording = read_recording(folder);
  const Summary found = follow(recording, recording.calibration, 160);
  EXPECT_GT(found.tracks, 110.0);
  EXPECT_GT(found.right_fraction, 0.6);
  // 10.27 with FMA, 9.93 without: of 1800 tracks some end a frame sooner or later by rounding.
  EXPECT_GT(found.length, 9.5);
  EXPECT_LT(std::abs(found.offset_px), 0.15);
  EXPECT_LT(found.median_px, 0.2);
  EXPECT_LT(found.p95_px, 0.9);
}

TEST(RealImages, OfEurocInFlightAndStronglyCompressedAreTrackedToo) {
  LIMBER_NEED_DATA(folder, "euroc_v101_imu_gt");
  const Recording recording = read_recording(folder);
  const Summary found = follow(recording, recording.calibration, 10);
  EXPECT_GT(found.tracks, 110.0);
  EXPECT_GT(found.right_fraction, 0.8);
  EXPECT_GT(found.length, 6.0);
  EXPECT_LT(found.median_px, 0.15);
  EXPECT_LT(found.p95_px, 0.6);
}

TEST(RealImages, OfKittiKeepTheirRealVerticalOffset) {
  LIMBER_NEED_DATA(folder, "kitti_06_first51");
  const Recording recording = read_recording(folder);
  const Summary found = follow(recording, recording.calibration, 51);
  EXPECT_GT(found.tracks, 110.0);
  EXPECT_GT(found.right_fraction, 0.65);
  EXPECT_GT(found.length, 1.8);
  EXPECT_LT(found.offset_px, -0.05);  // a wrong rectification is in the images, and must stay in the tracks
  EXPECT_LT(found.median_px, 0.4);
  EXPECT_LT(found.p95_px, 1.2);
}

TEST(RealImages, AreTrackedAsWellWithAWrongCalibration) {
  LIMBER_NEED_DATA(folder, "euroc_mh01_a");
  const Recording recording = read_recording(folder);
  const Summary given = follow(recording, recording.calibration, 40);
  const Summary wrong = follow(recording, misjudged(recording.calibration), 40);
  EXPECT_EQ(wrong.tracks, given.tracks);
  EXPECT_EQ(wrong.length, given.length);
  EXPECT_NEAR(wrong.right_fraction, given.right_fraction, 0.01);
  EXPECT_NEAR(wrong.median_px, given.median_px, 0.01);
  EXPECT_NEAR(wrong.p95_px, given.p95_px, 0.05);
}

}  // namespace
}  // namespace limber
