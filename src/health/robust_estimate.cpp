// SPDX-License-Identifier: MIT
#include "limber/health/robust_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <span>

#include "limber/core/factors.hpp"
#include "limber/core/time.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kSize = NormalEquations::kSize;
/// What a window is taken to vary by, in variances within it, and how many windows that belief is worth.
constexpr double kOfAWindow = 3.0, kWorthWindows = 2.0;
/// Of the covariance by tracks, the share that is by their weights and a common variance, not by the score of
/// each.
constexpr double kByWeights = 0.5;

MatrixXd positive_part(const MatrixXd& M) {
  const SymmetricEigen eigen = symmetric_eigen(symmetric_part(M));
  const MatrixXd scaled = eigen.vectors * eigen.values.cwiseMax(0.0).asDiagonal();
  return multiply(scaled, transposed(eigen.vectors));
}

/// The larger of two covariances in every direction: a + positive part of (b − a).
MatrixXd larger(const MatrixXd& a, const MatrixXd& b) { return a + positive_part(b - a); }

/// Errors of a window: beta = sum over p of basis(p) x_p. Adds a Kronecker product with the bases of two.
void add_spread(const VectorXd& a, const VectorXd& b, const NormalEquations::Matrix& M, MatrixXd& sum) {
  for (Index i = 0; i < a.size(); ++i) {
    for (Index j = 0; j < b.size(); ++j) {
      if (const double share = a(i) * b(j); share != 0.0) {
        sum.block<kSize, kSize>(i * kSize, j * kSize) += share * M;
      }
    }
  }
}

void add_spread(const VectorXd& basis, const NormalEquations::Vector& v, VectorXd& sum) {
  for (Index i = 0; i < basis.size(); ++i) {
    sum.segment<kSize>(i * kSize) += basis(i) * v;
  }
}

NormalEquations::Vector at(const VectorXd& basis, const VectorXd& x) {
  NormalEquations::Vector out = NormalEquations::Vector::Zero();
  for (Index i = 0; i < basis.size(); ++i) {
    out += basis(i) * x.segment<kSize>(i * kSize);
  }
  return out;
}

struct Fit {
  VectorXd x;
  MatrixXd covariance, between;  // the second: part of the first that windows show, and clusters do not
};

/// Sums over clusters of score scoreᵀ.
struct Clusters {
  MatrixXd tracks, both;
};

/// What windows have to do with each other that see the same tracks.
enum class SharedTracks { kLeftOut, kCounted };

/// Few tracks may by chance have small scores: half of what counts is what they would be expected to have,
/// were errors of tracks alike.
Clusters by_track(const std::vector<RigEvidence>& windows, const std::vector<VectorXd>& basis,
                  SharedTracks shared) {
  TrackErrors errors;
  for (const RigEvidence& window : windows) {
    errors += window.errors;
  }
  const auto counted = [&](const ScoreProducts& products) -> NormalEquations::Matrix {
    NormalEquations::Matrix out = (1.0 - kByWeights) * products.tracks;
    for (std::size_t kind = 0; kind < kKinds; ++kind) {
      out += kByWeights * errors.variance(kind) * products.of_a_pixel[kind];
    }
    return out;
  };
  const Index size = basis.front().size() * kSize;
  Clusters out{MatrixXd::Zero(size, size), MatrixXd::Zero(size, size)}, between = out;
  for (std::size_t k = 0; k < windows.size(); ++k) {
    add_spread(basis[k], basis[k], counted(windows[k].products), out.tracks);
    add_spread(basis[k], basis[k], windows[k].products.both, out.both);
    const std::size_t lags =
        shared == SharedTracks::kCounted ? std::min(windows[k].with_earlier.size(), k) : 0;
    for (std::size_t lag = 1; lag <= lags; ++lag) {
      const ScoreProducts& products = windows[k].with_earlier[lag - 1];
      add_spread(basis[k], basis[k - lag], counted(products), between.tracks);
      add_spread(basis[k], basis[k - lag], products.both, between.both);
    }
  }
  out.tracks += between.tracks + between.tracks.transpose();
  out.both += between.both + between.both.transpose();
  return out;
}

/// Of a place in the image over all windows.
struct CellSums {
  MatrixXd information;
  VectorXd score;
};

/// Scores of places. A fit follows each place, the more the fewer there are, and what a smooth error of the
/// lens does in all of them, it follows altogether: counted is what each has in a fit without it (the
/// jackknife, CV3). Steps leave what lenses do out, and count scores as they are.
MatrixXd by_place(const std::map<int, CellSums>& cells, const MatrixXd& information, SharedTracks shared) {
  const auto count = static_cast<double>(cells.size());
  MatrixXd out = MatrixXd::Zero(information.rows(), information.rows());
  for (const auto& [cell, sums] : cells) {
    if (shared == SharedTracks::kCounted) {
      out += count / std::max(count - 1.0, 1.0) * sums.score * sums.score.transpose();
      continue;
    }
    const VectorXd score =
        multiply(information, Cholesky(information - sums.information).solve(sums.score).eval());
    out += (count - 1.0) / count * score * score.transpose();
  }
  return out;
}

/// Scores summed over clusters, V_track + V_cell − V_both, and windows as clusters as they become many.
/// @param basis  of each window; all alike in size. Zero: the window counts for nothing
Fit fit(const std::vector<RigEvidence>& windows, const std::vector<VectorXd>& basis,
        SharedTracks shared = SharedTracks::kLeftOut) {
  const Index size = basis.front().size() * kSize;
  const MatrixXd prior = NormalEquations::kPrior * MatrixXd::Identity(size, size);
  MatrixXd information = prior;
  VectorXd vector = VectorXd::Zero(size);
  for (std::size_t k = 0; k < windows.size(); ++k) {
    add_spread(basis[k], basis[k], windows[k].all.information, information);
    add_spread(basis[k], windows[k].all.vector, vector);
  }
  const MatrixXd inverse = Cholesky(information).inverse();
  const VectorXd x = inverse * vector;
  std::map<int, CellSums> cells;
  MatrixXd by_window = MatrixXd::Zero(size, size);
  const auto n = static_cast<double>(
      std::count_if(basis.begin(), basis.end(), [](const VectorXd& b) { return !b.isZero(0.0); }));
  const double dof = std::max(n - static_cast<double>(basis.front().size()), 0.0);
  for (std::size_t k = 0; k < windows.size(); ++k) {
    const NormalEquations::Vector beta = at(basis[k], x);
    for (const auto& [cell, sums] : windows[k].cells) {
      CellSums& sum =
          cells.try_emplace(cell, CellSums{MatrixXd::Zero(size, size), VectorXd::Zero(size)}).first->second;
      add_spread(basis[k], basis[k], sums.information, sum.information);
      add_spread(basis[k], sums.score(beta), sum.score);
    }
    VectorXd score = VectorXd::Zero(size);
    add_spread(basis[k], windows[k].all.score(beta), score);
    by_window += n / std::max(dof, 1.0) * score * score.transpose();
  }
  const MatrixXd by_cell = by_place(cells, information, shared);
  const Clusters clusters = by_track(windows, basis, shared);
  const MatrixXd within = positive_part(larger(clusters.tracks, clusters.tracks + by_cell - clusters.both));
  const MatrixXd expected = kOfAWindow * within;
  const MatrixXd meat = larger(within, (kWorthWindows * expected + dof * by_window) / (kWorthWindows + dof));
  return {x, multiply(multiply(inverse, meat + prior), inverse),
          multiply(multiply(inverse, meat - within), inverse)};
}

/// Mean of J Jᵀ over the points seen.
NormalEquations::Matrix mean_epipolar(const std::vector<RigEvidence>& windows) {
  NormalEquations::Matrix out = NormalEquations::Matrix::Zero();
  double points = 0.0;
  for (const RigEvidence& window : windows) {
    out += window.epipolar;
    points += static_cast<double>(window.points);
  }
  return out / std::max(points, 1.0);
}

/// What the trajectory's scale may be wrong by is along the baseline.
/// @param length    of that, as along_length
/// @param constant  part of it that is the same in all windows
NormalEquations::Matrix by_scale(std::span<const RigEvidence> windows, const NormalEquations::Vector& length,
                                 bool metric, double constant) {
  std::vector<const RigEvidence*> each;
  for (const RigEvidence& window : windows) each.push_back(&window);
  const double variance = metric ? constant * constant + mean_scale_variance(each) : kUnknownScale;
  return variance * length * length.transpose();
}

double middle(const RigEvidence& window, std::int64_t origin_ns) {
  return 0.5 * (seconds_between(origin_ns, window.from_ns) + seconds_between(origin_ns, window.to_ns));
}

}  // namespace

NormalEquations::Vector along_length(const RigParameters& theta, const NormalEquations::Vector& beta) {
  NormalEquations::Vector out = NormalEquations::Vector::Zero();
  out.segment<3>(3) =
      theta.tail<3>().cwiseQuotient(plausible_error(theta.tail<3>().norm()).tail<3>()) + beta.segment<3>(3);
  return out;
}

RigParameters RigEstimate::sigma() const { return covariance.diagonal().cwiseSqrt(); }

bool loses_scale(const BetaEstimate& estimate, const RigParameters& theta) {
  const double assumed = along_length(theta, NormalEquations::Vector::Zero()).norm();
  const double found = along_length(theta, estimate.beta).norm();
  return std::abs(found / assumed - 1.0) > std::sqrt(kUnknownScale);
}

BetaEstimate with_unknown_length(const BetaEstimate& estimate, const RigParameters& theta) {
  const NormalEquations::Vector found = along_length(theta, estimate.beta);
  const double assumed = along_length(theta, NormalEquations::Vector::Zero()).norm();
  const NormalEquations::Vector too_long = found - assumed * found.normalized();
  BetaEstimate out = estimate;
  out.covariance += too_long * too_long.transpose();
  return out;
}

BetaEstimate with_assumed_vergence(const BetaEstimate& estimate, const RigParameters& theta) {
  const Eigen::Index k = vergence_axis(theta);
  const NormalEquations::Vector by_vergence = estimate.covariance.col(k) / estimate.covariance(k, k);
  BetaEstimate out = estimate;
  out.beta -= estimate.beta(k) * by_vergence;
  out.covariance -= estimate.covariance(k, k) * by_vergence * by_vergence.transpose();
  return out;
}

BetaEstimate robust_estimate(const std::vector<RigEvidence>& windows, const RigParameters& theta,
                             bool metric) {
  const Fit found = fit(windows, std::vector<VectorXd>(windows.size(), VectorXd::Ones(1)));
  return {found.x, found.covariance + by_scale(windows, along_length(theta, found.x), metric, kLeastScale),
          mean_epipolar(windows)};
}

BetaTrend robust_trend(const std::vector<RigEvidence>& windows, const RigParameters& theta, bool metric) {
  const std::int64_t origin = windows.front().from_ns;
  const double first = middle(windows.front(), origin), last = middle(windows.back(), origin);
  const double end = seconds_between(origin, windows.back().to_ns);
  std::vector<VectorXd> basis;
  for (const RigEvidence& window : windows) {
    basis.emplace_back(Eigen::Vector2d(1.0, (middle(window, origin) - end) / (last - first)));
  }
  const Fit found = fit(windows, basis);
  const NormalEquations::Matrix epipolar = mean_epipolar(windows);
  const NormalEquations::Vector length = along_length(theta, found.x.head<kSize>());
  return {{found.x.head<kSize>(),
           found.covariance.topLeftCorner<kSize, kSize>() + by_scale(windows, length, metric, kLeastScale),
           epipolar},
          {found.x.tail<kSize>(), found.covariance.bottomRightCorner<kSize, kSize>(), epipolar},
          found.covariance.topRightCorner<kSize, kSize>(),
          last - first};
}

std::vector<BetaEstimate> robust_waves(const std::vector<RigEvidence>& windows, std::size_t count) {
  const std::int64_t origin = windows.front().from_ns;
  const double end = seconds_between(origin, windows.back().to_ns);
  const NormalEquations::Matrix epipolar = mean_epipolar(windows);
  std::vector<BetaEstimate> out;
  for (std::size_t k = 0; k < count; ++k) {
    std::vector<VectorXd> basis;
    for (const RigEvidence& window : windows) {
      const double t = middle(window, origin) / end;
      basis.emplace_back(
          Eigen::Vector3d(1.0, t, std::cos(std::numbers::pi * static_cast<double>(k + 2) * t)));
    }
    const Fit found = fit(windows, basis);
    out.push_back({found.x.tail<kSize>(), found.covariance.bottomRightCorner<kSize, kSize>(), epipolar});
  }
  return out;
}

BetaEstimate with_drift_within(const BetaTrend& trend, const NormalEquations::Matrix& expected) {
  const NormalEquations::Matrix gain =
      Cholesky(trend.change.covariance + expected).solve(trend.covariance.transpose()).transpose();
  BetaEstimate out = trend.now;
  out.beta -= gain * trend.change.beta;
  out.covariance -= gain * trend.covariance.transpose();
  return out;
}

std::vector<BetaEstimate> robust_steps(const std::vector<RigEvidence>& windows,
                                       const std::vector<std::size_t>& firsts, const RigParameters& theta,
                                       bool metric) {
  const auto states = static_cast<Index>(firsts.size()) + 1;
  std::vector<VectorXd> basis;
  for (std::size_t k = 0; k < windows.size(); ++k) {
    VectorXd steps = VectorXd::Zero(states);
    if (std::find(firsts.begin(), firsts.end(), k + 1) == firsts.end()) {
      const auto taken = std::count_if(firsts.begin(), firsts.end(), [k](std::size_t f) { return k >= f; });
      steps.head(taken + 1).setOnes();
    }
    basis.push_back(std::move(steps));
  }
  const Fit found = fit(windows, basis, SharedTracks::kCounted);
  const NormalEquations::Matrix epipolar = mean_epipolar(windows);
  std::vector<BetaEstimate> out;
  for (Index k = 1; k < states; ++k) {
    out.push_back({found.x.segment<kSize>(k * kSize),
                   found.covariance.block<kSize, kSize>(k * kSize, k * kSize), epipolar,
                   found.between.block<kSize, kSize>(k * kSize, k * kSize)});
    if (metric) {
      const auto at = static_cast<std::size_t>(k - 1);
      const std::size_t from = at == 0 ? 0 : firsts[at - 1];
      const std::size_t to = at + 1 == firsts.size() ? windows.size() : firsts[at + 1] - 1;
      const std::span<const RigEvidence> all(windows);
      const NormalEquations::Vector length = along_length(theta, found.x.head<kSize>());
      out.back().covariance += by_scale(all.subspan(from, firsts[at] - 1 - from), length, metric, 0.0) +
                               by_scale(all.subspan(firsts[at], to - firsts[at]), length, metric, 0.0);
    }
  }
  return out;
}

RigEstimate BetaEstimate::rig(const RigParameters& theta) const {
  const RigParameters scale = plausible_error(theta.tail<3>().norm());
  return {scale.cwiseProduct(beta.head<6>()),
          scale.asDiagonal() * covariance.topLeftCorner<6, 6>() * scale.asDiagonal()};
}

}  // namespace limber
