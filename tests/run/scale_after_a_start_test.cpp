// SPDX-License-Identifier: MIT
// What filters know of the scale long after a start that knew it to a per cent.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "limber/diagnose/run_summary.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/run/shared_starts.hpp"
#include "limber/simulate/scenario_presets.hpp"
#include "limber/simulate/simulator.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using ::testing::Each;
using ::testing::Lt;

Scenario paper_i() { return testing::shipped("paper_i", {}, PixelPreset::kRealistic); }

/// Of each method the mean over recordings of NEES of the scale, each the mean over its frames. Methods
/// share their starts, which are bit by bit their own (run_recording_test.cpp).
std::vector<double> mean_scale_nees(const std::vector<Method>& methods, const Scenario& scenario,
                                    StartMode start = StartMode::kAuto,
                                    const std::vector<std::uint64_t>& seeds = {8101, 8102, 8103}) {
  std::vector<double> out(methods.size(), 0.0);
  for (const std::uint64_t seed : seeds) {
    const Recording recording = simulate(scenario, seed);
    SharedStarts starts;
    for (std::size_t k = 0; k < methods.size(); ++k) {
      RunOptions options;
      options.method = methods[k];
      options.start = start;
      const RunRecord record = run_recording(recording, options, matched_frames(recording), {}, &starts);
      out[k] += summarize(recording, options, record).anees_scale.value() / static_cast<double>(seeds.size());
    }
  }
  return out;
}

/// Landmarks that are corrected by several per cent each tell of the scale by chance what nobody has seen.
/// Where the covariance was not carried along, lcekf and adaptive had 7.9 and 8.0 here (ekf-full 7.9,
/// mono-left 3.8), ekf 3.8 where it took lenses for exact. A mean of three runs, whose scale errors hardly
/// change within a run, is below 3.1 in 97.5 % (chi-square of 3, over 3).
TEST(FullScaleAfterAStart, IsKnownAsWellAsItIsSaidToBe) {
  EXPECT_THAT(mean_scale_nees({Method::kEkf, Method::kLcekf, Method::kAdaptive}, paper_i()), Each(Lt(3.1)));
}

/// The truth's start hands over no map, but depths are corrected all the same: 8.0 where the covariance was
/// not carried along. Recordings that state their noise keep the paper's filter.
TEST(ScaleAfterAStart, OfTheTruthIsKnownAsWellAsItIsSaidToBe) {
  EXPECT_THAT(mean_scale_nees({Method::kLcekf}, paper_i(), StartMode::kGroundTruth), Each(Lt(3.1)));
}

/// With odometry, which tells the scale all the time, but not well: 21 where the covariance was not carried
/// along, 4.5 where it is. That is more than the 3.1 of a consistent filter; the bound guards what was won.
TEST(FullScaleAfterAStart, OfOdometryIsHardlySurerThanItIsRight) {
  Scenario scenario = paper_i();
  scenario.use_imu = false;
  scenario.odometry = OdometryScenario{20.0, 0.2, 0.02};
  EXPECT_THAT(mean_scale_nees({Method::kLcekf}, scenario), Each(Lt(7.0)));
}

/// Where nothing but the baseline tells a metre, and lenses err: 11 of sigmas that took them for exact.
TEST(FullScaleAfterAStart, OfVisionAloneIsKnownAsWellAsItIsSaidToBe) {
  const Scenario scenario = testing::shipped("drone_none_vision", {}, PixelPreset::kRealistic);
  EXPECT_THAT(mean_scale_nees({Method::kLcekf}, scenario, StartMode::kAuto, {1, 2, 3, 4}), Each(Lt(2.8)));
}

TEST(ScaleAfterAStart, OfVisionAloneIsAsUnsureAsLensesMakeIt) {
  const Recording recording = testing::realistic("drone_none_vision", 6.0, 4);
  const RunRecord record = run_recording(recording, {}, matched_frames(recording));
  ASSERT_TRUE(record.pixel_noise);
  const double share = record.pixel_noise->length_sigma;
  EXPECT_GT(share, 0.005);
  EXPECT_LT(share, 0.05);
  const TrajectoryRow& last = record.trajectory.back();
  const Eigen::Vector3d way = last.T_world_body.p;
  const double variance = way.normalized().dot(last.covariance->topLeftCorner<3, 3>() * way.normalized());
  EXPECT_GT(std::sqrt(variance), share * way.norm());
  EXPECT_LT(std::sqrt(variance), 2.0 * share * way.norm());
}

}  // namespace
}  // namespace limber
