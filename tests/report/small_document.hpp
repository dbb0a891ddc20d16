// SPDX-License-Identifier: MIT
#pragma once

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
  space.traces = {{"path", "truth", TraceShape::kLine, {0.0, 1.0}, {1.0, 2.0}, {5.0, 6.0}, 0}};
  const ReportTable table{
      "Table", {"method", "error [m]"}, {{{"ekf"}, {"9", TableCell::Mark::kBad}}}, "A note."};
  const ReportClaims claims{"Claims", {{"It flies.", "4.1", "height above 0", "2 m", Verdict::kAgrees}}};
  return {"A title",
          "of a test",
          {{"frames", "2"}},
          {{"first", "First", {ReportText{"Words."}, curves, table}},
           {"second",
            "Second",
            {space, claims, ReportListing{"File", "key: 1\n"}, ReportFacts{"", {{"a", "b"}}}}}},
          "Made by a test."};
}

}  // namespace limber::testing
