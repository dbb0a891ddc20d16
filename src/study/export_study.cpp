// SPDX-License-Identifier: MIT
#include "limber/study/export_study.hpp"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>

#include "figures_table.hpp"
#include "io/json_text.hpp"
#include "limber/io/atomic_file.hpp"
#include "limber/study/curve.hpp"

namespace limber {
namespace {

using Json = nlohmann::ordered_json;

std::filesystem::path beside(const std::filesystem::path& database, const std::string& suffix) {
  return database.parent_path() / (database.stem().string() + suffix);
}

/// A cell of CSV: quoted where it has to be.
std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) {
    return text;
  }
  std::string out = "\"";
  for (const char c : text) {
    out += c == '"' ? "\"\"" : std::string(1, c);
  }
  return out + "\"";
}

void each_method(const StudyDatabase& study,
                 const std::function<void(const StudyCaseInfo&, std::size_t, std::size_t)>& visit) {
  for (std::size_t c = 0; c < study.info().cases.size(); ++c) {
    for (std::size_t m = 0; m < study.info().cases[c].methods.size(); ++m) {
      visit(study.info().cases[c], c, m);
    }
  }
}

std::string runs_csv(const StudyDatabase& study) {
  std::string text = "case,method,run,diverged_frame,diverged_s,diverged_reason";
  auto out = std::back_inserter(text);
  const RunFigures names;
  detail::visit_figures(names, [&](const char* name, const auto&) { fmt::format_to(out, ",{}", name); });
  text += '\n';
  each_method(study, [&](const StudyCaseInfo& info, std::size_t c, std::size_t m) {
    for (const StudyRun& run : study.runs(c, m)) {
      fmt::format_to(out, "{},{},{},", quoted(info.name), quoted(info.labels[m]), run.run);
      if (run.diverged) {
        fmt::format_to(out, "{},{},{}", run.diverged->frame, run.diverged->t, quoted(run.diverged->reason));
      } else {
        text += ",,";
      }
      detail::visit_figures(run.figures, [&](const char*, const auto& figure) {
        fmt::format_to(out, ",{}", figure ? fmt::format("{}", *figure) : "");
      });
      text += '\n';
    }
  });
  return text;
}

CurveQuantity quantity_at(std::size_t index) { return static_cast<CurveQuantity>(index); }

std::string curves_csv(const StudyDatabase& study) {
  std::string text = "case,method,t [s],runs";
  auto out = std::back_inserter(text);
  for (std::size_t q = 0; q < kCurveQuantities; ++q) {
    fmt::format_to(out, ",{} [{}]", name_of(quantity_at(q)), unit_of(quantity_at(q)));
  }
  text += '\n';
  each_method(study, [&](const StudyCaseInfo& info, std::size_t c, std::size_t m) {
    std::vector<std::optional<StudyCurve>> curves;
    for (std::size_t q = 0; q < kCurveQuantities; ++q) {
      curves.push_back(study.curve(c, m, quantity_at(q)));
    }
    for (std::size_t k = 0; curves.front() && k < info.frame_times.size(); ++k) {
      fmt::format_to(out, "{},{},{},{}", quoted(info.name), quoted(info.labels[m]), info.frame_times[k],
                     curves.front()->count[k]);
      for (const std::optional<StudyCurve>& curve : curves) {
        const bool known = curve && std::isfinite(curve->mean[k]);
        fmt::format_to(out, ",{}", known ? fmt::format("{}", curve->mean[k]) : "");
      }
      text += '\n';
    }
  });
  return text;
}

Json run_json(const StudyRun& run) {
  Json json;
  json["run"] = run.run;
  json["diverged"] =
      run.diverged
          ? Json{{"frame", run.diverged->frame}, {"t_s", run.diverged->t}, {"reason", run.diverged->reason}}
          : Json(nullptr);
  detail::visit_figures(run.figures, [&](const char* name, const auto& figure) {
    json[name] = figure ? Json(*figure) : Json(nullptr);
  });
  return json;
}

Json method_json(const StudyDatabase& study, const StudyCaseInfo& info, std::size_t c, std::size_t m) {
  Json json;
  json["method"] = info.labels[m];
  json["runs"] = Json::array();
  for (const StudyRun& run : study.runs(c, m)) {
    json["runs"].push_back(run_json(run));
  }
  json["curves"] = Json::object();
  for (std::size_t q = 0; q < kCurveQuantities; ++q) {
    if (const auto curve = study.curve(c, m, quantity_at(q))) {
      json["curves"][std::string(name_of(quantity_at(q)))] = {
          {"unit", unit_of(quantity_at(q))}, {"mean", curve->mean}, {"runs", curve->count}};
    }
  }
  return json;
}

}  // namespace

std::vector<std::filesystem::path> export_csv(const StudyDatabase& study,
                                              const std::filesystem::path& database) {
  const auto runs = beside(database, "_runs.csv"), curves = beside(database, "_curves.csv");
  write_file_atomically(runs, runs_csv(study));
  write_file_atomically(curves, curves_csv(study));
  return {runs, curves};
}

std::vector<std::filesystem::path> export_json(const StudyDatabase& study,
                                               const std::filesystem::path& database) {
  Json json;
  json["program_version"] = study.info().program_version;
  json["seed"] = study.info().seed;
  json["cases"] = Json::array();
  for (const StudyCaseInfo& info : study.info().cases) {
    json["cases"].push_back({{"name", info.name},
                             {"scenario", info.scenario_text},
                             {"runs", info.runs},
                             {"finished", info.finished},
                             {"t_s", info.frame_times},
                             {"methods", Json::array()}});
  }
  each_method(study, [&](const StudyCaseInfo& info, std::size_t c, std::size_t m) {
    json["cases"][c]["methods"].push_back(method_json(study, info, c, m));
  });
  const auto path = beside(database, ".json");
  write_file_atomically(path, detail::json_text(json, 1) + "\n");
  return {path};
}

}  // namespace limber
