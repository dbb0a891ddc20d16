// SPDX-License-Identifier: MIT
#include "limber/diagnose/health_summary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "datasets/files.hpp"
#include "limber/core/errors.hpp"
#include "limber/run_files/health_file.hpp"

namespace limber {
namespace {

using enum HealthVerdict;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr std::int64_t kSecond = 1'000'000'000;

CalibrationState state(HealthVerdict verdict, std::int64_t from, std::int64_t to) {
  CalibrationState out;
  out.verdict = verdict;
  out.from_ns = from * kSecond;
  out.to_ns = to * kSecond;
  return out;
}

/// A frame after a window that ended at t seconds.
FrameReport frame(std::int64_t t, const CalibrationState& present,
                  const std::vector<CalibrationState>& past = {}) {
  FrameReport out;
  out.t_ns = t * kSecond;
  out.calibration = std::make_shared<CalibrationReport>(CalibrationReport{present, present, past});
  return out;
}

TEST(HealthSummary, IsThePresentStateAndNotTheWorst) {
  const std::vector<FrameReport> frames = {frame(0, state(kOk, 0, 0)),
                                           frame(5, state(kDecalibrated, 3, 5), {state(kOk, 0, 3)}),
                                           frame(9, state(kOk, 7, 9), {state(kDecalibrated, 3, 7)})};
  const HealthSummary summary = summarize_health(std::span(frames).first(2)).value();
  EXPECT_EQ(summary.verdict, kDecalibrated);
  EXPECT_EQ(summary.past.size(), 1u);
  EXPECT_DOUBLE_EQ(summary.seconds(summary.present.from_ns), 3.0);
}

TEST(HealthSummary, DoesNotAverageAwayWhatComesAndGoes) {
  const std::vector<FrameReport> frames = {
      frame(0, state(kOk, 0, 0)), frame(5, state(kDecalibrated, 3, 5), {state(kOk, 0, 3)}),
      frame(9, state(kOk, 7, 9), {state(kDecalibrated, 3, 7)}),
      frame(17, state(kOk, 15, 17), {state(kOk, 7, 11), state(kDegraded, 12, 14)})};
  const HealthSummary summary = summarize_health(frames).value();
  EXPECT_TRUE(summary.comes_and_goes());
  EXPECT_EQ(summary.verdict, kDegraded);
  EXPECT_THAT(in_words(summary, Tolerance{}), HasSubstr("comes and goes"));
}

TEST(HealthSummary, IsOkAfterAnErrorThatIsOver) {
  const std::vector<FrameReport> frames = {
      frame(0, state(kOk, 0, 0)), frame(9, state(kOk, 7, 9), {state(kOk, 0, 3), state(kDecalibrated, 3, 7)})};
  const HealthSummary summary = summarize_health(frames).value();
  EXPECT_FALSE(summary.comes_and_goes());
  EXPECT_EQ(summary.verdict, kOk);
  EXPECT_EQ(summary.past.size(), 2u);
  EXPECT_THAT(in_words(summary, Tolerance{}), StartsWith("within the tolerance since 7.0 s, but not before"));
}

TEST(HealthSummary, CountsAWindowOnceHoweverManyFramesShowIt) {
  const FrameReport once = frame(5, state(kOk, 3, 5), {state(kOk, 0, 3)});
  const std::vector<FrameReport> frames = {once, once, once};
  EXPECT_EQ(summarize_health(frames)->past.size(), 1u);
}

TEST(HealthSummary, IsNothingWhereNothingWasJudged) {
  EXPECT_FALSE(summarize_health(std::vector<FrameReport>(3)));
}

TEST(HealthSummary, SaysWhyItCannotTell) {
  HealthSummary summary;
  EXPECT_THAT(in_words(summary, Tolerance{}), HasSubstr("hardly moved"));
  summary.present.deep = 500;
  summary.present.deep_tracks = 50;
  summary.present.by_epipolar = kOk;
  EXPECT_THAT(in_words(summary, Tolerance{}), StartsWith("the depth is not known well enough"));
  summary.present.tracks = 80;
  summary.present.deep_tracks = 12;
  EXPECT_THAT(in_words(summary, Tolerance{}), StartsWith("of only 12 tracks is the depth known from motion"));
  summary.present.scale_is_lost = true;
  EXPECT_THAT(in_words(summary, Tolerance{}), StartsWith("vision alone has lost the scale"));
  summary.present.verdict = kDecalibrated;
  EXPECT_THAT(in_words(summary, Tolerance{}),
              HasSubstr("off the epipolar lines, and nothing tells the depths"));
}

TEST(HealthSummary, IsJsonInDegreesMillimetresAndPercent) {
  HealthSummary summary;
  summary.present = state(kDegraded, 2, 9);
  summary.present.estimate.delta << std::numbers::pi / 180.0, 0, 0, 0.002, 0, 0;
  summary.present.effect.depth = {0.07, 0.06, 0.08};
  summary.present.effect.depth_signed = -0.07;
  summary.present.named = 0;
  WatchOptions options;
  options.false_alarms_per_hour = 0.5;
  const auto json = nlohmann::json::parse(to_json(summary, options));
  EXPECT_EQ(json["verdict"], "cannot tell");
  EXPECT_TRUE(json["changed_s"].is_null());
  const auto& present = json["present"];
  EXPECT_EQ(present["verdict"], "degraded");
  EXPECT_NEAR(present["axes"]["ax"]["error"], 1.0, 1e-12);
  EXPECT_NEAR(present["axes"]["tx"]["error"], 2.0, 1e-12);
  EXPECT_EQ(present["most_likely_axis"], "ax");
  EXPECT_NEAR(present["depth_percent"]["error"], -7.0, 1e-12);
  EXPECT_NEAR(present["depth_percent"]["ok"], 5.0, 1e-12);
  EXPECT_EQ(json["false_alarms_per_hour"], 0.5);
}

TEST(HealthFile, KeepsEveryWindow) {
  const testing::TemporaryFolder folder;
  CalibrationState present = state(kDecalibrated, 2, 3);
  present.axes[5] = kDegraded;
  present.estimate.delta << 1, 2, 3, 4, 5, 6;
  present.estimate.covariance.diagonal() << 1, 4, 9, 16, 25, 36;
  present.effect.epipolar_px = {2.0, 1.5, 2.5};
  present.effect.depth = {0.25, 0.125, 0.5};
  const FrameReport second = frame(3, present, {state(kOk, 0, 2)});
  const std::vector<FrameReport> frames = {frame(1, state(kOk, 0, 1)), FrameReport{}, second, second};
  write_health_csv(folder.path() / "health.csv", frames);
  const std::vector<HealthRow> rows = read_health_csv(folder.path() / "health.csv");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].t_ns, kSecond);
  EXPECT_FALSE(rows[0].changed);
  EXPECT_TRUE(rows[1].changed);
  EXPECT_EQ(rows[1].since_ns, 2 * kSecond);
  EXPECT_EQ(rows[1].verdict, kDecalibrated);
  EXPECT_EQ(rows[1].axes, present.axes);
  EXPECT_NEAR(rows[1].depth.high, 0.5, 1e-12);
  EXPECT_LT((rows[1].delta - present.estimate.delta).norm(), 1e-12);
  EXPECT_LT((rows[1].sigma - present.estimate.delta).norm(), 1e-12);
}

TEST(HealthFile, NamesFileLineAndWhatWasExpected) {
  const testing::TemporaryFolder folder;
  const auto path = folder.path() / "health.csv";
  write_health_csv(path, std::vector<FrameReport>{frame(1, state(kOk, 0, 1))});
  std::string text = testing::read_text(path);
  const std::size_t at = text.find(",ok,");
  ASSERT_NE(at, std::string::npos);
  testing::write_text(path, text.replace(at, 4, ",fine,"));
  try {
    (void)read_health_csv(path);
    FAIL();
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("health.csv"));
    EXPECT_THAT(error.what(), HasSubstr("ok, degraded, decalibrated or cannot tell"));
  }
}

}  // namespace
}  // namespace limber
