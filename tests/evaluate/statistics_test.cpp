// SPDX-License-Identifier: MIT
#include "limber/evaluate/statistics.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace limber
