// SPDX-License-Identifier: MIT
#include "limber/evaluate/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <tuple>
#include <utility>
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

TEST(MeanInterval, IsStudentsWhereNeighboursAreNotAlike) {
  // Alternating values: neighbours are anything but alike. Quantiles of Student's T from the tables.
  for (const auto& [n, quantile] : {std::pair{6u, 2.5706}, {10u, 2.2622}, {20u, 2.0930}, {120u, 1.9801}}) {
    std::vector<double> values;
    for (std::size_t k = 0; k < n; ++k) {
      values.push_back(k % 2 == 0 ? 4.0 : 2.0);
    }
    const auto interval = mean_interval(values);
    ASSERT_TRUE(interval && interval->lower && interval->upper);
    EXPECT_DOUBLE_EQ(interval->mean, 3.0);
    EXPECT_EQ(interval->correlation, 0.0);
    EXPECT_EQ(interval->count, n);
    EXPECT_NEAR(*interval->upper - 3.0, quantile / std::sqrt(n - 1.0), 1e-4) << n;
    EXPECT_NEAR(3.0 - *interval->lower, quantile / std::sqrt(n - 1.0), 1e-4) << n;
  }
}

TEST(MeanInterval, SaysLittleWhereLittleIsKnown) {
  EXPECT_FALSE(mean_interval(std::vector<double>{}));
  EXPECT_FALSE(mean_interval(std::vector<double>{1.0, 2.0, 1.0, 2.0})->lower);
  const auto slope = mean_interval(std::vector<double>{1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0});
  EXPECT_LT(*slope->lower, 0.0);
  EXPECT_GT(*slope->upper, 9.0);
  EXPECT_THROW((void)mean_interval(std::vector<double>{1.0, std::nan("")}), std::invalid_argument);
  const auto equal = mean_interval(std::vector<double>(7, 2.5));
  EXPECT_EQ(equal->lower, 2.5);
  EXPECT_EQ(equal->upper, 2.5);
}

TEST(MeanInterval, HoldsTheMeanAsOftenAsItSays) {
  // 2000 sequences each: the share has a standard deviation of 0.5 %. Alike neighbours are known from the
  // values alone, so that it holds a little less there.
  std::mt19937_64 generator(7);
  std::normal_distribution<double> normal;
  for (const auto& [alike, least, most] : {std::tuple{0.0, 0.94, 0.985}, {0.3, 0.91, 0.985}}) {
    std::size_t held = 0;
    for (int sequence = 0; sequence < 2000; ++sequence) {
      std::vector<double> values;
      double value = normal(generator) / std::sqrt(1.0 - alike * alike);
      for (int k = 0; k < 12; ++k) {
        value = alike * value + normal(generator);
        values.push_back(value);
      }
      const auto interval = mean_interval(values);
      held += *interval->lower < 0.0 && *interval->upper > 0.0 ? 1 : 0;
    }
    EXPECT_GT(static_cast<double>(held) / 2000.0, least) << alike;
    EXPECT_LT(static_cast<double>(held) / 2000.0, most) << alike;
  }
}

}  // namespace
}  // namespace limber
