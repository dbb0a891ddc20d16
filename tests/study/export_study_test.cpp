// SPDX-License-Identifier: MIT
#include "limber/study/export_study.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "datasets/files.hpp"
#include "study/tiny_study.hpp"

namespace limber {
namespace {

using Json = nlohmann::json;
using testing::TemporaryFolder;
using testing::two_cases;

std::vector<std::string> lines_of(const std::filesystem::path& path) {
  std::istringstream stream(testing::read_text(path));
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) {
    lines.push_back(line);
  }
  return lines;
}

/// Commas outside quotes.
std::ptrdiff_t commas(const std::string& line) {
  bool quoted = false;
  return std::count_if(line.begin(), line.end(), [&](char c) {
    quoted = c == '"' ? !quoted : quoted;
    return c == ',' && !quoted;
  });
}

class ExportStudy : public ::testing::Test {
 protected:
  void SetUp() override { run_study(two_cases(3), path_); }

  const TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "study.sqlite";
};

TEST_F(ExportStudy, WritesTablesWhoseRowsAreAllAsLongAsTheirHeads) {
  const StudyDatabase study(path_);
  const auto files = export_csv(study, path_);
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[0], folder_.path() / "study_runs.csv");
  EXPECT_EQ(files[1], folder_.path() / "study_curves.csv");
  EXPECT_EQ(lines_of(files[0]).size(), 1u + 4u * 3u + 2u * 2u);
  EXPECT_EQ(lines_of(files[1]).size(), 1u + (4u + 2u) * 21u);
  for (const auto& file : files) {
    const std::vector<std::string> lines = lines_of(file);
    for (const std::string& line : lines) {
      EXPECT_EQ(commas(line), commas(lines.front())) << line;
    }
  }
}

TEST_F(ExportStudy, WritesJsonWithEveryRunAndCurve) {
  const StudyDatabase study(path_);
  const auto files = export_json(study, path_);
  ASSERT_EQ(files.size(), 1u);
  const Json json = Json::parse(testing::read_text(files[0]));
  EXPECT_EQ(json["seed"], 1);
  ASSERT_EQ(json["cases"].size(), 2u);
  const Json& study_case = json["cases"][0];
  EXPECT_EQ(study_case["name"], "tiny");
  EXPECT_EQ(study_case["t_s"].size(), 21u);
  ASSERT_EQ(study_case["methods"].size(), 4u);
  const Json& ekf = study_case["methods"][0];
  EXPECT_EQ(ekf["method"], "ekf");
  EXPECT_EQ(ekf["runs"].size(), 3u);
  EXPECT_EQ(ekf["runs"][2]["position_rmse_m"], *study.runs(0, 0)[2].figures.position_rmse_m);
  EXPECT_TRUE(ekf["runs"][2]["diverged"].is_null());
  EXPECT_EQ(ekf["curves"]["pose_nees"]["runs"][20], 3);
  EXPECT_FALSE(ekf["curves"].contains("delta_tx"));
  const Json& hopeless = study_case["methods"][3];
  EXPECT_TRUE(hopeless["runs"][0]["position_rmse_m"].is_null());
  EXPECT_TRUE(hopeless["runs"][0]["diverged"]["frame"].is_number());
  EXPECT_TRUE(hopeless["curves"]["pose_nees"]["mean"][20].is_null());
}

}  // namespace
}  // namespace limber
