// SPDX-License-Identifier: MIT
#include "limber/compare/compare_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "compare_folders.hpp"
#include "limber/core/angle.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/so3.hpp"
#include "limber/evaluate/evaluation.hpp"
#include "run_labels.hpp"
#include "same_recording.hpp"

namespace limber {

namespace fs = std::filesystem;

namespace detail {
namespace {

/// Two runs at the times that both have, and where both have a truth, with it.
struct Pair {
  std::vector<MatchedPose> run, against;  ///< with truth; equally long
  std::vector<MatchedPose> both;          ///< estimate: the run; truth: the other one
};

const MatchedPose* pose_at(const RunFolder& run, std::int64_t t_ns) {
  const auto it = std::lower_bound(run.matched.begin(), run.matched.end(), t_ns,
                                   [](const MatchedPose& pose, std::int64_t t) { return pose.t_ns < t; });
  return it != run.matched.end() && it->t_ns == t_ns ? &*it : nullptr;
}

Pair pair_of(const RunFolder& run, const RunFolder& against) {
  Pair pair;
  for (const auto& [n, m] : common_frames(run, against)) {
    const TrajectoryRow &row = run.trajectory[n], &other = against.trajectory[m];
    pair.both.push_back({row.t_ns, n, row.T_world_body, other.T_world_body});
    const MatchedPose *of_run = pose_at(run, row.t_ns), *of_other = pose_at(against, row.t_ns);
    if (of_run != nullptr && of_other != nullptr) {
      pair.run.push_back(*of_run);
      pair.against.push_back(*of_other);
    }
  }
  return pair;
}

void compare_pieces(const Pair& pair, double piece_m, RunDifference& out) {
  const std::vector<IndexPair> pieces = disjoint_pieces(pair.run, piece_m);
  const std::vector<RelativeError> of_run = relative_errors_of(pair.run, pieces),
                                   of_other = relative_errors_of(pair.against, pieces);
  std::vector<double> percent, degrees;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    percent.push_back(100.0 * (of_run[k].position_m - of_other[k].position_m) / piece_m);
    degrees.push_back(of_run[k].attitude_deg - of_other[k].attitude_deg);
  }
  out.rpe_percent = mean_interval(percent);
  out.rpe_deg = mean_interval(degrees);
}

std::optional<double> ate_of(const std::vector<MatchedPose>& poses) {
  const Alignment fit = align(poses, AlignmentKind::kSe3);
  return fit.status == AlignmentStatus::kAligned ? std::optional(absolute_errors(poses, fit).position_m.rmse)
                                                 : std::nullopt;
}

void measure_distance(const std::vector<MatchedPose>& both, RunDifference& out) {
  const Alignment start = align(both, AlignmentKind::kFirstPose);
  out.apart_rms_m = absolute_errors(both, start).position_m.rmse;
  const Pose last = start * both.back().estimate;
  out.apart_end_m = (last.p - both.back().truth.p).norm();
  out.apart_end_deg = kToDegrees * so3_log(last.R.transpose() * both.back().truth.R).norm();
}

RunDifference difference_of(const RunFolder& run, const RunFolder& against, double piece_m,
                            const CompareOptions& options) {
  RunDifference out;
  const Pair pair = pair_of(run, against);
  out.assumptions = different_assumptions(against, run);
  out.frames = pair.both.size();
  measure_distance(pair.both, out);
  if (pair.run.empty() || (!out.assumptions.empty() && !options.across_assumptions)) {
    return out;
  }
  compare_pieces(pair, piece_m, out);
  const std::optional<double> ate = ate_of(pair.run), other = ate_of(pair.against);
  if (ate && other) {
    out.ate_m = *ate - *other;
  }
  return out;
}

/// The first run of the same recording; the run itself if there is none before it.
std::size_t first_alike(const std::vector<RunFolder>& runs, std::size_t run) {
  const auto it = std::find_if(runs.begin(), runs.begin() + static_cast<std::ptrdiff_t>(run),
                               [&](const RunFolder& other) { return same_recording(other, runs[run]); });
  return static_cast<std::size_t>(it - runs.begin());
}

void note_tilted_truth(RunComparison& out) {
  std::vector<std::string> tilted;
  for (const ComparedRun& run : out.runs) {
    if (run.truth_is_tilted) {
      tilted.push_back(run.label);
    }
  }
  if (!tilted.empty()) {
    out.notes.push_back(
        fmt::format("{}: the world of the truth is not level; that tilt is taken out of errors and ANEES",
                    fmt::join(tilted, ", ")));
  }
}

void note_unpaired(const RunDifference& difference, bool across, RunComparison& out) {
  if (!difference.assumptions.empty()) {
    out.notes.push_back(fmt::format(
        "{} and {} assume different things of {}: {}; {}", out.runs[difference.run].label,
        out.runs[difference.against].label, out.runs[difference.run].recording,
        fmt::join(difference.assumptions, ", "),
        across ? "their difference is of both, method and assumptions" : "their errors are not paired"));
  }
}

}  // namespace

std::vector<RunFolder> read_run_folders(std::span<const fs::path> folders) {
  std::vector<RunFolder> runs;
  for (const fs::path& folder : folders) {
    runs.push_back(read_run_folder(folder));
  }
  return runs;
}

RunComparison compare_folders(const std::vector<RunFolder>& runs, const CompareOptions& options) {
  if (runs.empty() || (options.piece_m && !(*options.piece_m > 0.0))) {
    throw std::invalid_argument("compare runs: expected at least one run, and pieces longer than 0 m");
  }
  RunComparison out;
  const std::vector<std::string> labels = run_labels(runs);
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const std::size_t first = first_alike(runs, k);
    const double piece_m =
        first < k ? out.runs[first].piece_m : options.piece_m.value_or(default_piece(poses_on_path(runs[k])));
    out.runs.push_back(compared_run(runs[k], piece_m));
    out.runs.back().label = labels[k];
    if (first < k) {
      out.differences.push_back(difference_of(runs[k], runs[first], piece_m, options));
      out.differences.back().run = k;
      out.differences.back().against = first;
      note_unpaired(out.differences.back(), options.across_assumptions, out);
    } else if (k > 0) {
      out.notes.push_back(
          fmt::format("{} is of another recording ({}) than those before it: not paired with them", labels[k],
                      out.runs[k].recording));
    }
  }
  note_tilted_truth(out);
  return out;
}

}  // namespace detail

std::string to_string(RunEnd end) {
  return end == RunEnd::kDone ? "done" : end == RunEnd::kPartial ? "partial" : "lost";
}

std::string end_in_words(const ComparedRun& run) {
  switch (run.end) {
    case RunEnd::kDone:
      break;
    case RunEnd::kPartial:
      return run.frames < run.frames_of_recording
                 ? fmt::format("partial: {} of {} frames", run.frames, run.frames_of_recording)
                 : "partial: of a damaged recording";
    case RunEnd::kLost:
      return fmt::format("lost since {:.1f} s", *run.lost_since_s);
  }
  return "done";
}

std::string to_string(Judgement judgement) {
  return judgement == Judgement::kBetter  ? "better"
         : judgement == Judgement::kWorse ? "worse"
                                          : "cannot tell";
}

Judgement judge(const MeanInterval& difference) {
  if (difference.upper && *difference.upper < 0.0) {
    return Judgement::kBetter;
  }
  return difference.lower && *difference.lower > 0.0 ? Judgement::kWorse : Judgement::kCannotTell;
}

std::string difference_in_words(const MeanInterval& difference) {
  const std::string verdict = to_string(judge(difference));
  if (!difference.lower || !difference.upper) {
    return fmt::format("{:+.2g} (too few pieces): {}", difference.mean, verdict);
  }
  const double half = 0.5 * (*difference.upper - *difference.lower);
  const int decimals = half > 0.0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(half))), 0, 9) : 2;
  return fmt::format("{:+.{}f} ({:+.{}f} to {:+.{}f}): {}", difference.mean, decimals, *difference.lower,
                     decimals, *difference.upper, decimals, verdict);
}

std::vector<fs::path> run_folders(std::span<const fs::path> paths) {
  std::vector<fs::path> out;
  for (const fs::path& path : paths) {
    std::vector<fs::path> inner;
    if (fs::is_directory(path) && !fs::exists(path / "summary.json")) {
      for (const auto& entry : fs::directory_iterator(path)) {
        if (fs::exists(entry.path() / "summary.json")) {
          inner.push_back(entry.path());
        }
      }
      std::sort(inner.begin(), inner.end());
    } else if (fs::is_directory(path)) {
      inner.push_back(path);
    }
    if (inner.empty()) {
      throw DataError(path.string(), 0,
                      "the folder of a run (summary.json, as limber run --out writes), or of several",
                      fs::is_directory(path) ? "a folder without any"
                      : fs::exists(path)     ? "a file"
                                             : "no such folder");
    }
    out.insert(out.end(), inner.begin(), inner.end());
  }
  return out;
}

RunComparison compare_runs(std::span<const fs::path> folders, const CompareOptions& options) {
  return detail::compare_folders(detail::read_run_folders(folders), options);
}

}  // namespace limber
