// SPDX-License-Identifier: MIT
#include "limber/diagnose/bias_move.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <utility>
#include <vector>

#include "limber/core/median.hpp"
#include "limber/core/time.hpp"

namespace limber {
namespace {

constexpr std::array kStretches = {1.0, 2.0, 4.0, 8.0};  // [s]
constexpr double kTooFar = 12.0;  // sigmas: simulated sound runs show six at most (docs/evidence/faults.md)
constexpr double kLargestGyro = 0.2, kLargestAccel = 2.0;  // [rad/s], [m/s^2]
constexpr double kSure = 3.0;                              // sigmas
constexpr double kImpossibleFor = 1.0;                     // [s]

/// One axis of one bias over the run.
struct BiasAxis {
  bool of_gyro;
  Eigen::Index axis;
  std::vector<double> added{};  // variance that was added since the first row

  [[nodiscard]] double value(const TrajectoryRow& row) const {
    return (*(of_gyro ? row.bias_gyro : row.bias_accel))(axis);
  }
  [[nodiscard]] double variance(const TrajectoryRow& row) const {
    const double sigma = (*(of_gyro ? row.sigma_bias_gyro : row.sigma_bias_accel))(axis);
    return sigma * sigma;
  }
  void sum_up(std::span<const TrajectoryRow> rows) {
    added.assign(rows.size(), 0.0);
    for (std::size_t k = 1; k < rows.size(); ++k) {
      added[k] = added[k - 1] + std::max(variance(rows[k]) - variance(rows[k - 1]), 0.0);
    }
  }
  [[nodiscard]] double sigmas(std::span<const TrajectoryRow> rows, std::size_t from, std::size_t to) const {
    return std::abs(value(rows[to]) - value(rows[from])) /
           std::sqrt(variance(rows[from]) + added[to] - added[from]);
  }
};

bool has_biases(const TrajectoryRow& row) {
  return row.bias_gyro && row.bias_accel && row.sigma_bias_gyro && row.sigma_bias_accel;
}

bool is_impossible(const Eigen::Vector3d& bias, const Eigen::Vector3d& sigma, double largest) {
  return (bias.cwiseAbs() - kSure * sigma).maxCoeff() > largest;
}

std::vector<BiasAxis> axes_of(std::span<const TrajectoryRow> rows) {
  std::vector<BiasAxis> out;
  for (const bool of_gyro : {true, false}) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      out.push_back({of_gyro, axis});
      out.back().sum_up(rows);
    }
  }
  return out;
}

std::vector<std::int64_t> contradictions_in(std::span<const FrameReport> frames) {
  std::vector<std::int64_t> out;
  for (const FrameReport& frame : frames) {
    if (frame.inputs.status == InputStatus::kContradicted) {
      out.push_back(frame.t_ns);
    }
  }
  return out;
}

bool is_excused(std::span<const std::int64_t> contradictions, std::int64_t from_ns, std::int64_t to_ns) {
  return std::ranges::any_of(contradictions, [&](std::int64_t t_ns) {
    return seconds_between(t_ns, from_ns) < InputAlarm::kCalm &&
           seconds_between(to_ns, t_ns) < InputAlarm::kCalm;
  });
}

/// The last row at least that long before row `to`; nothing where the run is younger.
std::optional<std::size_t> row_before(std::span<const TrajectoryRow> rows, std::size_t to, double seconds) {
  const auto earlier = rows.first(to + 1);
  const auto behind = std::ranges::partition_point(
      earlier, [&](const TrajectoryRow& row) { return seconds_between(row.t_ns, rows[to].t_ns) >= seconds; });
  if (behind == earlier.begin()) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(behind - earlier.begin()) - 1;
}

/// A run whose biases may have moved.
struct BiasHistory {
  std::span<const TrajectoryRow> rows;
  std::vector<BiasAxis> axes;
  std::vector<std::int64_t> contradictions;

  /// Of the axis that moved furthest within that long [s] before row `to`; nothing where that is excused.
  [[nodiscard]] std::optional<BiasMove> largest(std::size_t to, double seconds) const {
    const auto from = row_before(rows, to, seconds);
    if (!from || is_excused(contradictions, rows[*from].t_ns, rows[to].t_ns)) {
      return std::nullopt;
    }
    BiasMove out{false, rows[*from].t_ns, rows[to].t_ns};
    for (const BiasAxis& axis : axes) {
      if (const double sigmas = axis.sigmas(rows, *from, to); sigmas > out.sigmas) {
        out.of_gyro = axis.of_gyro;
        out.size = std::abs(axis.value(rows[to]) - axis.value(rows[*from]));
        out.sigmas = sigmas;
      }
    }
    return out;
  }

  /// A quarter of the moves of a second are smaller.
  [[nodiscard]] double usual() const {
    std::vector<double> moves;
    for (std::size_t to = 0; to < rows.size(); ++to) {
      if (const auto move = largest(to, kStretches.front())) {
        moves.push_back(move->sigmas);
      }
    }
    return moves.empty() ? 0.0 : quantile(std::move(moves), 0.25);
  }
};

}  // namespace

bool BiasMove::is_sudden() const {
  return !after_contradiction && sigmas > kTooFar * std::max(usual_sigmas, 1.0);
}

std::optional<BiasMove> bias_beyond_its_sigma(std::span<const TrajectoryRow> rows,
                                              std::span<const FrameReport> frames) {
  if (rows.size() != frames.size()) {
    throw std::invalid_argument("bias moves: needs a frame for each row of the trajectory");
  }
  const auto begin = static_cast<std::size_t>(std::ranges::find_if(rows, has_biases) - rows.begin());
  rows = rows.subspan(begin);
  frames = frames.subspan(begin);
  if (!std::ranges::all_of(rows, has_biases)) {
    return std::nullopt;
  }
  const BiasHistory history{rows, axes_of(rows), contradictions_in(frames)};
  const double usual = history.usual();
  std::optional<BiasMove> first;
  for (std::size_t to = 0; to < rows.size(); ++to) {
    for (const double stretch : kStretches) {
      auto move = history.largest(to, stretch);
      if (move && move->sigmas > kTooFar) {
        move->usual_sigmas = usual;
        move->after_contradiction =
            !history.contradictions.empty() && history.contradictions.front() < move->from_ns;
        if (move->is_sudden()) {
          return move;
        }
        first = first ? first : move;
      }
    }
  }
  return first;
}

std::optional<std::int64_t> impossible_bias_since(std::span<const TrajectoryRow> rows) {
  std::optional<std::int64_t> since;
  for (const TrajectoryRow& row : rows) {
    if (!has_biases(row) || !(is_impossible(*row.bias_gyro, *row.sigma_bias_gyro, kLargestGyro) ||
                              is_impossible(*row.bias_accel, *row.sigma_bias_accel, kLargestAccel))) {
      since.reset();
      continue;
    }
    since = since.value_or(row.t_ns);
    if (seconds_between(*since, row.t_ns) >= kImpossibleFor) {
      return since;
    }
  }
  return std::nullopt;
}

}  // namespace limber
