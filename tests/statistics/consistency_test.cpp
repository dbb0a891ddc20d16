// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "limber/diagnose/run_summary.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/simulator.hpp"
#include "source_folder.hpp"

/// A small version of docs/evidence/results.md: three runs of ten seconds of each case.
namespace limber {
namespace {

constexpr std::uint64_t kRuns = 3;

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

TEST(PaperCases, TheConstrainedFilterIsConsistentInAll) {
  for (const std::string name :
       {"paper_i", "paper_ii", "paper_iii", "paper_iv", "paper_v", "paper_v_strong"}) {
    const Outcome lcekf = outcome(name, Method::kLcekf);
    EXPECT_GT(lcekf.anees, 0.3) << name;
    EXPECT_LT(lcekf.anees, 3.0) << name;
    EXPECT_LT(lcekf.squared, kRuns * 0.25 * 0.25) << name;
  }
}

TEST(PaperCases, TrustIsBestOnASoundRigAndMisleadsOnAWrongOne) {
  EXPECT_LT(outcome("paper_i", Method::kEkf).squared, outcome("paper_i", Method::kLcekf).squared);
  EXPECT_GT(outcome("paper_ii", Method::kEkf).squared, 9.0 * outcome("paper_ii", Method::kLcekf).squared);
}

}  // namespace
}  // namespace limber
