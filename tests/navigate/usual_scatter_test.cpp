// SPDX-License-Identifier: MIT
#include "limber/navigate/usual_scatter.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace limber {
namespace {

/// After so many frames of one scatter, with a pixel's noise of one.
UsualScatter after(int frames, double scatter) {
  UsualScatter usual;
  for (int frame = 0; frame < frames; ++frame) {
    usual.learn(scatter, 1.0);
  }
  return usual;
}

TEST(UsualScatter, IsUnknownForSomeFrames) {
  EXPECT_FALSE(UsualScatter().beside(1.0));
  EXPECT_FALSE(after(9, 0.1).beside(1.0));
  EXPECT_NEAR(after(10, 0.1).beside(1.0).value(), 0.1, 1e-12);
}

TEST(UsualScatter, IsThatOfThePixelsWhateverIsAssumedOfThem) {
  EXPECT_NEAR(after(20, 0.1).beside(0.5).value(), 0.4, 1e-12);
}

/// A body that begins to move is not usual for a second, though nothing but it is seen.
TEST(UsualScatter, GrowsByATenthOfItselfInAFrame) {
  UsualScatter usual = after(20, 0.1);
  for (int frame = 0; frame < 20; ++frame) {
    usual.learn(50.0, 1.0);
    usual.learn({}, 1.0);
  }
  EXPECT_NEAR(usual.beside(1.0).value(), 0.1 * std::pow(1.1, 20), 1e-9);
}

TEST(UsualScatter, ForgetsWithinHalfASecond) {
  UsualScatter usual = after(20, 1.0);
  for (int frame = 0; frame < 10; ++frame) {
    usual.learn(0.1, 1.0);
  }
  EXPECT_LT(usual.beside(1.0).value(), 0.45);
}

}  // namespace
}  // namespace limber
