// SPDX-License-Identifier: MIT
#include "diagnosis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "commands.hpp"

namespace limber::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array kAxisWords = {"nod, about x",   "vergence, about y", "roll, about z",
                                   "right, along x", "down, along y",     "forward, along z"};
constexpr double kSignificant = 5.0;                      // standard deviations of a time offset ...
constexpr double kLeastCam1 = 1e-3, kLeastCamera = 3e-3;  // ... that is at least that large [s]
constexpr double kAtTheStart = 5.0;                       // [s] a change that early was there before

std::string_view conclusion(HealthVerdict verdict) {
  switch (verdict) {
    case HealthVerdict::kOk:
      return "what was seen agrees with the calibration";
    case HealthVerdict::kSuspect:
      return "what was seen hardly agrees with the calibration, but there was no alarm";
    case HealthVerdict::kDecalibrated:
      return "the calibration is not that of this rig";
    case HealthVerdict::kCannotTell:
      break;
  }
  return "the points and the motion are too weak to judge the calibration";
}

std::string advice(const Diagnosis& diagnosis) {
  switch (verdict_of(diagnosis)) {
    case HealthVerdict::kOk:
      return "nothing; --method ekf gets the most out of a sound rig";
    case HealthVerdict::kSuspect:
      return "record longer, with more motion, and look again";
    case HealthVerdict::kDecalibrated:
      return diagnosis.mistakes.empty()
                 ? "recalibrate; until then --method lcekf or adaptive, which do not rely on the calibration"
                 : "mend the mistake below, and look again";
    case HealthVerdict::kCannotTell:
      break;
  }
  return "record more motion: turn and tilt the rig, with at least twenty points in both cameras, some of "
         "them "
         "nearer than a hundred baselines";
}

std::optional<std::string> offset_in_words(const std::optional<TimeOffset>& offset, double least,
                                           const char* what) {
  if (!offset || std::abs(offset->seconds) < std::max(least, kSignificant * offset->sigma)) {
    return std::nullopt;
  }
  return fmt::format("{} {:.1f} ± {:.1f} ms {} than stamped: it looks like a rig that bends while it moves",
                     what, 1e3 * std::abs(offset->seconds), 1e3 * offset->sigma,
                     offset->seconds > 0.0 ? "later" : "earlier");
}

std::vector<std::string> all_mistakes(const Diagnosis& diagnosis) {
  std::vector<std::string> out = diagnosis.mistakes;
  for (const auto& words :
       {offset_in_words(diagnosis.cam1_offset, kLeastCam1, "time offset: beside cam0, cam1 is taken"),
        offset_in_words(diagnosis.camera_offset, kLeastCamera,
                        "time offset: beside the IMU, the cameras are taken")}) {
    if (words) {
      out.push_back(*words);
    }
  }
  return out;
}

template <typename Out>
void add_axes(Out out, const HealthSummary& health) {
  const RigParameters delta = in_degrees_and_mm(health.since_change.delta);
  const RigParameters sigma = in_degrees_and_mm(health.since_change.sigma);
  fmt::format_to(out, "\n{:<24}{:>15}{:>12}\n", "cam1 against cam0", "true - assumed", "± sigma");
  for (std::size_t k = 0; k < 6; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    fmt::format_to(out, "{}  {:<20}{:>+15.4f}{:>12.4f} {:<4}{}\n", kParameterNames[k], kAxisWords[k],
                   delta(i), sigma(i), k < 3 ? "deg" : "mm",
                   health.axes[k] == HealthVerdict::kDecalibrated ? "MOVED" : to_string(health.axes[k]));
  }
}

template <typename Out>
void add_depths(Out out, const std::vector<DepthEffect>& depths) {
  fmt::format_to(out, "\nA depth measured straight ahead with this calibration\n");
  for (const DepthEffect& effect : depths) {
    if (effect.error) {
      fmt::format_to(out, "  at {:>2.0f} m  is wrong by {:+.3f} ± {:.3f} m ({:+.2f} %)\n", effect.depth,
                     *effect.error, effect.sigma, 100.0 * *effect.error / effect.depth);
    } else {
      fmt::format_to(out, "  at {:>2.0f} m  cannot be measured: the rays do not meet\n", effect.depth);
    }
  }
}

template <typename Out>
void add_certainty(Out out, const Diagnosis& diagnosis) {
  const HealthSummary& health = *diagnosis.health;
  if (!health.first_alarm_s) {
    fmt::format_to(out, "no alarm at {:g} false alarms per hour; smallest p-value {:.2g}\n",
                   diagnosis.false_alarms_per_hour, health.p_value);
    return;
  }
  fmt::format_to(out, "alarm after {:.2f} s at {:g} false alarms per hour, p-value {:.2g}; since {}\n",
                 *health.first_alarm_s, diagnosis.false_alarms_per_hour, health.p_value,
                 *health.changed_s < kAtTheStart ? std::string("the start of the recording")
                                                 : fmt::format("{:.2f} s", *health.changed_s));
}

Json json_of(const std::optional<TimeOffset>& offset) {
  return offset ? Json{{"ms", 1e3 * offset->seconds}, {"sigma_ms", 1e3 * offset->sigma}} : Json(nullptr);
}

}  // namespace

HealthVerdict verdict_of(const Diagnosis& diagnosis) {
  if (!diagnosis.mistakes.empty()) {
    return HealthVerdict::kDecalibrated;
  }
  return diagnosis.health ? diagnosis.health->verdict : HealthVerdict::kCannotTell;
}

int exit_code(HealthVerdict verdict) {
  switch (verdict) {
    case HealthVerdict::kOk:
      return kExitDone;
    case HealthVerdict::kSuspect:
      return kExitSuspect;
    case HealthVerdict::kDecalibrated:
      return kExitDecalibrated;
    case HealthVerdict::kCannotTell:
      break;
  }
  return kExitCannotTell;
}

std::string to_text(const Diagnosis& diagnosis) {
  const HealthVerdict verdict = verdict_of(diagnosis);
  std::string text = fmt::format("{}: {}, {}\n", diagnosis.dataset, to_string(verdict), conclusion(verdict));
  auto out = std::back_inserter(text);
  if (!diagnosis.failure.empty()) {
    fmt::format_to(out, "no run was possible: {}\n", diagnosis.failure);
  } else {
    fmt::format_to(out, "{} frames in {:.1f} s; ", diagnosis.frames, diagnosis.duration_s);
  }
  if (diagnosis.health) {
    add_certainty(out, diagnosis);
    add_axes(out, *diagnosis.health);
    add_depths(out, diagnosis.depths);
  } else if (diagnosis.failure.empty()) {
    fmt::format_to(out, "no frame had points that could be judged\n");
  }
  fmt::format_to(out, "\nWhat to do: {}\n", advice(diagnosis));
  for (const std::string& mistake : all_mistakes(diagnosis)) {
    fmt::format_to(out, "Looks like a mistake: {}\n", mistake);
  }
  return text;
}

std::string to_json(const Diagnosis& diagnosis) {
  Json depths = Json::array();
  for (const DepthEffect& effect : diagnosis.depths) {
    depths.push_back({{"depth_m", effect.depth},
                      {"error_m", effect.error ? Json(*effect.error) : Json(nullptr)},
                      {"sigma_m", effect.sigma}});
  }
  const Json json = {{"dataset", diagnosis.dataset},
                     {"verdict", to_string(verdict_of(diagnosis))},
                     {"frames", diagnosis.frames},
                     {"duration_s", diagnosis.duration_s},
                     {"nis_per_dof", diagnosis.nis_per_dof ? Json(*diagnosis.nis_per_dof) : Json(nullptr)},
                     {"health", diagnosis.health ? Json::parse(limber::to_json(
                                                       *diagnosis.health, diagnosis.false_alarms_per_hour))
                                                 : Json(nullptr)},
                     {"depths", depths},
                     {"mistakes", all_mistakes(diagnosis)},
                     {"time_offset_cam1_cam0", json_of(diagnosis.cam1_offset)},
                     {"time_offset_cameras_imu", json_of(diagnosis.camera_offset)},
                     {"failure", diagnosis.failure.empty() ? Json(nullptr) : Json(diagnosis.failure)},
                     {"advice", advice(diagnosis)}};
  return json.dump(2) + "\n";
}

}  // namespace limber::app
