// SPDX-License-Identifier: MIT
// The definitions are those of the tool evo: on a real drive every statistic agrees with what evo printed for
// it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "limber/evaluate/evaluation.hpp"
#include "real_data.hpp"

namespace limber {
namespace {

// As evo reads them: the matrices as they stand, not made orthonormal beyond their printed digits.
std::vector<StampedPose> read_matrices(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<StampedPose> poses;
  StampedPose pose;
  auto& [R, p] = pose.T_world_body;
  while (file >> R(0, 0) >> R(0, 1) >> R(0, 2) >> p(0) >> R(1, 0) >> R(1, 1) >> R(1, 2) >> p(1) >> R(2, 0) >>
         R(2, 1) >> R(2, 2) >> p(2)) {
    poses.push_back(pose);
    ++pose.t_ns;
  }
  return poses;
}

void expect_equal(const nlohmann::json& evo, const std::string& entry, const Statistics& found) {
  const nlohmann::json& expected = evo.at(entry);
  const auto near = [&](const char* name, double value) {
    const double reference = expected.at(name).get<double>();
    EXPECT_NEAR(value, reference, 1e-9 * std::abs(reference) + 1e-14) << entry << " " << name;
  };
  near("rmse", found.rmse);
  near("mean", found.mean);
  near("median", found.median);
  near("std", found.std);
  near("min", found.min);
  near("max", found.max);
  near("sse", found.sse);
}

void expect_equal(const nlohmann::json& evo, const std::string& alignment, const AlignedErrors& found) {
  ASSERT_TRUE(found.errors) << alignment;
  expect_equal(evo, "ape_translation_m_" + alignment, found.errors->position_m);
  expect_equal(evo, "ape_rotation_deg_" + alignment, found.errors->attitude_deg);
  EXPECT_NEAR(found.alignment.scale, evo["ape_translation_m_" + alignment]["alignment_scale"].get<double>(),
              1e-12);
}

TEST(EvoAgreement, EveryStatisticOfAKittiDriveIsTheSame) {
  LIMBER_NEED_DATA(folder, "trajectories");
  const nlohmann::json evo =
      nlohmann::json::parse(std::ifstream(folder / "KITTI_00_ORB.evo.json")).at("results");
  const auto poses =
      match_by_index(read_matrices(folder / "KITTI_00_ORB.txt"), read_matrices(folder / "KITTI_00_gt.txt"));
  ASSERT_EQ(poses.size(), 4541u);
  const TrajectoryEvaluation found = evaluate_trajectory(poses);

  expect_equal(evo, "none", found.none);
  expect_equal(evo, "se3", found.se3);
  expect_equal(evo, "sim3", found.sim3);
  ASSERT_TRUE(found.relative_1_frame && found.relative_distance);
  expect_equal(evo, "rpe_translation_m_1_frame", found.relative_1_frame->position_m);
  expect_equal(evo, "rpe_rotation_deg_1_frame", found.relative_1_frame->attitude_deg);
  expect_equal(evo, "rpe_translation_m_100_m_all_pairs", found.relative_distance->position_m);
  expect_equal(evo, "rpe_rotation_deg_100_m_all_pairs", found.relative_distance->attitude_deg);
}

}  // namespace
}  // namespace limber
