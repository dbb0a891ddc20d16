// SPDX-License-Identifier: MIT
#include "limber/run/input_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "limber/core/time.hpp"

namespace limber {
namespace {

constexpr std::int64_t kSameEventNs = 1'000'000'000;
constexpr std::size_t kMostRemarks = 8;
/// Innovations that many times as large as expected, or that many pixels of noise to explain them, most
/// points refused by a gate that was overruled, for that long [s]: no calibration is so wrong, the state is.
/// The former is beside a noise that may have been learned from such innovations, the latter is not.
constexpr double kLostNis = 300.0, kLost_px = 10.0, kLostAfter = 1.0;
/// Such a frame that moves the body by that many sigmas of its prediction.
constexpr double kLeap = 10.0;
constexpr double kWorthARemark = 0.05;  // [s], a shorter gap is a dropped sample or two

/// The event of that kind to which a frame belongs: the last one, or a new one.
RunEvent& event_at(std::vector<RunEvent>& events, RunEventKind kind, std::int64_t from_ns,
                   std::int64_t t_ns) {
  const auto last =
      std::find_if(events.rbegin(), events.rend(), [&](const RunEvent& e) { return e.kind == kind; });
  RunEvent& event = last != events.rend() && from_ns - last->to_ns <= kSameEventNs
                        ? *last
                        : events.emplace_back(RunEvent{kind, from_ns});
  event.to_ns = t_ns;
  ++event.frames;
  return event;
}

void count(const FrameReport& frame, InputSummary& out) {
  out.updated += frame.status == UpdateStatus::kUpdated ? 1 : 0;
  out.no_points += frame.status == UpdateStatus::kEmpty ? 1 : 0;
  out.singular += frame.status == UpdateStatus::kSingularInnovation ? 1 : 0;
  switch (frame.inputs.status) {
    case InputStatus::kNotNeeded:
      ++out.not_needed;
      break;
    case InputStatus::kSound:
      ++out.sound;
      break;
    case InputStatus::kFaulty:
      ++out.faulty;
      break;
    case InputStatus::kGap:
      ++out.gap;
      break;
    case InputStatus::kContradicted:
      ++out.contradicted;
      break;
    case InputStatus::kNone:
      ++out.none;
      break;
  }
}

bool contradicts_the_state(const FrameReport& frame) {
  const auto dof = static_cast<double>(frame.dof);
  const double misfit = frame.nis * frame.sigma_px * frame.sigma_px;
  return frame.gate_overruled && (frame.nis > kLostNis * dof || misfit > kLost_px * kLost_px * dof);
}

std::string so_often(std::size_t times) { return times == 1 ? "once" : fmt::format("{} times", times); }

std::string samples_in_words(const RunEvent& e, const std::string& when, const char* then) {
  return fmt::format("{} {} input samples were {}: {}", when, e.samples, to_string(e.kind), then);
}

std::string in_words(const RunEvent& e) {
  const std::string when =
      e.to_ns - e.from_ns > 100'000'000
          ? fmt::format("from {:.3f} s to {:.3f} s", to_seconds(e.from_ns), to_seconds(e.to_ns))
          : fmt::format("at {:.3f} s", to_seconds(e.to_ns));
  switch (e.kind) {
    case RunEventKind::kGap:
      return fmt::format(
          "{} up to {:.2f} s without a usable input sample: what could have happened counts as noise", when,
          e.longest_s);
    case RunEventKind::kContradicted:
      return fmt::format(
          "{} the images contradict the inputs (a bias or clock that stepped, a fault): velocity and biases "
          "were opened, and the calibration not judged",
          when);
    case RunEventKind::kClockStepped:
      return fmt::format(
          "{} the images showed that the IMU's clock is off, or had stepped: its samples were taken {:.4f} s "
          "{} than they are stamped, and are used so since then",
          when, std::abs(e.clock_offset_s), e.clock_offset_s > 0.0 ? "earlier" : "later");
    case RunEventKind::kNoInputs:
      return fmt::format("{} no input sample had come yet: the motion was guessed", when);
    case RunEventKind::kNoPoints:
      return fmt::format("{} no point could be used in {} frames: dead reckoning", when, e.frames);
    case RunEventKind::kStateContradicted:
      return fmt::format("{} most points contradict the state by far", when);
    case RunEventKind::kGateOverruled:
      return fmt::format("{} most points contradict the rig or the state: sigmas are too small", when);
    case RunEventKind::kMostMove:
      return fmt::format(
          "{} most points were of something that moves: they were left out, the others and the inputs "
          "carried the state on",
          when);
    case RunEventKind::kMostMismatched:
      return fmt::format(
          "{} most points agreed neither with the inputs nor with each other (mismatches): they were left "
          "out",
          when);
    case RunEventKind::kLedAstray:
      return fmt::format(
          "{} the points contradicted the state so far that correcting it would have put them farther off, "
          "{}: they were taken for new ones, the inputs carried the state on",
          when, so_often(e.frames));
    case RunEventKind::kLeapt:
      return fmt::format("{} the body leapt by more than {:.0f} of its own sigmas", when, kLeap);
    case RunEventKind::kReset:
      return fmt::format("{} the filter had broken down and began anew, {}", when, so_often(e.frames));
    case RunEventKind::kSaturated:
      return samples_in_words(e, when, "taken with more noise");
    case RunEventKind::kLate:
      return samples_in_words(e, when, "they came after the frame they belong to");
    default:
      return samples_in_words(e, when, "left out");
  }
}

}  // namespace

InputSummary summarize_inputs(const std::vector<FrameReport>& frames) {
  InputSummary out;
  std::int64_t before_ns = frames.empty() ? 0 : frames.front().t_ns;
  std::optional<std::int64_t> contradicted_since_ns;
  std::int64_t silent_since_ns = before_ns;  // no sample between this frame and those after it
  for (const FrameReport& frame : frames) {
    count(frame, out);
    const auto add = [&](RunEventKind kind) -> RunEvent& {
      return event_at(out.events, kind, before_ns, frame.t_ns);
    };
    if (frame.inputs.gap_s < seconds_between(before_ns, frame.t_ns)) silent_since_ns = frame.t_ns;
    if (frame.inputs.status == InputStatus::kNone && frame.t_ns > before_ns) {
      add(RunEventKind::kNoInputs);
    } else if (frame.inputs.gap_s > 0.0) {
      RunEvent& event = add(RunEventKind::kGap);
      event.longest_s =
          std::max({event.longest_s, frame.inputs.gap_s, seconds_between(silent_since_ns, frame.t_ns)});
    }
    for (std::size_t k = 0; k < kInputFaults; ++k) {
      if (frame.inputs.faults.count[k] > 0) {
        add(event_of(static_cast<InputFault>(k))).samples += frame.inputs.faults.count[k];
      }
    }
    if (frame.inputs.contradiction && frame.inputs.contradiction->clock_offset_ns) {
      add(RunEventKind::kClockStepped).clock_offset_s =
          to_seconds(*frame.inputs.contradiction->clock_offset_ns);
    } else if (frame.inputs.contradiction) {
      add(RunEventKind::kContradicted);
    }
    if (frame.status == UpdateStatus::kEmpty && frame.t_ns > before_ns) {
      add(RunEventKind::kNoPoints);
    }
    if (frame.gate_overruled) {
      add(RunEventKind::kGateOverruled);
    }
    if (frame.most_move) {
      add(RunEventKind::kMostMove);
    }
    if (frame.most_mismatched) {
      add(RunEventKind::kMostMismatched);
    }
    if (frame.led_astray) {
      add(RunEventKind::kLedAstray);
    }
    if (contradicts_the_state(frame) && frame.correction > kLeap) {
      add(RunEventKind::kLeapt);
    }
    if (!contradicts_the_state(frame)) {
      contradicted_since_ns.reset();
    } else if (!contradicted_since_ns) {
      contradicted_since_ns = frame.t_ns;
    } else if (seconds_between(*contradicted_since_ns, frame.t_ns) >= kLostAfter) {
      add(RunEventKind::kStateContradicted);
      out.lost_since_ns = out.lost_since_ns.value_or(*contradicted_since_ns);
    }
    if (frame.reset) {
      add(RunEventKind::kReset);
      out.lost_since_ns = out.lost_since_ns.value_or(frame.t_ns);
    }
    before_ns = frame.t_ns;
  }
  if (frames.size() > 1 && out.updated == 0 && !out.lost_since_ns) {
    out.lost_since_ns = frames.front().t_ns;
  }
  return out;
}

std::vector<std::string> remarks_on_inputs(const InputSummary& summary) {
  std::vector<std::string> out;
  std::size_t more = 0;
  for (const RunEvent& event : summary.events) {
    const bool trifle =
        (event.kind == RunEventKind::kGap && event.longest_s < kWorthARemark) ||
        ((event.kind == RunEventKind::kNoPoints || event.kind == RunEventKind::kGateOverruled) &&
         event.to_ns - event.from_ns < kSameEventNs);
    if (trifle) {
      continue;
    }
    if (out.size() < kMostRemarks) {
      out.push_back(in_words(event));
    } else {
      ++more;
    }
  }
  if (more > 0) {
    out.push_back(fmt::format("{} more such events: see events in summary.json", more));
  }
  const bool began_anew = std::ranges::any_of(
      summary.events, [](const RunEvent& event) { return event.kind == RunEventKind::kReset; });
  if (summary.lost_since_ns && summary.updated == 0 && !began_anew) {
    out.emplace_back("the run is lost from its begin: no frame corrected the state");
  } else if (summary.lost_since_ns) {
    out.push_back(
        fmt::format("the run is lost since {:.3f} s: what follows is in another world than what was before",
                    to_seconds(*summary.lost_since_ns)));
  }
  return out;
}

}  // namespace limber
