// SPDX-License-Identifier: MIT
#include "limber/diagnose/misled_since.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "diagnose/run_events.hpp"
#include "limber/core/median.hpp"
#include "limber/core/time.hpp"
#include "limber/diagnose/bias_move.hpp"
#include "limber/diagnose/scale_check.hpp"
#include "limber/diagnose/trusted_rig.hpp"

namespace limber {
namespace {

constexpr double kBlock = 1.0;            // [s]
constexpr std::size_t kBefore = 3;        // blocks that tell what is usual
constexpr std::size_t kLasting = 3;       // blocks in a row
constexpr std::size_t kSudden = 2;        // blocks in which it grows to that, at most
constexpr std::size_t kFewestFrames = 3;  // of a block
constexpr double kGrown = 6.0;            // misfit, over the usual one
constexpr double kManyRefused = 0.1;
constexpr double kRefused = 0.05;      // share of the points
constexpr double kDoubtfulRig = 0.01;  // share of exact rigs that look so

/// A second of the run.
struct Block {
  std::int64_t begin_ns = 0;
  double misfit = 0.0;   // median of NIS per degree of freedom, in pixels: noise is learned meanwhile [px²]
  double refused = 0.0;  // share of the points; all of them where the gate was overruled
};

/// Nothing of a second in which something large moves, or most is mismatched: points contradict, and no input
/// failed.
std::optional<Block> block_of(std::span<const FrameReport> frames) {
  if (std::ranges::any_of(frames, [](const FrameReport& f) { return f.most_move || f.most_mismatched; })) {
    return std::nullopt;
  }
  std::vector<double> misfits;
  double refused = 0.0, points = 0.0;
  for (const FrameReport& frame : frames) {
    if (frame.dof > 0) {
      const auto out = static_cast<double>(frame.refused.size()), all = out + static_cast<double>(frame.used);
      misfits.push_back(frame.sigma_px * frame.sigma_px * frame.nis / static_cast<double>(frame.dof));
      refused += frame.gate_overruled ? all : out;
      points += all;
    }
  }
  if (misfits.size() < kFewestFrames) {
    return std::nullopt;
  }
  return Block{frames.front().t_ns, upper_median(std::move(misfits)), refused / std::max(points, 1.0)};
}

std::vector<Block> blocks_of(std::span<const FrameReport> frames) {
  std::vector<Block> out;
  while (!frames.empty()) {
    const auto end = std::ranges::find_if(frames, [&](const FrameReport& frame) {
      return seconds_between(frames.front().t_ns, frame.t_ns) >= kBlock;
    });
    const auto size = static_cast<std::size_t>(end - frames.begin());
    if (const auto block = block_of(frames.first(size))) {
      out.push_back(*block);
    }
    frames = frames.subspan(size);
  }
  return out;
}

double usual(std::span<const Block> blocks, double Block::*what) {
  std::vector<double> values;
  for (const Block& block : blocks) {
    values.push_back(block.*what);
  }
  return upper_median(std::move(values));
}

/// What a block may show before it is out of the ordinary of those before.
struct Limits {
  double misfit, refused;

  explicit Limits(std::span<const Block> before)
      : misfit(kGrown * usual(before, &Block::misfit)),
        refused(std::max(kManyRefused, kGrown * usual(before, &Block::refused))) {}
  /// One after the other, with points refused among them: noise alone that has grown refuses none.
  [[nodiscard]] bool are_passed_by(std::span<const Block> blocks) const {
    double sum = 0.0;
    for (const Block& block : blocks) {
      sum += block.refused;
    }
    return sum > kRefused * static_cast<double>(blocks.size()) &&
           std::ranges::all_of(blocks,
                               [&](const Block& b) { return b.misfit > misfit || b.refused > refused; });
  }
  /// A rig that drifts away gets there by and by.
  [[nodiscard]] bool is_far_from(const Block& block) const {
    return block.misfit < 0.5 * misfit && block.refused < 0.5 * refused;
  }
};

/// The block behind the last usual one before `k`, unless that is too long ago.
std::optional<std::size_t> begin_of_growth(std::span<const Block> blocks, std::size_t k,
                                           const Limits& limits) {
  for (std::size_t begin = k; begin + kSudden > k; --begin) {
    if (limits.is_far_from(blocks[begin - 1])) {
      return begin;
    }
  }
  return std::nullopt;
}

void call_lost(const RunEvent& event, const std::string& why, RunRecord& record, InputSummary& inputs) {
  detail::add_event(event, record, inputs);
  detail::lose(event.from_ns, why, record, inputs);
}

/// Not where nobody judged the rig, or it is wrong: that may have moved a bias.
bool acquits_the_rig(const RunSummary& summary) {
  return summary.health && !is_wrong(summary.health->verdict);
}

/// Nor where biases move all along: something else than a fault does it.
bool proves_a_fault(const BiasMove& move, const RunSummary& summary) {
  return move.is_sudden() && acquits_the_rig(summary);
}

/// A wrong rig that a method trusts may move a bias as well, and need not be sure.
std::string or_the_rig(const RunOptions& options, const RunRecord& record, const RunSummary& summary) {
  const auto off = trusted_rig_off(*summary.health,
                                   trusted_parts(options, record.motion, record.theta_assumed), kDoubtfulRig);
  return off ? fmt::format(", or the rig is off, by {}", off->in_words) : "";
}

void judge_move(const RunOptions& options, const BiasMove& move, RunRecord& record, RunSummary& summary) {
  const std::string what = fmt::format(
      "from {:.3f} s to {:.3f} s the bias of the {} moved by {:.2g} {}, {:.0f} times its sigma",
      to_seconds(move.from_ns), to_seconds(move.to_ns), move.of_gyro ? "gyroscope" : "accelerometer",
      move.size, move.of_gyro ? "rad/s" : "m/s^2", move.sigmas);
  const RunEvent event{RunEventKind::kBiasMoved, move.from_ns, move.to_ns};
  if (proves_a_fault(move, summary)) {
    call_lost(event,
              what + ": an input failed (a bias or a clock that stepped)" +
                  or_the_rig(options, record, summary) + ", and no sigma since then is true",
              record, summary.inputs);
  } else {
    detail::add_event(event, record, summary.inputs);
    record.notes.push_back(what + ": the sigmas of this run are too small");
  }
}

/// A filter that trusts the rig, and what it found out late.
struct LateStep {
  std::int64_t since_ns, found_ns;
};

std::optional<LateStep> late_step_in(std::span<const FrameReport> frames) {
  for (const FrameReport& frame : frames) {
    if (frame.inputs.contradiction && frame.inputs.contradiction->astray_since_ns) {
      // A filter that was given no time supposes its first step at 0.
      return LateStep{std::max(*frame.inputs.contradiction->astray_since_ns, frames.front().t_ns),
                      frame.t_ns};
    }
  }
  return std::nullopt;
}

void judge_late_step(const RunOptions& options, const LateStep& step, RunRecord& record,
                     RunSummary& summary) {
  const std::string what =
      fmt::format("steps of the IMU's biases or its clock after {:.3f} s were found at {:.3f} s",
                  to_seconds(step.since_ns), to_seconds(step.found_ns));
  const RunEvent event{RunEventKind::kMisled, step.since_ns, step.found_ns};
  if (acquits_the_rig(summary)) {
    call_lost(event,
              what + or_the_rig(options, record, summary) +
                  ". No sigma in between is true; the filter has gone on from there. --method lcekf would "
                  "have noticed sooner",
              record, summary.inputs);
  } else {
    detail::add_event(event, record, summary.inputs);
    record.notes.push_back(what + ", which the rig may explain: no sigma in between is true");
  }
}

/// Without an IMU nothing but images says where the body is once they have thrown it away.
void lose_after_a_leap(RunRecord& record, InputSummary& inputs) {
  const auto leap = std::ranges::find(inputs.events, RunEventKind::kLeapt, &RunEvent::kind);
  if (leap != inputs.events.end()) {
    detail::lose(leap->to_ns, "points that contradicted the state threw it away", record, inputs);
  }
}

}  // namespace

std::optional<std::int64_t> misled_since(std::span<const FrameReport> frames,
                                         const std::optional<HealthSummary>& rig) {
  if (!rig || is_wrong(rig->verdict) || !rig->past.empty()) {
    return std::nullopt;
  }
  const std::vector<Block> blocks = blocks_of(frames);
  for (std::size_t k = kBefore; k + kLasting <= blocks.size(); ++k) {
    const Limits limits{std::span<const Block>(blocks).first(k)};
    const auto since = std::span(blocks).subspan(k);
    const std::optional<std::size_t> begin = begin_of_growth(blocks, k, limits);
    const auto as_usual = [&](const Block& block) { return limits.is_far_from(block); };
    if (begin && limits.are_passed_by(since.first(kLasting)) &&
        2 * static_cast<std::size_t>(std::ranges::count_if(since, as_usual)) < since.size()) {
      return blocks[*begin].begin_ns;
    }
  }
  return std::nullopt;
}

void add_misled(const Recording& recording, const RunOptions& options, RunRecord& record,
                RunSummary& summary) {
  if (record.frames.empty() || summary.inputs.lost_since_ns) {
    return;
  }
  if (record.motion != MotionModel::kImu) {
    lose_after_a_leap(record, summary.inputs);
    return;
  }
  const std::int64_t end_ns = record.frames.back().t_ns;
  const auto misled =
      options.method == Method::kEkf ? misled_since(record.frames, summary.health) : std::nullopt;
  const auto impossible = impossible_bias_since(record.trajectory);
  const auto move = bias_beyond_its_sigma(record.trajectory, record.frames);
  const auto moved_before = [&](std::int64_t since_ns) {
    return move && proves_a_fault(*move, summary) && move->from_ns < since_ns;
  };
  const std::optional<LateStep> late = late_step_in(record.frames);
  if (late && !moved_before(late->since_ns) && (!misled || late->since_ns < *misled)) {
    judge_late_step(options, *late, record, summary);
  } else if (misled && !moved_before(*misled) &&
             !agrees_with_lcekf(recording, options, record, *misled).value_or(false)) {
    call_lost({RunEventKind::kMisled, *misled, end_ns},
              "points contradict the prediction since then, and the rig did not change: an input failed (a "
              "bias or a clock that stepped). --method lcekf would notice and go on",
              record, summary.inputs);
  } else if (impossible && !moved_before(*impossible)) {
    call_lost({RunEventKind::kImpossibleBias, *impossible, end_ns},
              "a bias of the IMU is estimated that no IMU has. Is the calibration wrong, or the IMU's unit?",
              record, summary.inputs);
  } else if (move) {
    judge_move(options, *move, record, summary);
  }
}

}  // namespace limber
