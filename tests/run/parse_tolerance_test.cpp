// SPDX-License-Identifier: MIT
#include "limber/run/parse_tolerance.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <stdexcept>

namespace limber {
namespace {

TEST(ParseTolerance, KeepsWhatIsNotNamed) {
  const Tolerance tolerance = parse_tolerance("px=0.5");
  EXPECT_DOUBLE_EQ(tolerance.epipolar_px.ok, 0.5);
  EXPECT_NEAR(tolerance.epipolar_px.wrong, 5.0 / 3.0, 1e-12);
  EXPECT_DOUBLE_EQ(tolerance.depth.ok, Tolerance{}.depth.ok);
  EXPECT_FALSE(tolerance.axes[0]);
}

TEST(ParseTolerance, ReadsEffectsAndAxes) {
  const Tolerance tolerance = parse_tolerance("depth=2:8,baselines=50,ay=0.1,tx=2:3");
  EXPECT_DOUBLE_EQ(tolerance.depth.wrong, 0.08);
  EXPECT_DOUBLE_EQ(tolerance.baselines, 50.0);
  EXPECT_NEAR(tolerance.axes[1]->wrong, 0.2 * std::numbers::pi / 180.0, 1e-15);
  EXPECT_DOUBLE_EQ(tolerance.axes[3]->ok, 0.002);
}

TEST(ParseTolerance, RefusesAnythingElse) {
  for (const char* bad :
       {"", "px", "px=", "px=0", "px=-1", "px=1:0.5", "nod=1", "px=1,", "px=nan", "px=1:2:3", "depth=5%"}) {
    EXPECT_THROW((void)parse_tolerance(bad), std::invalid_argument) << bad;
  }
}

}  // namespace
}  // namespace limber
