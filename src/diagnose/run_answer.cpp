// SPDX-License-Identifier: MIT
#include "limber/diagnose/run_answer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "limber/core/angle.hpp"
#include "limber/core/time.hpp"

namespace limber {
namespace {

constexpr double kTooSure = 2.0;  // times as wrong as claimed; half: too careful

AnswerLight light_of(HealthVerdict verdict) {
  switch (verdict) {
    case HealthVerdict::kOk:
      return AnswerLight::kGreen;
    case HealthVerdict::kSuspect:
    case HealthVerdict::kDegraded:
      return AnswerLight::kYellow;
    case HealthVerdict::kDecalibrated:
      return AnswerLight::kRed;
    case HealthVerdict::kCannotTell:
      break;
  }
  return AnswerLight::kGrey;
}

std::string headline_of(HealthVerdict verdict) {
  switch (verdict) {
    case HealthVerdict::kCannotTell:
      return "cannot tell whether the calibration holds";
    case HealthVerdict::kDecalibrated:
      return "rig decalibrated";
    default:
      return "calibration " + to_string(verdict);
  }
}

/// "2.1 times as large as the filter claims (ANEES 4.4)"
std::string claim_in_words(double anees) {
  const double ratio = std::sqrt(anees);
  if (ratio > kTooSure) {
    return fmt::format("{:.3g} times as large as the filter claims (ANEES {:.3g})", ratio, anees);
  }
  return fmt::format("{} the filter claims (ANEES {:.2f})",
                     ratio < 1.0 / kTooSure ? "less than half as large as" : "about as large as", anees);
}

/// What the filter says of its last pose.
std::string claimed_pose(const RunRecord& record) {
  const TrajectoryRow& last = record.trajectory.back();
  if (!last.covariance) {
    return "no truth is known";
  }
  const auto variance = last.covariance->diagonal();
  return fmt::format("no truth is known; the filter claims {:.2g} m and {:.2g} deg (1σ) at the end",
                     std::sqrt(variance.head<3>().sum()), kToDegrees * std::sqrt(variance.tail<3>().sum()));
}

std::string pose_in_words(const RunRecord& record, const RunSummary& s) {
  std::string text = "poses: ";
  if (s.ate_se3_m || s.position_rmse_m) {
    text += fmt::format("{:.3g} m from the truth ({}) on a path of {:.3g} m",
                        s.ate_se3_m.value_or(s.position_rmse_m.value_or(0.0)),
                        s.ate_se3_m ? "ATE after a rigid fit" : "RMSE", s.path_length_m);
    text += s.anees ? ", errors " + claim_in_words(*s.anees) : "";
  } else {
    text += claimed_pose(record);
  }
  if (record.frames_unreadable > 0) {
    text += fmt::format("; the images of {} of {} frames could not be read", record.frames_unreadable,
                        record.frames_of_recording);
  }
  if (record.stopped) {
    text += fmt::format("; stopped after {} of {} frames", s.frames, record.frames_of_recording);
  }
  return text;
}

constexpr double kKnownOff = 3.0;  // sigmas from which on a length is said to be off
constexpr const char* kLengthAdvice =
    "ask limber health, which trusts no length, and limber recalibrate; until then --method lcekf or "
    "adaptive";

/// What positions are worth whose scale is that of the baseline.
std::string trust_in_words(const RunRecord& record, const RunSummary& s) {
  const std::string rest = "positions rest on the length of the baseline, which ";
  if (!s.scale_check) {
    const bool doubts_lenses = !has_scale(record.motion) && record.pixel_noise;
    return rest + "nothing here shows beside it: they are wrong by as many per cent as it is" +
           (doubts_lenses ? fmt::format("; sigmas count {:.2g} % (1σ) for what lenses may do, and nothing "
                                        "for the rig",
                                        100.0 * record.pixel_noise->length_sigma)
                          : "");
  }
  const auto from_start = [&](const TrajectoryRow& row) {
    return (row.T_world_body.p - record.trajectory.front().T_world_body.p).norm();
  };
  const TrajectoryRow& farthest = *std::ranges::max_element(record.trajectory, {}, from_start);
  const double distance = from_start(farthest), sigma = s.scale_check->scale.sigma;
  const double off = s.scale_check->scale.too_long;
  const bool known_off = std::abs(off) > kKnownOff * sigma;
  std::string out =
      rest + (known_off ? fmt::format("beside the IMU makes them {:.2g} ± {:.2g} % too {}",
                                      100.0 * std::abs(off), 100.0 * sigma, off > 0.0 ? "long" : "short")
                        : fmt::format("the IMU shows to {:.2g} % (1σ)", 100.0 * sigma));
  out += fmt::format(": {:.2g} m at {:.3g} m from the start",
                     (known_off ? std::hypot(off, sigma) : sigma) * distance, distance);
  if (farthest.covariance) {
    out += fmt::format(", where {:.2g} m are claimed",
                       std::sqrt(farthest.covariance->diagonal().head<3>().sum()));
  }
  return out;
}

/// What sigmas are worth that rest on odometry whose noise was learned: docs/evidence/real-data.md.
constexpr const char* kOdometrySigmas =
    "sigmas with odometry of unstated noise count a wheel's size and what is fresh in every sample and "
    "pixel, "
    "not what lasts for a while (points that slide): on real drives errors were 2 to 6 times as large as "
    "claimed";

/// Poses that are wrong by more than they claim come before the verdict on the rig.
void say_what_contradicts(const RunSummary& s, RunAnswer& out) {
  const auto holds = [](const OffsetMistake& mistake) { return mistake.sigmas_hold; };
  const auto worst = std::ranges::find_if_not(s.camera_imu_mistakes, holds);
  std::vector<std::string> words;
  for (const OffsetMistake& mistake : s.camera_imu_mistakes) {
    words.push_back(mistake.words);
  }
  const bool contradicted = worst != s.camera_imu_mistakes.end();
  out.sentences.insert(contradicted ? out.sentences.begin() : out.sentences.end(), words.begin(),
                       words.end());
  if (contradicted) {
    const bool wrong_rig = s.health->verdict == HealthVerdict::kDecalibrated;
    out.light = AnswerLight::kRed;
    out.headline = "cameras and IMU contradict each other" + (wrong_rig ? ", " + out.headline : "");
    out.advice = worst->advice;
  } else if (!words.empty()) {
    out.advice = s.camera_imu_mistakes.front().advice;
  }
}

/// The verdict on the calibration, and why.
void judge_calibration(const RunOptions& options, const RunRecord& record, const RunSummary& s,
                       RunAnswer& out) {
  if (!s.mistakes.empty()) {
    out.light = AnswerLight::kRed;
    out.headline = "looks like a mistake";
    out.sentences = s.mistakes;
    out.advice = kMistakeAdvice;
  } else if (s.readout_contradicted) {
    out.headline = headline_of(HealthVerdict::kCannotTell);
    out.sentences.push_back(record.notes.front());
    out.advice = kReadoutAdvice;
  } else if (s.clocks_hide_rig) {
    out.headline = headline_of(HealthVerdict::kCannotTell);
    out.sentences = s.clock_mistakes;
    out.sentences.emplace_back(kClocksHideRig);
    out.advice = kClockAdvice;
  } else if (s.health) {
    out.light = light_of(s.health->verdict);
    out.headline = headline_of(s.health->verdict);
    out.sentences.push_back(in_words(*s.health, watch_options(options).tolerance));
    out.advice = advice_on(s.health->verdict, s.health->present.moves());
    out.sentences.insert(out.sentences.end(), s.clock_mistakes.begin(), s.clock_mistakes.end());
    if (s.corrected_clock) {
      out.sentences.push_back(*s.corrected_clock);
    }
    if (s.health->verdict == HealthVerdict::kCannotTell && s.scale_check && is_off(s.scale_check->scale)) {
      out.light = AnswerLight::kYellow;
      out.headline = "calibration in doubt: its baseline has another length than the IMU shows";
      out.advice = kLengthAdvice;
    }
    say_what_contradicts(s, out);
    if (!s.clock_mistakes.empty()) {
      out.advice = kClockAdvice;
    }
  } else {
    out.headline = "calibration not judged";
    out.sentences.emplace_back(options.method == Method::kMonoLeft
                                   ? "mono-left does not look through the right camera"
                                   : "no window of the run was judged");
    out.advice = "ask limber health whether the calibration holds";
  }
}

/// A mistake or a rig that is wrong may be why, and what to do about it stays.
void say_it_is_lost(const RunRecord& record, const RunSummary& s, RunAnswer& out) {
  const double since = seconds_between(record.trajectory.front().t_ns, *s.inputs.lost_since_ns);
  const bool wrong_rig = s.health && s.health->verdict == HealthVerdict::kDecalibrated;
  out.light = AnswerLight::kRed;
  std::string words =
      "the filter broke down, or images or its own sigmas contradict its state, and nothing brought it back";
  std::string advice = fmt::format("use no pose later than {:.1f} s; the notes below say what failed", since);
  if (!s.mistakes.empty()) {
    out.sentences.push_back(std::move(words));
    out.headline += fmt::format(", lost since {:.1f} s", since);
  } else if (wrong_rig) {
    out.sentences.insert(out.sentences.begin(), std::move(words));
    out.headline = fmt::format("lost since {:.1f} s, {}", since, out.headline);
    out.advice = advice + "; " + out.advice;
  } else {
    out.sentences = {words + "; until then: " + out.headline};
    out.headline = fmt::format("lost since {:.1f} s", since);
    out.advice = std::move(advice);
  }
}

}  // namespace

std::string_view to_string(AnswerLight light) {
  constexpr std::string_view kNames[] = {"green", "yellow", "red", "grey"};
  return kNames[static_cast<std::size_t>(light)];
}

RunAnswer answer_of(const RunOptions& options, const RunRecord& record, const RunSummary& s) {
  RunAnswer out;
  judge_calibration(options, record, s, out);
  if (s.inputs.lost_since_ns) {
    say_it_is_lost(record, s, out);
  }
  out.sentences.push_back(pose_in_words(record, s));
  if (s.rests_on_length) {
    out.sentences.push_back(trust_in_words(record, s));
  }
  if (record.motion == MotionModel::kOdometry && record.odometry_noise) {
    out.sentences.emplace_back(kOdometrySigmas);
  }
  if (!s.truth_is_level) {
    out.sentences.push_back(fmt::format(
        "the world of the truth is not level, its vertical is {:.1f} deg from the run's: errors, bounds and "
        "ANEES are of the aligned poses, with that tilt taken out",
        s.truth_tilt_deg.value_or(0.0)));
  }
  return out;
}

}  // namespace limber
