// SPDX-License-Identifier: MIT
#include "limber/health/rig_evidence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace limber {
namespace {

void add_scores(const TrackScores& other, TrackScores& into) {
  for (const auto& [cell, score] : other.cells) {
    into.cells.try_emplace(cell, NormalEquations::Vector::Zero()).first->second += score;
  }
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    into.of_a_pixel[kind] += other.of_a_pixel[kind];
  }
}

void add_product(const TrackScores& a, const TrackScores& b, ScoreProducts& out) {
  NormalEquations::Vector of_a = NormalEquations::Vector::Zero(), of_b = of_a;
  for (const auto& [cell, score] : a.cells) {
    of_a += score;
    if (const auto same = b.cells.find(cell); same != b.cells.end()) {
      out.both.noalias() += score * same->second.transpose();
    }
  }
  for (const auto& [cell, score] : b.cells) {
    of_b += score;
  }
  out.tracks.noalias() += of_a * of_b.transpose();
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    out.of_a_pixel[kind].noalias() += a.of_a_pixel[kind] * b.of_a_pixel[kind].transpose();
  }
}

void merge(const RigEvidence& other, RigEvidence& into) {
  into.to_ns = other.to_ns;
  into.all += other.all;
  for (const auto& [cell, sums] : other.cells) {
    into.cells[cell] += sums;
  }
  for (const auto& [id, scores] : other.tracks) {
    add_scores(scores, into.tracks[id]);
  }
  into.errors += other.errors;
  into.products += other.products;
  into.epipolar += other.epipolar;
  into.points += other.points;
  into.track_count += other.track_count;
  into.deep += other.deep;
  into.deep_tracks += other.deep_tracks;
  const std::array<const RigEvidence*, 2> both = {&into, &other};
  into.scale_sigma = std::sqrt(mean_scale_variance(both));
  into.length_weight += other.length_weight;
  for (std::size_t k = 0; k < into.blocks.size() && k < other.blocks.size(); ++k) {
    into.blocks[k] += other.blocks[k];
  }
  for (std::size_t k = 0; k < into.depth_blocks.size() && k < other.depth_blocks.size(); ++k) {
    into.depth_blocks[k] += other.depth_blocks[k];
  }
}

/// Of windows 2 k and 2 k + 1 with 2 (k - lag) and the one after it.
ScoreProducts halved(const std::vector<RigEvidence>& windows, std::size_t k, std::size_t lag) {
  ScoreProducts out;
  for (std::size_t later = 2 * k; later < std::min(2 * k + 2, windows.size()); ++later) {
    const std::vector<ScoreProducts>& known = windows[later].with_earlier;
    for (const std::size_t earlier : {2 * (k - lag), 2 * (k - lag) + 1}) {
      if (later - earlier <= known.size()) {
        out += known[later - earlier - 1];
      }
    }
  }
  return out;
}

}  // namespace

double mean_scale_variance(std::span<const RigEvidence* const> windows) {
  double variance = 0.0, weights = 0.0, worst = 0.0;
  for (const RigEvidence* window : windows) {
    const double own = window->scale_sigma * window->scale_sigma;
    const double weight = std::max(window->length_weight, 0.0);  // what is nil may be less by rounding
    variance += weight * own;
    weights += weight;
    worst = std::max(worst, own);
  }
  return weights > 0.0 ? variance / weights : worst;
}

ScoreProducts& ScoreProducts::operator+=(const ScoreProducts& other) {
  tracks += other.tracks;
  both += other.both;
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    of_a_pixel[kind] += other.of_a_pixel[kind];
  }
  return *this;
}

ScoreProducts ScoreProducts::transposed() const {
  ScoreProducts out{tracks.transpose(), both.transpose()};
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    out.of_a_pixel[kind] = of_a_pixel[kind].transpose();
  }
  return out;
}

TrackErrors& TrackErrors::operator+=(const TrackErrors& other) {
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    squares[kind] += other.squares[kind];
    weights[kind] += other.weights[kind];
  }
  return *this;
}

double TrackErrors::variance(std::size_t kind) const {
  return squares[kind] / std::max(weights[kind], 1e-30);
}

ScoreProducts products_of(const std::map<std::int64_t, TrackScores>& window,
                          const std::map<std::int64_t, TrackScores>& other) {
  ScoreProducts out;
  auto seen = other.begin();
  for (const auto& [id, scores] : window) {
    while (seen != other.end() && seen->first < id) {
      ++seen;
    }
    if (seen != other.end() && seen->first == id) {
      add_product(scores, seen->second, out);
    }
  }
  return out;
}

void append(const RigEvidence& window, std::vector<RigEvidence>& windows) {
  const std::size_t before = windows.size();
  RigEvidence& last = windows.emplace_back(window);
  for (std::size_t lag = 1; lag <= std::min(kSharedWindows, before); ++lag) {
    last.with_earlier.push_back(products_of(last.tracks, windows[before - lag].tracks));
  }
  if (before >= kSharedWindows) {
    windows[before - kSharedWindows].tracks.clear();
  }
}

void halve(std::vector<RigEvidence>& windows) {
  std::vector<RigEvidence> out;
  for (std::size_t k = 0; 2 * k < windows.size(); ++k) {
    RigEvidence& one = out.emplace_back(windows[2 * k]);
    if (2 * k + 1 < windows.size()) {
      const RigEvidence& next = windows[2 * k + 1];
      merge(next, one);
      if (!next.with_earlier.empty()) {
        one.products += next.with_earlier.front();
        one.products += next.with_earlier.front().transposed();
      }
    }
    one.with_earlier.clear();
    for (std::size_t lag = 1; lag <= std::min(kSharedWindows, k); ++lag) {
      one.with_earlier.push_back(halved(windows, k, lag));
    }
  }
  windows = std::move(out);
}

}  // namespace limber
