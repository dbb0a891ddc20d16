// SPDX-License-Identifier: MIT
#include "reproduce/paper_comments.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/small_study.hpp"
#include "reproduce/paper_scenario.hpp"

namespace limber {
namespace {

using testing::case_results;
using testing::Got;
using ::testing::HasSubstr;
using testing::paper_scenario;
using testing::study_of;

const PaperCase kConstant{PaperNoise::kConstant, true};

StudyResults small_study() {
  Got diverging{"ekf-full"};
  diverging.diverged = 3;
  Got best{"lcekf"};
  best.position = 0.05;
  return study_of({case_results(paper_scenario(kConstant), {{"ekf"}, diverging, best, {"mono-left"}})});
}

template <typename Block>
std::vector<Block> blocks(const ReportDocument& document) {
  std::vector<Block> out;
  for (const ReportSection& section : document.sections) {
    for (const ReportBlock& block : section.blocks) {
      if (const auto* found = std::get_if<Block>(&block)) {
        out.push_back(*found);
      }
    }
  }
  return out;
}

ReportDocument with_comments(const StudyResults& results) {
  return study_report(results, paper_comments(results));
}

TEST(PaperComments, PutClaimsWithTheirCase) {
  const ReportDocument document = with_comments(small_study());
  const auto claims = blocks<ReportClaims>(document);
  ASSERT_EQ(claims.size(), 3u);  // all in brief, those of the case, those across cases
  EXPECT_TRUE(claims[0].brief);
  EXPECT_GT(claims[0].claims.size(), claims[1].claims.size() + claims[2].claims.size());
  EXPECT_THAT(claims[1].claims.front().source, HasSubstr("Figure 6"));
}

TEST(PaperComments, LeaveThePaperOutWhereItIsNotTheSubject) {
  Scenario scenario = paper_scenario(kConstant);
  scenario.noise.pixel = 1.0;
  const ReportDocument document = with_comments(study_of({case_results(scenario, {{"ekf"}, {"lcekf"}})}));
  EXPECT_TRUE(blocks<ReportClaims>(document).empty());
  EXPECT_EQ(document.title, "Monte Carlo study");
}

}  // namespace
}  // namespace limber
