// SPDX-License-Identifier: MIT
#include "limber/datasets/trajectory_files.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "files.hpp"
#include "limber/core/so3.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

using testing::data_error_of;
using testing::read_text;
using testing::TemporaryFolder;
using testing::write_text;

constexpr double kTextRounding = 2e-15;

class TrajectoryFile : public ::testing::Test {
 protected:
  [[nodiscard]] fs::path write(const std::string& content) const { return write_text(path(), content); }
  [[nodiscard]] fs::path path() const { return folder_.path() / "trajectory"; }
  void expect_error(const std::string& content, std::size_t line, const std::string& words) const {
    const DataError error = data_error_of([&] { static_cast<void>(read_trajectory(write(content))); });
    EXPECT_EQ(error.file(), path().string());
    EXPECT_EQ(error.line(), line) << error.what();
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(TrajectoryFile, InTumFormatKeepsEveryNanosecondAndDigit) {
  std::vector<StampedPose> poses;
  for (const std::int64_t t_ns : {-1'500'000'001L, 0L, 7L, 1403636584763555584L, 1403636584763555585L}) {
    const double s = 1.0 / (3.0 + static_cast<double>(poses.size()));
    poses.push_back({t_ns, {so3_exp({s, -4.0 * s, 9.0 * s}), {s, -1e5 * s, 1e-9 * s}}});
  }
  write_tum(path(), poses);
  EXPECT_NE(read_text(path()).find("\n-1.500000001 "), std::string::npos);
  EXPECT_NE(read_text(path()).find("\n1403636584.763555585 "), std::string::npos);
  const Trajectory actual = read_trajectory(path());
  EXPECT_EQ(actual.format, TrajectoryFormat::kTum);
  EXPECT_TRUE(actual.has_time);
  ASSERT_EQ(actual.poses.size(), poses.size());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    EXPECT_EQ(actual.poses[k].t_ns, poses[k].t_ns);
    EXPECT_EQ(actual.poses[k].T_world_body.p, poses[k].T_world_body.p);
    EXPECT_LE((actual.poses[k].T_world_body.R - poses[k].T_world_body.R).cwiseAbs().maxCoeff(),
              kTextRounding);
  }
}

TEST_F(TrajectoryFile, InTumFormatStoresTheQuaternionWithWLast) {
  write_tum(path(), {{1, {so3_exp({0, 0, M_PI / 2}), {1, 2, 3}}}});
  const std::string text = read_text(path());
  EXPECT_NE(text.find("0.000000001 1 2 3 0 0 0.7071067811865"), std::string::npos) << text;
  const auto poses = read_tum(write("5 1 2 3 0 0 0.70710678 0.70710678\n"));
  EXPECT_LE((poses[0].T_world_body.R - so3_exp({0, 0, M_PI / 2})).norm(), 1e-8);
}

TEST_F(TrajectoryFile, InTumFormatMayCarryExtraColumnsExponentsAndManyDecimals) {
  const auto poses =
      read_tum(write("# format\n1521753105.031429052352905  0 0 0 0 0 0 1  1 2 3 4 5 6 \n"
                     "1.5217531055e+09\t1 2 3 0 0 0 1 1 2 3 4 5 6\n"));
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[0].t_ns, 1521753105031429052);
  EXPECT_EQ(poses[1].t_ns, 1521753105500000000);
  EXPECT_EQ(poses[1].T_world_body.p, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(read_tum(write("0.0000000005 0 0 0 0 0 0 1"))[0].t_ns, 1) << "rounded to the nearest";
  EXPECT_EQ(read_tum(write("-0.00000000049 0 0 0 0 0 0 1"))[0].t_ns, 0);
  EXPECT_EQ(read_tum(write("1e-20 0 0 0 0 0 0 1"))[0].t_ns, 0);
}

TEST_F(TrajectoryFile, WithKittiPosesHasIndicesForTimesAndZUp) {
  const Trajectory actual = read_trajectory(write("1 0 0 4 0 1 0 5 0 0 1 6\n1 0 0 7 0 1 0 8 0 0 1 9\n"));
  EXPECT_EQ(actual.format, TrajectoryFormat::kKittiPoses);
  EXPECT_FALSE(actual.has_time);
  ASSERT_EQ(actual.poses.size(), 2U);
  EXPECT_EQ(actual.poses[1].t_ns, 1);
  EXPECT_EQ(actual.poses[1].T_world_body.p, Eigen::Vector3d(9, -7, -8));
  EXPECT_EQ(actual.poses[0].T_world_body.R * Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX());
}

TEST_F(TrajectoryFile, OfEurocGroundTruthIsRead) {
  const auto path = write("#timestamp, p\n10,1,2,3,0,1,0,0,4,5,6\n20,1,2,4,0,1,0,0,4,5,7\n");
  const Trajectory actual = read_trajectory(path);
  EXPECT_EQ(actual.format, TrajectoryFormat::kEurocGroundTruth);
  ASSERT_EQ(actual.poses.size(), 2U);
  EXPECT_EQ(actual.poses[1].T_world_body.p.z(), 4.0);
  EXPECT_EQ(actual.poses[0].T_world_body.R.diagonal(), Eigen::Vector3d(1, -1, -1))
      << "w x y z: half a turn about x";
  const GroundTruth truth = read_euroc_groundtruth(path);
  EXPECT_TRUE(truth.has_velocity);
  EXPECT_FALSE(truth.has_biases);
  EXPECT_EQ(truth.states[1].v_world_body, Eigen::Vector3d(4, 5, 7));
}

TEST_F(TrajectoryFile, OfGroundTruthGivesBackWhatIsKnown) {
  GroundTruthState state;
  state.t_ns = 1403636584763555584;
  state.R_world_body = so3_exp({0.1, 0.2, -0.3});
  state.p_world_body = {1.0 / 7.0, -2, 3};
  state.v_world_body = {0.1, 0.2, 0.3};
  state.bias_gyro = {1e-3, 2e-3, 3e-3};
  state.bias_accel = {0.01, 0.02, 0.03};
  for (const auto& [velocity, biases] :
       {std::pair(false, false), std::pair(true, false), std::pair(true, true)}) {
    write_euroc_groundtruth(path(), {{state}, velocity, biases});
    const GroundTruth truth = read_euroc_groundtruth(path());
    EXPECT_EQ(truth.has_velocity, velocity);
    EXPECT_EQ(truth.has_biases, biases);
    EXPECT_EQ(truth.states[0].p_world_body, state.p_world_body);
    EXPECT_EQ(truth.states[0].v_world_body, velocity ? state.v_world_body : Eigen::Vector3d::Zero());
    EXPECT_EQ(truth.states[0].bias_accel, biases ? state.bias_accel : Eigen::Vector3d::Zero());
  }
}

TEST_F(TrajectoryFile, OfLimberGivesBackKnownAndUnknownValues) {
  TrajectoryRow full;
  full.t_ns = 1403636584763555584;
  full.T_world_body = {so3_exp({1.0 / 3.0, 2, -1}), {1.0 / 7.0, -2e10, 3e-10}};
  full.v_world_body = Eigen::Vector3d(0.1, 0.2, 0.1 + 0.2);
  full.bias_gyro = Eigen::Vector3d(1e-5, -1e-6, 1.0 / 9.0);
  full.bias_accel = Eigen::Vector3d(0.01, -0.02, 0);
  const Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::NullaryExpr(
      [](Eigen::Index i, Eigen::Index j) { return std::sin(static_cast<double>(1 + 6 * i + j)); });
  full.covariance = A * A.transpose();
  full.covariance->triangularView<Eigen::StrictlyLower>() = full.covariance->transpose();
  full.sigma_v = Eigen::Vector3d(0.01, 1.0 / 3.0, 0);
  full.sigma_bias_gyro = Eigen::Vector3d(1e-6, 2e-6, 1.0 / 7.0);
  full.sigma_bias_accel = Eigen::Vector3d(1, 2, 3);
  TrajectoryRow bare;
  bare.t_ns = full.t_ns + 1;
  write_trajectory_csv(path(), {full, bare});

  const auto rows = read_trajectory_csv(path());
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].t_ns, full.t_ns);
  EXPECT_EQ(rows[0].T_world_body.p, full.T_world_body.p);
  EXPECT_LE((rows[0].T_world_body.R - full.T_world_body.R).cwiseAbs().maxCoeff(), kTextRounding);
  EXPECT_EQ(rows[0].v_world_body, full.v_world_body);
  EXPECT_EQ(rows[0].bias_gyro, full.bias_gyro);
  EXPECT_EQ(rows[0].bias_accel, full.bias_accel);
  EXPECT_EQ(*rows[0].covariance, *full.covariance);
  EXPECT_EQ(rows[1].t_ns, bare.t_ns);
  EXPECT_EQ(rows[0].sigma_v, full.sigma_v);
  EXPECT_EQ(rows[0].sigma_bias_gyro, full.sigma_bias_gyro);
  EXPECT_EQ(rows[0].sigma_bias_accel, full.sigma_bias_accel);
  EXPECT_FALSE(rows[1].v_world_body || rows[1].bias_gyro || rows[1].bias_accel || rows[1].covariance ||
               rows[1].sigma_v || rows[1].sigma_bias_gyro || rows[1].sigma_bias_accel);
  EXPECT_EQ(read_trajectory(path()).format, TrajectoryFormat::kLimber);
  EXPECT_EQ(read_trajectory(path()).poses[0].T_world_body.p, full.T_world_body.p);
}

TEST_F(TrajectoryFile, OfLimberNamesColumnsAndUnits) {
  write_trajectory_csv(path(), {});
  EXPECT_EQ(
      read_text(path()),
      "t_ns,px [m],py [m],pz [m],qw [-],qx [-],qy [-],qz [-],vx [m/s],vy [m/s],vz [m/s],bgx [rad/s],bgy "
      "[rad/s],bgz [rad/s],bax [m/s^2],bay [m/s^2],baz [m/s^2],P_px_px [m^2],P_px_py [m^2],P_px_pz "
      "[m^2],P_px_rx [m rad],P_px_ry [m rad],P_px_rz [m rad],P_py_py [m^2],P_py_pz [m^2],P_py_rx [m "
      "rad],P_py_ry [m rad],P_py_rz [m rad],P_pz_pz [m^2],P_pz_rx [m rad],P_pz_ry [m rad],P_pz_rz [m "
      "rad],P_rx_rx [rad^2],P_rx_ry [rad^2],P_rx_rz [rad^2],P_ry_ry [rad^2],P_ry_rz [rad^2],P_rz_rz "
      "[rad^2],sigma_vx [m/s],sigma_vy [m/s],sigma_vz [m/s],sigma_bgx [rad/s],sigma_bgy [rad/s],sigma_bgz "
      "[rad/s],sigma_bax [m/s^2],sigma_bay [m/s^2],sigma_baz [m/s^2]\n");
  const DataError error = data_error_of([&] { static_cast<void>(read_trajectory_csv(path())); });
  EXPECT_NE(std::string(error.what()).find("at least one pose"), std::string::npos);
}

TEST_F(TrajectoryFile, OfLimberIsReadWithoutTheColumnsThatOlderOnesDoNotHave) {
  TrajectoryRow row;
  row.v_world_body = Eigen::Vector3d(1, 2, 3);
  row.sigma_v = Eigen::Vector3d(4, 5, 6);
  write_trajectory_csv(path(), {row});
  std::istringstream lines(read_text(path()));
  std::string older;
  for (std::string line; std::getline(lines, line);) {
    for (int k = 0; k < 9; ++k) {
      line.erase(line.rfind(','));
    }
    older += line + "\n";
  }
  (void)write(older);
  const auto rows = read_trajectory_csv(path());
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].v_world_body, row.v_world_body);
  EXPECT_FALSE(rows[0].sigma_v || rows[0].sigma_bias_gyro || rows[0].sigma_bias_accel);
}

TEST_F(TrajectoryFile, OfLimberIsRefusedWhenItsCellsAreNotInOrder) {
  TrajectoryRow row;
  row.v_world_body = Eigen::Vector3d(1, 2, 3);
  write_trajectory_csv(path(), {row});
  const std::string text = read_text(path());
  expect_error(testing::replaced(text, "1,2,3", "1,,3"), 2,
               "columns 9 to 11 all filled or all empty, found 1 of 3");
  expect_error(testing::replaced(text, "px [m],py [m]", "py [m],px [m]"), 1, "px [m] as name of column 2");
  expect_error(testing::replaced(text, "1,2,3", "1,2,nan"), 2, "a finite number for vz [m/s]");
  expect_error(testing::replaced(text, "1,2,3", "1,2"), 2, "47 columns");
  row.sigma_v = Eigen::Vector3d(0.5, -0.25, 1);
  write_trajectory_csv(path(), {row});
  expect_error(read_text(path()), 2, "standard deviations that are not negative, found -0.25");
  const DataError error = data_error_of([&] { static_cast<void>(read_trajectory_csv(write("1 2 3\n"))); });
  EXPECT_NE(std::string(error.what()).find("the header of a trajectory.csv"), std::string::npos);
}

TEST_F(TrajectoryFile, IsRefusedWhenBroken) {
  expect_error("", 0, "a trajectory: TUM");
  expect_error("# only\n# comments\n", 0, "no line of data");
  expect_error("1 2 3\n", 0, "found '1 2 3'");
  expect_error("0 0 0 0 0 0 0 1\n0 0 0 0 0 0 0 1\n", 2, "the same timestamp again");
  expect_error("1 0 0 0 0 0 0 1\n0.5 0 0 0 0 0 0 1\n", 2, "later than the previous one");
  expect_error("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0\n", 2, "8 columns");
  expect_error("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 2\n", 2, "a unit quaternion, found one of norm 2");
  expect_error("0 0 0 nan 0 0 0 1\n", 1, "a finite number for tz [m], found 'nan'");
  expect_error("1e99 0 0 0 0 0 0 1\n", 1, "a time in seconds, found '1e99'");
  expect_error("now 0 0 0 0 0 0 1\n", 1, "a time in seconds, found 'now'");
  expect_error("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 2 0 0 0 0 1 0\n", 2, "a rotation");
  expect_error("1 0 0 0 0 1 0 0 0 0 -1 0\n", 1, "a rotation");
  expect_error(std::string("1 0 0\0", 6), 1, "binary data (byte 0x00)");
}

TEST_F(TrajectoryFile, IsNotWrittenWithTimesOrNumbersThatCouldNotBeReadBack) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(write_tum(path(), {{1, {}}, {1, {}}}), std::invalid_argument);
  EXPECT_THROW(write_tum(path(), {{1, {Eigen::Matrix3d::Identity(), {0, nan, 0}}}}), std::invalid_argument);
  TrajectoryRow row;
  EXPECT_THROW(write_trajectory_csv(path(), {row, row}), std::invalid_argument);
  row.covariance = Eigen::Matrix<double, 6, 6>::Constant(nan);
  EXPECT_THROW(write_trajectory_csv(path(), {row}), std::invalid_argument);
  EXPECT_FALSE(fs::exists(path()));
}

}  // namespace
}  // namespace limber
