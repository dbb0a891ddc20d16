// SPDX-License-Identifier: MIT
// `limber run --view` as its users see it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <regex>

#include "cli/child_process.hpp"
#include "cli/small_log.hpp"
#include "view/http_client.hpp"
#include "view/small_view.hpp"

namespace limber {
namespace {

using namespace std::chrono_literals;
using testing::Address;
using testing::ChildProcess;
using testing::data_of;
using testing::EventStream;
using testing::expect_refused;
using ::testing::HasSubstr;
using testing::name_of_event;
using testing::post;
using testing::read_text;

class LiveRun : public testing::SmallLog {
 protected:
  [[nodiscard]] std::vector<std::string> arguments(const std::vector<std::string>& more) const {
    std::vector<std::string> out = {"run", log().string(), "--out", this->out().string(), "--view"};
    out.insert(out.end(), more.begin(), more.end());
    return out;
  }

  /// Where a run that has just begun is to be seen.
  static Address address_of(const ChildProcess& run) {
    const std::regex url("live view: (http://127.0.0.1:[0-9]+/[0-9a-f]{32}/)\n");
    for (int k = 0; k < 1000; ++k) {
      const std::string text = run.err();
      std::smatch found;
      if (std::regex_search(text, found, url)) return testing::address_of(found[1]);
      std::this_thread::sleep_for(10ms);
    }
    ADD_FAILURE() << run.err();
    return {};
  }

  /// The next event of this name.
  static std::string next(EventStream& stream, const std::string& name) {
    std::string event;
    do {
      event = stream.next();
    } while (!event.empty() && name_of_event(event) != name);
    return event;
  }
};

/// Results without what a clock says.
std::string results_in(const std::filesystem::path& folder) {
  std::string content;
  for (const char* const name : {"trajectory.csv", "landmarks.ply", "health.csv", "refusals.csv"}) {
    content += read_text(folder / name);
  }
  return content +
         std::regex_replace(read_text(folder / "frames.csv"), std::regex(",[0-9.]+,[0-9.]+\n"), "\n");
}

TEST_F(LiveRun, HasTheSameBitsWithAndWithoutAPage) {
  const auto plain = folder() / "plain";
  ASSERT_EQ(run_into(plain).exit_code, 0);
  ChildProcess run(arguments({"--view-paused"}));
  const Address at = address_of(run);
  EventStream stream(at, "events");
  EXPECT_EQ(data_of(next(stream, "frame"))["n"], 1);
  ASSERT_EQ(post(at, at.path + "control?do=run")->status, 204);
  EXPECT_THAT(data_of(next(stream, "end"))["message"].get<std::string>(), HasSubstr("Done: 41 of 41 frames"));
  ASSERT_EQ(post(at, at.path + "control?do=dismiss")->status, 204);
  EXPECT_EQ(run.wait(), 0);
  EXPECT_EQ(results_in(out()), results_in(plain));
}

TEST_F(LiveRun, StepsFrameByFrame) {
  ChildProcess run(arguments({"--view-paused", "--view-exit"}));
  const Address at = address_of(run);
  EventStream stream(at, "events");
  for (int n = 1; n <= 5; ++n) {
    const auto frame = data_of(next(stream, "frame"));
    EXPECT_EQ(frame["n"], n);
    std::this_thread::sleep_for(30ms);  // it might go further by itself
    EXPECT_EQ(stream.waiting(), 0u);
    ASSERT_EQ(post(at, at.path + "control?do=step")->status, 204);
  }
  ASSERT_EQ(post(at, at.path + "control?do=run")->status, 204);
  EXPECT_EQ(name_of_event(next(stream, "end")), "end");
  EXPECT_EQ(run.wait(), 0);
}

TEST_F(LiveRun, ShowsTheFramesThatAStartWaitsWithBeforeTheyHaveAPose) {
  ChildProcess run(arguments({"--view-paused", "--view-exit"}));
  const Address at = address_of(run);
  EventStream stream(at, "events");
  const auto first = data_of(next(stream, "frame"));
  EXPECT_EQ(first["waiting"], true);
  EXPECT_THAT(first["status"].get<std::string>(), ::testing::StartsWith("start: "));
  EXPECT_FALSE(first["points"]["fates"].get<std::string>().empty());
  int frames = 1;
  bool waiting = true;
  for (; waiting && frames < 41; ++frames) {
    ASSERT_EQ(post(at, at.path + "control?do=step")->status, 204);
    const auto frame = data_of(next(stream, "frame"));
    waiting = frame["waiting"];
    EXPECT_EQ(frame["n"], waiting ? frames + 1 : 1);
  }
  EXPECT_FALSE(waiting);
  run.signal(SIGINT);
  EXPECT_EQ(run.wait(), 1);
}

TEST_F(LiveRun, EndsByItselfWhereNobodyLooks) {
  const auto result = run({"--view"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("limber: live view: http://127.0.0.1:"));
}

TEST_F(LiveRun, IsInterruptedWhilePaused) {
  ChildProcess run(arguments({"--view-paused"}));
  EventStream stream(address_of(run), "events");
  EXPECT_EQ(data_of(next(stream, "frame"))["n"], 1);
  run.signal(SIGINT);
  EXPECT_THAT(data_of(next(stream, "end"))["message"].get<std::string>(), HasSubstr("Stopped after "));
  EXPECT_EQ(run.wait(), 1);
  EXPECT_THAT(run.err(), HasSubstr("these are partial results"));
}

TEST_F(LiveRun, WritesAPageThatNeedsNoServer) {
  const auto plain = folder() / "plain", page = folder() / "view.html";
  ASSERT_EQ(run_into(plain).exit_code, 0);
  const auto result = run({"--view-out", page.string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, ::testing::Not(HasSubstr("http://")));
  EXPECT_THAT(read_text(page), HasSubstr("\"n\":41"));
  EXPECT_EQ(results_in(out()), results_in(plain));
  expect_refused(run({"--view-out", page.string()}), 1, "--force");
  EXPECT_EQ(run({"--view-out", page.string(), "--force"}).exit_code, 0);
}

TEST_F(LiveRun, RefusesPlacesWhereThePageCannotGoBeforeItRuns) {
  testing::write_text(folder() / "notes.html", "mine");
  expect_refused(run({"--view-out", (folder() / "notes.html").string()}), 1, "notes.html");
  EXPECT_EQ(read_text(folder() / "notes.html"), "mine");
  expect_refused(run({"--view-out", (folder() / "nowhere/view.html").string()}), 1, "nowhere");
  expect_refused(run({"--view-out", (out() / "report.html").string()}), 2, "one of the run's results");
  EXPECT_FALSE(std::filesystem::exists(out()));
}

TEST_F(LiveRun, RefusesOptionsThatBelongToThePageWithoutIt) {
  for (const char* const option : {"--view-paused", "--view-exit"}) {
    expect_refused(run({option}), 2, "--view");
  }
  expect_refused(run({"--view", "--view-port", "70000"}), 2, "65535");
}

}  // namespace
}  // namespace limber
