// SPDX-License-Identifier: MIT
#include "limber/diagnose/health_summary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "datasets/files.hpp"
#include "limber/core/errors.hpp"
#include "limber/run_files/health_file.hpp"

namespace limber {
namespace {

using enum HealthVerdict;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr std::int64_t kSecond = 1'000'000'000;

/// A report of the window that began at `since` seconds, with one offset and one sigma for all axes.
FrameReport frame(std::int64_t t, std::int64_t since, double delta, double sigma) {
  HealthReport report;
  report.t_ns = t * kSecond;
  report.gathered_since_ns = since * kSecond;
  report.gathered_delta.setConstant(delta);
  report.gathered_sigma.setConstant(sigma);
  report.verdict = kOk;
  FrameReport out;
  out.t_ns = report.t_ns;
  out.health = report;
  return out;
}

/// The same as an alarm, with the first axes named.
FrameReport alarm(FrameReport frame, std::int64_t changed, std::size_t named) {
  frame.health->alarm = true;
  frame.health->verdict = kDecalibrated;
  frame.health->changed_ns = changed * kSecond;
  frame.health->p_value = 1e-9;
  for (std::size_t k = 0; k < named; ++k) {
    frame.health->axes[k] = kDecalibrated;
  }
  return frame;
}

TEST(HealthSummary, AveragesTheLastReportOfEachWindowByItsInformation) {
  // Windows [0, 2] and [2, 4]: 1 with sigma 1, 4 with sigma 2. Reports within a window do not count.
  const std::vector<FrameReport> frames = {frame(0, 0, 9.0, 9.0), frame(1, 0, 8.0, 3.0),
                                           frame(2, 0, 1.0, 1.0), frame(3, 2, 7.0, 4.0),
                                           frame(4, 2, 4.0, 2.0)};
  const HealthSummary summary = summarize_health(frames).value();
  EXPECT_NEAR(summary.mean.delta(3), (1.0 + 4.0 / 4.0) / 1.25, 1e-12);
  EXPECT_NEAR(summary.mean.sigma(3), (1.0 + 2.0 / 4.0) / 1.25, 1e-12);
  EXPECT_EQ(summary.since_change.delta, summary.mean.delta);
}

TEST(HealthSummary, OfAlikeWindowsHasTheSigmaOfOne) {
  std::vector<FrameReport> frames;
  for (std::int64_t t = 0; t < 100; ++t) {
    frames.push_back(frame(t, t, 0.5, 0.1));
  }
  EXPECT_NEAR(summarize_health(frames)->mean.sigma(0), 0.1, 1e-12);
}

TEST(HealthSummary, IsDecalibratedOnceThereWasAnAlarmAndTellsWhatCameAfterIt) {
  const std::vector<FrameReport> frames = {frame(10, 10, 0.0, 1.0), alarm(frame(12, 10, 0.5, 1.0), 12, 1),
                                           alarm(frame(13, 12, 2.0, 1.0), 12, 1), frame(14, 13, 2.0, 1.0)};
  const HealthSummary summary = summarize_health(frames).value();
  EXPECT_EQ(summary.verdict, kDecalibrated);
  EXPECT_DOUBLE_EQ(summary.first_alarm_s.value(), 2.0);
  EXPECT_DOUBLE_EQ(summary.changed_s.value(), 2.0);
  EXPECT_DOUBLE_EQ(summary.p_value, 1e-9);
  EXPECT_NEAR(summary.since_change.delta(0), 2.0, 1e-12);
  EXPECT_THAT(summary.axes, ElementsAre(kDecalibrated, kOk, kOk, kOk, kOk, kOk));
}

TEST(HealthSummary, AnAlarmInTheLastFrameSpeaksForItself) {
  const std::vector<FrameReport> frames = {frame(0, 0, 0.0, 1.0), alarm(frame(1, 0, 3.0, 0.5), 1, 2)};
  const HealthSummary summary = summarize_health(frames).value();
  EXPECT_DOUBLE_EQ(summary.since_change.delta(0), 3.0);
  EXPECT_DOUBLE_EQ(summary.since_change.sigma(0), 0.5);
}

TEST(HealthSummary, DoesNotNameAnAxisThatWasNamedNowAndThen) {
  std::vector<FrameReport> frames;
  for (std::int64_t t = 0; t < 10; ++t) {
    frames.push_back(alarm(frame(t, t, 1.0, 1.0), 0, t == 4 ? 3 : 1));
  }
  EXPECT_THAT(summarize_health(frames)->axes, ElementsAre(kDecalibrated, kOk, kOk, kOk, kOk, kOk));
}

TEST(HealthSummary, CannotTellAnAxisThatNoWindowCouldJudge) {
  std::vector<FrameReport> frames = {frame(0, 0, 0.0, 1.0), frame(1, 0, 0.0, 1.0)};
  frames[0].health->axes.fill(kCannotTell);
  frames[1].health->axes = {kOk, kOk, kOk, kCannotTell, kOk, kOk};
  const HealthSummary summary = summarize_health(frames).value();
  EXPECT_EQ(summary.verdict, kOk);
  EXPECT_THAT(summary.axes, ElementsAre(kOk, kOk, kOk, kCannotTell, kOk, kOk));
  frames[1].health->axes.fill(kCannotTell);
  EXPECT_EQ(summarize_health(frames)->verdict, kCannotTell);
}

TEST(HealthSummary, IsSuspectIfTheLastFrameIs) {
  std::vector<FrameReport> frames = {frame(0, 0, 0.0, 1.0), frame(1, 0, 0.0, 1.0)};
  frames[0].health->verdict = kSuspect;
  EXPECT_EQ(summarize_health(frames)->verdict, kOk);
  frames[1].health->verdict = kSuspect;
  EXPECT_EQ(summarize_health(frames)->verdict, kSuspect);
}

TEST(HealthSummary, IsNothingWhereNothingWasWatched) {
  EXPECT_FALSE(summarize_health(std::vector<FrameReport>(3)));
}

TEST(HealthSummary, IsJsonInDegreesAndMillimetres) {
  HealthSummary summary;
  summary.mean.delta << std::numbers::pi / 180.0, 0, 0, 0.002, 0, 0;
  const auto json = nlohmann::json::parse(to_json(summary, 0.5));
  EXPECT_EQ(json["verdict"], "cannot tell");
  EXPECT_TRUE(json["first_alarm_s"].is_null() && json["changed_s"].is_null());
  EXPECT_NEAR(json["delta_mean"][0], 1.0, 1e-12);
  EXPECT_NEAR(json["delta_mean"][3], 2.0, 1e-12);
  EXPECT_EQ(json["axes"]["ax"], "ok");
  EXPECT_EQ(json["false_alarms_per_hour"], 0.5);
}

TEST(HealthFile, KeepsEveryReport) {
  const testing::TemporaryFolder folder;
  std::vector<FrameReport> frames = {frame(1, 1, 0.25, 2.0), FrameReport{},
                                     alarm(frame(3, 1, -0.5, 1.0), 2, 2)};
  frames[2].health->axes[5] = kCannotTell;
  frames[2].health->delta << 1, 2, 3, 4, 5, 6;
  write_health_csv(folder.path() / "health.csv", frames);
  const std::vector<HealthReport> rows = read_health_csv(folder.path() / "health.csv");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].t_ns, kSecond);
  EXPECT_FALSE(rows[0].changed_ns);
  EXPECT_EQ(rows[1].changed_ns, 2 * kSecond);
  EXPECT_EQ(rows[1].verdict, kDecalibrated);
  EXPECT_TRUE(rows[1].alarm);
  EXPECT_EQ(rows[1].axes, frames[2].health->axes);
  EXPECT_EQ(rows[1].p_value, 1e-9);
  EXPECT_LT((rows[1].delta - frames[2].health->delta).norm(), 1e-12);
  EXPECT_NEAR(rows[1].gathered_delta(4), -0.5, 1e-15);
  const std::string text = testing::read_text(folder.path() / "health.csv");
  EXPECT_THAT(text, StartsWith("#t_ns,verdict,alarm,p_value [-],delta_ax [deg],"));
  EXPECT_THAT(text, HasSubstr("gathered_sigma_tz [mm],verdict_ax,"));
}

TEST(HealthFile, RefusesAWordThatIsNoVerdict) {
  const testing::TemporaryFolder folder;
  write_health_csv(folder.path() / "health.csv", std::vector{frame(1, 1, 0.0, 1.0)});
  std::string text = testing::read_text(folder.path() / "health.csv");
  text.replace(text.find(",ok,"), 4, ",fine,");
  testing::write_text(folder.path() / "health.csv", text);
  const DataError error =
      testing::data_error_of([&] { (void)read_health_csv(folder.path() / "health.csv"); });
  EXPECT_THAT(error.what(), HasSubstr("expected ok, suspect, decalibrated or cannot tell, found fine"));
}

}  // namespace
}  // namespace limber
