// SPDX-License-Identifier: MIT
#include "limber/study/exact_sum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

namespace limber {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr auto kQuantity = CurveQuantity::kPositionSquaredError;

TEST(ToFixed, RoundsToTheNearestMultiple) {
  EXPECT_TRUE(to_fixed(0.75, 2) == Int128{3});
  EXPECT_TRUE(to_fixed(0.76, 2) == Int128{3});
  EXPECT_TRUE(to_fixed(-0.76, 2) == Int128{-3});
  EXPECT_TRUE(to_fixed(0.0, 80) == Int128{0});
}

TEST(ToFixed, KeepsEveryBitOfANumberThatIsNotTiny) {
  std::mt19937_64 generator(1);
  std::uniform_real_distribution<double> exponent(-20.0, 20.0);
  for (int k = 0; k < 1000; ++k) {
    const double value = std::exp2(exponent(generator));  // the last bit is worth at least 2^-73
    EXPECT_EQ(from_fixed(to_fixed(value, 80).value(), 80), value);
  }
}

TEST(ToFixed, RefusesWhatIsNotFiniteOrWouldNotFitManyTimes) {
  for (const double value : {kNaN, std::numeric_limits<double>::infinity(), -1e300, std::ldexp(1.0, 23)}) {
    EXPECT_FALSE(to_fixed(value, 80)) << value;
  }
  EXPECT_TRUE(to_fixed(std::nextafter(std::ldexp(1.0, 23), 0.0), 80));
}

TEST(ToFixed, LeavesRoomForAsManyTermsAsAStudyMayHave) {
  const Int128 largest = to_fixed(std::nextafter(std::ldexp(1.0, 23), 0.0), 80).value();
  Int128 sum = 0;
  ASSERT_FALSE(__builtin_mul_overflow(largest, Int128{static_cast<std::int64_t>(kMaxTerms)}, &sum));
}

TEST(CurveSum, IsTheSameInEveryOrderAndInEveryGrouping) {
  std::mt19937_64 generator(2);
  std::uniform_real_distribution<double> exponent(-30.0, 15.0);
  std::vector<std::vector<double>> runs(50);
  for (auto& run : runs) {
    for (int k = 0; k < 7; ++k) {
      run.push_back(std::exp(exponent(generator)));
    }
  }
  runs[3][2] = kNaN;
  CurveSum forward(kQuantity, 7), shuffled(kQuantity, 7), left(kQuantity, 7), right(kQuantity, 7);
  double naive_forward = 0.0, naive_shuffled = 0.0;
  for (const auto& run : runs) {
    forward.add(run);
    naive_forward += run[0];
  }
  std::shuffle(runs.begin(), runs.end(), generator);
  for (std::size_t k = 0; k < runs.size(); ++k) {
    shuffled.add(runs[k]);
    (k % 3 == 0 ? left : right).add(runs[k]);
    naive_shuffled += runs[k][0];
  }
  left.add(right);
  EXPECT_EQ(forward.to_bytes(), shuffled.to_bytes());
  EXPECT_EQ(forward.to_bytes(), left.to_bytes());
  EXPECT_NE(naive_forward, naive_shuffled);  // which is why sums are kept like this
  EXPECT_NEAR(forward.curve().mean[0], naive_forward / 50.0, 1e-12 * naive_forward);
}

TEST(CurveSum, AveragesOverTheRunsThatHaveSomethingToSay) {
  CurveSum sum(kQuantity, 3);
  sum.add(std::vector<double>{1.0, 2.0, kNaN});
  sum.add(std::vector<double>{3.0, kNaN, kNaN});
  const StudyCurve curve = sum.curve();
  EXPECT_EQ(curve.count, (std::vector<std::uint64_t>{2, 1, 0}));
  EXPECT_EQ(curve.mean[0], 2.0);
  EXPECT_EQ(curve.mean[1], 2.0);
  EXPECT_TRUE(std::isnan(curve.mean[2]));
}

TEST(CurveSum, StaysAsItWasWhenAValueIsOutOfRange) {
  CurveSum sum(kQuantity, 2);
  sum.add(std::vector<double>{1.0, 2.0});
  const std::string before = sum.to_bytes();
  EXPECT_THROW(sum.add(std::vector<double>{1.0, 1e30}), std::invalid_argument);
  EXPECT_THROW(sum.add(std::vector<double>{1.0}), std::invalid_argument);
  EXPECT_THROW(sum.add(CurveSum(kQuantity, 3)), std::invalid_argument);
  EXPECT_EQ(sum.to_bytes(), before);
}

TEST(CurveSum, GoesThroughBytesAndBack) {
  CurveSum sum(kQuantity, 4);
  sum.add(std::vector<double>{1e-9, -1e6, kNaN, 0.1});
  const std::string bytes = sum.to_bytes();
  EXPECT_EQ(bytes.size(), 4u * 24u);
  EXPECT_EQ(CurveSum(kQuantity, bytes).to_bytes(), bytes);
  EXPECT_EQ(CurveSum(kQuantity, bytes).curve().mean[1], -1e6);
  EXPECT_THROW((void)CurveSum(kQuantity, bytes.substr(1)), std::invalid_argument);
}

TEST(CurveQuantity, IsFoundByItsName) {
  for (std::size_t k = 0; k < kCurveQuantities; ++k) {
    const auto quantity = static_cast<CurveQuantity>(k);
    EXPECT_EQ(quantity_from_name(name_of(quantity)), quantity);
    EXPECT_FALSE(unit_of(quantity).empty());
  }
  EXPECT_EQ(name_of(theta_axis(CurveQuantity::kThetaVarianceAx, 5)), "theta_variance_tz");
  EXPECT_THROW((void)quantity_from_name("speed"), std::invalid_argument);
}

}  // namespace
}  // namespace limber
