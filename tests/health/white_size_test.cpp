// SPDX-License-Identifier: MIT
#include "limber/health/white_size.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "check_covariance.hpp"
#include "random_geometry.hpp"

namespace limber {
namespace {

using testing::Generator;
using Vector6 = WhiteSize::Vector6;

constexpr double kFrame = 0.05;  // [s]

/// A frame's evidence: each axis known to `sigma`, its fresh part of size `size`.
ParameterEvidence frame(Generator& generator, const Vector6& sigma, const Vector6& size) {
  const Vector6 beta = size.cwiseProduct(testing::random_normal(generator, 6)) +
                       sigma.cwiseProduct(testing::random_normal(generator, 6));
  const Vector6 information = sigma.cwiseAbs2().cwiseInverse();
  return {information.asDiagonal(), information.cwiseProduct(beta)};
}

TEST(WhiteSize, IsZeroUntilSomebodyDoubts) {
  WhiteSize size;
  EXPECT_TRUE(size.is_zero());
  EXPECT_TRUE(size.variance().isZero(0.0));
  size.begin(Vector6::Constant(2.0));
  EXPECT_FALSE(size.is_zero());
  EXPECT_GE(size.variance().minCoeff(), 4.0);
}

TEST(WhiteSize, ComesDownToWhatTheFramesShow) {
  Generator generator(1);
  Vector6 sigma, truth;
  sigma << 0.1, 0.3, 0.5, 0.1, 0.3, 0.5;
  truth << 0.0, 0.0, 0.0, 0.5, 1.0, 2.0;
  WhiteSize size;
  size.begin(Vector6::Constant(3.0));
  for (int k = 0; k < 600; ++k) {
    size.learn(frame(generator, sigma, truth), kFrame);
  }
  // 10 s of memory are 200 frames: s² is known to sqrt(2 / 200) = 0.1 of sigma². In use is four times that,
  // and the estimate itself may be three times that above zero.
  for (int k = 0; k < 3; ++k) {
    EXPECT_LE(size.variance()(k), 0.7 * sigma(k) * sigma(k)) << k;
  }
  for (int k = 3; k < 6; ++k) {
    EXPECT_GE(std::sqrt(size.variance()(k)), 0.9 * truth(k)) << k;
    EXPECT_LE(std::sqrt(size.variance()(k)), 1.5 * truth(k)) << k;
  }
}

TEST(WhiteSize, AnotherDoubtNeverMakesItSmaller) {
  WhiteSize size;
  size.begin(Vector6::Constant(2.0));
  const Vector6 before = size.variance();
  size.begin(Vector6::Constant(0.1));
  EXPECT_TRUE((size.variance().array() >= before.array()).all());
}

}  // namespace
}  // namespace limber
