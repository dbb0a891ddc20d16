// SPDX-License-Identifier: MIT
// --calib, --imu and --images of run, smooth and health.
#include "cli/small_log.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/rig_files/write_rig_files.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using testing::expect_refused;
using ::testing::HasSubstr;
using testing::read_text;
using testing::write_text;

class CalibrationOption : public testing::SmallLog {
 protected:
  [[nodiscard]] StereoCalibration own() const { return read_recording(log()).calibration; }
  [[nodiscard]] std::string written(const StereoCalibration& calibration) const {
    return write_text(folder() / "camchain.yaml", kalibr_camchain(calibration)).string();
  }
};

TEST_F(CalibrationOption, TheOwnCalibrationFromAFileChangesNothing) {
  ASSERT_EQ(run_into(folder() / "without").exit_code, 0);
  const auto result = run_into(folder() / "with", {"--calib", written(own())});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto last_of = [](const std::string& text) { return text.substr(text.rfind('\n', text.size() - 2)); };
  const std::string a = last_of(read_text(folder() / "without/trajectory.tum")),
                    b = last_of(read_text(folder() / "with/trajectory.tum"));
  EXPECT_EQ(a.substr(0, 25), b.substr(0, 25)) << "but for rounding";
}

TEST_F(CalibrationOption, AnotherCalibrationIsUsed) {
  StereoCalibration other = own();
  other.theta(3) *= 1.3;
  ASSERT_EQ(run_into(folder() / "ekf", {"--method", "ekf"}).exit_code, 0);
  ASSERT_EQ(run_into(folder() / "long", {"--method", "ekf", "--calib", written(other)}).exit_code, 0);
  EXPECT_NE(read_text(folder() / "ekf/trajectory.tum"), read_text(folder() / "long/trajectory.tum"));
}

TEST_F(CalibrationOption, OtherImagesAreRefused) {
  StereoCalibration other = own();
  other.cam0.distortion = other.cam1.distortion = RadialTangential{-0.2, 0.05, 0.0, 0.0};
  expect_refused(run({"--calib", written(other)}), 1, "--images raw");
  other = own();
  other.cam0.width += 1;
  expect_refused(run({"--calib", written(other)}), 1,
                 "camchain.yaml: the calibration of cam0 is for images of");
  EXPECT_FALSE(std::filesystem::exists(out()));
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

// T_imu_cam of both cameras written as T_cam_imu, as in a chain of OpenVINS renamed by hand.
TEST_F(CalibrationOption, ThatIsInvertedIsNamedOnceAndInTheResults) {
  StereoCalibration inverted = own();
  inverted.T_body_cam0.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  inverted.T_body_cam0.p = {0.1, 0.05, -0.02};
  const Pose T_imu_cam1 = pose_from_rig(own().theta) * inverted.T_body_cam0;  // the wrong way round
  inverted.theta = rig_from_pose(T_imu_cam1.inverse() * inverted.T_body_cam0);
  const std::string said = "looks like a mistake: T_BS of both cameras is inverted: it maps camera to IMU";
  const auto result = run({"--method", "mono-left", "--init", "groundtruth", "--calib", written(inverted)});
  EXPECT_EQ(count_of(result.err, "limber: warning: " + said), 1U) << result.err;
  EXPECT_EQ(count_of(result.err, said), 1U) << result.err;
  EXPECT_THAT(result.err,
              HasSubstr("% of the stereo points that tell agree with the calibration, 100 % would without"));
  EXPECT_THAT(read_text(out() / "summary.json"), HasSubstr(said));
  EXPECT_EQ(result.exit_code, 1) << "no pose of it is worth anything";
}

TEST_F(CalibrationOption, ThatSitsOnTheImuTheWrongWayRoundIsNamedWhereTheRigTurns) {
  Scenario scenario = testing::shipped("drone_moving", 10.0);
  const Recording drone = simulate(scenario, 3);
  write_track_log(drone, folder() / "drone");
  const auto said_of = [&](const StereoCalibration& calibration) {
    return testing::run_limber({"run", (folder() / "drone").string(), "--method", "mono-left", "--init",
                                "groundtruth", "--max-landmarks", "20", "--max-points", "60", "--calib",
                                written(calibration), "--out", out().string(), "--force"})
        .err;
  };
  EXPECT_THAT(said_of(drone.calibration), ::testing::Not(HasSubstr("mistake")));
  StereoCalibration inverted = drone.calibration;
  inverted.T_body_cam0 = inverted.T_body_cam0.inverse();
  EXPECT_THAT(said_of(inverted),
              HasSubstr("limber: warning: looks like a mistake: T_BS of cam0 is inverted"));
}

TEST_F(CalibrationOption, UsageIsChecked) {
  EXPECT_EQ(run({"--images", "raw"}).exit_code, 2) << "without --calib";
  expect_refused(run({"--calib", (folder() / "none.yaml").string()}), 1, "none.yaml");
}

TEST_F(CalibrationOption, NoiseOfTheImuIsReplaced) {
  const auto imu = write_text(folder() / "imu.yaml", "gyroscope_noise_density: 0.1\n").string();
  expect_refused(run({"--imu", imu}), 1, "imu.yaml");
  write_text(folder() / "imu.yaml", kalibr_imu(ImuNoise{}));
  EXPECT_EQ(run({"--imu", imu}).exit_code, 0);
  const std::string camchain = written(own());
  expect_refused(run_again({"--calib", imu, "--imu", camchain}), 1,
                 "found the noise of an IMU, which --imu takes");
  expect_refused(run_again({"--imu", camchain}), 1, "found a calibration of cameras, which --calib takes");
}

}  // namespace
}  // namespace limber
