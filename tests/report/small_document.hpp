// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "limber/report/document.hpp"

namespace limber::testing {

/// One of everything.
inline ReportDocument small_document() {
  ReportFigure curves;
  curves.id = "curves";
  curves.title = "Curves";
  curves.x = {"time", "s"};
  curves.y = {{"error", "m"}, {"error", "deg"}};
  curves.log_switch = true;
  curves.variants = {{"all", {}}, {"without ekf", {"ekf"}}};
  curves.traces = {{"ekf", "ekf", TraceShape::kLine, {0.0, 1.0}, {1.0, 2.0}, {}, 0},
                   {"lcekf", "lcekf", TraceShape::kBound, {0.0, 1.0}, {3.0, 4.0}, {}, 1}};
  ReportFigure space;
  space.id = "space";
  space.kind = FigureKind::kSpace;
  space.x = {"x", "m"};
  space.y = {{"y", "m"}, {"z", "m"}};
  space.traces = {{"path", "truth", TraceShape::kLine, {0.0, 1.0}, {1.0, 2.0}, {5.0, 6.0}, 0, {7.0, 8.0}}};
  const ReportTable table{
      "Table", {"method", "error [m]"}, {{{"ekf"}, {"9", TableCell::Mark::kBad}}}, "A note."};
  const ReportClaims claims{"Claims", {{"It flies.", "4.1", "height above 0", "2 m", Verdict::kAgrees}}};
  return {"A title",
          "of a test",
          ReportAnswer{ReportAnswer::Light::kGreen, "It works", {"Because."}, "Go on."},
          {{"frames", "2"}},
          {{"first", "First", {ReportText{"Words."}, curves, table}},
           {"second",
            "Second",
            {space, claims, ReportListing{"File", "key: 1\n"}, ReportFacts{"", {{"a", "b"}}}}}},
          "Made by a test."};
}

/// The numbers of a series as report_json writes them.
inline std::vector<float> decoded(const std::string& base64) {
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::uint8_t> bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char letter : base64.substr(0, base64.find('='))) {
    bits = bits << 6 | static_cast<std::uint32_t>(letters.find(letter));
    count += 6;
    if (count >= 8) {
      count -= 8;
      bytes.push_back(static_cast<std::uint8_t>(bits >> count & 0xffu));
    }
  }
  std::vector<float> values;
  for (std::size_t k = 0; k + 3 < bytes.size(); k += 4) {
    values.push_back(std::bit_cast<float>(bytes[k] | std::uint32_t{bytes[k + 1]} << 8 |
                                          std::uint32_t{bytes[k + 2]} << 16 |
                                          std::uint32_t{bytes[k + 3]} << 24));
  }
  return values;
}

}  // namespace limber::testing
