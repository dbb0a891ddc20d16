// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cli/small_log.hpp"
#include "compare/run_files_of.hpp"
#include "limber/report/write_report.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using testing::expect_refused;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using testing::read_text;
using testing::run_limber;
using testing::RunFilesOf;
using ::testing::StartsWith;
using testing::write_text;
using Json = nlohmann::json;

/// Folders of runs with made-up errors.
class CompareCommand : public ::testing::Test {
 protected:
  CompareCommand() {
    RunFilesOf good("ekf"), bad("lcekf");
    good.scale = 1.01;
    bad.scale = 1.04;
    good.write(folder() / "runs/a");
    bad.write(folder() / "runs/b");
  }
  [[nodiscard]] fs::path folder() const { return folder_.path(); }
  [[nodiscard]] std::string a() const { return (folder() / "runs/a").string(); }
  [[nodiscard]] std::string b() const { return (folder() / "runs/b").string(); }

 private:
  testing::TemporaryFolder folder_;
};

TEST_F(CompareCommand, PrintsTablesToStdoutAlone) {
  const auto result = run_limber({"compare", a(), b()});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, IsEmpty());
  EXPECT_THAT(result.out, StartsWith("2 runs on walk (60.0 s, 1"));
  EXPECT_THAT(result.out, AllOf(HasSubstr("ATE [m]"), HasSubstr("+4.00"), HasSubstr("degraded"),
                                HasSubstr("2.00 (3.00)"), HasSubstr("done")));
  EXPECT_THAT(result.out, AllOf(HasSubstr("\nlcekf  ekf    12      +"), HasSubstr("): worse")));
  EXPECT_EQ(run_limber({"compare", (folder() / "runs").string()}).out, result.out);
}

TEST_F(CompareCommand, PrintsJson) {
  const auto result = run_limber({"compare", a(), b(), "--json", "--piece", "20"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["runs"][0]["folder"], a());
  EXPECT_EQ(json["runs"][1]["method"], "lcekf");
  EXPECT_EQ(json["runs"][1]["piece_m"], 20.0);
  const Json difference = json["differences"][0];
  EXPECT_EQ(difference["run"], "lcekf");
  EXPECT_EQ(difference["against"], "ekf");
  EXPECT_EQ(difference["rpe_percent"]["judgement"], "worse");
  EXPECT_EQ(difference["rpe_percent"]["pieces"], 6);
  EXPECT_LT(difference["rpe_percent"]["low"], difference["rpe_percent"]["mean"]);
  EXPECT_THAT(json["notes"], IsEmpty());
}

TEST_F(CompareCommand, DrawsAPageThatReplacesNobodysFile) {
  if (!can_write_reports()) {
    GTEST_SKIP() << why_no_reports();
  }
  const fs::path page = folder() / "page.html";
  const auto drawn = run_limber({"compare", a(), b(), "--out", page.string()});
  EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
  EXPECT_THAT(drawn.err, HasSubstr("written: " + page.string()));
  EXPECT_THAT(read_text(page), HasSubstr("<title>2 runs on walk</title>"));
  expect_refused(run_limber({"compare", b(), a(), "--out", page.string()}), 1, "--force replaces it");
  EXPECT_EQ(run_limber({"compare", b(), a(), "--out", page.string(), "--force"}).exit_code, 0);
  write_text(page, "mine");
  expect_refused(run_limber({"compare", a(), b(), "--out", page.string()}), 1, "page.html: expected no file");
  EXPECT_EQ(read_text(page), "mine");
  const std::string summary = a() + "/summary.json";
  expect_refused(run_limber({"compare", a(), b(), "--out", summary, "--force"}), 1,
                 "what this command reads");
}

TEST_F(CompareCommand, RefusesWhatIsNoRun) {
  expect_refused(run_limber({"compare", a(), (folder() / "none").string()}), 1,
                 "none: expected the folder of a run (summary.json, as limber run --out writes)");
  expect_refused(run_limber({"compare", a(), a()}), 1, "is given twice");
  expect_refused(run_limber({"compare", a()}), 2, "expected two runs at least");
  expect_refused(run_limber({"compare", a(), b(), "--piece", "0"}), 2, "--piece: expected a positive number");
  expect_refused(run_limber({"compare"}), 2, "RUN is required");
  write_text(fs::path(b()) / "frames.csv", "nonsense");
  expect_refused(run_limber({"compare", a(), b()}), 1, b() + "/frames.csv");
}

}  // namespace
}  // namespace limber
