// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/small_log.hpp"
#include "limber/report/write_report.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::read_text;
using testing::run_limber;
using testing::write_text;

class ReportCommand : public testing::SmallLog {
 protected:
  void SetUp() override {
    if (!can_write_reports()) {
      GTEST_SKIP() << why_no_reports();
    }
  }
};

TEST_F(ReportCommand, IsDoneAtTheEndOfARunAndAgainFromItsFolderAlone) {
  const auto run = run_into(out());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("written: " + (out() / "report.html").string()));
  const std::string page = read_text(out() / "report.html");
  EXPECT_THAT(page, HasSubstr("<title>lcekf on log</title>"));
  fs::remove_all(log());
  fs::remove(out() / "report.html");
  const auto again = run_limber({"report", out().string()});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(again.out, (out() / "report.html").string() + "\n");
  EXPECT_THAT(again.err, IsEmpty());
  EXPECT_EQ(read_text(out() / "report.html"), page);
}

TEST_F(ReportCommand, WritesWhereItIsTold) {
  ASSERT_EQ(run_into(out()).exit_code, 0);
  const fs::path page = folder() / "elsewhere.html";
  EXPECT_EQ(run_limber({"report", out().string(), "--out", page.string()}).exit_code, 0);
  EXPECT_EQ(read_text(page), read_text(out() / "report.html"));
  const auto nowhere = run_limber({"report", out().string(), "--out", (folder() / "no" / "a.html").string()});
  EXPECT_EQ(nowhere.exit_code, 1);
  EXPECT_THAT(nowhere.err, HasSubstr("a.html: expected a place where a file can be written"));
}

TEST_F(ReportCommand, DrawsAStudyBesideItsDatabase) {
  const fs::path scenario = write_text(folder() / "a.yaml", "duration: 1\nworld: {points: 60}\n");
  const fs::path database = folder() / "s.sqlite";
  const auto study = run_limber({"study", scenario.string(), "--runs", "1", "--out", database.string()});
  ASSERT_EQ(study.exit_code, 0) << study.err;
  const std::string page = read_text(folder() / "s.html");
  EXPECT_THAT(page, HasSubstr("<title>Monte Carlo study</title>"));
  fs::remove(folder() / "s.html");
  EXPECT_EQ(run_limber({"report", database.string()}).out, (folder() / "s.html").string() + "\n");
  EXPECT_EQ(read_text(folder() / "s.html"), page);
}

TEST_F(ReportCommand, NamesWhatIsMissingOrNoResult) {
  const auto absent = run_limber({"report", (folder() / "none").string()});
  EXPECT_EQ(absent.exit_code, 1);
  EXPECT_THAT(absent.err, HasSubstr((folder() / "none").string()));
  const auto recording = run_limber({"report", log().string()});
  EXPECT_EQ(recording.exit_code, 1);
  EXPECT_THAT(recording.err, HasSubstr("summary.json: expected a text file, found no such file"));
  EXPECT_EQ(run_limber({"report"}).exit_code, 2);
}

}  // namespace
}  // namespace limber
