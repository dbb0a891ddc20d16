// SPDX-License-Identifier: MIT
// What limber replaces (its own earlier results), and what it does not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "cli/small_log.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using testing::expect_refused;
using ::testing::HasSubstr;
using testing::read_text;
using testing::run_command;
using testing::run_limber;
using testing::write_text;

const char* const kOneLine = "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 1 0 0 0 0 1\n";

class CarefulOutput : public testing::SmallLog {
 protected:
  [[nodiscard]] fs::path trajectory() const { return write_text(folder() / "t.tum", kOneLine); }
  [[nodiscard]] fs::path scenario() const {
    return write_text(folder() / "s.yaml", "duration: 0.5\nworld: {points: 60}\n");
  }
  [[nodiscard]] std::vector<std::string> study(const std::string& out) const {
    return {"study", scenario().string(),      "--methods", "ekf", "--runs", "1",
            "--out", (folder() / out).string()};
  }
};

TEST_F(CarefulOutput, RepeatsARunButKeepsOtherPeoplesFilesUnlessForced) {
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_EQ(run({"--method", "ekf"}).exit_code, 0) << "into a folder that a run has written";
  const fs::path other = folder() / "other";
  write_text(other / "frames.csv", "mine");
  expect_refused(run_into(other), 1, "frames.csv: expected no file of this name, or one that limber wrote");
  EXPECT_EQ(read_text(other / "frames.csv"), "mine");
  EXPECT_EQ(run_into(other, {"--force"}).exit_code, 0);
  EXPECT_NE(read_text(other / "frames.csv"), "mine");
  const fs::path page = folder() / "page";
  write_text(page / "report.html", "mine");
  expect_refused(run_into(page), 1, "report.html");
  EXPECT_EQ(read_text(page / "report.html"), "mine");
  EXPECT_FALSE(fs::exists(page / "summary.json"));
}

TEST_F(CarefulOutput, NeverReplacesAnInputOfAnEvaluation) {
  const std::string t = trajectory().string();
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--force"}}) {
    std::vector<std::string> arguments = {"evaluate", t, t, "--out", t};
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_refused(run_limber(arguments), 1, "found what this command reads");
    EXPECT_EQ(read_text(t), kOneLine);
  }
  const fs::path json = folder() / "e.json";
  EXPECT_EQ(run_limber({"evaluate", t, t, "--out", json.string()}).exit_code, 0);
  EXPECT_EQ(run_limber({"evaluate", t, t, "--out", json.string()}).exit_code, 0) << "its own, again";
  write_text(json, "{\"mine\": 1}");
  expect_refused(run_limber({"evaluate", t, t, "--out", json.string()}), 1, "--force replaces it");
  EXPECT_EQ(run_limber({"evaluate", t, t, "--out", json.string(), "--force"}).exit_code, 0);
}

TEST_F(CarefulOutput, NeverPutsAPageInPlaceOfAStudyOrOfAnotherPage) {
  expect_refused(run_limber(study("x.html")), 1, "a name that does not end in .html");
  EXPECT_FALSE(fs::exists(folder() / "x.html"));
  write_text(folder() / "notes.html", "mine");
  expect_refused(run_limber(study("notes.sqlite")), 1, "notes.html");
  EXPECT_EQ(read_text(folder() / "notes.html"), "mine");
  EXPECT_FALSE(fs::exists(folder() / "notes.sqlite")) << "refused before the work";
  ASSERT_EQ(run_limber(study("s.sqlite")).exit_code, 0);
  ASSERT_EQ(run_limber(study("s.sqlite")).exit_code, 0) << "again, over its own page";
  const std::string database = (folder() / "s.sqlite").string(), before = read_text(database);
  for (const char* const force : {"", "--force"}) {
    std::vector<std::string> arguments = {"report", database, "--out", database};
    if (*force != '\0') {
      arguments.emplace_back(force);
    }
    expect_refused(run_limber(arguments), 1, "found what this command reads");
  }
  EXPECT_EQ(read_text(database), before);
  write_text(folder() / "s_runs.csv", "mine");
  EXPECT_EQ(run_limber({"study", "show", database, "--export", "csv"}).exit_code, 1);
  EXPECT_EQ(read_text(folder() / "s_runs.csv"), "mine");
}

TEST_F(CarefulOutput, LeavesDevicesAndPipesAlone) {
  const fs::path pipe = folder() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const std::string t = trajectory().string();
  for (const fs::path& place : {pipe, fs::path("/dev/null")}) {
    expect_refused(run_limber({"evaluate", t, t, "--out", place.string(), "--force"}), 1,
                   place.string() + ": expected a regular file to replace, or none");
  }
  EXPECT_TRUE(fs::is_fifo(pipe));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(CarefulOutput, ReplacesNoTrackLogOfAnotherProgram) {
  const fs::path yaml = mav0() / "cam0" / "sensor.yaml";
  write_text(yaml, testing::replaced(read_text(yaml), "  # fu, fv, cu, cv", ""));
  const auto before = read_text(mav0() / "tracks0/data.csv");
  const auto result = run_limber({"simulate", scenario().string(), "--out", log().string()});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("a log that limber did not write"));
  EXPECT_EQ(read_text(mav0() / "tracks0/data.csv"), before);
}

TEST_F(CarefulOutput, EndsInOrderWhereMessagesCannotBeWritten) {
  const std::string limber = testing::limber_command({"run", "/nowhere", "--out", out().string()});
  for (const char* const err : {"2>/dev/full", "2>&-", "1>&- 2>&-"}) {
    EXPECT_EQ(run_command("(" + limber + " " + err + ")").exit_code, 1) << err;
  }
  // Nothing that is opened later gets the number of a closed stream, and messages with it.
  const auto arguments = study("closed.sqlite");
  ASSERT_EQ(run_command("(" + testing::limber_command(arguments) + " 2>&-)").exit_code, 0);
  EXPECT_EQ(run_limber({"study", "show", (folder() / "closed.sqlite").string()}).exit_code, 0);
}

}  // namespace
}  // namespace limber
