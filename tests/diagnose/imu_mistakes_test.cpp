// SPDX-License-Identifier: MIT
// Units and mounts of an IMU that cannot be right beside the cameras.
#include "limber/diagnose/imu_mistakes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <numbers>
#include <variant>

#include "limber/core/so3.hpp"
#include "limber/simulate/simulator.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Recording drone() { return simulate(testing::shipped("drone_moving", 10.0), 3); }

std::vector<std::string> mistakes_after(const std::function<void(Recording&)>& change) {
  Recording recording = drone();
  change(recording);
  return imu_mistakes(recording.calibration, recording.frames, recording.imu, 9.81);
}

void each_sample(Recording& recording, const std::function<void(ImuSample&)>& change) {
  for (ImuSample& sample : recording.imu) {
    change(sample);
  }
}

TEST(ImuMistakes, OfASoundImuAreNone) {
  EXPECT_THAT(mistakes_after([](Recording&) {}), IsEmpty());
}

TEST(ImuMistakes, NameTheUnit) {
  EXPECT_THAT(mistakes_after([](Recording& recording) {
                each_sample(recording, [](ImuSample& s) { s.omega_imu *= 180.0 / std::numbers::pi; });
              }),
              ElementsAre(HasSubstr("the gyro's rates are in deg/s")));
  EXPECT_THAT(mistakes_after([](Recording& recording) {
                each_sample(recording, [](ImuSample& s) { s.accel_imu /= 9.80665; });
              }),
              ElementsAre(HasSubstr("the accelerometer is in g instead of m/s^2: its length is 1.0")));
}

/// A rover on mostly straight ways: half of the time it turns by less than 2 deg/s.
TEST(ImuMistakes, NameTheUnitOfAGyroThatTurnsLittle) {
  Scenario scenario = testing::shipped("drone_moving", 10.0);
  std::get<RandomSplineTrajectory>(scenario.trajectory).max_angular_rate = 0.06;
  Recording rover = simulate(scenario, 3);
  EXPECT_THAT(imu_mistakes(rover.calibration, rover.frames, rover.imu, 9.81), IsEmpty());
  each_sample(rover, [](ImuSample& s) { s.omega_imu *= 180.0 / std::numbers::pi; });
  EXPECT_THAT(imu_mistakes(rover.calibration, rover.frames, rover.imu, 9.81),
              ElementsAre(HasSubstr("the gyro's rates are in deg/s")));
}

TEST(ImuMistakes, NameTheMount) {
  EXPECT_THAT(mistakes_after([](Recording& recording) {
                recording.calibration.T_body_cam0 = recording.calibration.T_body_cam0.inverse();
              }),
              ElementsAre(HasSubstr("T_BS of cam0 is inverted")));
  const Eigen::Matrix3d quarter = so3_exp(0.5 * std::numbers::pi * Eigen::Vector3d::UnitZ());
  EXPECT_THAT(mistakes_after([&](Recording& recording) {
                recording.calibration.T_body_cam0.R = recording.calibration.T_body_cam0.R * quarter;
              }),
              ElementsAre(HasSubstr("does not fit the IMU's axes: it is turned by 90 deg")));
  EXPECT_THAT(mistakes_after([](Recording& recording) {
                each_sample(recording, [](ImuSample& s) { std::swap(s.omega_imu.x(), s.omega_imu.z()); });
              }),
              ElementsAre(HasSubstr("an axis of the gyro has the wrong sign, or two of them are swapped")));
}

/// Of a walk with a rig that is bent by a degree, whose lengths are wrong: signs are not.
class AccelerometerMistakes : public ::testing::Test {
 protected:
  static std::vector<std::string> after(const std::function<void(Eigen::Vector3d&)>& change) {
    static const Recording sound = [] {
      Scenario scenario = testing::shipped("walk");
      Recording out = simulate(scenario, 11);
      out.calibration.theta(1) += std::numbers::pi / 180.0;
      return out;
    }();
    Recording recording = sound;
    each_sample(recording, [&](ImuSample& s) { change(s.accel_imu); });
    return imu_mistakes(recording.calibration, recording.frames, recording.imu, 9.81);
  }
};

TEST_F(AccelerometerMistakes, AreNoneOfASoundOne) {
  EXPECT_THAT(after([](Eigen::Vector3d&) {}), IsEmpty());
}

TEST_F(AccelerometerMistakes, NameTheSign) {
  EXPECT_THAT(after([](Eigen::Vector3d& f) { f = -f; }),
              ElementsAre(HasSubstr("the accelerometer has the wrong sign: at rest it has to point up")));
}

TEST_F(AccelerometerMistakes, NameTheAxes) {
  EXPECT_THAT(
      after([](Eigen::Vector3d& f) { f.y() = -f.y(); }),
      ElementsAre(HasSubstr("the accelerometer's axes are not those of the gyro and of T_BS: y has the "
                            "wrong sign (")));
  EXPECT_THAT(after([](Eigen::Vector3d& f) { std::swap(f.x(), f.z()); }),
              ElementsAre(HasSubstr("T_BS: x is given as z, z is given as x (")));
  EXPECT_THAT(after([](Eigen::Vector3d& f) { f = Eigen::Vector3d(-f.y(), f.x(), f.z()); }),
              ElementsAre(HasSubstr("T_BS: x is given as y, y is given as -x (")));
}

TEST_F(AccelerometerMistakes, NameGravityThatIsMissing) {
  EXPECT_THAT(after([](Eigen::Vector3d& f) { f *= 0.05; }),
              ElementsAre(AllOf(HasSubstr("without gravity"), HasSubstr("expected about 9.81"))));
  // Of a length about 1, as in g, which does not stay there.
  Recording recording = drone();
  std::size_t k = 0;
  each_sample(recording, [&k](ImuSample& s) {
    s.accel_imu = 1.4 * std::sin(0.02 * static_cast<double>(k)) * Eigen::Vector3d::UnitX();
    ++k;
  });
  EXPECT_THAT(imu_mistakes(recording.calibration, recording.frames, recording.imu, 9.81),
              ElementsAre(HasSubstr("without gravity")));
}

/// A body that hardly accelerates could have any.
TEST_F(AccelerometerMistakes, AreNotInventedWhereNothingAccelerates) {
  Scenario scenario = testing::shipped("creeping");
  for (const std::uint64_t seed : {1U, 2U}) {
    const Recording recording = simulate(scenario, seed);
    EXPECT_THAT(imu_mistakes(recording.calibration, recording.frames, recording.imu, 9.81), IsEmpty());
  }
}

TEST(ImuMistakes, AreNotInventedWhereNothingTurns) {
  Recording recording = drone();
  for (StereoFrame& frame : recording.frames) {
    frame.observations = recording.frames.front().observations;  // it stands
  }
  each_sample(recording, [](ImuSample& s) { s.omega_imu *= 10.0; });
  EXPECT_THAT(imu_mistakes(recording.calibration, recording.frames, recording.imu, 9.81), IsEmpty());
}

TEST(ImuMistakes, NeedAnImu) {
  EXPECT_THAT(mistakes_after([](Recording& recording) { recording.imu.clear(); }), IsEmpty());
}

}  // namespace
}  // namespace limber
