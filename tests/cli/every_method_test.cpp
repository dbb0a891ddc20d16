// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "cli/small_log.hpp"

namespace limber {
namespace {

using EveryMethod = testing::SmallLog;

TEST_F(EveryMethod, StartsFromTheSensors) {
  for (const std::string method :
       {"ekf", "ekf-full", "lcekf", "soft", "consider", "mono-left", "oracle", "adaptive"}) {
    const testing::ProgramResult result = run_again({"--method", method});
    EXPECT_EQ(result.exit_code, 0) << method << result.err;
    const auto summary = nlohmann::json::parse(testing::read_text(out() / "summary.json"));
    EXPECT_EQ(summary["method"], method);
    EXPECT_EQ(summary["options"]["init"], "auto");
  }
}

}  // namespace
}  // namespace limber
