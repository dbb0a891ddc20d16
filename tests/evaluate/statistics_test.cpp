// SPDX-License-Identifier: MIT
#include "limber/evaluate/statistics.hpp"

#include <gtest/gtest.h>
#include <tuple>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace limber {
namespace {

TEST(Statistics, OfFourNumbersAreThoseOnPaper) {
  const Statistics s = statistics_of(std::vector<double>{4.0, 1.0, 3.0, 2.0});
  EXPECT_DOUBLE_EQ(s.sse, 30.0);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(1.25));
  EXPECT_DOUBLE_EQ(s.min, 1.0);
  EXPECT_DOUBLE_EQ(s.max, 4.0);
  EXPECT_EQ(s.count, 4u);
}

TEST(Statistics, MedianOfAnOddCountIsTheMiddleOne) {
  EXPECT_DOUBLE_EQ(statistics_of(std::vector<double>{9.0, 1.0, 2.0}).median, 2.0);
}

TEST(Statistics, OneNumberHasNoSpread) {
  const Statistics s = statistics_of(std::vector<double>{3.0});
  EXPECT_DOUBLE_EQ(s.rmse, 3.0);
  EXPECT_DOUBLE_EQ(s.std, 0.0);
}

TEST(Statistics, RefuseNothingAndNonsense) {
  EXPECT_THROW((void)statistics_of(std::vector<double>{}), std::invalid_argument);
  EXPECT_THROW((void)statistics_of(std::vector<double>{1.0, std::nan("")}), std::invalid_argument);
  EXPECT_THROW((void)statistics_of(std::vector<double>{std::numeric_limits<double>::infinity()}),
               std::invalid_argument);
}

TEST(MedianInterval, IsOfTheTextbook) {
  // Order statistics that hold the median with 95 %: 1st and 6th of 6, 2nd and 9th of 10, 6th and 15th of 20.
  const auto of = [](std::size_t n) {
    std::vector<double> values;
    for (std::size_t k = n; k > 0; --k) {
      values.push_back(static_cast<double>(k));
    }
    return median_interval(values);
  };
  EXPECT_FALSE(of(0));
  EXPECT_EQ(of(5)->median, 3.0);
  EXPECT_FALSE(of(5)->lower || of(5)->upper);
  for (const auto& [n, lower, upper] : {std::tuple{6u, 1.0, 6.0}, {10u, 2.0, 9.0}, {20u, 6.0, 15.0}}) {
    const auto interval = of(n);
    ASSERT_TRUE(interval);
    EXPECT_EQ(interval->lower, lower);
    EXPECT_EQ(interval->upper, upper);
    EXPECT_EQ(interval->median, 0.5 * (n + 1.0));
  }
}

TEST(MedianInterval, TakesInfinityForWorseThanAll) {
  const double inf = std::numeric_limits<double>::infinity();
  const auto one = median_interval(std::vector<double>{1, 2, 3, 4, 5, inf});
  EXPECT_EQ(one->median, 3.5);
  EXPECT_EQ(one->upper, inf);
  EXPECT_EQ(median_interval(std::vector<double>{1, 2, inf, inf, inf, inf})->median, inf);
  EXPECT_THROW((void)median_interval(std::vector<double>(9, std::nan(""))), std::invalid_argument);
}

}  // namespace
}  // namespace limber
