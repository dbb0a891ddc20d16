// SPDX-License-Identifier: MIT
// Files that mean harm, or were cut: a message that names the file, and soon.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/child_process.hpp"
#include "cli/small_log.hpp"
#include "study/tiny_study.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using testing::expect_refused;
using ::testing::HasSubstr;
using testing::read_text;
using testing::rows_of;
using testing::run_limber;
using testing::TemporaryFolder;
using testing::write_text;

TEST(HostileYaml, EndsWithAMessage) {
  const TemporaryFolder folder;
  for (const std::string& text :
       {std::string(",\n"), std::string("a: 1\n---\nb: 2\n"), std::string(20'000, '['), std::string("")}) {
    const fs::path file = write_text(folder.path() / "h.yaml", text);
    testing::ChildProcess limber({"simulate", file.string(), "--print"});
    EXPECT_EQ(limber.wait(), 1) << text.substr(0, 20);
    EXPECT_THAT(limber.err(), HasSubstr(file.string()));
    EXPECT_LT(limber.peak_rss_mb(), 500.0);
  }
}

/// A study on disk, to be tampered with.
class HostileStudy : public ::testing::Test {
 protected:
  HostileStudy() {
    const fs::path scenario = write_text(folder_.path() / "s.yaml", "duration: 0.5\nworld: {points: 60}\n");
    arguments_ = {"study", scenario.string(), "--methods",        "ekf", "--runs",
                  "2",     "--out",           database().string()};
    EXPECT_EQ(run_limber(arguments_).exit_code, 0);
  }
  [[nodiscard]] fs::path database() const { return folder_.path() / "s.sqlite"; }

  /// Nothing that reads the study takes it: one line, which names the file.
  void expect_refused_after(const std::string& sql, const std::string& words, bool by_study = false) const {
    const std::string before = read_text(database());
    rows_of(database(), sql);
    ASSERT_NE(read_text(database()), before) << sql;
    std::vector<std::vector<std::string>> commands = {
        {"study", "show", database().string(), "--export", "csv"}, {"report", database().string()}};
    if (by_study) {
      commands = {arguments_};
    }
    for (const auto& command : commands) {
      const auto result = run_limber(command);
      EXPECT_EQ(result.exit_code, 1) << sql << "\n" << result.err;
      EXPECT_THAT(result.err, HasSubstr("limber: error: " + database().string() + ": expected ")) << sql;
      EXPECT_THAT(result.err, HasSubstr(words)) << sql;
    }
    write_text(database(), before);
  }

  std::vector<std::string> arguments_;

 private:
  const TemporaryFolder folder_;
};

TEST_F(HostileStudy, IsRefusedWhereBytesAreMissing) {
  expect_refused_after("UPDATE curves SET sums = x''", "0 bytes instead of");
  expect_refused_after("UPDATE curves SET sums = substr(sums, 1, 24 * 5)", "120 bytes instead of");
  expect_refused_after("UPDATE curves SET sums = CAST(sums || zeroblob(24) AS BLOB)", "bytes instead of");
  expect_refused_after("UPDATE curves SET sums = 'text'", "the table curves with bytes, found sums 'text'");
  expect_refused_after("UPDATE cases SET runs = 4000000000000", "found runs 4000000000000");
  expect_refused_after("UPDATE cases SET runs = 1", "no more finished than planned");
  expect_refused_after("UPDATE methods SET label = 'magic'", "methods of");
  expect_refused_after("DELETE FROM methods", "at least one method");
}

TEST_F(HostileStudy, IsRefusedWhereRowsDoNotFitTogether) {
  const std::string path =
      "the table runs with a path of run 0 in the table examples, found run 0 (case 1, method 0, run 0)";
  for (const auto& [sql, words] : std::vector<std::pair<std::string, std::string>>{
           {"UPDATE runs SET position_rmse_m = 'abc' WHERE run = 1",
            "the table runs with a number or nothing, found position_rmse_m 'abc' (case 1, method 0, run 1)"},
           {"UPDATE runs SET frames = -5", "found frames -5 (case 1, method 0, run 0)"},
           {"UPDATE runs SET share_within_95 = 2", "a share, at most 1"},
           {"UPDATE runs SET diverged_s = 0.1", "frame, time and reason of a divergence"},
           {"UPDATE runs SET method = 9",
            "the table runs with a case and a method of the table methods, found method 9"},
           {"UPDATE runs SET case_id = 7", "found method 0 (case 7, method 0, run 0)"},
           {"UPDATE methods SET method = 1", "methods numbered from 0"},
           {"DELETE FROM examples", path},
           {"UPDATE examples SET positions = x''",
            "the table examples with 24 bytes for each frame of run 0"},
           {"DELETE FROM curves", "the table methods with curves of pose errors"},
           {"UPDATE curves SET quantity = 'luck' WHERE quantity = 'landmarks'", "found quantity 'luck'"},
           {"DELETE FROM study", "one row in the table study, found 0 rows"},
           {"UPDATE starts SET threads = 'many'",
            "the table starts with an integer, found threads 'many'"}}) {
    expect_refused_after(sql, words);
    expect_refused_after(sql, words, true);
  }
}

TEST_F(HostileStudy, IsRefusedWithTheDefinitionOfAnother) {
  expect_refused_after("UPDATE cases SET definition = replace(definition, '60', '61')", "the hash");
  expect_refused_after("UPDATE cases SET scenario = replace(scenario, '60', '61')",
                       "as its definition in the table cases");
  expect_refused_after("UPDATE methods SET label = 'ekf-full'", "as its definition in the table cases");
}

TEST_F(HostileStudy, IsNotGoneOnWith) {
  arguments_[5] = "3";
  expect_refused_after("UPDATE curves SET sums = zeroblob(24 * 12)", "sums of every frame", true);
  expect_refused_after("UPDATE cases SET runs = 4000000000000", "at most", true);
  expect_refused_after("UPDATE runs SET run = 77 WHERE run = 1", "found run 77", true);
}

TEST_F(HostileStudy, IsRefusedWithViewsOrTriggers) {
  for (const bool by_study : {false, true}) {
    expect_refused_after("CREATE TRIGGER t AFTER INSERT ON runs BEGIN DELETE FROM runs; END",
                         "found the trigger t", by_study);
    expect_refused_after(
        "CREATE VIEW v AS WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x FROM c) SELECT x FROM c",
        "found the view v", by_study);
    expect_refused_after("CREATE TABLE more(x)", "found the table more", by_study);
    expect_refused_after("ALTER TABLE curves ADD COLUMN more", "of another form", by_study);
  }
}

class HostileLog : public testing::SmallLog {};

TEST_F(HostileLog, OfDeeplyNestedJsonIsNoRun) {
  ASSERT_EQ(run().exit_code, 0);
  for (const std::string& text : {std::string(20'000, '['), std::string(2'000'000, '['),
                                  std::string(20'000, '[') + std::string(20'000, ']')}) {
    write_text(out() / "summary.json", text);
    expect_refused(run_limber({"report", out().string()}), 1, "summary.json: expected JSON");
  }
}

TEST_F(HostileLog, MayNotNameImagesOutsideIt) {
  fs::remove_all(mav0() / "tracks0");
  for (const std::string& name : {std::string("../../../secret.png"), (folder() / "secret.png").string()}) {
    write_text(folder() / "secret.png", testing::png_header(512, 512));
    for (const char* const camera : {"cam0", "cam1"}) {
      write_text(mav0() / camera / "data.csv", "#timestamp [ns],filename\n0," + name + "\n");
    }
    expect_refused(run(), 1, "cam0/data.csv:2: expected the name of an image within");
  }
}

TEST_F(HostileLog, MayHaveANameThatIsNoUtf8) {
  const fs::path odd = folder() / "l\xff g";
  fs::rename(log(), odd);
  const fs::path results = folder() / "o\xfe t";
  const auto ran = run_limber({"run", odd.string(), "--out", results.string()});
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_THAT(read_text(results / "summary.json"), HasSubstr("l\xef\xbf\xbd g"));
  for (const std::vector<std::string>& command : {std::vector<std::string>{"health", odd.string(), "--json"},
                                                  {"evaluate", results.string(), odd.string(), "--json"}}) {
    EXPECT_THAT(run_limber(command).err, ::testing::Not(HasSubstr("error"))) << command.front();
  }
}

TEST_F(HostileLog, WithFiveThousandPointsAFrameIsThinnedAndSaysSo) {
  std::string text = "#timestamp [ns],track_id,u0 [px],v0 [px],u1 [px],v1 [px]\n";
  for (int frame = 0; frame < 3; ++frame) {
    for (int id = 0; id < 5000; ++id) {
      text += std::to_string(frame * 50'000'000) + "," + std::to_string(id) + "," +
              std::to_string(5 + id % 100 * 5) + "," + std::to_string(5 + id / 100 * 10) + "," +
              std::to_string(id % 100 * 5) + "," + std::to_string(5 + id / 100 * 10) + "\n";
    }
  }
  write_text(mav0() / "tracks0/data.csv", text);
  const auto result = run({"--max-points", "200"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("3 of 3 frames hold more points than --max-points"));
  EXPECT_THAT(read_text(out() / "summary.json"), HasSubstr("\"thinned_points\": 14400"));
}

}  // namespace
}  // namespace limber
