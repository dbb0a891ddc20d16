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
  EXPECT_EQ(claims[0].claims.size(), claims[1].claims.size() + claims[2].claims.size());
  EXPECT_THAT(claims[1].claims.front().source, HasSubstr("Figure 6"));
}

TEST(PaperComments, ShowWhatTheStudyCanJudgeAndFoldTheRest) {
  const ReportDocument document = with_comments(small_study());
  for (const ReportClaims& shown : blocks<ReportClaims>(document)) {
    for (const ReportClaim& claim : shown.claims) {
      EXPECT_NE(claim.verdict, Verdict::kNotMeasured) << claim.statement;
    }
  }
  const ReportListing folded = blocks<ReportListing>(document).front();
  EXPECT_THAT(folded.title, HasSubstr("claims of the paper are about what this study does not hold"));
  EXPECT_THAT(folded.text, HasSubstr("Figure 10"));
  EXPECT_THAT(document.answer->headline, HasSubstr("claims of the paper that this study can judge agree"));
  EXPECT_THAT(document.answer->sentences,
              ::testing::ElementsAre(HasSubstr("others are about what it does not hold")));
  for (const ReportFact& fact : document.facts) {
    EXPECT_NE(fact.name, "not measured");
  }
  EXPECT_TRUE(std::holds_alternative<ReportClaims>(document.sections[0].blocks[0]));
}

TEST(PaperComments, OfAStudyThatJudgesNothingSaySo) {
  const ReportDocument document =
      with_comments(study_of({case_results(paper_scenario(kConstant), {{"mono-left"}})}));
  EXPECT_TRUE(blocks<ReportClaims>(document).empty());
  EXPECT_THAT(document.answer->headline, HasSubstr("No claim of the paper can be judged"));
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
