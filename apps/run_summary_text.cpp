// SPDX-License-Identifier: MIT
#include "run_summary_text.hpp"

#include <fmt/format.h>

#include <optional>
#include <string>

#include "limber/diagnose/run_answer.hpp"
#include "limber/io/parameter_text.hpp"

namespace limber::app {
namespace {

std::string text_of(const std::optional<double>& value, const char* unit, int digits = 4) {
  return value ? fmt::format("{:.{}f}{}", *value, digits, unit) : std::string("unknown");
}

void print_estimated(const CalibrationEstimate& estimate) {
  const char* heading = "estimated";
  const ParameterSet told = told_parameters(estimate);
  for (std::size_t k = 0; k < kParameterNames.size(); ++k) {
    if (!told[k]) continue;
    const auto at = static_cast<Eigen::Index>(k);
    fmt::print("  {:<16}{:<7} {:+.3g} ± {:.2g} {} (true - assumed)\n", heading, kParameterNames[k],
               in_user_units(k, estimate.error(at)), in_user_units(k, estimate.sigma(at)), user_unit_of(k));
    heading = "";
  }
}

}  // namespace

void print_run_summary(const RunOptions& options, const RunRecord& record, const RunSummary& s,
                       const std::filesystem::path& folder) {
  fmt::print("{} on {}\n", s.method, s.dataset);
  const RunAnswer answer = answer_of(options, record, s);
  fmt::print("  answer          {}\n", answer.headline);
  for (const std::string& sentence : answer.sentences) {
    fmt::print("                  {}\n", sentence);
  }
  fmt::print("  what to do      {}\n", answer.advice);
  fmt::print("  frames          {} in {:.1f} s, {:.1f} points a frame, {} refused in all\n", s.frames,
             s.duration_s, s.points_per_frame, s.points_refused);
  fmt::print("  path            {:.2f} m\n", s.path_length_m);
  fmt::print("  ATE             SE(3) {}, Sim(3) {}, scale {}\n", text_of(s.ate_se3_m, " m"),
             text_of(s.ate_sim3_m, " m"), text_of(s.scale, ""));
  fmt::print("  RMSE            position {}, attitude {}\n", text_of(s.position_rmse_m, " m"),
             text_of(s.attitude_rmse_deg, " deg"));
  fmt::print("  consistency     ANEES {} (1 = consistent), NIS per d.o.f. {}\n", text_of(s.anees, "", 2),
             text_of(s.nis_per_dof, "", 2));
  if (!record.calibration.empty()) {
    print_estimated(record.calibration.back().estimate);
  }
  fmt::print(
      "  time            p50 {:.2f} ms, p99 {:.2f} ms, worst {:.2f} ms a frame, {:.1f} times real time\n",
      s.ms_per_frame_p50, s.ms_per_frame_p99, s.ms_per_frame_worst, s.realtime_factor);
  if (s.start_ms) {
    fmt::print("  start           {:.0f} ms, of which the longest frame took {:.0f} ms\n", *s.start_ms,
               *s.start_worst_ms);
  }
  if (const auto& f = s.frontend) {
    fmt::print(
        "  images          decoding p50 {:.2f} ms, p99 {:.2f} ms; tracking {:.2f} ms, {:.2f} ms; to the "
        "state {:.2f} ms, "
        "{:.2f} ms\n",
        f->decode.p50, f->decode.p99, f->track.p50, f->track.p99, f->end_to_end.p50, f->end_to_end.p99);
    fmt::print(
        "  tracks          {:.1f} points in the left image, {:.1f} in the right one, {:.1f} frames a track\n",
        f->left_points, f->right_points, f->frames_per_track);
  }
  fmt::print("  results in      {}\n", folder.string());
}

}  // namespace limber::app
