// SPDX-License-Identifier: MIT
#include "limber/view/view_board.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <thread>

#include "limber/core/errors.hpp"
#include "view/small_view.hpp"

namespace limber {
namespace {

using namespace std::chrono_literals;
using testing::data_of;
using testing::name_of_event;
using testing::small_frame;
using testing::small_run;

/// A page that was greeted.
std::uint64_t enter(ViewBoard& board, bool acknowledges = false) {
  const std::uint64_t viewer = board.enter(acknowledges);
  EXPECT_EQ(name_of_event(board.next(viewer)), "hello");
  return viewer;
}

TEST(ViewBoard, GreetsAPageWithTheRunAndThePathSoFar) {
  ViewBoard board(small_run());
  board.note(0.0, {1.0, 2.0, 3.0});
  const auto hello = data_of(board.next(board.enter(false)));
  EXPECT_EQ(hello["run"]["title"], "small");
  EXPECT_EQ(hello["run"]["axes"].size(), 6u);
  EXPECT_EQ(hello["path"], "AAAAAAAAgD8AAABAAABAQA==");  // 0, 1, 2, 3 as 32-bit floats
  EXPECT_EQ(hello["paused"], false);
}

TEST(ViewBoard, HandsOverFramesInOrderAndThenTheEnd) {
  ViewBoard board(small_run());
  const std::uint64_t viewer = enter(board);
  for (std::size_t n = 1; n <= 3; ++n) {
    board.publish(small_frame(n));
    const std::string event = board.next(viewer);
    EXPECT_EQ(name_of_event(event), "frame");
    EXPECT_EQ(data_of(event)["n"], n);
  }
  board.finish("done");
  EXPECT_FALSE(board.told_all());
  const std::string end = board.next(viewer);
  EXPECT_EQ(name_of_event(end), "end");
  EXPECT_EQ(data_of(end)["message"], "done");
  EXPECT_TRUE(board.told_all());
}

TEST(ViewBoard, SendsWhatAPageDraws) {
  ViewBoard board(small_run());
  const std::uint64_t viewer = enter(board);
  ViewFrame frame = small_frame(1);
  frame.images = [] { return ViewImages{{{1, 2, 3}, {4, 5}}}; };
  board.publish(frame);
  const auto data = data_of(board.next(viewer));
  EXPECT_EQ(data["points"]["ids"], nlohmann::json({7}));
  EXPECT_EQ(data["points"]["fates"], "r");
  EXPECT_EQ(data["points"]["uv"], "AACAPwAAAEAAAMB/AADAfw==");  // 1, 2, NaN, NaN
  EXPECT_EQ(data["map"]["p"], "AACAPwAAAEAAAEBA");
  EXPECT_EQ(data["stages"][0][0], "filter");
  EXPECT_EQ(data["images"], nlohmann::json({"AQID", "BAU="}));
  EXPECT_TRUE(data["health"].is_null());
}

TEST(ViewBoard, GoesOnWithoutImagesThatCannotBeRead) {
  ViewBoard board(small_run());
  const std::uint64_t viewer = enter(board);
  ViewFrame frame = small_frame(1);
  frame.status = "updated";
  frame.images = []() -> ViewImages { throw DataError("a.png", 0, "an image", "none"); };
  board.publish(frame);
  const nlohmann::json data = data_of(board.next(viewer));
  EXPECT_TRUE(data["images"].is_null());
  EXPECT_EQ(data["status"], "updated; no images: a.png: expected an image, found none");
}

TEST(ViewBoard, HidesNoOtherFaultOfImages) {
  ViewBoard board(small_run());
  const std::uint64_t viewer = enter(board);
  ViewFrame frame = small_frame(1);
  frame.images = []() -> ViewImages { throw std::bad_alloc(); };
  board.publish(frame);
  EXPECT_THROW((void)board.next(viewer), std::bad_alloc);
}

TEST(ViewBoard, LeavesFramesOutForABusyPage) {
  ViewBoard board(small_run());
  const std::uint64_t viewer = enter(board, true);
  for (std::size_t n = 1; n <= 2; ++n) {
    board.publish(small_frame(n));
    EXPECT_EQ(data_of(board.next(viewer))["n"], n);
  }
  for (std::size_t n = 3; n <= 9; ++n) {
    board.publish(small_frame(n));
  }
  EXPECT_EQ(name_of_event(board.next(viewer)), "");  // two are on their way: nothing but a comment
  board.acknowledge(viewer, 1);
  EXPECT_EQ(data_of(board.next(viewer))["n"], 9u);
}

TEST(ViewBoard, AnotherPageDoesNotWaitForABusyOne) {
  ViewBoard board(small_run());
  const std::uint64_t busy = enter(board, true), quick = enter(board);
  for (std::size_t n = 1; n <= 4; ++n) {
    board.publish(small_frame(n));
    EXPECT_EQ(data_of(board.next(quick))["n"], n);
    if (n <= 2) {
      EXPECT_EQ(data_of(board.next(busy))["n"], n);
    }
  }
}

TEST(ViewBoard, HoldsOneFrameAndAPathOfBoundedLengthFor20MinutesAt20Hz) {
  ViewBoard board(small_run());
  const std::uint64_t viewer = enter(board, true);
  const auto alive = std::make_shared<int>();
  long most_alive = 0;
  for (std::size_t n = 1; n <= 24'000; ++n) {
    ViewFrame frame = small_frame(n);
    frame.images = [alive] { return ViewImages{}; };
    board.note(frame.t_s, frame.T_world_body.p);
    board.publish(std::move(frame));
    most_alive = std::max(most_alive, alive.use_count() - 1);
    if (n <= 2) {
      (void)board.next(viewer);  // and never says that it has shown them
    }
  }
  EXPECT_EQ(most_alive, 1);
  const std::string hello = board.next(board.enter(false));
  const std::size_t places = data_of(hello)["path"].get<std::string>().size() * 3 / 4 / 16;
  EXPECT_GT(places, 2000u);
  EXPECT_LE(places, 4096u);
}

TEST(ViewBoard, AsksForFewFramesUnlessAPageTakesThem) {
  ViewBoard board(small_run());
  EXPECT_TRUE(board.due());
  board.publish(small_frame(1));
  EXPECT_FALSE(board.due());
  std::this_thread::sleep_for(60ms);
  EXPECT_FALSE(board.due());
  (void)enter(board);
  EXPECT_TRUE(board.due());
}

TEST(ViewBoard, HoldsThePausedRunAndLetsItGoFrameByFrame) {
  ViewBoard board(small_run(), true);
  std::atomic<int> done = 0, published = 0;
  std::thread run([&] {
    for (int n = 1; n <= 5; ++n) {
      done = n;
      board.hold(n, {}, [&] { ++published; });
    }
    done = 6;
  });
  const auto reaches = [&](int count) {
    for (int k = 0; k < 500 && done < count; ++k) std::this_thread::sleep_for(2ms);
    std::this_thread::sleep_for(20ms);  // it might go further
    return done == count;
  };
  EXPECT_TRUE(reaches(1));
  EXPECT_EQ(published, 1);  // so that the page shows where it stands
  board.command(ViewCommand::kStep);
  EXPECT_TRUE(reaches(2));
  board.command(ViewCommand::kStep);
  EXPECT_TRUE(reaches(3));
  board.command(ViewCommand::kRun);
  run.join();
  EXPECT_EQ(done, 6);
  EXPECT_GT(board.held_s(), 0.04);
}

TEST(ViewBoard, EndsAPauseWhenTheRunIsToStop) {
  ViewBoard board(small_run(), true);
  int asked = 0;
  board.hold(0.0, [&] { return ++asked == 2; }, {});
  EXPECT_EQ(asked, 2);
}

TEST(ViewBoard, KeepsTheRecordingsPaceOnlyAsLongAsSomebodyLooks) {
  ViewBoard board(small_run());
  board.command(ViewCommand::kRunInTime);
  const auto seconds = [&board](double from) {
    const double before = board.held_s();
    for (int n = 0; n <= 5; ++n) board.hold(from + 0.04 * n, {}, {});
    return board.held_s() - before;
  };
  EXPECT_EQ(seconds(0.0), 0.0);
  const std::uint64_t viewer = enter(board);
  EXPECT_GT(seconds(1.0), 0.15);  // 0.2 s of the recording
  board.leave(viewer);
  EXPECT_EQ(seconds(2.0), 0.0);
}

TEST(ViewBoard, TellsPagesWhatOthersHaveAskedFor) {
  ViewBoard board(small_run());
  const std::uint64_t viewer = enter(board);
  board.command(ViewCommand::kPause);
  const std::string event = board.next(viewer);
  EXPECT_EQ(name_of_event(event), "control");
  EXPECT_EQ(data_of(event)["paused"], true);
  EXPECT_FALSE(board.dismissed());
  board.command(ViewCommand::kDismiss);
  EXPECT_TRUE(board.dismissed());
}

TEST(ViewBoard, TurnsAwayPagesBeyondTheEighth) {
  ViewBoard board(small_run());
  for (int k = 0; k < 8; ++k) {
    EXPECT_NE(board.enter(false), 0u);
  }
  EXPECT_EQ(board.enter(false), 0u);
  board.leave(1);
  EXPECT_NE(board.enter(false), 0u);
}

}  // namespace
}  // namespace limber
