// SPDX-License-Identifier: MIT
#include "limber/core/median.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace limber {
namespace {

TEST(Median, OfAnOddCountIsTheMiddleValueByEitherConvention) {
  const std::vector<double> values = {5.0, -1.0, 3.0};
  EXPECT_EQ(median(values), 3.0);
  EXPECT_EQ(upper_median(values), 3.0);
}

TEST(Median, OfAnEvenCountIsTheMeanOrTheLargerOfTheTwoInTheMiddle) {
  const std::vector<double> values = {4.0, 1.0, 100.0, 2.0};
  EXPECT_EQ(median(values), 3.0);
  EXPECT_EQ(upper_median(values), 4.0);
}

TEST(Median, IsInfiniteWhereTheUpperMiddleIs) {
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(median({1.0, inf}), inf);
  EXPECT_EQ(median({1.0, 2.0, inf}), 2.0);
}

TEST(OrderStatistic, CountsRanksFromTheSmallest) {
  const std::vector<int> values = {7, 3, 9, 3};
  EXPECT_EQ(order_statistic(values, 0), 3);
  EXPECT_EQ(order_statistic(values, 1), 3);
  EXPECT_EQ(order_statistic(values, 2), 7);
  EXPECT_EQ(order_statistic(values, 3), 9);
}

}  // namespace
}  // namespace limber
