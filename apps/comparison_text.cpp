// SPDX-License-Identifier: MIT
#include "comparison_text.hpp"

#include <fmt/format.h>

#include <optional>

#include "ordered_json.hpp"
#include "text_table.hpp"

namespace limber::app {
namespace {

std::string digits(const std::optional<double>& value) { return value ? fmt::format("{:.3g}", *value) : "-"; }

std::string two_decimals(const std::optional<double>& value) {
  return value ? fmt::format("{:.2f}", *value) : "-";
}

/// Columns that say the same of every run, or what the label says, are left out.
struct NamesShown {
  bool recording = false, method = false;
};

NamesShown names_of(const RunComparison& comparison) {
  NamesShown out;
  for (const ComparedRun& run : comparison.runs) {
    out.recording = out.recording || run.recording != comparison.runs.front().recording;
    out.method = out.method || run.label != run.method;
  }
  return out;
}

void append_names(const NamesShown& shown, const std::string& recording, const std::string& method,
                  TextRow& row) {
  if (shown.recording) {
    row.push_back(recording);
  }
  if (shown.method) {
    row.push_back(method);
  }
}

TextRow row_of(const ComparedRun& run, const NamesShown& shown) {
  TextRow row = {run.label};
  append_names(shown, run.recording, run.method, row);
  row.insert(row.end(),
             {digits(run.ate_m),
              run.rpe_percent ? fmt::format("{:.2f} / {:g} m", *run.rpe_percent, run.piece_m) : "-",
              digits(run.attitude_rmse_deg), two_decimals(run.anees),
              run.scale_error_percent ? fmt::format("{:+.2f}", *run.scale_error_percent) : "-",
              run.verdict.value_or("-"),
              fmt::format("{} ({})", two_decimals(run.ms_per_frame), two_decimals(run.ms_per_frame_p99)),
              end_in_words(run)});
  return row;
}

std::string run_table(const RunComparison& comparison) {
  const NamesShown shown = names_of(comparison);
  TextRow head = {"run"};
  append_names(shown, "recording", "method", head);
  head.insert(head.end(), {"ATE [m]", "RPE [%]", "attitude [deg]", "ANEES", "scale [%]", "calibration",
                           "ms/frame (p99)", "end"});
  std::vector<TextRow> rows = {head};
  for (const ComparedRun& run : comparison.runs) {
    rows.push_back(row_of(run, shown));
  }
  const ComparedRun& first = comparison.runs.front();
  const std::string where = shown.recording ? "several recordings"
                                            : fmt::format("{} ({:.1f} s, {:.1f} m)", first.recording,
                                                          first.duration_s, first.path_length_m);
  return fmt::format("{} run{} on {}{}\n", comparison.runs.size(), comparison.runs.size() == 1 ? "" : "s",
                     where, first.has_truth ? "" : ", whose truth is not known") +
         text_table(rows);
}

std::string difference_text(const std::optional<MeanInterval>& difference) {
  return difference ? difference_in_words(*difference) : "-";
}

TextRow row_of(const RunDifference& difference, const RunComparison& of) {
  return {of.runs[difference.run].label,
          of.runs[difference.against].label,
          difference.rpe_percent ? std::to_string(difference.rpe_percent->count) : "-",
          difference_text(difference.rpe_percent),
          difference_text(difference.rpe_deg),
          difference.ate_m ? fmt::format("{:+.3g}", *difference.ate_m) : "-",
          digits(difference.apart_rms_m),
          fmt::format("{:.3g}, {:.2g} deg", difference.apart_end_m, difference.apart_end_deg)};
}

template <typename T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json json_of(const ComparedRun& run) {
  return {{"folder", run.folder.string()},
          {"label", run.label},
          {"recording", run.recording},
          {"method", run.method},
          {"end", to_string(run.end)},
          {"lost_since_s", or_null(run.lost_since_s)},
          {"frames", run.frames},
          {"frames_of_recording", run.frames_of_recording},
          {"duration_s", run.duration_s},
          {"path_length_m", run.path_length_m},
          {"has_truth", run.has_truth},
          {"ate_m", or_null(run.ate_m)},
          {"attitude_rmse_deg", or_null(run.attitude_rmse_deg)},
          {"piece_m", run.piece_m},
          {"pieces", run.pieces},
          {"rpe_percent", or_null(run.rpe_percent)},
          {"rpe_deg", or_null(run.rpe_deg)},
          {"scale_error_percent", or_null(run.scale_error_percent)},
          {"anees", or_null(run.anees)},
          {"truth_is_tilted", run.truth_is_tilted},
          {"verdict", or_null(run.verdict)},
          {"ms_per_frame", {{"p50", or_null(run.ms_per_frame)}, {"p99", or_null(run.ms_per_frame_p99)}}}};
}

Json json_of(const std::optional<MeanInterval>& difference) {
  if (!difference) {
    return nullptr;
  }
  return {{"mean", difference->mean},
          {"low", or_null(difference->lower)},
          {"high", or_null(difference->upper)},
          {"pieces", difference->count},
          {"correlation", difference->correlation},
          {"judgement", to_string(judge(*difference))}};
}

Json json_of(const RunDifference& difference, const RunComparison& of) {
  return {{"run", of.runs[difference.run].label},
          {"against", of.runs[difference.against].label},
          {"different_assumptions", difference.assumptions},
          {"frames", difference.frames},
          {"rpe_percent", json_of(difference.rpe_percent)},
          {"rpe_deg", json_of(difference.rpe_deg)},
          {"ate_m", or_null(difference.ate_m)},
          {"apart_rms_m", difference.apart_rms_m},
          {"apart_end_m", difference.apart_end_m},
          {"apart_end_deg", difference.apart_end_deg}};
}

}  // namespace

std::string to_text(const RunComparison& comparison) {
  std::string out = run_table(comparison);
  if (!comparison.differences.empty()) {
    std::vector<TextRow> rows = {{"run", "minus", "pieces", "RPE [%], 95 %", "RPE [deg a piece], 95 %",
                                  "ATE [m]", "apart [m]", "at the end [m]"}};
    for (const RunDifference& difference : comparison.differences) {
      rows.push_back(row_of(difference, comparison));
    }
    out += "\nDifferences, piece by piece of the path\n" + text_table(rows);
  }
  for (const std::string& note : comparison.notes) {
    out += "\nNote: " + note;
  }
  return out + (comparison.notes.empty() ? "" : "\n");
}

std::string to_json(const RunComparison& comparison) {
  Json json = {{"runs", Json::array()}, {"differences", Json::array()}, {"notes", comparison.notes}};
  for (const ComparedRun& run : comparison.runs) {
    json["runs"].push_back(json_of(run));
  }
  for (const RunDifference& difference : comparison.differences) {
    json["differences"].push_back(json_of(difference, comparison));
  }
  return json_text(json);
}

}  // namespace limber::app
