// SPDX-License-Identifier: MIT
#include "reproduce/paper_claims.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/small_study.hpp"
#include "reproduce/paper_scenario.hpp"
#include "source_folder.hpp"

namespace limber {
namespace {

using testing::case_results;
using testing::Got;
using ::testing::HasSubstr;
using testing::paper_scenario;
using testing::study_of;

constexpr Verdict kYes = Verdict::kAgrees, kNo = Verdict::kDisagrees, kOpen = Verdict::kNotMeasured;

/// The claim whose statement and source hold these words.
ReportClaim claim(const StudyResults& results, const std::string& words, const std::string& source = "") {
  std::vector<ReportClaim> found;
  for (const PaperClaim& c : paper_claims(results)) {
    if (c.claim.statement.find(words) != std::string::npos &&
        c.claim.source.find(source) != std::string::npos) {
      found.push_back(c.claim);
    }
  }
  if (found.size() != 1) {
    ADD_FAILURE() << found.size() << " claims say '" << words << "' in '" << source << "'";
    return {};
  }
  return found.front();
}

/// One case with the paper's three methods.
StudyResults one_case(const PaperCase& paper_case, const Got& ekf, const Got& ekf_full, const Got& lcekf) {
  return study_of({case_results(paper_scenario(paper_case), {ekf, ekf_full, lcekf})});
}

const std::string kLcekf = "lcekf:full";  // what it is without an IMU

Got got(const std::string& label, double position, double attitude = 0.1) {
  Got out{label};
  out.position = position;
  out.attitude = attitude;
  return out;
}

TEST(PaperCase, RecognisesTheShippedScenarios) {
  const std::string folder = (testing::source_folder() / "scenarios/").string();
  const std::vector<std::pair<std::string, PaperNoise>> files = {
      {"paper_i", PaperNoise::kNone},    {"paper_ii", PaperNoise::kConstant},
      {"paper_iii", PaperNoise::kSinus}, {"paper_iv", PaperNoise::kSteps},
      {"paper_v", PaperNoise::kSquare},  {"paper_v_strong", PaperNoise::kSquareStrong}};
  for (const auto& [name, noise] : files) {
    Scenario scenario = read_scenario(folder + name + ".yaml");
    EXPECT_EQ(paper_case_of(scenario), (PaperCase{noise, true})) << name;
    scenario.use_imu = false;
    EXPECT_EQ(paper_case_of(scenario), (PaperCase{noise, false})) << name;
  }
  EXPECT_FALSE(paper_case_of(read_scenario(folder + "drone_none.yaml")));
}

TEST(PaperCase, IsNoneWithAnotherParameter) {
  Scenario scenario;
  EXPECT_TRUE(paper_case_of(scenario));
  scenario.noise.pixel = 0.6;
  EXPECT_FALSE(paper_case_of(scenario));
  scenario = Scenario{};
  scenario.decalibration = {{paper_decalibration(), RampShape{0.0, 1.0}}};
  EXPECT_FALSE(paper_case_of(scenario));
}

TEST(PaperClaims, SayNothingOfWhatTheStudyDoesNotHold) {
  const auto claims = paper_claims(study_of({}));
  EXPECT_GT(claims.size(), 30u);
  for (const PaperClaim& c : claims) {
    EXPECT_EQ(c.claim.verdict, kOpen) << c.claim.statement;
    EXPECT_THAT(c.claim.measured, ::testing::ContainsRegex("[Nn]ot in this study"));
    EXPECT_FALSE(c.cases.empty());
    EXPECT_FALSE(c.claim.criterion.empty());
  }
}

TEST(PaperClaims, TheReferenceCaseIsDecidedByItsNumbers) {
  const PaperCase reference{PaperNoise::kNone, true};
  Got full = got("ekf-full", 0.05, 0.04), lcekf = got("lcekf", 0.04, 0.04);
  full.landmarks_start = 0.5;
  const auto agrees = one_case(reference, got("ekf", 0.01, 0.02), full, lcekf);
  EXPECT_EQ(claim(agrees, "same localization").verdict, kYes);
  EXPECT_EQ(claim(agrees, "better initialization").verdict, kYes);
  EXPECT_EQ(claim(agrees, "same convergence").verdict, kYes);
  EXPECT_EQ(claim(agrees, "perfect knowledge").verdict, kYes);
  EXPECT_THAT(claim(agrees, "same localization").measured, HasSubstr("lcekf 0.04 m, ekf-full 0.05 m"));

  full.position = 0.051;  // above 1.25 times 0.04
  full.landmarks_start = 1.1;
  full.landmarks_end = 0.2;
  const auto disagrees = one_case(reference, got("ekf", 0.01, 0.05), full, lcekf);
  EXPECT_EQ(claim(disagrees, "same localization").verdict, kNo);
  EXPECT_EQ(claim(disagrees, "better initialization").verdict, kNo);
  EXPECT_EQ(claim(disagrees, "same convergence").verdict, kNo);
  EXPECT_EQ(claim(disagrees, "perfect knowledge").verdict, kNo);
}

TEST(PaperClaims, AFilterDivergesWhereItsErrorLeavesThreeSigma) {
  const PaperCase strong{PaperNoise::kSquareStrong, true};
  Got full = got("ekf-full", 0.31);
  full.sigma = 0.1;
  EXPECT_EQ(claim(one_case(strong, got("ekf", 0.2), full, got("lcekf", 0.1)), "very strong noise").verdict,
            kYes);
  full.position = 0.29;
  EXPECT_EQ(claim(one_case(strong, got("ekf", 0.2), full, got("lcekf", 0.1)), "very strong noise").verdict,
            kNo);
  full.diverged = 1;
  const ReportClaim broken =
      claim(one_case(strong, got("ekf", 0.2), full, got("lcekf", 0.1)), "very strong noise");
  EXPECT_EQ(broken.verdict, kYes);
  EXPECT_THAT(broken.measured, HasSubstr("diverged in 1 of 10 runs"));
}

TEST(PaperClaims, AMethodThatDivergedIsNeverTheBetterOne) {
  const PaperCase strong{PaperNoise::kSquareStrong, true};
  Got ekf = got("ekf", 0.1, 0.1);
  ekf.diverged = 2;  // whatever the other eight runs got
  const auto study = one_case(strong, ekf, got("ekf-full", 5.0, 5.0), got("lcekf", 0.04));
  const ReportClaim better = claim(study, "EKF performed better than the EKFfull");
  EXPECT_EQ(better.verdict, kNo);
  EXPECT_THAT(better.measured, HasSubstr("ekf diverged in 2 of 10 runs"));
  EXPECT_EQ(claim(study, "clearly outperformed").verdict, kYes);
}

TEST(PaperClaims, ClearlyOutperformingMeansHalfTheError) {
  const PaperCase strong{PaperNoise::kSquareStrong, true};
  const auto verdict = [&](double lcekf) {
    return claim(one_case(strong, got("ekf", 1.0), got("ekf-full", 5.0), got("lcekf", lcekf)),
                 "clearly outperformed")
        .verdict;
  };
  EXPECT_EQ(verdict(0.49), kYes);
  EXPECT_EQ(verdict(0.51), kNo);
}

TEST(PaperClaims, ANoisyCaseNeedsAnEkfThatIsBothInconsistentAndMuchWorse) {
  const PaperCase constant{PaperNoise::kConstant, true};
  Got ekf = got("ekf", 0.5);
  const auto verdict = [&] {
    return claim(one_case(constant, ekf, got("ekf-full", 0.1), got("lcekf", 0.1)),
                 "did not provide any good results", "Figure 6")
        .verdict;
  };
  EXPECT_EQ(verdict(), kYes);
  ekf.sigma = 1.0;  // as wrong, but it knows
  EXPECT_EQ(verdict(), kNo);
  ekf = got("ekf", 0.15);
  ekf.sigma = 0.01;  // too sure of itself, but not twice as bad
  EXPECT_EQ(verdict(), kNo);
}

/// All cases (i) to (v) with and without IMU; `change` may make one of them odd.
StudyResults all_cases(const std::function<void(const PaperCase&, std::vector<Got>&)>& change = {}) {
  std::vector<StudyCaseResults> cases;
  for (const bool with_imu : {true, false}) {
    for (const PaperNoise noise : {PaperNoise::kNone, PaperNoise::kConstant, PaperNoise::kSinus,
                                   PaperNoise::kSteps, PaperNoise::kSquare}) {
      const PaperCase paper_case{noise, with_imu};
      std::vector<Got> methods = {got("ekf", 0.1), got("ekf-full", 0.1), got(kLcekf, with_imu ? 0.1 : 0.11)};
      if (change) {
        change(paper_case, methods);
      }
      cases.push_back(case_results(paper_scenario(paper_case), methods));
    }
  }
  return study_of(std::move(cases));
}

TEST(PaperClaims, ClaimsAboutAllCasesFailWithOne) {
  const std::vector<std::string> claims = {"With both evolution models", "maintain the scale",
                                           "IMU was not mandatory", "IMU made the estimation",
                                           "negligible use"};
  const StudyResults good = all_cases();
  const StudyResults bad = all_cases([](const PaperCase& c, std::vector<Got>& methods) {
    if (c == PaperCase{PaperNoise::kSteps, false}) {
      methods[2].position = 1.0;
      methods[2].scale = 1.03;
    }
    if (c == PaperCase{PaperNoise::kSteps, true}) {
      methods[2].position = 2.0;
      methods[2].ms = 1.2;
    }
  });
  for (const std::string& words : claims) {
    EXPECT_EQ(claim(good, words).verdict, kYes) << words;
    EXPECT_EQ(claim(bad, words).verdict, kNo) << words;
    EXPECT_THAT(claim(bad, words).measured, HasSubstr("(iv) steps")) << words;
  }
  StudyResults partial = all_cases();
  partial.cases.pop_back();
  EXPECT_EQ(claim(partial, "maintain the scale").verdict, kOpen);
}

TEST(PaperClaims, WithoutImuThePapersLcekfHasAllSixConstrained) {
  const StudyResults default_set = all_cases([](const PaperCase&, std::vector<Got>& methods) {
    methods[2].label = "lcekf";  // without an IMU: rotation+direction
  });
  EXPECT_EQ(claim(default_set, "IMU was not mandatory").verdict, kOpen);
  EXPECT_EQ(claim(default_set, "same localization").verdict, kYes);  // with IMU it is the full set
}

TEST(PaperClaims, ErrorsThatGrowAreSeen) {
  StudyResults study = all_cases();
  EXPECT_EQ(claim(study, "increased over time", "Figure 11").verdict, kNo);
  for (StudyCaseResults& c : study.cases) {
    for (StudyMethodResults& m : c.methods) {
      auto& mean = m.curves[CurveQuantity::kPositionSquaredError].mean;
      for (std::size_t k = 0; k < mean.size(); ++k) {
        mean[k] = 0.01 * static_cast<double>(k + 1);
      }
    }
  }
  EXPECT_EQ(claim(study, "increased over time", "Figure 11").verdict, kYes);
}

TEST(PaperClaims, Table1FindsItsWalksInAnyCase) {
  Got none = got("ekf-full:walk=0/0", 2.0), under = got("ekf-full:walk=5e-07/0.1", 0.15),
      over = got("ekf-full:walk=2e-05/20", 0.11);
  none.sigma = 0.1;
  const PaperCase sinus{PaperNoise::kSinus, false};
  Scenario other = paper_scenario(sinus);
  other.name = "overestimated";
  const StudyResults study =
      study_of({case_results(paper_scenario(sinus), {got(kLcekf, 0.1), got("ekf-full", 0.11), none, under}),
                case_results(other, {got(kLcekf, 0.1), over})});
  EXPECT_EQ(claim(study, "With a good random walk").verdict, kYes);
  EXPECT_EQ(claim(study, "With no random walk").verdict, kYes);
  EXPECT_EQ(claim(study, "With an underestimated").verdict, kNo);
  EXPECT_EQ(claim(study, "With an overestimated").verdict, kNo);
  EXPECT_EQ(claim(study, "no impact on the LCEKF").verdict, kYes);
  EXPECT_EQ(claim(study, "very sensitive").verdict, kYes);
}

TEST(PaperClaims, Table1SeesAnLcekfThatChanges) {
  const PaperCase sinus{PaperNoise::kSinus, false};
  std::vector<StudyCaseResults> cases;
  double position = 0.1;
  for (const char* const full :
       {"ekf-full", "ekf-full:walk=0/0", "ekf-full:walk=5e-07/0.1", "ekf-full:walk=2e-05/20"}) {
    Scenario scenario = paper_scenario(sinus);
    scenario.name = full;
    cases.push_back(case_results(scenario, {got(kLcekf, position += 1e-6), got(full, 0.1)}));
  }
  const StudyResults study = study_of(std::move(cases));
  EXPECT_EQ(claim(study, "no impact on the LCEKF").verdict, kNo);
  EXPECT_EQ(claim(study, "very sensitive").verdict, kNo);
}

}  // namespace
}  // namespace limber
