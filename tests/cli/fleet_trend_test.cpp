// SPDX-License-Identifier: MIT
#include "fleet_trend.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "limber/core/random.hpp"

namespace limber::app {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr double kDegree = 0.017453292519943295;
constexpr std::int64_t kDay = 86'400'000'000'000, kMonday = 1'700'000'000'000'000'000;

void set_ax(FleetRow& row, double ax_deg) {
  const double plausible = 0.1 * kDegree;  // the unit of beta
  row.diagnosis->state->rig.estimate.beta(0) = ax_deg * kDegree / plausible;
}

/// A recording of a rig whose ax is off by so many degrees, known to 0.01 degrees as all other angles.
FleetRow row(double ax_deg, std::int64_t t_ns, const std::string& camera = "left") {
  FleetRow out{"log", Diagnosis{}, "", false};
  HealthState state;
  state.cameras = {camera, "right"};
  state.rig.theta << 0.001, 0, 0, -0.1, 0, 0;
  state.rig.from_ns = t_ns;
  state.rig.to_ns = t_ns + 1'000'000'000;
  state.rig.estimate.covariance.setIdentity();
  state.rig.estimate.covariance *= 0.01;
  out.diagnosis->state = state;
  set_ax(out, ax_deg);
  return out;
}

TEST(FleetTrend, IsTheSlopePerDayWithAnIntervalFromTheSigmas) {
  const std::vector<FleetRow> rows = {row(0.00, kMonday), row(0.05, kMonday + kDay),
                                      row(0.10, kMonday + 2 * kDay)};
  const auto trends = fleet_trends(rows);
  ASSERT_EQ(trends.size(), 1u);
  EXPECT_EQ(trends[0].per, "day");
  ASSERT_TRUE(trends[0].axes[0] && trends[0].axes[1]);
  EXPECT_NEAR(trends[0].axes[0]->slope / kDegree, 0.05, 1e-9);
  EXPECT_NEAR(trends[0].axes[0]->half_width / kDegree, 1.96 * 0.01 / std::sqrt(2.0), 1e-4);
  EXPECT_TRUE(trends[0].axes[0]->is_certain());
  EXPECT_FALSE(trends[0].axes[1]->is_certain());
  EXPECT_THAT(to_text(trends[0], rows), HasSubstr("ax [deg]"));
  EXPECT_THAT(to_text(trends[0], rows), HasSubstr("drifts"));
  EXPECT_EQ(to_json(trends[0])["axes"]["ax"]["drifts"], true);
}

TEST(FleetTrend, CountsHoursOrRecordingsWhereThereAreNoDays) {
  EXPECT_EQ(fleet_trends({row(0, kMonday), row(0, kMonday + kDay / 24), row(0, kMonday + kDay / 12)})[0].per,
            "hour");
  const auto trends = fleet_trends({row(0.0, 0), row(0.1, 0), row(0.2, 0)});
  EXPECT_EQ(trends[0].per, "recording");
  EXPECT_NEAR(trends[0].axes[0]->slope / kDegree, 0.1, 1e-9);
}

TEST(FleetTrend, IsOfRecordingsWithTheSameCamerasAndOfThreeAtLeast) {
  EXPECT_THAT(fleet_trends({row(0, 0), row(0, 0), row(0, 0, "other"), row(0, 0, "other")}), IsEmpty());
  std::vector<FleetRow> rows = {row(0, 0), row(0, 0, "other"), row(0, 0), row(0, 0)};
  EXPECT_THAT(fleet_trends(rows)[0].rows, ::testing::ElementsAre(0u, 2u, 3u));
  rows[2].diagnosis->state.reset();
  EXPECT_THAT(fleet_trends(rows), IsEmpty());
}

/// 5 % of the intervals may miss it, or by chance two sigmas of their number more.
void expect_coverage(std::uint64_t fleets) {
  const double n = static_cast<double>(fleets);
  std::vector<FleetRow> rows;
  for (std::uint32_t k = 0; k < 5; ++k) {
    rows.push_back(row(0.0, kMonday + k * kDay));
  }
  for (const double scatter : {0.01, 0.03}) {  // [deg]; the sigmas say 0.01
    const RandomStream random(1, 0, "fleet");
    int missed = 0;
    for (std::uint64_t i = 0; i < fleets; ++i) {
      for (std::uint32_t k = 0; k < 5; ++k) {
        set_ax(rows[k], 0.02 * k + scatter * random.normal2(i, k)(0));
      }
      const AxisTrend trend = *fleet_trends(rows)[0].axes[0];
      missed += std::abs(trend.slope - 0.02 * kDegree) > trend.half_width ? 1 : 0;
    }
    EXPECT_LT(missed, 0.05 * n + 2.0 * std::sqrt(0.05 * 0.95 * n)) << scatter;
    EXPECT_GT(missed, 0.005 * n) << scatter << ": not much wider than needed";
  }
}

TEST(FleetTrend, CoversTheTruthAsOftenAsItSaysAlsoWhereRecordingsScatterMore) { expect_coverage(500); }

TEST(FullFleetTrend, CoversTheTruthAsOftenAsItSaysAlsoWhereRecordingsScatterMore) { expect_coverage(2000); }

TEST(FleetText, MarksWhatWasNotJudgedToItsEnd) {
  std::vector<FleetRow> rows = {row(0, 0), {"second", std::nullopt, "", true}};
  rows[0].diagnosis->stopped = true;
  rows[0].diagnosis->frames = 80;
  rows[0].diagnosis->frames_of_recording = 160;
  EXPECT_EQ(fleet_exit_code(rows), 1);
  EXPECT_THAT(fleet_text(rows), HasSubstr("(partial: 80 of 160 frames)"));
  EXPECT_THAT(fleet_text(rows), HasSubstr("not judged"));
  EXPECT_THAT(fleet_json(rows), HasSubstr("not judged: stopped"));
}

}  // namespace
}  // namespace limber::app
