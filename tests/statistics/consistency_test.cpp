// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "limber/diagnose/run_summary.hpp"
#include "limber/evaluate/consistency.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/simulator.hpp"
#include "source_folder.hpp"

/// A small version of docs/evidence/results.md: ten runs of ten seconds of each case.
namespace limber {
namespace {

constexpr std::uint64_t kRuns = 10;

struct Outcome {
  double squared = 0.0;  ///< sum of squared RMSE [m²]
  double anees = 0.0;    ///< mean over runs
};

Outcome outcome(const std::string& name, Method method) {
  Scenario scenario = read_scenario(testing::source_folder() / "scenarios" / (name + ".yaml"));
  scenario.duration = 10.0;
  RunOptions options;
  options.method = method;
  options.start = StartMode::kGroundTruth;
  options.gate = false;
  Outcome out;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Recording recording = simulate(scenario, 1, run);
    options.run = run;
    const RunSummary summary =
        summarize(recording, options, run_recording(recording, options, matched_frames(recording)));
    out.squared += *summary.position_rmse_m * *summary.position_rmse_m;
    out.anees += *summary.anees / static_cast<double>(kRuns);
  }
  return out;
}

/// Of the mean over runs, 95 %. The frames of a run are taken to correlate fully, so that each run counts as
/// one pose of six degrees of freedom however many frames it has.
TEST(PaperCases, TheConstrainedFilterIsConsistentInAll) {
  const Interval bounds = normalized_mean_interval(6.0, kRuns);
  for (const std::string name :
       {"paper_i", "paper_ii", "paper_iii", "paper_iv", "paper_v", "paper_v_strong"}) {
    const Outcome lcekf = outcome(name, Method::kLcekf);
    EXPECT_GT(lcekf.anees, bounds.lower) << name;
    EXPECT_LT(lcekf.anees, bounds.upper) << name;
    EXPECT_LT(lcekf.squared, kRuns * 0.25 * 0.25) << name;
  }
}

TEST(PaperCases, TrustIsBestOnASoundRigAndMisleadsOnAWrongOne) {
  EXPECT_LT(outcome("paper_i", Method::kEkf).squared, outcome("paper_i", Method::kLcekf).squared);
  EXPECT_GT(outcome("paper_ii", Method::kEkf).squared, 9.0 * outcome("paper_ii", Method::kLcekf).squared);
}

}  // namespace
}  // namespace limber
