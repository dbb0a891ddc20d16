// SPDX-License-Identifier: MIT
// Ctrl-C in health, its fleet, smooth and recalibrate: what is kept, what is said, how it ends.
#include <nlohmann/json.hpp>

#include "cli/child_process.hpp"
#include "cli/small_log.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Json = nlohmann::json;
using testing::files_below;
using testing::read_text;

/// A minute of a drone, which no command is done with at once.
class Interrupted : public ::testing::Test {
 protected:
  Interrupted() {
    Scenario drone = testing::shipped("drone_none", 60.0);
    write_track_log(simulate(drone, 1), folder_.path() / "log");
  }
  [[nodiscard]] std::string log() const { return (folder_.path() / "log").string(); }
  [[nodiscard]] fs::path out() const { return folder_.path() / "out"; }

  /// Ctrl-C after a while, twice as late each time, until `enough` says that it came neither too early nor
  /// too late.
  /// @return what the program said at last
  template <typename Enough>
  std::string interrupt(const std::vector<std::string>& arguments, const Enough& enough) const {
    std::string err;
    for (useconds_t delay = 500'000; delay < 20'000'000; delay *= 2) {
      testing::ChildProcess program(arguments);
      usleep(delay);
      program.signal(SIGINT);
      EXPECT_EQ(program.wait(), 1);
      err = program.err();
      if (enough()) {
        break;
      }
    }
    return err;
  }

 private:
  const testing::TemporaryFolder folder_;
};

TEST_F(Interrupted, HealthKeepsTheFramesBeforeButNoStateToCompareWith) {
  const std::string err = interrupt({"health", log(), "--init", "groundtruth", "--out", out().string()},
                                    [this] { return fs::exists(out() / "summary.json"); });
  EXPECT_THAT(err, HasSubstr("these are partial results"));
  EXPECT_EQ(Json::parse(read_text(out() / "summary.json"))["complete"], false);
  EXPECT_FALSE(fs::exists(out() / "health_state.json"));
}

TEST_F(Interrupted, AFleetJudgesTheRestNoMore) {
  const std::string err =
      interrupt({"health", log(), log(), log(), "--fleet", "--init", "groundtruth", "--out", out().string()},
                [this] { return fs::exists(out() / "01-log/summary.json"); });
  EXPECT_THAT(err, HasSubstr("these are partial results"));
  EXPECT_FALSE(fs::exists(out() / "03-log"));
}

TEST_F(Interrupted, SmoothAndRecalibrateWriteNothingAndSaySo) {
  for (const char* command : {"smooth", "recalibrate"}) {
    testing::ChildProcess program({command, log(), "--init", "groundtruth", "--out", out().string()});
    usleep(1'000'000);
    program.signal(SIGINT);
    EXPECT_EQ(program.wait(), 1) << command;
    EXPECT_THAT(program.err(), HasSubstr("limber: error: stopped: nothing is written")) << command;
    EXPECT_FALSE(fs::exists(out())) << command;
  }
}

}  // namespace
}  // namespace limber
