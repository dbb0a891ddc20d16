// SPDX-License-Identifier: MIT
#include "limber/core/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

using Words = std::array<std::uint32_t, 4>;

// The vectors that Random123 (Salmon et al.) publishes for philox4x32-10.
TEST(Philox, GivesThePublishedAnswers) {
  EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}), (Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox4x32({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}),
            (Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(RandomStream, GivesTheSameDrawInAnyOrder) {
  const RandomStream stream(1, 2, "name");
  std::vector<double> forward, backward;
  for (std::uint64_t i = 0; i < 100; ++i) {
    forward.push_back(stream.uniform(i));
    backward.push_back(RandomStream(1, 2, "name").uniform(99 - i));
  }
  std::reverse(backward.begin(), backward.end());
  EXPECT_EQ(forward, backward);
}

TEST(RandomStream, DiffersForEverySeedRunNameAndIndex) {
  std::set<double> draws;
  std::size_t made = 0;
  const std::uint64_t high_word = std::uint64_t{1} << 32;
  for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{1}, high_word}) {
    for (const std::uint64_t run : {std::uint64_t{0}, std::uint64_t{1}, high_word}) {
      for (const char* name : {"pixel_cam0", "pixel_cam1"}) {
        for (const std::uint64_t i : {std::uint64_t{0}, std::uint64_t{1}, high_word}) {
          for (const std::uint32_t j : {0u, 1u}) {
            draws.insert(RandomStream(seed, run, name).uniform(i, j));
            ++made;
          }
        }
      }
    }
  }
  EXPECT_EQ(draws.size(), made);
}

// 30000 draws, fixed seed: each bound is five standard deviations of what it judges.
TEST(RandomStream, DrawsUniformlyFromTheOpenUnitInterval) {
  const RandomStream stream(3, 0, "uniform");
  constexpr int kDraws = 30000;
  double sum = 0.0, squares = 0.0;
  for (std::uint64_t i = 0; i < kDraws; ++i) {
    const double u = stream.uniform(i);
    ASSERT_GT(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    squares += (u - 0.5) * (u - 0.5);
  }
  EXPECT_NEAR(sum / kDraws, 0.5, 5.0 * std::sqrt(1.0 / 12.0 / kDraws));
  EXPECT_NEAR(squares / kDraws, 1.0 / 12.0, 5.0 * std::sqrt(1.0 / 180.0 / kDraws));
}

TEST(RandomStream, DrawsStandardNormalVectorsWithIndependentComponents) {
  const RandomStream stream(3, 0, "normal");
  constexpr int kDraws = 30000;
  Vector3d mean = Vector3d::Zero(), fourth = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero(), neighbour = Matrix3d::Zero();
  for (std::uint64_t i = 0; i < kDraws; ++i) {
    const Vector3d x = stream.normal3(i);
    mean += x / kDraws;
    second += x * x.transpose() / kDraws;
    neighbour += x * stream.normal3(i + 1).transpose() / kDraws;
    fourth += x.array().pow(4).matrix() / kDraws;
  }
  const double bound = 5.0 / std::sqrt(kDraws);
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), bound);
  EXPECT_LT((second - Matrix3d::Identity()).cwiseAbs().maxCoeff(), bound * std::sqrt(2.0));
  EXPECT_LT(neighbour.cwiseAbs().maxCoeff(), bound);
  EXPECT_LT((fourth - Vector3d::Constant(3.0)).cwiseAbs().maxCoeff(), bound * std::sqrt(96.0));
}

TEST(RandomStream, GivesTheFirstTwoOfThreeNormalsAsTheTwoNormals) {
  const RandomStream stream(4, 5, "pair");
  EXPECT_EQ(stream.normal2(7, 3), stream.normal3(7, 3).head<2>());
}

}  // namespace
}  // namespace limber
