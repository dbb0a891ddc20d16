// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "limber/diagnose/run_summary.hpp"
#include "limber/evaluate/consistency.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/simulate/simulator.hpp"
#include "shipped_scenario.hpp"

/// A small version of docs/evidence/results.md: runs of ten seconds of each case.
namespace limber {
namespace {

struct Outcome {
  double squared = 0.0;  ///< sum of squared RMSE [m²]
  double anees = 0.0;    ///< mean over runs
};

Outcome outcome(const std::string& name, Method method, std::uint64_t runs) {
  Scenario scenario = testing::shipped(name, 10.0);
  RunOptions options;
  options.method = method;
  options.start = StartMode::kGroundTruth;
  options.gate = false;
  Outcome out;
  for (std::uint64_t run = 0; run < runs; ++run) {
    const Recording recording = simulate(scenario, 1, run);
    options.run = run;
    const RunSummary summary =
        summarize(recording, options, run_recording(recording, options, matched_frames(recording)));
    out.squared += *summary.position_rmse_m * *summary.position_rmse_m;
    out.anees += *summary.anees / static_cast<double>(runs);
  }
  return out;
}

/// Of the mean over runs, 95 %. The frames of a run are taken to correlate fully, so that each run counts as
/// one pose of six degrees of freedom however many frames it has.
void expect_consistent(std::uint64_t runs) {
  const Interval bounds = normalized_mean_interval(6.0, runs);
  for (const std::string name :
       {"paper_i", "paper_ii", "paper_iii", "paper_iv", "paper_v", "paper_v_strong"}) {
    const Outcome lcekf = outcome(name, Method::kLcekf, runs);
    EXPECT_GT(lcekf.anees, bounds.lower) << name;
    EXPECT_LT(lcekf.anees, bounds.upper) << name;
    EXPECT_LT(lcekf.squared, static_cast<double>(runs) * 0.25 * 0.25) << name;
  }
}

void expect_trust_to_mislead(std::uint64_t runs) {
  const auto squared = [&](const std::string& name, Method method) {
    return outcome(name, method, runs).squared;
  };
  EXPECT_LT(squared("paper_i", Method::kEkf), squared("paper_i", Method::kLcekf));
  EXPECT_GT(squared("paper_ii", Method::kEkf), 9.0 * squared("paper_ii", Method::kLcekf));
}

TEST(PaperCases, TheConstrainedFilterIsConsistentInAll) { expect_consistent(3); }

TEST(PaperCases, TrustIsBestOnASoundRigAndMisleadsOnAWrongOne) { expect_trust_to_mislead(2); }

TEST(FullPaperCases, TheConstrainedFilterIsConsistentInAll) { expect_consistent(10); }

TEST(FullPaperCases, TrustIsBestOnASoundRigAndMisleadsOnAWrongOne) { expect_trust_to_mislead(10); }

}  // namespace
}  // namespace limber
