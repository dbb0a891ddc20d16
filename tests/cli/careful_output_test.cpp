// SPDX-License-Identifier: MIT
// What is there stays there: results, too, are replaced only with --force.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/child_process.hpp"
#include "cli/small_log.hpp"
#include "limber/report/write_report.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using testing::expect_refused;
using ::testing::HasSubstr;
using ::testing::Not;
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

TEST_F(CarefulOutput, KeepsAnEarlierRunUnlessForced) {
  ASSERT_EQ(run().exit_code, 0);
  const std::string before = read_text(out() / "summary.json");
  for (const char* const command : {"run", "smooth", "health"}) {
    const auto again = run_limber({command, log().string(), "--out", out().string()});
    expect_refused(
        again, 1,
        out().string() +
            ": expected a folder without results, found those of an earlier run; --force replaces");
    EXPECT_THAT(again.err, Not(HasSubstr("note"))) << "refused before the recording is read";
  }
  EXPECT_EQ(read_text(out() / "summary.json"), before);
  ASSERT_EQ(run({"--method", "ekf", "--force"}).exit_code, 0);
  EXPECT_NE(read_text(out() / "summary.json"), before);
}

TEST_F(CarefulOutput, RefusesBeforeTheInputIsRead) {
  ASSERT_EQ(run().exit_code, 0);
  const std::string nowhere = (folder() / "nowhere").string();
  for (const char* const command : {"run", "smooth", "health"}) {
    expect_refused(run_limber({command, nowhere, "--out", out().string()}), 1, "--force replaces them");
  }
  write_text(folder() / "mended/recalibration.json", "{\"recalibration\": 1}");
  expect_refused(run_limber({"recalibrate", nowhere, "--out", (folder() / "mended").string()}), 1,
                 "recalibration.json: expected no file of this name, found an earlier result; --force");
  expect_refused(run_limber({"convert", nowhere, "--out", log().string()}), 1,
                 "found a recording that limber wrote; --force replaces it");
  expect_refused(run_limber({"decalibrate", nowhere, "--as", "ay=1", "--out", log().string()}), 1,
                 "found a recording that limber wrote; --force replaces it");
}

TEST_F(CarefulOutput, KeepsEveryRunOfAFleetAndOfSeveralMethods) {
  write_text(out() / "02-log/summary.json", "mine");
  write_text(out() / "ekf/report.html", "mine");
  expect_refused(run_limber({"health", log().string(), log().string(), "--fleet", "--out", out().string()}),
                 1, "02-log/summary.json: expected no file of this name");
  expect_refused(run({"--methods", "lcekf,ekf"}), 1, "ekf/report.html: expected no file of this name");
  EXPECT_FALSE(fs::exists(out() / "01-log"));
  EXPECT_FALSE(fs::exists(out() / "lcekf"));
}

TEST_F(CarefulOutput, KeepsOtherPeoplesFilesUnlessForced) {
  const fs::path other = folder() / "other";
  write_text(other / "frames.csv", "mine");
  expect_refused(run_into(other), 1,
                 "frames.csv: expected no file of this name, found one that limber did not write; --force");
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
  expect_refused(run_limber({"evaluate", t, t, "--out", json.string()}), 1,
                 "found an earlier result; --force replaces it");
  EXPECT_EQ(run_limber({"evaluate", t, t, "--out", json.string(), "--force"}).exit_code, 0);
  write_text(json, "{\"mine\": 1}");
  expect_refused(run_limber({"evaluate", t, t, "--out", json.string()}), 1,
                 "found one that limber did not write; --force replaces it, too");
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
  ASSERT_EQ(run_limber(study("s.sqlite")).exit_code, 0) << "goes on, and draws its page anew";
  const std::string database = (folder() / "s.sqlite").string(), before = read_text(database);
  for (const char* const force : {"", "--force"}) {
    std::vector<std::string> arguments = {"report", database, "--out", database};
    if (*force != '\0') {
      arguments.emplace_back(force);
    }
    expect_refused(run_limber(arguments), 1, "found what this command reads");
  }
  EXPECT_EQ(read_text(database), before);
  const std::vector<std::string> to_csv = {"study", "show", database, "--export", "csv"};
  EXPECT_EQ(run_limber(to_csv).exit_code, 0);
  EXPECT_EQ(run_limber(to_csv).exit_code, 0) << "made anew of the same database";
  write_text(folder() / "s_runs.csv", "mine");
  EXPECT_EQ(run_limber({"study", "show", database, "--export", "csv"}).exit_code, 1);
  EXPECT_EQ(read_text(folder() / "s_runs.csv"), "mine");
}

TEST_F(CarefulOutput, APageThatOutlivedItsStudyIsKept) {
  if (!can_write_reports()) {
    GTEST_SKIP() << why_no_reports();
  }
  ASSERT_EQ(run_limber(study("s.sqlite")).exit_code, 0);
  const fs::path page = folder() / "s.html";
  const std::string before = read_text(page);
  fs::remove(folder() / "s.sqlite");
  expect_refused(run_limber(study("s.sqlite")), 1, "s.html: expected no file of this name");
  EXPECT_EQ(read_text(page), before);
  std::vector<std::string> forced = study("s.sqlite");
  forced.emplace_back("--force");
  EXPECT_EQ(run_limber(forced).exit_code, 0);
}

TEST_F(CarefulOutput, AReportIsDrawnAnewInItsPlaceButNotElsewhere) {
  if (!can_write_reports()) {
    GTEST_SKIP() << why_no_reports();
  }
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_EQ(run_limber({"report", out().string()}).exit_code, 0) << "of the results beside it";
  const std::string elsewhere = (folder() / "a.html").string();
  ASSERT_EQ(run_limber({"report", out().string(), "--out", elsewhere}).exit_code, 0);
  expect_refused(run_limber({"report", out().string(), "--out", elsewhere}), 1, "--force replaces it");
  EXPECT_EQ(run_limber({"report", out().string(), "--out", elsewhere, "--force"}).exit_code, 0);
}

TEST_F(CarefulOutput, KeepsWhatAnotherProgramWroteDuringTheRun) {
  testing::ChildProcess limber({"run", log().string(), "--methods", "lcekf,ekf", "--out", out().string()});
  for (int k = 0; k < 30'000 && !fs::exists(out() / "lcekf/summary.json"); ++k) {
    usleep(1000);
  }
  const fs::path other = write_text(out() / "ekf/trajectory.csv", "mine");
  EXPECT_EQ(limber.wait(), 1);
  EXPECT_THAT(limber.err(), HasSubstr("ekf/trajectory.csv: expected no file of this name"));
  EXPECT_EQ(read_text(other), "mine");
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
  // Others write what the numbers are, too: a log with that comment was deleted.
  write_text(yaml, testing::replaced(read_text(yaml), "; written by limber", ""));
  const auto before = read_text(mav0() / "tracks0/data.csv");
  const fs::path other = folder() / "other";
  ASSERT_EQ(run_limber({"simulate", scenario().string(), "--out", other.string()}).exit_code, 0);
  for (const auto& result :
       {run_limber({"simulate", scenario().string(), "--out", log().string(), "--force"}),
        run_limber({"convert", other.string(), "--out", log().string(), "--force"})}) {
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.err, HasSubstr("found something that limber did not write"));
    EXPECT_EQ(read_text(mav0() / "tracks0/data.csv"), before);
  }
}

TEST_F(CarefulOutput, ReplacesNothingOfOthersInARecordingOfItsOwn) {
  const fs::path other = folder() / "other";
  ASSERT_EQ(run_limber({"simulate", scenario().string(), "--out", other.string()}).exit_code, 0);
  for (const char* name : {"mav0/notes.txt", "mav0/cam0/data/mine.txt", "mav0/cam2/data.csv"}) {
    const fs::path mine = log() / name;
    fs::create_directories(mine.parent_path());
    write_text(mine, "mine");
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"simulate", scenario().string()}, {"convert", other.string()}}) {
      std::vector<std::string> words = command;
      words.insert(words.end(), {"--out", log().string(), "--force"});
      EXPECT_EQ(run_limber(words).exit_code, 1) << name;
      EXPECT_EQ(read_text(mine), "mine") << name;
    }
    fs::remove(mine);
    fs::remove(log() / "mav0/cam2");
    fs::remove(log() / "mav0/cam0/data");
  }
}

/// A program that is killed while it asks whether results could be written had left an empty folder.
TEST_F(CarefulOutput, AsksWhetherAPlaceCanBeWrittenWithoutMakingIt) {
  const int nameless = open(folder().c_str(), O_TMPFILE | O_WRONLY, 0600);
  if (nameless < 0) {
    GTEST_SKIP() << "this file system has no files without names";
  }
  close(nameless);
  const auto before = fs::last_write_time(folder());
  EXPECT_THAT(run_limber({"run", "no-recording", "--out", (folder() / "new" / "results").string()}).err,
              HasSubstr("expected the folder of a recording"));
  EXPECT_EQ(fs::last_write_time(folder()), before);
}

TEST_F(CarefulOutput, PutsNoResultsBesideARecording) {
  const auto before = testing::files_below(log());
  for (const fs::path& place : {log(), mav0(), mav0() / "tracks0", mav0() / "run", log() / "../log"}) {
    for (const char* const command : {"run", "smooth", "health", "recalibrate"}) {
      expect_refused(run_limber({command, (folder() / "other").string(), "--out", place.string(), "--force"}),
                     1,
                     place.string() + ": expected a folder for the results alone, such as " +
                         fs::canonical(log()).string() + "-results, found ");
    }
    expect_refused(run_into(place, {"--methods", "ekf,lcekf"}), 1, "a folder for the results alone");
  }
  for (const char* const file : {"kitti/image_0/000000.png", "day/drive/image_00/timestamps.txt",
                                 "bag/metadata.yaml", "flat/tracks0/data.csv"}) {
    write_text(folder() / file, "x");
    const fs::path place = folder() / *fs::path(file).begin();
    expect_refused(run_into(place), 1, "found that of a recording");
  }
  EXPECT_EQ(testing::files_below(log()), before);
  EXPECT_EQ(run_into(log() / "run").exit_code, 0) << "a folder of its own within may be";
  EXPECT_EQ(run_into(out()).exit_code, 0) << "and the recording is read as before";
}

TEST_F(CarefulOutput, PutsNoRecordingIntoARecording) {
  const auto before = testing::files_below(log());
  for (const fs::path& place : {mav0(), mav0() / "copy"}) {
    for (const auto& result :
         {run_limber({"simulate", scenario().string(), "--out", place.string(), "--force"}),
          run_limber({"convert", log().string(), "--out", place.string(), "--force"})}) {
      expect_refused(result, 1, place.string() + ": expected a ");
    }
  }
  EXPECT_EQ(testing::files_below(log()), before);
}

TEST_F(CarefulOutput, PutsNoPageInPlaceOfResults) {
  for (const char* const name : {"summary.json", "trajectory.csv", "report.html"}) {
    const auto result = run({"--view-out", (out() / name).string(), "--force"});
    expect_refused(result, 2, "is the name of one of the run's results");
  }
}

TEST_F(CarefulOutput, LeavesNothingWhereFilesMayNotGrow) {
  const std::string limber = testing::limber_command({"run", log().string(), "--out", out().string()});
  const auto result = run_command("(ulimit -f 4; " + limber + ")");
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(CarefulOutput, PutsNoRecordingBesideResults) {
  ASSERT_EQ(run().exit_code, 0);
  for (const auto& result :
       {run_limber({"simulate", scenario().string(), "--out", out().string(), "--force"}),
        run_limber({"convert", log().string(), "--out", out().string(), "--force"})}) {
    expect_refused(result, 1, out().string() + ": expected a folder for the recording alone");
  }
  EXPECT_FALSE(fs::exists(out() / "mav0"));
}

/// Programs before this one wrote a run into the folder of its recording.
TEST_F(CarefulOutput, TakesNoResultsForTheRecordingThatTheyLieBeside) {
  ASSERT_EQ(run().exit_code, 0);
  for (const char* const name : {"summary.json", "trajectory.csv", "truth.csv"}) {
    fs::copy_file(out() / name, log() / name);
  }
  const std::string estimate = (out() / "trajectory.csv").string();
  const auto evaluated = run_limber({"evaluate", estimate, log().string()});
  EXPECT_EQ(evaluated.exit_code, 0) << evaluated.err;
  EXPECT_THAT(evaluated.out, HasSubstr((mav0() / "state_groundtruth_estimate0/data.csv").string()));
  const fs::path copy = folder() / "copy";
  EXPECT_EQ(run_limber({"convert", log().string(), "--out", copy.string()}).exit_code, 0);
  EXPECT_EQ(read_text(copy / "mav0/tracks0/data.csv"), read_text(mav0() / "tracks0/data.csv"));
  EXPECT_THAT(run_limber({"info", log().string()}).out, HasSubstr("log: track log"));
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
