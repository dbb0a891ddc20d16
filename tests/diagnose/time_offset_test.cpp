// SPDX-License-Identifier: MIT
// Clocks that disagree: found where they do, and not where only points are wrong.
#include "limber/diagnose/time_offset.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "diagnose/clustered_regression.hpp"
#include "limber/core/angle.hpp"
#include "limber/core/random.hpp"
#include "limber/core/so3.hpp"
#include "limber/core/time.hpp"
#include "limber/diagnose/cameras_beside_imu.hpp"
#include "limber/simulate/scenario_presets.hpp"
#include "measure/two_views.hpp"
#include "run/short_recording.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

/// Right pixels as they will be `tau` seconds later, along the line to the next frame.
std::vector<StereoFrame> with_late_cam1(const Recording& recording, double tau) {
  std::vector<StereoFrame> out = recording.frames;
  for (std::size_t n = 0; n + 1 < out.size(); ++n) {
    const double share = tau / (1e-9 * static_cast<double>(out[n + 1].t_ns - out[n].t_ns));
    for (StereoObservation& o : out[n].observations) {
      for (const StereoObservation& next : recording.frames[n + 1].observations) {
        if (next.track_id == o.track_id && next.in_cam1 && o.in_cam1) {
          o.uv_cam1 += share * (next.uv_cam1 - o.uv_cam1);
        }
      }
    }
  }
  return out;
}

TEST(TimeOffset, OfCam1IsFoundBesideAWrongCalibration) {
  Scenario scenario = testing::short_scenario();  // decalibrated
  scenario.duration = 8.0;
  const Recording recording = simulate(scenario, 1);
  const TimeOffset none = cam1_time_offset(recording.calibration, recording.frames).value();
  EXPECT_LT(std::abs(none.seconds), 4.0 * none.sigma);
  const TimeOffset late = cam1_time_offset(recording.calibration, with_late_cam1(recording, 0.01)).value();
  EXPECT_NEAR(late.seconds, 0.01, 4.0 * late.sigma);
  EXPECT_LT(late.sigma, 0.003);
}

/// The same recording, assumed to be seen by rigs that are off by five degrees: to first order they had
/// clocks of 16 ms at ten sigmas, and a picture that is a frame late was found with 52 ± 29 ms of 104 beside
/// a rig that had taken it for its own.
TEST(TimeOffset, OfCam1IsTheSameWhateverRigIsAssumed) {
  Scenario scenario = testing::shipped("drone_moving", 8.0);
  const Recording recording = simulate(scenario, 31);
  const double frame = seconds_between(recording.frames[0].t_ns, recording.frames[1].t_ns);
  const std::vector<StereoFrame> a_frame_late = with_late_cam1(recording, frame);
  for (const Eigen::Index axis : {0, 1, 2}) {
    for (const double degrees : {-5.0, 0.0, 5.0}) {
      StereoCalibration assumed = recording.calibration;
      assumed.theta(axis) += degrees / kToDegrees;
      const TimeOffset none = cam1_time_offset(assumed, recording.frames).value();
      EXPECT_LT(std::abs(none.seconds), 4.0 * none.sigma) << axis << ' ' << degrees;
      EXPECT_LT(none.sigma, 0.002);
      const TimeOffset late = cam1_time_offset(assumed, a_frame_late).value();
      EXPECT_NEAR(late.seconds, frame, 4.0 * late.sigma) << axis << ' ' << degrees;
      EXPECT_LT(late.sigma, 0.002);
    }
  }
}

/// With one rig for the whole recording a rig that was another one for a while looked like milliseconds,
/// eleven sigmas and more of them.
TEST(TimeOffset, OfCam1IsNothingWhereTheRigJumpsAndComesBack) {
  Scenario scenario = testing::shipped("drone_none");
  DecalibrationSignal pulse;
  pulse.amplitude << 0.004, 0.0, 0.0, 0.0, 0.0, 0.0;
  pulse.shape = StepsShape{{{0.3 * scenario.duration, 1.0}, {0.6 * scenario.duration, 0.0}}};
  scenario.decalibration = {pulse};
  double normalized_squared = 0.0;
  constexpr int kRuns = 6;
  for (int seed = 31; seed < 31 + kRuns; ++seed) {
    const Recording recording = simulate(scenario, static_cast<std::uint64_t>(seed));
    const TimeOffset none = cam1_time_offset(recording.calibration, recording.frames).value();
    EXPECT_LT(none.sigma, 0.002);
    normalized_squared += std::pow(none.seconds / none.sigma, 2) / kRuns;
    const TimeOffset late = cam1_time_offset(recording.calibration, with_late_cam1(recording, 0.01)).value();
    EXPECT_NEAR(late.seconds, 0.01, 5.0 * late.sigma);
  }
  EXPECT_LT(normalized_squared, 4.0);
}

/// Bearings at the rim of a wide lens are noisy, and so are the derivatives by the rig there: an offset of up
/// to twelve sigmas was seen.
TEST(TimeOffset, OfCam1IsNothingThroughAWideLens) {
  Scenario scenario = testing::shipped("drone_moving", 12.0);
  Camera& camera = scenario.rig.cam0;
  camera.fu = camera.fv = 300.0;
  camera.distortion = Equidistant{};
  scenario.rig.cam1 = camera;
  double normalized_squared = 0.0;
  constexpr int kRuns = 6;
  for (int seed = 1; seed <= kRuns; ++seed) {
    const Recording recording = simulate(scenario, static_cast<std::uint64_t>(seed));
    const TimeOffset none = cam1_time_offset(recording.calibration, recording.frames).value();
    normalized_squared += std::pow(none.seconds / none.sigma, 2) / kRuns;
  }
  EXPECT_LT(normalized_squared, 4.0);
}

TEST(TimeOffset, OfTheCamerasIsFoundAgainstTheGyro) {
  Scenario scenario = testing::short_scenario();
  scenario.duration = 12.0;
  scenario.decalibration.clear();
  Recording recording = simulate(scenario, 1);
  recording.calibration.body = BodyFrame::kImu;  // the simulated body is cam0
  const TimeOffset none =
      cameras_beside_imu(recording.calibration, recording.frames, recording.imu).value().clock;
  EXPECT_LT(std::abs(none.seconds), 4.0 * none.sigma);
  for (ImuSample& sample : recording.imu) {
    sample.t_ns +=
        20'000'000;  // so the cameras seem early by nothing, the IMU late: motion is at stamp + 20 ms
  }
  const TimeOffset late =
      cameras_beside_imu(recording.calibration, recording.frames, recording.imu).value().clock;
  EXPECT_NEAR(late.seconds - none.seconds, 0.02, 4.0 * late.sigma);
}

/// Pixels with constants per track made depths wrong for as long as the track lives; a motion sideways then
/// looked like a turn, and that like milliseconds with a sigma of 0.3 ms.
TEST(TimeOffset, OfASoundClockIsNothingWithRealisticPixels) {
  Scenario scenario = testing::shipped("drone_none", 20.0, PixelPreset::kRealistic);
  double normalized_squared = 0.0;
  constexpr int kRuns = 6;
  for (int seed = 41; seed < 41 + kRuns; ++seed) {
    Recording recording = simulate(scenario, static_cast<std::uint64_t>(seed));
    const auto beside = cameras_beside_imu(recording.calibration, recording.frames, recording.imu);
    ASSERT_TRUE(beside);
    const TimeOffset offset = beside->clock;
    EXPECT_LT(offset.sigma, 0.001);
    EXPECT_LT(std::abs(offset.seconds), 0.003);
    normalized_squared += std::pow(offset.seconds / offset.sigma, 2) / kRuns;
    recording.calibration.theta(1) += 0.01;  // a wrong rig is no wrong clock
    const auto wrong = cameras_beside_imu(recording.calibration, recording.frames, recording.imu);
    ASSERT_TRUE(wrong);
    EXPECT_LT(std::abs(wrong->clock.seconds), 5.0 * wrong->clock.sigma);
  }
  EXPECT_LT(normalized_squared, 4.0);  // twenty seconds tell their own spread within a factor of two
}

TEST(LeftTurn, IsTheTrueOneWithExactPixelsWhateverTheRig) {
  Scenario scenario = testing::short_scenario();
  scenario.noise.pixel = 1e-9;
  Recording recording = simulate(scenario, 1);
  const auto truth = [&](std::int64_t t_ns) {
    for (const GroundTruthState& state : recording.truth.motion.states) {
      if (state.t_ns == t_ns) {
        return state.R_world_body;
      }
    }
    throw std::out_of_range("no truth at this time");
  };
  recording.calibration.theta(1) += 0.003;  // 3 mrad: the stereo depths are wrong
  const StereoFrame &from = recording.frames[3], &to = recording.frames[7];
  const auto motion = detail::left_motion(recording.calibration, from, to);
  ASSERT_TRUE(motion);
  const Eigen::Vector3d expected = so3_log(truth(from.t_ns).transpose() * truth(to.t_ns));
  EXPECT_GT(expected.norm(), 1e-3);
  EXPECT_LT((motion->turn - expected).norm(), 2e-3 * expected.norm());
}

/// y = 2 + 3 s + noise, where the noise of a cluster is one draw and s is measured with noise.
TEST(ClusteredRegression, StatesWhatItIsWrongBy) {
  constexpr int kRuns = 200, kClusters = 40, kRows = 10;
  double normalized_squared = 0.0, mean = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    const RandomStream random(1, static_cast<std::uint64_t>(run), "clustered");
    detail::ClusteredRows rows;
    for (int c = 0; c < kClusters; ++c) {
      const Eigen::Vector3d shared = random.normal3(static_cast<std::uint64_t>(1000 * c));
      for (int k = 0; k < kRows; ++k) {
        const Eigen::Vector3d own = random.normal3(static_cast<std::uint64_t>(1000 * c + k + 1));
        const double s = shared.x() + 0.3 * own.x();
        rows.A.push_back(Eigen::Vector2d(1.0, s + 0.7 * own.y()));
        rows.Z.push_back(Eigen::Vector2d(1.0, s + 0.7 * own.z()));
        rows.y.push_back(2.0 + 3.0 * s + shared.y());
        rows.cluster.push_back(c);
      }
    }
    const auto solution = detail::solve(rows);
    ASSERT_TRUE(solution);
    mean += (solution->x(1) - 3.0) / kRuns;
    normalized_squared += std::pow((solution->x(1) - 3.0) / solution->sigma_of_last(), 2) / kRuns;
  }
  EXPECT_LT(std::abs(mean), 0.05);  // without instruments 0.9 less
  EXPECT_GT(normalized_squared, 0.75);
  EXPECT_LT(normalized_squared, 1.35);
}

/// A rig that turns in one second of ten: that second decides, and nothing tells its error.
TEST(ClusteredRegression, HasTheFreedomOfTheClustersThatTell) {
  const auto freedom = [](double turning_of_others) {
    detail::ClusteredRows rows;
    const RandomStream random(2, 0, "freedom");
    for (int c = 0; c < 10; ++c) {
      for (int k = 0; k < 20; ++k) {
        const Eigen::Vector3d draw = random.normal3(static_cast<std::uint64_t>(20 * c + k));
        const double s = (c == 0 ? 1.0 : turning_of_others) * draw.x();
        rows.A.push_back(Eigen::Vector2d(1.0, s));
        rows.y.push_back(s + draw.y());
        rows.cluster.push_back(c);
      }
    }
    rows.Z = rows.A;
    return detail::solve(rows).value().dof_of_last();
  };
  EXPECT_GT(freedom(1.0), 6.0);
  EXPECT_LT(freedom(0.1), 1.0);
}

TEST(ClusteredRegression, OfOneClusterKnowsNothing) {
  detail::ClusteredRows rows;
  for (int k = 0; k < 10; ++k) {
    rows.A.push_back(Eigen::Vector2d(1.0, k));
    rows.y.push_back(k);
    rows.cluster.push_back(0);
  }
  rows.Z = rows.A;
  EXPECT_FALSE(detail::solve(rows));
}

TEST(TimeOffset, IsUnknownWithoutMotionOrPoints) {
  Scenario scenario = testing::short_scenario();
  scenario.decalibration.clear();
  const Recording recording = simulate(scenario, 1);
  EXPECT_FALSE(cam1_time_offset(recording.calibration, std::vector<StereoFrame>(2)));
  EXPECT_FALSE(cameras_beside_imu(recording.calibration, recording.frames, {}));
}

}  // namespace
}  // namespace limber
