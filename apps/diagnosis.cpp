// SPDX-License-Identifier: MIT
#include "diagnosis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "commands.hpp"
#include "limber/core/angle.hpp"
#include "ordered_json.hpp"

namespace limber::app {
namespace {

constexpr const char* kLostAdvice =
    "find out what failed first: limber run says since when, and what images and inputs contradict";

bool is_lost(const Diagnosis& diagnosis) { return diagnosis.mistakes.empty() && diagnosis.lost_since_s; }

std::string advice(const Diagnosis& diagnosis) {
  if (!diagnosis.mistakes.empty()) {
    return kMistakeAdvice;
  }
  if (!diagnosis.readout_contradicted.empty()) {
    return kReadoutAdvice;
  }
  if (!clock_mistakes(diagnosis.offsets).empty()) {
    return kClockAdvice;
  }
  if (const auto mistakes = camera_imu_mistakes(diagnosis.offsets); !mistakes.empty()) {
    return mistakes.front().advice;
  }
  if (is_lost(diagnosis) && !is_wrong(verdict_of(diagnosis))) {
    return kLostAdvice;
  }
  return advice_on(verdict_of(diagnosis), diagnosis.health && diagnosis.health->present.moves());
}

/// A clock that is off may be why the rig looks as it does.
bool clocks_hide_rig(const Diagnosis& diagnosis) {
  return diagnosis.mistakes.empty() && verdict_of(diagnosis) == HealthVerdict::kCannotTell &&
         diagnosis.health->verdict != HealthVerdict::kCannotTell;
}

std::vector<std::string> all_mistakes(const Diagnosis& diagnosis) {
  std::vector<std::string> out = diagnosis.mistakes;
  if (!diagnosis.readout_contradicted.empty()) {
    out.push_back(diagnosis.readout_contradicted);
  }
  const std::vector<std::string> of_offsets = offset_mistakes(diagnosis.offsets);
  out.insert(out.end(), of_offsets.begin(), of_offsets.end());
  return out;
}

template <typename Out>
void add_effect(Out out, const char* name, const SizeInterval& size, const Band& band, double unit,
                const char* unit_name, HealthVerdict verdict) {
  fmt::format_to(out, "{:<26} {:>8.3f} {:>8.3f} {:>8.3f} {:>8.3g} {:>8.3g}  {:<4}{}\n", name,
                 unit * size.size, unit * size.low, unit * size.high, unit * band.ok, unit * band.wrong,
                 unit_name, to_string(verdict));
}

std::string limit_text(double limit) { return std::isfinite(limit) ? fmt::format("{:.3f}", limit) : "–"; }

template <typename Out>
void add_axes(Out out, const CalibrationState& state, const char* what) {
  const RigParameters delta = in_degrees_and_mm(state.estimate.delta);
  const RigParameters sigma = in_degrees_and_mm(state.estimate.sigma());
  const RigParameters unit = in_degrees_and_mm(RigParameters::Ones());
  fmt::format_to(out, "\n{:<22}{:>15}{:>10}{:>10}{:>9}\n", "cam1 against cam0", what, "± sigma", "ok up to",
                 "wrong");
  for (std::size_t k = 0; k < 6; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    fmt::format_to(out, "{}  {:<18}{:>+15.4f} {:>9.4f} {:>9} {:>8}  {:<4}{}{}\n", kParameterNames[k],
                   axis_in_words(k, state.vergence), delta(i), sigma(i),
                   limit_text(unit(i) * state.bands[k].ok), limit_text(unit(i) * state.bands[k].wrong),
                   k < 3 ? "deg" : "mm", to_string(state.axes[k]),
                   state.named == k ? ", explains it best" : "");
  }
}

/// Sizes with their intervals against the tolerance.
template <typename Out>
void add_state(Out out, const CalibrationState& state, const Tolerance& tolerance) {
  fmt::format_to(out, "\n{:<26}{:>9}{:>9}{:>9}{:>9}{:>9}\n", "", "size", "from", "to 95 %", "ok up to",
                 "wrong");
  add_effect(out, "off the epipolar line", state.effect.epipolar_px, tolerance.epipolar_px, 1.0, "px",
             state.by_epipolar);
  add_effect(out, "moves from frame to frame", state.movement.px, tolerance.epipolar_px, 1.0, "px",
             state.by_movement);
  add_effect(out, "and so do depths", state.depth_movement.share, tolerance.depth, 100.0, "%",
             state.by_depth_movement);
  add_effect(out, fmt::format("depth at {:g} baselines", tolerance.baselines).c_str(), state.effect.depth,
             tolerance.depth, 100.0, "%", state.by_depth);
  add_axes(out, state, "true - assumed");
}

template <typename Out>
void add_past(Out out, const HealthSummary& health) {
  if (health.past.empty()) {
    fmt::format_to(out, "no change in {:.1f} s\n", health.seconds(health.present.to_ns));
    return;
  }
  for (const CalibrationState& state : health.past) {
    fmt::format_to(out, "{:.1f} to {:.1f} s: {}, {:.2f} px, {:.1f} % of depth\n",
                   health.seconds(state.from_ns), health.seconds(state.to_ns), to_string(state.verdict),
                   state.effect.epipolar_px.size, 100.0 * state.effect.depth.size);
  }
  fmt::format_to(out, "since {:.1f} s: as above\n", health.seconds(health.present.from_ns));
}

template <typename Out>
void add_depths(Out out, const Diagnosis& diagnosis) {
  fmt::format_to(out, "\nA depth measured straight ahead with this calibration{}\n",
                 diagnosis.metric ? "" : ", if its baseline is as long as it says");
  for (const DepthEffect& effect : diagnosis.depths) {
    if (effect.error) {
      fmt::format_to(out, "  at {:>2.0f} m  is wrong by {:+.3f} ± {:.3f} m ({:+.2f} %)\n", effect.depth,
                     *effect.error, effect.sigma, 100.0 * *effect.error / effect.depth);
    } else {
      fmt::format_to(out, "  at {:>2.0f} m  cannot be measured: the rays do not meet\n", effect.depth);
    }
  }
}

Json json_of(const std::optional<SinceThen>& since, const Tolerance& tolerance) {
  if (!since) {
    return nullptr;
  }
  Json out = {{"recording", since->recording}};
  out.update(Json::parse(change_json(since->change, tolerance)));
  return out;
}

Json json_of(const std::optional<PoseLoss>& pose) {
  return pose ? Json{{"path_m", pose->path_m},
                     {"scale", pose->scale},
                     {"drift_per_100_m", pose->drift_per_100_m},
                     {"turn_deg", pose->turn_deg}}
              : Json(nullptr);
}

Json json_of(const std::optional<TimeOffset>& offset) {
  return offset ? Json{{"ms", 1e3 * offset->seconds}, {"sigma_ms", 1e3 * offset->sigma}} : Json(nullptr);
}

Json json_of(const std::optional<MountTurn>& mount) {
  const Eigen::Vector3d deg = mount ? Eigen::Vector3d(kToDegrees * mount->turn) : Eigen::Vector3d::Zero();
  return mount ? Json{{"imu-ax_deg", deg.x()},
                      {"imu-ay_deg", deg.y()},
                      {"imu-az_deg", deg.z()},
                      {"sigma_deg", kToDegrees * mount->sigma}}
               : Json(nullptr);
}

Json json_of(const std::optional<TurnScale>& scale) {
  return scale ? Json{{"of", to_string(scale->of)},
                      {"excess_percent", 100.0 * scale->excess},
                      {"sigma_percent", 100.0 * scale->sigma}}
               : Json(nullptr);
}

Json json_of(const std::optional<InertialCheck>& check) {
  if (!check) {
    return nullptr;
  }
  Json out = Json::array();
  for (const InertialOffset& offset : check->offsets) {
    out.push_back({{"of", to_string(offset.of)},
                   {"size", offset.value.norm()},
                   {"sigma", offset.sigma},
                   {"sureness", offset.sureness}});
  }
  return out;
}

/// As in summary.json.
Json health_json(const Diagnosis& diagnosis) {
  if (!diagnosis.health) {
    return nullptr;
  }
  Json out = Json::parse(limber::to_json(*diagnosis.health, diagnosis.judged_by));
  out["verdict"] = to_string(verdict_beside(diagnosis.offsets, *diagnosis.health));
  return out;
}

}  // namespace

HealthVerdict verdict_of(const Diagnosis& diagnosis) {
  if (!diagnosis.mistakes.empty()) {
    return HealthVerdict::kDecalibrated;
  }
  if (!diagnosis.readout_contradicted.empty()) {
    return HealthVerdict::kCannotTell;
  }
  return diagnosis.health ? verdict_beside(diagnosis.offsets, *diagnosis.health) : HealthVerdict::kCannotTell;
}

int exit_code(HealthVerdict verdict) {
  switch (verdict) {
    case HealthVerdict::kOk:
      return kExitDone;
    case HealthVerdict::kSuspect:
    case HealthVerdict::kDegraded:
      return kExitDegraded;
    case HealthVerdict::kDecalibrated:
      return kExitDecalibrated;
    case HealthVerdict::kCannotTell:
      break;
  }
  return kExitCannotTell;
}

std::string to_text(const Diagnosis& diagnosis) {
  std::string text = fmt::format("{}: {}\n", diagnosis.dataset, to_string(verdict_of(diagnosis)));
  auto out = std::back_inserter(text);
  if (diagnosis.stopped) {
    fmt::format_to(out, "Partial: stopped after {} of {} frames; all of this is of those\n", diagnosis.frames,
                   diagnosis.frames_of_recording);
  }
  for (const std::string& mistake : all_mistakes(diagnosis)) {
    fmt::format_to(out, "Looks like a mistake: {}\n", mistake);
  }
  if (!diagnosis.readout_contradicted.empty()) {
    fmt::format_to(out,
                   "the rig is not judged: rows with times of their own look like a rig that bends while it "
                   "moves; what follows has them in it\n");
  } else if (is_lost(diagnosis)) {
    fmt::format_to(
        out,
        "the run is lost since {:.1f} s: the rig is judged by its epipolar lines alone; what follows "
        "of depths, and of the pose, says nothing\n",
        *diagnosis.lost_since_s);
  } else if (diagnosis.health && clocks_hide_rig(diagnosis)) {
    fmt::format_to(out, "{}; what follows has it in it\n", kClocksHideRig);
  } else if (diagnosis.health) {
    fmt::format_to(out, "{}\n", in_words(*diagnosis.health, diagnosis.judged_by.tolerance));
  }
  if (const auto corrected = corrected_clock_in_words(diagnosis.offsets)) {
    fmt::format_to(out, "{}\n", *corrected);
  }
  if (diagnosis.pose) {
    fmt::format_to(out,
                   "What the pose loses: ekf drifts {:.2f} m per 100 m from lcekf, scale {:.4f} ({:.0f} m)\n",
                   diagnosis.pose->drift_per_100_m, diagnosis.pose->scale, diagnosis.pose->path_m);
  }
  if (!diagnosis.ekf_failure.empty()) {
    fmt::format_to(out, "What the pose loses: ekf fails: {}\n", diagnosis.ekf_failure);
  }
  if (diagnosis.since) {
    fmt::format_to(out, "Since {}: {}\n", diagnosis.since->recording,
                   change_in_words(diagnosis.since->change, diagnosis.judged_by.tolerance));
  }
  fmt::format_to(out, "What to do: {}\n", advice(diagnosis));
  if (!diagnosis.failure.empty()) {
    fmt::format_to(out, "\nno run was possible: {}\n", diagnosis.failure);
    return text;
  }
  fmt::format_to(out, "\n{} frames in {:.1f} s; ", diagnosis.frames, diagnosis.duration_s);
  if (!diagnosis.health) {
    fmt::format_to(out,
                   "no window of {:g} s had points that could be judged: too few, or too many of them "
                   "matched wrongly\n",
                   diagnosis.judged_by.window_s);
    return text;
  }
  add_past(out, *diagnosis.health);
  add_state(out, diagnosis.health->present, diagnosis.judged_by.tolerance);
  if (diagnosis.since) {
    fmt::format_to(out, "\nHow it moved since {}", diagnosis.since->recording);
    add_axes(out, diagnosis.since->change, "now - then");
  }
  add_depths(out, diagnosis);
  return text;
}

std::string to_json(const Diagnosis& diagnosis) {
  Json depths = Json::array();
  for (const DepthEffect& effect : diagnosis.depths) {
    depths.push_back({{"depth_m", effect.depth},
                      {"error_m", effect.error ? Json(*effect.error) : Json(nullptr)},
                      {"sigma_m", effect.sigma}});
  }
  const Json json = {
      {"dataset", diagnosis.dataset},
      {"verdict", to_string(verdict_of(diagnosis))},
      {"frames", diagnosis.frames},
      {"complete", !diagnosis.stopped},
      {"duration_s", diagnosis.duration_s},
      {"lost_since_s", diagnosis.lost_since_s ? Json(*diagnosis.lost_since_s) : Json(nullptr)},
      {"nis_per_dof", diagnosis.nis_per_dof ? Json(*diagnosis.nis_per_dof) : Json(nullptr)},
      {"health", health_json(diagnosis)},
      {"since", json_of(diagnosis.since, diagnosis.judged_by.tolerance)},
      {"depths", depths},
      {"ekf_beside_lcekf", json_of(diagnosis.pose)},
      {"ekf_failure", diagnosis.ekf_failure.empty() ? Json(nullptr) : Json(diagnosis.ekf_failure)},
      {"mistakes", all_mistakes(diagnosis)},
      {"time_offset_cam1_cam0", json_of(diagnosis.offsets.cam1)},
      {"time_offset_cameras_imu", json_of(diagnosis.offsets.cameras)},
      {"mount_turn", json_of(diagnosis.offsets.mount)},
      {"turn_scale", json_of(surest_scale(diagnosis.offsets))},
      {"inertial_offsets", json_of(diagnosis.offsets.inertial)},
      {"readout_time", diagnosis.readout ? Json{{"ms", 1e3 * diagnosis.readout->seconds},
                                                {"sigma_ms", 1e3 * diagnosis.readout->sigma}}
                                         : Json(nullptr)},
      {"failure", diagnosis.failure.empty() ? Json(nullptr) : Json(diagnosis.failure)},
      {"advice", advice(diagnosis)}};
  return json_text(json);
}

}  // namespace limber::app
