// SPDX-License-Identifier: MIT
#include "limber/view/view_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <regex>
#include <thread>

#include "view/http_client.hpp"
#include "view/small_view.hpp"

namespace limber {
namespace {

using namespace std::chrono_literals;
using testing::Address;
using testing::address_of;
using ::testing::AllOf;
using testing::data_of;
using testing::EventStream;
using testing::get;
using ::testing::HasSubstr;
using testing::name_of_event;
using testing::post;
using testing::small_frame;
using testing::small_run;

class ServedBoard : public ::testing::Test {
 protected:
  ViewBoard board_{small_run()};
  ViewServer server_{board_, 0};
  Address at_ = address_of(server_.url());
};

TEST_F(ServedBoard, HasATokenOf128BitsThatNoOtherServerHas) {
  EXPECT_TRUE(std::regex_match(server_.url(), std::regex("http://127\\.0\\.0\\.1:[0-9]+/[0-9a-f]{32}/")));
  ViewBoard board(small_run());
  const ViewServer other(board, 0);
  EXPECT_NE(address_of(other.url()).path, at_.path);
}

TEST_F(ServedBoard, ServesAPageThatAsksNobodyElse) {
  const auto page = get(at_, at_.path);
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 200);
  EXPECT_THAT(page->body, AllOf(HasSubstr("default-src 'none'"), HasSubstr("connect-src 'self'")));
  EXPECT_EQ(page->get_header_value("Cache-Control"), "no-store");
  EXPECT_EQ(page->get_header_value("Referrer-Policy"), "no-referrer");
  EXPECT_EQ(page->get_header_value("X-Frame-Options"), "DENY");
}

TEST_F(ServedBoard, RefusesEveryRequestWithoutTheToken) {
  std::string wrong = at_.path;
  wrong[5] = wrong[5] == '0' ? '1' : '0';
  for (const std::string& path :
       {std::string("/"), std::string("/events"), wrong, wrong + "events", at_.path.substr(0, 20),
        "/" + at_.path, std::string("/../"), at_.path.substr(0, at_.path.size() - 1)}) {
    const auto got = get(at_, path);
    ASSERT_TRUE(got) << path;
    EXPECT_EQ(got->status, 403) << path;
    const auto posted = post(at_, path + "control?do=pause");
    ASSERT_TRUE(posted) << path;
    EXPECT_EQ(posted->status, 403) << path;
  }
  EXPECT_EQ(board_.viewers(), 0u);
}

TEST_F(ServedBoard, RefusesOtherNamesOfTheHostAndOtherOrigins) {
  const std::string port = std::to_string(at_.port);
  for (const auto& [header, value, status] :
       {std::tuple("Host", "evil.example:" + port, 403), std::tuple("Host", std::string("127.0.0.1"), 403),
        std::tuple("Host", "localhost:" + port, 200),
        std::tuple("Origin", std::string("http://evil.example"), 403),
        std::tuple("Origin", "http://127.0.0.1:" + port, 200),
        std::tuple("Origin", std::string("null"), 403)}) {
    const auto answer = get(at_, at_.path, {{header, value}});
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->status, status) << header << ": " << value;
  }
}

TEST_F(ServedBoard, ListensOn127001Alone) {
  for (const std::string& host : testing::other_addresses()) {
    EXPECT_FALSE(get({host, at_.port, at_.path}, at_.path)) << host;
  }
}

TEST_F(ServedBoard, SendsFramesInOrderAsServerSentEvents) {
  EventStream stream(at_, "events");
  ASSERT_EQ(name_of_event(stream.next()), "hello");
  for (std::size_t n = 1; n <= 20; ++n) {
    board_.publish(small_frame(n));
    const std::string event = stream.next();
    ASSERT_EQ(name_of_event(event), "frame");
    EXPECT_EQ(data_of(event)["n"], n);
  }
  board_.finish("done");
  EXPECT_EQ(name_of_event(stream.next()), "end");
}

TEST_F(ServedBoard, TakesCommandsAndRefusesOthers) {
  EventStream stream(at_, "events");
  ASSERT_EQ(name_of_event(stream.next()), "hello");
  EXPECT_EQ(post(at_, at_.path + "control?do=pause")->status, 204);
  EXPECT_EQ(data_of(stream.next())["paused"], true);
  EXPECT_EQ(post(at_, at_.path + "control?do=run")->status, 204);
  EXPECT_EQ(data_of(stream.next())["paused"], false);
  EXPECT_EQ(post(at_, at_.path + "control?do=format")->status, 400);
  EXPECT_EQ(get(at_, at_.path + "control?do=pause")->status, 404);  // a link must not steer
  EXPECT_EQ(get(at_, at_.path + "secret")->status, 404);
}

TEST_F(ServedBoard, SendsABusyPageNoMoreUntilItHasShownAFrame) {
  EventStream stream(at_, "events?acknowledge=1");
  const auto viewer = data_of(stream.next())["viewer"].get<int>();
  for (std::size_t n = 1; n <= 2; ++n) {
    board_.publish(small_frame(n));
    EXPECT_EQ(data_of(stream.next())["n"], n);
  }
  board_.publish(small_frame(3));
  board_.publish(small_frame(4));
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(stream.waiting(), 0u);
  EXPECT_EQ(post(at_, at_.path + "shown?viewer=" + std::to_string(viewer) + "&frame=2")->status, 204);
  EXPECT_EQ(data_of(stream.next())["n"], 4u);
}

TEST_F(ServedBoard, ForgetsAPageThatHasGone) {
  {
    EventStream stream(at_, "events");
    ASSERT_EQ(name_of_event(stream.next()), "hello");
    EXPECT_EQ(board_.viewers(), 1u);
  }
  for (std::size_t n = 1; n <= 300 && board_.viewers() > 0; ++n) {
    board_.publish(small_frame(n));
    std::this_thread::sleep_for(10ms);
  }
  EXPECT_EQ(board_.viewers(), 0u);
}

TEST(ViewServer, RefusesAPortThatIsTaken) {
  ViewBoard board(small_run()), other(small_run());
  const ViewServer first(board, 0);
  const auto port = static_cast<std::uint16_t>(address_of(first.url()).port);
  EXPECT_THROW(ViewServer(other, port), std::runtime_error);
}

TEST(ViewServer, EndsWhileAPageLooksOn) {
  ViewBoard board(small_run());
  auto server = std::make_unique<ViewServer>(board, std::uint16_t{0});
  EventStream stream(address_of(server->url()), "events");
  ASSERT_EQ(name_of_event(stream.next()), "hello");
  server.reset();
  EXPECT_EQ(stream.next(), "");
}

TEST(ViewServer, GivesAwayTheEndBeforeItGoes) {
  for (int k = 0; k < 30; ++k) {
    ViewBoard board(small_run());
    auto server = std::make_unique<ViewServer>(board, std::uint16_t{0});
    EventStream stream(address_of(server->url()), "events");
    ASSERT_EQ(name_of_event(stream.next()), "hello");
    board.finish("Done");
    while (!board.told_all()) {
      std::this_thread::yield();
    }
    server.reset();
    EXPECT_EQ(name_of_event(stream.next()), "end");
  }
}

}  // namespace
}  // namespace limber
