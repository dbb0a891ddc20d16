// SPDX-License-Identifier: MIT
#include "limber/report/thinning.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace limber {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::vector<double> noise(std::size_t count) {
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  std::vector<double> out(count);
  std::generate(out.begin(), out.end(), [&] { return normal(generator); });
  return out;
}

TEST(ThinToExtremes, KeepsAllUpToTheLimit) {
  const std::vector<double> y = noise(50);
  const auto kept = thin_to_extremes(y, 50);
  ASSERT_EQ(kept.size(), 50u);
  for (std::size_t k = 0; k < kept.size(); ++k) {
    EXPECT_EQ(kept[k], k);
  }
  EXPECT_TRUE(thin_to_extremes({}, 8).empty());
}

TEST(ThinToExtremes, NeverPassesTheLimitNorRepeatsASample) {
  for (const std::size_t count : {9u, 10u, 101u, 1000u, 4321u}) {
    for (const std::size_t limit : {8u, 9u, 50u, 333u}) {
      const auto kept = thin_to_extremes(noise(count), limit);
      EXPECT_LE(kept.size(), limit) << count;
      EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end(), std::less_equal<>())) << count;
      EXPECT_EQ(kept.front(), 0u);
      EXPECT_EQ(kept.back(), count - 1);
    }
  }
}

TEST(ThinToExtremes, LosesNoPeakHoweverNarrow) {
  for (std::size_t at = 0; at < 1000; at += 7) {
    std::vector<double> y(1000, 1.0);
    y[at] = 9.0;
    y[999 - at] = -9.0;
    const auto kept = thin_to_extremes(y, 40);
    EXPECT_TRUE(std::binary_search(kept.begin(), kept.end(), at));
    EXPECT_TRUE(std::binary_search(kept.begin(), kept.end(), 999 - at));
  }
}

TEST(ThinToExtremes, LeavesGapsOpen) {
  std::vector<double> y = noise(1000);
  std::fill(y.begin() + 400, y.begin() + 600, kNan);
  const auto kept = thin_to_extremes(y, 60);
  const auto missing =
      std::count_if(kept.begin(), kept.end(), [&](std::size_t k) { return std::isnan(y[k]); });
  EXPECT_GE(missing, 2);
  EXPECT_LE(kept.size(), 60u);
}

TEST(ThinEvenly, KeepsBothEndsAndEqualSteps) {
  const auto kept = thin_evenly(1001, 101);
  ASSERT_EQ(kept.size(), 101u);
  for (std::size_t k = 0; k < kept.size(); ++k) {
    EXPECT_EQ(kept[k], 10 * k);
  }
  EXPECT_EQ(thin_evenly(7, 100).size(), 7u);
  EXPECT_TRUE(thin_evenly(0, 100).empty());
}

TEST(Thinning, RefusesALimitThatIsTooSmall) {
  EXPECT_THROW((void)thin_to_extremes(noise(9), 7), std::invalid_argument);
  EXPECT_THROW((void)thin_evenly(9, 1), std::invalid_argument);
}

}  // namespace
}  // namespace limber
