// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <optional>
#include <utility>

#include "run_sections.hpp"

namespace limber::detail {
namespace {

std::string with_unit(std::optional<double> value, const char* unit) {
  return value ? fmt::format("{:.4g}{}{}", *value, *unit == '\0' ? "" : " ", unit) : "unknown";
}

/// Names and values of a JSON object; what is nested gets the outer name before its own.
void add_facts(const Json& object, const std::string& prefix, std::vector<ReportFact>& out) {
  for (const auto& [key, value] : object.items()) {
    if (value.is_object()) {
      add_facts(value, prefix + key + ".", out);
    } else {
      out.push_back({prefix + key, in_words(value)});
    }
  }
}

}  // namespace

std::string in_words(const Json& value) {
  if (value.is_null()) {
    return "–";
  }
  if (value.is_boolean()) {
    return value.get<bool>() ? "on" : "off";
  }
  if (value.is_string()) {
    return value.get<std::string>();
  }
  if (value.is_array()) {
    std::string text;
    for (const Json& item : value) {
      text += (text.empty() ? "" : ", ") + in_words(item);
    }
    return text;
  }
  return value.is_number_float() ? fmt::format("{:.6g}", value.get<double>()) : value.dump();
}

std::vector<ReportFact> lead_facts(const Json& s) {
  return {{"position RMSE", with_unit(number_at(s, {"position_rmse_m"}), "m")},
          {"attitude RMSE", with_unit(number_at(s, {"attitude_rmse_deg"}), "deg")},
          {"ATE, SE(3)", with_unit(number_at(s, {"ate_m", "se3"}), "m")},
          {"ANEES (1 = consistent)", with_unit(number_at(s, {"anees"}), "")},
          {"path", with_unit(number_at(s, {"path_length_m"}), "m")},
          {"frame, median", with_unit(number_at(s, {"ms_per_frame", "p50"}), "ms")}};
}

ReportSection summary_section(const RunFolder& run) {
  Json rest = run.summary;
  const Json options = rest.value("options", Json::object());
  const Json notes = rest.value("notes", Json::array());
  rest.erase("options");
  rest.erase("notes");
  ReportSection section{"summary", "Options and summary", {}};
  ReportFacts chosen{"Options, as in summary.json (–: limber chose, see below)", {}},
      found{"The rest of summary.json (–: not known)", {}};
  add_facts(options, "", chosen.facts);
  add_facts(rest, "", found.facts);
  if (!chosen.facts.empty()) {
    section.blocks.emplace_back(std::move(chosen));
  }
  if (!notes.empty()) {
    section.blocks.emplace_back(ReportText{"Chosen on the user's behalf, or noticed on the way:"});
    for (const Json& note : notes) {
      section.blocks.emplace_back(ReportText{"• " + in_words(note)});
    }
  }
  section.blocks.emplace_back(std::move(found));
  return section;
}

}  // namespace limber::detail
