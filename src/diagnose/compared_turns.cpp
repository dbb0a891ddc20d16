// SPDX-License-Identifier: MIT
#include "diagnose/compared_turns.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "limber/core/so3.hpp"

namespace limber::detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kAround = 0.15;  // length of what is before and behind a turn [s]
constexpr double kBin = 0.2;      // where steps may be [s]
constexpr std::int64_t kBinsOfCluster = 5;
constexpr std::size_t kMostSteps = 4;
constexpr Eigen::Index kBiasSize = 3;    // columns of a bias
constexpr std::size_t kFewestBins = 20;  // on either side of a step
constexpr double kSureRatio = 20.0;      // of what a step explains to what is left, by degrees of freedom

/// A mount that is turned, and a scale of each axis of the gyro.
Matrix3Xd turned_and_scaled(const Vector3d& gyro) {
  Matrix3Xd columns(3, 6);
  columns << skew(gyro), Matrix3d(gyro.asDiagonal());
  return columns;
}

struct Residual {
  Vector3d sum = Vector3d::Zero();  ///< by axis
  double count = 0.0;               ///< of turns
  void add(const Residual& other) {
    sum += other.sum;
    count += other.count;
  }
};

using Residuals = std::map<std::int64_t, Residual>;  ///< by bin

/// Beside a mount that may be turned, scales and a clock.
std::optional<Residuals> residuals_beside(const std::vector<Compared>& compared, const BiasSteps& steps) {
  const ClusteredRows rows = rows_of(compared, steps, turned_and_scaled);
  const auto solution = solve(rows);
  if (!solution) {
    return std::nullopt;
  }
  Residuals out;
  for (std::size_t k = 0; k < rows.y.size(); ++k) {
    Residual& bin = out[compared[k / kBiasSize].bin];
    bin.sum(static_cast<Eigen::Index>(k % kBiasSize)) += rows.y[k] - rows.A[k].dot(solution->x);
    bin.count += 1.0 / static_cast<double>(kBiasSize);
  }
  return out;
}

/// From where on the residuals are on average another: the largest of their cumulated sums, each against what
/// chance gives there; nothing with too few bins on either side.
std::optional<std::int64_t> largest_break(const Residuals& residuals) {
  Residual all, before;
  for (const auto& [bin, part] : residuals) {
    all.add(part);
  }
  std::optional<std::int64_t> found;
  double most = 0.0;
  std::size_t bins = 0;
  for (const auto& [bin, part] : residuals) {
    if (bins >= kFewestBins && residuals.size() - bins >= kFewestBins) {
      const double size = (before.sum - before.count / all.count * all.sum).squaredNorm() /
                          (before.count * (all.count - before.count));
      if (size > most) {
        most = size;
        found = bin;
      }
    }
    before.add(part);
    ++bins;
  }
  return found;
}

/// Steps of the bias, and the squares of what they leave in the means of seconds.
struct Explained {
  BiasSteps steps;
  double squares = 0.0, dof = 0.0;
  std::optional<std::int64_t> next;  ///< where another step would explain most
};

Explained explain(const std::vector<Compared>& compared, BiasSteps steps) {
  Explained out{std::move(steps), std::numeric_limits<double>::infinity(), 1.0, {}};
  if (const auto residuals = residuals_beside(compared, out.steps)) {
    out.squares = 0.0;
    Residuals clusters;
    for (const auto& [bin, part] : *residuals) {
      clusters[bin / kBinsOfCluster].add(part);
    }
    for (const auto& [cluster, part] : clusters) {
      out.squares += part.sum.squaredNorm() / part.count;
    }
    const auto unknowns = static_cast<double>(turned_and_scaled(Vector3d::Zero()).cols() + 1) +
                          static_cast<double>(kBiasSize) * static_cast<double>(1 + out.steps.size());
    out.dof = static_cast<double>(kBiasSize) * static_cast<double>(clusters.size()) - unknowns;
    out.next = largest_break(*residuals);
  }
  return out;
}

/// Fisher's ratio: more steps explain more than chance does.
bool is_better(const Explained& more, const Explained& fewer) {
  const auto added =
      static_cast<double>(kBiasSize) * static_cast<double>(more.steps.size() - fewer.steps.size());
  return more.dof > 0.0 && (fewer.squares - more.squares) / added > kSureRatio * more.squares / more.dof;
}

}  // namespace

std::vector<Compared> compare(const std::vector<Turn>& turns, const GyroAttitude& gyro, double tau) {
  std::vector<Compared> out;
  const double sample = gyro.sample_time();
  for (const Turn& turn : turns) {
    const double begin = turn.begin_s + tau, end = turn.end_s + tau;
    const auto mean = gyro.mean_rate(begin, end), first = gyro.rate(begin), last = gyro.rate(end);
    const auto before = gyro.mean_rate(begin - sample - kAround, begin - sample),
               behind = gyro.mean_rate(end + sample, end + sample + kAround);
    if (mean && first && last && before && behind) {
      out.push_back({turn.rate, *mean, (*last - *first) / (end - begin),
                     (*behind - *before) / (end - begin + 2.0 * sample + kAround),
                     static_cast<std::int64_t>(turn.begin_s / kBin)});
    }
  }
  return out;
}

std::int64_t cluster_of(const Compared& turn) { return turn.bin / kBinsOfCluster; }

ClusteredRows rows_of(const std::vector<Compared>& compared, const BiasSteps& steps, const Columns& more) {
  ClusteredRows rows;
  const Eigen::Index tau = kBiasSize * (1 + static_cast<Eigen::Index>(steps.size()));
  for (const Compared& turn : compared) {
    const Matrix3Xd columns = more(turn.gyro);
    for (Eigen::Index axis = 0; axis < kBiasSize; ++axis) {
      VectorXd row = VectorXd::Zero(tau + 1 + columns.cols());
      row(axis) = 1.0;
      for (std::size_t k = 0; k < steps.size(); ++k) {
        row(kBiasSize * (1 + static_cast<Eigen::Index>(k)) + axis) = turn.bin >= steps[k] ? 1.0 : 0.0;
      }
      row.tail(columns.cols()) = columns.row(axis);
      row(tau) = turn.slope(axis);
      rows.A.push_back(row);
      row(tau) = turn.around(axis);
      rows.Z.push_back(row);
      rows.y.push_back(turn.camera(axis) - turn.gyro(axis));
      rows.cluster.push_back(cluster_of(turn));
    }
  }
  return rows;
}

BiasSteps bias_steps(const std::vector<Compared>& compared) {
  Explained best = explain(compared, {}), tried = best;
  while (tried.steps.size() < kMostSteps && tried.next &&  // one of two steps alone may explain nothing
         std::ranges::find(tried.steps, *tried.next) == tried.steps.end()) {
    BiasSteps more = tried.steps;
    more.push_back(*tried.next);
    tried = explain(compared, std::move(more));
    best = is_better(tried, best) ? tried : best;
  }
  for (std::size_t k = best.steps.size(); k-- > 0;) {  // those that others made superfluous
    BiasSteps fewer = best.steps;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(k));
    const Explained without = explain(compared, std::move(fewer));
    best = is_better(best, without) ? best : without;
  }
  return best.steps;
}

}  // namespace limber::detail
