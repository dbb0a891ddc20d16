// SPDX-License-Identifier: MIT
#include "diagnosis.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace limber::app {
namespace {

using enum HealthVerdict;
using ::testing::HasSubstr;
using ::testing::Not;

Diagnosis with(HealthVerdict verdict) {
  Diagnosis out;
  out.dataset = "log";
  out.health.emplace();
  out.health->verdict = verdict;
  return out;
}

TEST(Diagnosis, HasAnExitCodeForEachVerdict) {
  EXPECT_EQ(exit_code(kOk), 0);
  EXPECT_EQ(exit_code(kDecalibrated), 3);
  EXPECT_EQ(exit_code(kCannotTell), 4);
  EXPECT_EQ(exit_code(kSuspect), 5);
}

TEST(Diagnosis, SaysWhatToDo) {
  EXPECT_THAT(to_text(with(kOk)), HasSubstr("What to do: nothing"));
  EXPECT_THAT(to_text(with(kDecalibrated)), HasSubstr("What to do: recalibrate"));
  EXPECT_THAT(to_text(with(kSuspect)), HasSubstr("What to do: record longer"));
  EXPECT_THAT(to_text(with(kCannotTell)), HasSubstr("What to do: record more motion"));
}

TEST(Diagnosis, NamesWhatMovedSinceWhenAndWhatItDoesToADepth) {
  Diagnosis diagnosis = with(kDecalibrated);
  diagnosis.health->axes[1] = kDecalibrated;
  diagnosis.health->first_alarm_s = 12.5;
  diagnosis.health->changed_s = 12.25;
  diagnosis.health->p_value = 1e-9;
  diagnosis.depths = {{10.0, -0.25, 0.01}, {20.0, std::nullopt, 0.0}};
  const std::string text = to_text(diagnosis);
  EXPECT_THAT(text, HasSubstr("alarm after 12.50 s"));
  EXPECT_THAT(text, HasSubstr("p-value 1e-09; since 12.25 s"));
  EXPECT_THAT(text, ::testing::ContainsRegex("ay  vergence.*deg MOVED"));
  EXPECT_THAT(text, HasSubstr("at 10 m  is wrong by -0.250 ± 0.010 m (-2.50 %)"));
  EXPECT_THAT(text, HasSubstr("at 20 m  cannot be measured"));
}

TEST(Diagnosis, CallsAMistakeDecalibratedWhateverTheMonitorSays) {
  Diagnosis diagnosis = with(kOk);
  diagnosis.mistakes = {"the two cameras are swapped"};
  EXPECT_EQ(verdict_of(diagnosis), kDecalibrated);
  EXPECT_THAT(to_text(diagnosis), HasSubstr("Looks like a mistake: the two cameras are swapped"));
}

TEST(Diagnosis, MentionsATimeOffsetThatIsLargeAndCertain) {
  Diagnosis diagnosis = with(kOk);
  diagnosis.cam1_offset = TimeOffset{0.010, 0.001};
  EXPECT_THAT(to_text(diagnosis), HasSubstr("cam1 is taken 10.0 ± 1.0 ms later than stamped"));
  diagnosis.cam1_offset = TimeOffset{0.010, 0.005};
  EXPECT_THAT(to_text(diagnosis), Not(HasSubstr("time offset")));
}

TEST(Diagnosis, IsJsonWithNullForWhatIsNotKnown) {
  const auto json = nlohmann::json::parse(to_json(with(kSuspect)));
  EXPECT_EQ(json["verdict"], "suspect");
  EXPECT_EQ(json["health"]["verdict"], "suspect");
  EXPECT_TRUE(json["time_offset_cam1_cam0"].is_null() && json["failure"].is_null());
}

}  // namespace
}  // namespace limber::app
