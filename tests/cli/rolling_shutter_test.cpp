// SPDX-License-Identifier: MIT
// Rows that are exposed one after the other: what run and health say, before and after they are told.
#include <nlohmann/json.hpp>

#include "cli/small_log.hpp"
#include "rolling_rows.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class RollingShutterLog : public testing::SmallLog {
 protected:
  RollingShutterLog() {
    Scenario scenario = testing::shipped("drone_none", 8.0);
    scenario.world.points = 120;
    scenario.noise.pixel = 0.15;  // as a tracker has it
    write_track_log(testing::with_rolling_rows(scenario, 0.025, 5), log(), true);
  }
};

using FullRollingShutterLog = RollingShutterLog;

TEST_F(RollingShutterLog, IsNoSuccessUntilTheReadoutTimeIsGiven) {
  const auto unknown = run();
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.err, HasSubstr("limber: rolling shutter: the rows"));
  const auto before = nlohmann::json::parse(testing::read_text(out() / "summary.json"));
  EXPECT_EQ(before["health"]["verdict"], "cannot tell");
  EXPECT_NEAR(before["readout"]["ms"].get<double>(), 25.0, 1.5);
  EXPECT_TRUE(before["readout"]["contradicts_calibration"]);
  EXPECT_THAT(before["notes"][0].get<std::string>(), StartsWith("rolling shutter"));

  const auto given = run_into(folder() / "given", {"--readout-time", "0.025"});
  EXPECT_EQ(given.exit_code, 0) << given.err;
  EXPECT_THAT(given.err, Not(HasSubstr("rolling shutter")));
  const auto after = nlohmann::json::parse(testing::read_text(folder() / "given" / "summary.json"));
  EXPECT_LT(after["position_rmse_m"].get<double>(), 0.5 * before["position_rmse_m"].get<double>());
  EXPECT_LT(after["anees"].get<double>(), 3.0);
  EXPECT_GT(before["anees"].get<double>(), 10.0);
}

TEST_F(FullRollingShutterLog, IsNoRigThatBendsForHealth) {
  const auto unknown = testing::run_limber({"health", log().string()});
  EXPECT_EQ(unknown.exit_code, 4) << unknown.out;
  EXPECT_THAT(unknown.out, HasSubstr("log: cannot tell\nLooks like a mistake: rolling shutter"));
  EXPECT_THAT(unknown.out, HasSubstr("the rig is not judged"));
  EXPECT_THAT(unknown.out, Not(HasSubstr("time offset")));
  const auto given = testing::run_limber({"health", log().string(), "--readout-time", "0.025"});
  EXPECT_EQ(given.exit_code, 0) << given.out;
  EXPECT_THAT(given.out, Not(HasSubstr("rolling shutter")));
  EXPECT_EQ(testing::run_limber({"health", log().string(), "--readout-time", "2"}).exit_code, 2);
}

}  // namespace
}  // namespace limber
