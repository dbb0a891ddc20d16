// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// What a report says, before it becomes a page: plain data. All text is UTF-8 and is shown as it is, never
/// as markup. Numbers in traces are drawn in the unit of their axis; NaN and infinity are gaps in a curve.
namespace limber {

/// A name and a value, e.g. {"position RMSE", "0.041 m"}.
struct ReportFact {
  /// value: with its unit
  std::string name, value;
};

/// What a page opens on.
struct ReportAnswer {
  /// A lamp before the headline.
  enum class Light : std::uint8_t { kNone, kGreen, kYellow, kRed, kGrey };
  Light light = Light::kNone;          ///< how it is
  std::string headline;                ///< in a few words
  std::vector<std::string> sentences;  ///< why, one below the other
  std::string advice;                  ///< what to do; may be empty
};

/// How a trace is drawn.
enum class TraceShape : std::uint8_t {
  kLine,
  kBound,  ///< dotted, thin, and without a line in the legend: the 3 sigma of the line with the same style
  kDots    ///< unconnected
};

/// One curve or cloud.
struct ReportTrace {
  std::string name;  ///< in the legend
  /// Chooses colour and dash, the same on every page: a method's name (with what is varied of it after a
  /// colon, "lcekf:rotation"), "truth", "landmarks", "band", "wide" (pale, to lie below another), or "series
  /// 1" to "series 4".
  std::string style;
  /// how it is drawn
  TraceShape shape = TraceShape::kLine;
  std::vector<double> x, y, z;  ///< equally long; z in figures of kind kSpace only, else empty
  std::size_t panel = 0;        ///< which of the figure's y axes
  /// When a path was at each sample, on the time axis of the document's curves [s]; as long as x, or empty.
  std::vector<double> t{};
};

/// What an axis shows, and in which unit.
struct ReportAxis {
  /// e.g. "position error" and "m"
  std::string title, unit;
  bool log = false;  ///< of an x axis: logarithmic, always
};

/// What the axes of a figure mean.
enum class FigureKind : std::uint8_t {
  kCurves,   ///< y over x; long traces are thinned to the extremes of each stretch
  kTopView,  ///< paths and points, equal scales; long ones are thinned evenly
  kSpace     ///< the same in 3-D, to be turned
};

/// One of several looks at a figure, e.g. {"without ekf", {"ekf"}}: the paper's (b).
struct FigureVariant {
  /// on its button
  std::string label;
  /// styles of the traces that it leaves out
  std::vector<std::string> hidden_styles;
};

/// A figure with its traces.
struct ReportFigure {
  std::string id;  ///< unique in the document; names the anchor and the file of an export
  /// caption: under the figure; may be empty
  std::string title, caption;
  /// what its axes mean
  FigureKind kind = FigureKind::kCurves;
  /// of all panels; kTopView and kSpace: the first coordinate; in curves, the title "time" joins them to the
  /// cursor of the page
  ReportAxis x;
  std::vector<ReportAxis> y;            ///< one per panel, from top to bottom; kTopView: one; kSpace: y and z
  bool log_switch = false;              ///< offer a logarithmic y axis
  bool starts_in_log = false;           ///< and begin with it
  bool half_width = false;              ///< two of them stand side by side where there is room
  std::vector<FigureVariant> variants;  ///< to choose from, the first at first; may be empty
  /// later ones lie over earlier ones
  std::vector<ReportTrace> traces;
};

/// A cell's text, and how it stands out.
struct TableCell {
  /// Why a cell stands out.
  enum class Mark : std::uint8_t { kNone, kBest, kBad };
  /// as it is shown
  std::string text;
  /// kNone: not at all
  Mark mark = Mark::kNone;
};

/// A table; every row has a cell per column.
struct ReportTable {
  /// over the table
  std::string title;
  std::vector<std::string> columns;  ///< heads, with unit; the first column names the row
  /// in order, each as long as `columns`
  std::vector<std::vector<TableCell>> rows;
  std::string note;  ///< under the table; may be empty
};

/// Whether a claim agrees with what was measured.
enum class Verdict : std::uint8_t { kAgrees, kDisagrees, kNotMeasured };
/// "agrees", "does not agree", "not measured".
[[nodiscard]] std::string_view to_string(Verdict verdict);

/// A statement that somebody made, and what was measured.
struct ReportClaim {
  /// as it was made, in words
  std::string statement;
  std::string source;     ///< e.g. "4.3.1, Figure 5"
  std::string criterion;  ///< the rule that turned `measured` into `verdict`
  std::string measured;   ///< may have several lines
  /// what the criterion made of it
  Verdict verdict = Verdict::kNotMeasured;
};

/// A paragraph.
struct ReportText {
  std::string text;  ///< a paragraph
};
/// Names and values under one heading.
struct ReportFacts {
  /// the heading
  std::string title;
  /// in order
  std::vector<ReportFact> facts;
};
/// Preformatted text behind a line that opens it, e.g. a scenario file.
struct ReportListing {
  /// title: the line that opens it
  std::string title, text;
};
/// Claims with their verdicts under one heading.
struct ReportClaims {
  /// the heading
  std::string title;
  /// in order
  std::vector<ReportClaim> claims;
  bool brief = false;  ///< statements and verdicts alone
};

/// Anything that a section may hold.
using ReportBlock =
    std::variant<ReportText, ReportFacts, ReportFigure, ReportTable, ReportClaims, ReportListing>;

/// A part of the page with an anchor.
struct ReportSection {
  std::string id, title;  ///< id: unique in the document
  /// in order
  std::vector<ReportBlock> blocks;
};

/// A whole page.
struct ReportDocument {
  /// subtitle: may be empty
  std::string title, subtitle;
  std::optional<ReportAnswer> answer;  ///< at the top of the page
  std::vector<ReportFact> facts;       ///< the main figures, below the answer
  /// in order
  std::vector<ReportSection> sections;
  std::string footer;  ///< e.g. the program and its version
};

}  // namespace limber
