// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <utility>

#include "run_sections.hpp"

namespace limber::detail {
namespace {

/// Leaves out what is not known.
void add_fact(const std::string& name, std::optional<double> value, const char* unit,
              std::vector<ReportFact>& out) {
  if (value) {
    out.push_back({name, fmt::format("{:.4g}{}{}", *value, *unit == '\0' ? "" : " ", unit)});
  }
}

std::string capitalised(std::string text) {
  if (!text.empty()) {
    text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  }
  return text;
}

/// As a page has it: summary.json says it as the terminal does.
std::string as_sentence(const std::string& text) {
  return capitalised(text) + (text.empty() || text.back() == '.' ? "" : ".");
}

ReportAnswer::Light light_of(const std::string& name) {
  using Light = ReportAnswer::Light;
  return name == "green"    ? Light::kGreen
         : name == "yellow" ? Light::kYellow
         : name == "red"    ? Light::kRed
                            : Light::kGrey;
}

bool is_level(const Json& summary) { return summary.value("truth_is_level", Json()) != false; }

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

ReportAnswer answer_of(const Json& summary) {
  ReportAnswer out;
  const Json answer = summary.value("answer", Json());
  if (answer.is_object()) {
    out.light = light_of(answer.value("light", ""));
    out.headline = answer.value("headline", "");
    out.sentences = answer.value("sentences", std::vector<std::string>());
    out.advice = as_sentence(answer.value("advice", ""));
  } else {  // of an older version
    const Json health = summary.value("health", Json());
    const std::string verdict = health.is_object() ? health.value("verdict", "") : "not judged";
    out.light = light_of(verdict == "ok"             ? "green"
                         : verdict == "degraded"     ? "yellow"
                         : verdict == "decalibrated" ? "red"
                                                     : "grey");
    out.headline = "calibration: " + verdict;
    if (!is_level(summary)) {
      out.sentences.push_back("errors, bounds and ANEES are of the aligned poses: without the " +
                              in_words(summary["alignment"]));
    }
  }
  out.headline = capitalised(out.headline);
  std::transform(out.sentences.begin(), out.sentences.end(), out.sentences.begin(), as_sentence);
  return out;
}

std::vector<ReportFact> lead_facts(const Json& s) {
  const std::string aligned = is_level(s) ? "" : ", aligned";
  std::vector<ReportFact> out;
  add_fact("position RMSE" + aligned, number_at(s, {"position_rmse_m"}), "m", out);
  add_fact("attitude RMSE" + aligned, number_at(s, {"attitude_rmse_deg"}), "deg", out);
  add_fact("ATE, SE(3)", number_at(s, {"ate_m", "se3"}), "m", out);
  add_fact("ANEES (ideal: 1)" + aligned, number_at(s, {"anees"}), "", out);
  add_fact("path", number_at(s, {"path_length_m"}), "m", out);
  add_fact("frame, median", number_at(s, {"ms_per_frame", "p50"}), "ms", out);
  return out;
}

ReportSection summary_section(const RunFolder& run) {
  Json rest = run.summary;
  const Json options = rest.value("options", Json::object());
  const Json notes = rest.value("notes", Json::array());
  rest.erase("options");
  rest.erase("notes");
  rest.erase("answer");
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
