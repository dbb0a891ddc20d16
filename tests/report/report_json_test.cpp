// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "limber/report/write_report.hpp"
#include "report/small_document.hpp"

namespace limber {
namespace {

using Json = nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::small_document;

Json parsed(const ReportDocument& document) { return Json::parse(report_json(document)); }

std::vector<float> series(const Json& json, const Json& index) {
  return testing::decoded(json["series"][index.get<std::size_t>()]);
}

ReportFigure& first_figure(ReportDocument& document) {
  return std::get<ReportFigure>(document.sections[0].blocks[1]);
}

std::string refusal_of(const ReportDocument& document) {
  try {
    (void)report_json(document);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ReportJson, HoldsEveryBlockInOrder) {
  const Json json = parsed(small_document());
  EXPECT_EQ(json["title"], "A title");
  EXPECT_EQ(json["answer"],
            Json::parse(R"({"light": "green", "headline": "It works", "sentences": ["Because."],
                                            "advice": "Go on."})"));
  EXPECT_EQ(json["facts"], Json::parse(R"([{"name": "frames", "value": "2"}])"));
  std::vector<std::string> types;
  for (const Json& section : json["sections"]) {
    for (const Json& block : section["blocks"]) {
      types.push_back(block["type"]);
    }
  }
  EXPECT_EQ(types,
            (std::vector<std::string>{"text", "figure", "table", "figure", "claims", "listing", "facts"}));
  const Json& table = json["sections"][0]["blocks"][2];
  EXPECT_EQ(table["rows"][0][1], Json::parse(R"({"text": "9", "mark": "bad"})"));
  EXPECT_EQ(json["sections"][1]["blocks"][1]["claims"][0]["verdict"], "agrees");
}

TEST(ReportJson, FiguresSayWhatIsDrawnAndHow) {
  const Json json = parsed(small_document());
  const Json& figure = json["sections"][0]["blocks"][1];
  EXPECT_EQ(figure["kind"], "curves");
  EXPECT_EQ(figure["y"][1]["unit"], "deg");
  EXPECT_EQ(figure["log_switch"], true);
  EXPECT_EQ(figure["variants"][1]["hidden_styles"], Json::array({"ekf"}));
  EXPECT_EQ(figure["traces"][1]["shape"], "bound");
  EXPECT_EQ(figure["traces"][1]["panel"], 1);
  EXPECT_EQ(figure["note"], "");
  const Json& path = json["sections"][1]["blocks"][0]["traces"][0];
  EXPECT_THAT(series(json, path["z"]), ElementsAre(5.0f, 6.0f));
  EXPECT_THAT(series(json, path["t"]), ElementsAre(7.0f, 8.0f));
  EXPECT_FALSE(figure["traces"][0].contains("t"));
}

TEST(ReportJson, StoresEqualSeriesOnce) {
  const Json json = parsed(small_document());
  // x of all three traces is one series, y of the first curve is that of the path.
  EXPECT_EQ(json["series"].size(), 5u);
  const Json& traces = json["sections"][0]["blocks"][1]["traces"];
  EXPECT_EQ(traces[0]["x"], traces[1]["x"]);
  EXPECT_NE(traces[0]["y"], traces[1]["y"]);
}

TEST(ReportJson, KeepsSevenDigitsAndGaps) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  ReportDocument document = small_document();
  ReportTrace& trace = first_figure(document).traces[0];
  trace.y = {1.23456789e-7, -123456.789, std::numeric_limits<double>::quiet_NaN(), kInfinity, -1e300};
  trace.x = {0.0, 0.05, 0.1, 0.15, 0.2};
  const Json json = parsed(document);
  const std::vector<float> y = series(json, json["sections"][0]["blocks"][1]["traces"][0]["y"]);
  ASSERT_EQ(y.size(), 5u);
  EXPECT_FLOAT_EQ(y[0], 1.23456789e-7f);
  EXPECT_FLOAT_EQ(y[1], -123456.789f);
  EXPECT_TRUE(std::isnan(y[2]) && std::isnan(y[3]) && std::isnan(y[4]));
}

TEST(ReportJson, ThinsLongTracesAndSaysSo) {
  ReportDocument document = small_document();
  ReportTrace& trace = first_figure(document).traces[0];
  trace.x.resize(50000);
  trace.y.resize(50000);
  for (std::size_t k = 0; k < trace.x.size(); ++k) {
    trace.x[k] = static_cast<double>(k);
    trace.y[k] = std::sin(0.001 * trace.x[k]);
  }
  trace.y[31234] = 7.0;
  const Json json = parsed(document);
  const Json& figure = json["sections"][0]["blocks"][1];
  EXPECT_THAT(figure["note"].get<std::string>(), HasSubstr("50000"));
  const std::vector<float> y = series(json, figure["traces"][0]["y"]);
  EXPECT_LE(y.size(), kMaxCurvePoints);
  EXPECT_GT(y.size(), kMaxCurvePoints / 2);
  EXPECT_EQ(*std::max_element(y.begin(), y.end()), 7.0f);
  EXPECT_EQ(figure["traces"][1]["name"], "lcekf");
}

TEST(ReportJson, TakesAnyBytesForText) {
  ReportDocument document = small_document();
  document.title = "caf\xe9";
  EXPECT_THAT(parsed(document)["title"].get<std::string>(), HasSubstr("caf"));
}

TEST(ReportJson, RefusesIdsThatRepeat) {
  ReportDocument document = small_document();
  document.sections[1].id = "curves";
  EXPECT_THAT(refusal_of(document), HasSubstr("'curves'"));
}

TEST(ReportJson, RefusesTracesThatDoNotFitTheirFigure) {
  ReportDocument document = small_document();
  first_figure(document).traces[0].y.push_back(1.0);
  EXPECT_THAT(refusal_of(document), HasSubstr("figure 'curves', trace 'ekf' has 2 x, 3 y and 0 z"));
  document = small_document();
  first_figure(document).traces[0].t = {1.0};
  EXPECT_THAT(refusal_of(document), HasSubstr("trace 'ekf' has 2 x and 1 t"));
  document = small_document();
  first_figure(document).traces[1].panel = 2;
  EXPECT_THAT(refusal_of(document), HasSubstr("there is no panel 2"));
}

TEST(ReportJson, RefusesRowsThatAreNotAsLongAsTheirHead) {
  ReportDocument document = small_document();
  std::get<ReportTable>(document.sections[0].blocks[2]).rows.push_back({{"alone"}});
  EXPECT_THAT(refusal_of(document), HasSubstr("table 'Table' has 2 columns and a row of 1"));
}

}  // namespace
}  // namespace limber
