// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "limber/run/smooth_recording.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

/// What a lens leaves is the same in all frames, and each axis was off by two to three of its sigmas.
TEST(SmoothedRig, IsAsSureAsItsErrorsOnRealisticPixels) {
  double squares = 0.0;
  constexpr int kRuns = 2;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const Recording recording = testing::realistic("drone_none", 8.0, seed);
    SmoothOptions options;
    options.rig = RigModel::kConstant;
    options.guess = Method::kLcekf;
    options.run.cleaning.max_points = 60;
    const RunRecord record = smooth_recording(recording, options, matched_frames(recording));
    const auto& rig = record.calibration.back().estimate;
    squares += (rig.error.head<6>().array() / rig.sigma.head<6>().array()).square().sum() / (6.0 * kRuns);
  }
  EXPECT_LT(squares, 2.0);
}

}  // namespace
}  // namespace limber
