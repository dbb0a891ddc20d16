// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <unordered_map>

#include "io/base64.hpp"
#include "io/json_text.hpp"
#include "limber/report/thinning.hpp"
#include "limber/report/write_report.hpp"

namespace limber {
namespace {

using Json = nlohmann::ordered_json;

/// All series of a document; equal ones (the time of every curve) are stored once.
class SeriesPool {
 public:
  std::size_t add(const std::vector<double>& values, const std::vector<std::size_t>& indices) {
    std::vector<float> drawn;
    drawn.reserve(indices.size());
    for (const std::size_t k : indices) {
      const bool is_gap = !(std::abs(values[k]) <= std::numeric_limits<float>::max());
      drawn.push_back(is_gap ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(values[k]));
    }
    std::string text = detail::to_base64(drawn);
    const auto [it, is_new] = index_of_.try_emplace(text, series_.size());
    if (is_new) {
      series_.push_back(std::move(text));
    }
    return it->second;
  }
  [[nodiscard]] Json take() { return std::move(series_); }

 private:
  Json series_ = Json::array();
  std::unordered_map<std::string, std::size_t> index_of_;
};

std::string_view to_string(FigureKind kind) {
  constexpr std::string_view kNames[] = {"curves", "top-view", "space"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::string_view to_string(TraceShape shape) {
  constexpr std::string_view kNames[] = {"line", "bound", "dots"};
  return kNames[static_cast<std::size_t>(shape)];
}

std::string_view to_string(ReportAnswer::Light light) {
  constexpr std::string_view kNames[] = {"", "green", "yellow", "red", "grey"};
  return kNames[static_cast<std::size_t>(light)];
}

Json to_json(const std::optional<ReportAnswer>& answer) {
  return answer ? Json{{"light", to_string(answer->light)},
                       {"headline", answer->headline},
                       {"sentences", answer->sentences},
                       {"advice", answer->advice}}
                : Json(nullptr);
}

std::string_view to_string(TableCell::Mark mark) {
  constexpr std::string_view kNames[] = {"", "best", "bad"};
  return kNames[static_cast<std::size_t>(mark)];
}

void require(bool holds, const std::string& message) {
  if (!holds) {
    throw std::invalid_argument("report: " + message);
  }
}

void check(const ReportFigure& figure, const ReportTrace& trace) {
  const bool in_space = figure.kind == FigureKind::kSpace;
  require(trace.x.size() == trace.y.size() && trace.z.size() == (in_space ? trace.x.size() : 0),
          fmt::format("figure '{}', trace '{}' has {} x, {} y and {} z", figure.id, trace.name,
                      trace.x.size(), trace.y.size(), trace.z.size()));
  require(trace.t.empty() || trace.t.size() == trace.x.size(),
          fmt::format("figure '{}', trace '{}' has {} x and {} t", figure.id, trace.name, trace.x.size(),
                      trace.t.size()));
  require(trace.panel < (in_space ? 1 : figure.y.size()),
          fmt::format("figure '{}', trace '{}': there is no panel {}", figure.id, trace.name, trace.panel));
}

std::vector<std::size_t> drawn_samples(FigureKind kind, const ReportTrace& trace) {
  return kind == FigureKind::kCurves ? thin_to_extremes(trace.y, kMaxCurvePoints)
                                     : thin_evenly(trace.x.size(), kMaxPathPoints);
}

/// What was left out of a figure, in plain words; empty if nothing was.
std::string thinning_note(FigureKind kind, std::size_t longest) {
  if (kind == FigureKind::kCurves) {
    return longest <= kMaxCurvePoints ? ""
                                      : fmt::format(
                                            "Curves of up to {} samples are drawn with at most {}: lowest "
                                            "and highest of each stretch.",
                                            longest, kMaxCurvePoints);
  }
  return longest <= kMaxPathPoints
             ? ""
             : fmt::format("Up to {} points are drawn with {}, taken evenly.", longest, kMaxPathPoints);
}

/// Turns blocks into JSON; what they share (series, ids in use) is kept here.
class DocumentWriter {
 public:
  Json operator()(const ReportText& block) { return {{"type", "text"}, {"text", block.text}}; }

  Json operator()(const ReportListing& block) {
    return {{"type", "listing"}, {"title", block.title}, {"text", block.text}};
  }

  Json operator()(const ReportFacts& block) {
    return {{"type", "facts"}, {"title", block.title}, {"facts", facts(block.facts)}};
  }

  Json operator()(const ReportClaims& block) {
    Json claims = Json::array();
    for (const ReportClaim& claim : block.claims) {
      claims.push_back({{"statement", claim.statement},
                        {"source", claim.source},
                        {"criterion", claim.criterion},
                        {"measured", claim.measured},
                        {"verdict", limber::to_string(claim.verdict)}});
    }
    return {
        {"type", "claims"}, {"title", block.title}, {"brief", block.brief}, {"claims", std::move(claims)}};
  }

  Json operator()(const ReportTable& table) {
    Json rows = Json::array();
    for (const std::vector<TableCell>& row : table.rows) {
      require(row.size() == table.columns.size(), fmt::format("table '{}' has {} columns and a row of {}",
                                                              table.title, table.columns.size(), row.size()));
      Json cells = Json::array();
      for (const TableCell& cell : row) {
        cells.push_back({{"text", cell.text}, {"mark", to_string(cell.mark)}});
      }
      rows.push_back(std::move(cells));
    }
    return {{"type", "table"},
            {"title", table.title},
            {"columns", table.columns},
            {"rows", std::move(rows)},
            {"note", table.note}};
  }

  Json operator()(const ReportFigure& figure) {
    claim_id(figure.id);
    Json json = {{"type", "figure"},
                 {"id", figure.id},
                 {"title", figure.title},
                 {"caption", figure.caption},
                 {"kind", to_string(figure.kind)},
                 {"x", to_json(figure.x)}};
    json["y"] = Json::array();
    for (const ReportAxis& axis : figure.y) {
      json["y"].push_back(to_json(axis));
    }
    json["log_switch"] = figure.log_switch;
    json["starts_in_log"] = figure.starts_in_log;
    json["half_width"] = figure.half_width;
    json["variants"] = Json::array();
    for (const FigureVariant& variant : figure.variants) {
      json["variants"].push_back({{"label", variant.label}, {"hidden_styles", variant.hidden_styles}});
    }
    std::size_t longest = 0;
    json["traces"] = Json::array();
    for (const ReportTrace& trace : figure.traces) {
      check(figure, trace);
      json["traces"].push_back(to_json(figure.kind, trace));
      longest = std::max(longest, trace.x.size());
    }
    json["note"] = thinning_note(figure.kind, longest);
    return json;
  }

  Json section(const ReportSection& section) {
    claim_id(section.id);
    Json blocks = Json::array();
    for (const ReportBlock& block : section.blocks) {
      blocks.push_back(std::visit(*this, block));
    }
    return {{"id", section.id}, {"title", section.title}, {"blocks", std::move(blocks)}};
  }

  Json facts(const std::vector<ReportFact>& facts) {
    Json out = Json::array();
    for (const ReportFact& fact : facts) {
      out.push_back({{"name", fact.name}, {"value", fact.value}});
    }
    return out;
  }

  [[nodiscard]] Json take_series() { return series_.take(); }

 private:
  Json to_json(FigureKind kind, const ReportTrace& trace) {
    const std::vector<std::size_t> drawn = drawn_samples(kind, trace);
    Json json = {{"name", trace.name},
                 {"style", trace.style},
                 {"shape", to_string(trace.shape)},
                 {"panel", trace.panel},
                 {"x", series_.add(trace.x, drawn)},
                 {"y", series_.add(trace.y, drawn)}};
    if (kind == FigureKind::kSpace) {
      json["z"] = series_.add(trace.z, drawn);
    }
    if (!trace.t.empty()) {
      json["t"] = series_.add(trace.t, drawn);
    }
    return json;
  }
  static Json to_json(const ReportAxis& axis) {
    return {{"title", axis.title}, {"unit", axis.unit}, {"log", axis.log}};
  }

  void claim_id(const std::string& id) {
    require(!id.empty() && ids_.insert(id).second, "the id '" + id + "' is empty or used twice");
  }

  SeriesPool series_;
  std::set<std::string> ids_;
};

}  // namespace

std::string report_json(const ReportDocument& document) {
  DocumentWriter writer;
  Json json;
  json["title"] = document.title;
  json["subtitle"] = document.subtitle;
  json["answer"] = to_json(document.answer);
  json["facts"] = writer.facts(document.facts);
  json["sections"] = Json::array();
  for (const ReportSection& section : document.sections) {
    json["sections"].push_back(writer.section(section));
  }
  json["footer"] = document.footer;
  json["series"] = writer.take_series();
  return detail::json_text(json);
}

}  // namespace limber
