// SPDX-License-Identifier: MIT
#include "limber/run/rig_parts.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <stdexcept>
#include <vector>

#include "limber/core/factors.hpp"

namespace limber {
namespace {

using Eigen::Index;

struct Sum {
  RigMatrix information = RigMatrix::Zero();
  RigParameters weighted = RigParameters::Zero();  ///< information times what to add to the given rig
};

Sum sum_of(std::span<const RigPart> windows, const RigParameters& given) {
  Sum out;
  for (const RigPart& window : windows) {
    out.information += window.information;
    out.weighted += window.information * (window.theta - given);
  }
  return out;
}

constexpr double kSurelyOff = 3.0;  // standard deviations

std::vector<Index> axes_of(const RigAxes& axes) {
  std::vector<Index> out;
  for (Index k = 0; k < 6; ++k) {
    if (axes[static_cast<std::size_t>(k)]) {
      out.push_back(k);
    }
  }
  return out;
}

/// Rows and columns of axes that are left alone, as if they were known.
RigFit solve(const Sum& sum, const RigParameters& given, const RigAxes& seen) {
  const std::vector<Index> free = axes_of(seen);
  RigFit out;
  out.theta = given;
  out.seen = seen;
  if (!free.empty()) {
    const Eigen::MatrixXd information = sum.information(free, free);
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(information);
    const Eigen::VectorXd step = ldlt.solve(Eigen::VectorXd(sum.weighted(free)));
    out.theta(free) += step;
    const Eigen::MatrixXd covariance =
        ldlt.solve(Eigen::MatrixXd::Identity(information.rows(), information.cols()));
    out.covariance(free, free) = covariance;
  }
  return out;
}

/// Variance of the differences between windows over what their information says.
double spread_of(std::span<const RigPart> windows, const RigFit& fit) {
  double dof = -static_cast<double>(fit.seen.count());
  for (const RigPart& window : windows) {  // axes that are left alone differ between windows, too
    dof += static_cast<double>((window.information.diagonal().array() > 0.0).count());
  }
  return dof > 0.0 ? std::max(1.0, misfit(windows, fit.theta) / dof) : 1.0;
}

/// `a`, as large as `b` in the directions in which that is larger, whatever the units.
Eigen::MatrixXd widened(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const Eigen::MatrixXd L = Cholesky(a).L();
  const Eigen::MatrixXd half = L.triangularView<Eigen::Lower>().solve(b);
  const SymmetricEigen eigen =
      symmetric_eigen(L.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd(half.transpose())));
  const Eigen::MatrixXd root = L * eigen.vectors * eigen.values.cwiseMax(1.0).cwiseSqrt().asDiagonal();
  return root * root.transpose();
}

/// Degrees of freedom of so many cells as count. Cells with few points count less (Carter, Schnepel and
/// Steigerwald 2017: the effective number of clusters).
/// @param shares  of the information, by cell
double degrees_of(const std::vector<double>& shares) {
  constexpr double kFewest = 3.0;
  double sum = 0.0, squares = 0.0;
  for (const double share : shares) {
    sum += share;
    squares += share * share;
  }
  return std::max(squares > 0.0 ? sum * sum / squares - 1.0 : 0.0, kFewest);
}

/// A covariance that few samples gave, which makes its small directions too small and its large ones too
/// large, drawn towards the shape of `target`: the oracle approximating shrinkage [Chen2010].
/// @param dof  of the samples
Eigen::MatrixXd shrunk(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& target, double dof) {
  const Eigen::MatrixXd L = Cholesky(target).L();
  const Eigen::MatrixXd half = L.triangularView<Eigen::Lower>().solve(covariance);
  const Eigen::MatrixXd white = L.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd(half.transpose()));
  const auto p = static_cast<double>(white.rows());
  const double trace = white.trace(), square = white.squaredNorm();
  const double unequal = square - trace * trace / p;
  if (p < 2.0 || !(unequal > 0.0)) {
    return covariance;
  }
  const double share =
      std::min(1.0, ((1.0 - 2.0 / p) * square + trace * trace) / ((dof + 1.0 - 2.0 / p) * unequal));
  return (1.0 - share) * covariance + share * trace / p * target;
}

/// The covariance of theta if the points of one image cell err together in all windows and those of different
/// cells do not: the cells are left out one after the other. Zero without two cells.
/// @param inverse  of the information of the windows
Eigen::MatrixXd by_cells(std::span<const RigPart> windows, const std::vector<Index>& free,
                         const Eigen::MatrixXd& inverse) {
  std::map<int, CellScore> cells;
  RigMatrix of_points = RigMatrix::Zero(), of_all = RigMatrix::Zero();
  for (const RigPart& window : windows) {
    of_all += window.information;
    for (const auto& [cell, score] : window.scores) {
      cells[cell].pull += score.pull;
      cells[cell].information += score.information;
      of_points += score.information;
    }
  }
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(inverse.rows(), inverse.cols());
  if (cells.size() < 2) return sum;
  // With what is known beside the points: a length that is trusted.
  const Eigen::MatrixXd all = widened(of_all(free, free), of_points(free, free));
  const auto count = static_cast<double>(cells.size());
  std::vector<double> shares;
  for (const auto& [cell, score] : cells) {
    shares.push_back((inverse * score.information(free, free)).trace());
    // What the others would have to make up for: (1 − its share)⁻¹.
    const Eigen::VectorXd step = inverse * Eigen::VectorXd(score.pull(free));
    const Eigen::VectorXd without =
        solve_symmetric(Eigen::MatrixXd(all - score.information(free, free)), Eigen::VectorXd(all * step));
    sum += (count - 1.0) / count * without * without.transpose();
  }
  const double dof = degrees_of(shares);
  return dof / (dof - 2.0) * shrunk(sum, inverse, dof);  // the variance of Student's t
}

/// What axes that are left as given may be off by, which is their bounds, goes into the others by what the
/// windows say of both.
void add_left_alone(const Sum& sum, const RigParameters& bounds, RigFit& fit) {
  const std::vector<Index> free = axes_of(fit.seen), left = axes_of(~fit.seen);
  Eigen::MatrixXd by_left = Eigen::MatrixXd::Identity(6, 6)(Eigen::all, left);
  if (!free.empty() && !left.empty()) {
    const Eigen::MatrixXd information = sum.information(free, free), shared = sum.information(free, left);
    by_left(free, Eigen::all) = -information.ldlt().solve(shared);
  }
  const Eigen::VectorXd variances = bounds.cwiseAbs2()(left);
  fit.covariance += by_left * variances.asDiagonal() * by_left.transpose();
}

/// What was found is further from what was given than its own standard deviation explains.
bool surely_off(const RigFit& fit, const RigParameters& given, Index axis) {
  const double off = fit.theta(axis) - given(axis);
  return off * off > kSurelyOff * kSurelyOff * fit.covariance(axis, axis);
}

/// The seen axis whose standard deviation is furthest above its bound, but for those that are surely off;
/// nothing if none is.
std::optional<Index> worst_axis(const RigFit& fit, const RigParameters& given, const RigParameters& bounds) {
  std::optional<Index> worst;
  double most = 1.0;
  for (Index k = 0; k < 6; ++k) {
    const double ratio = fit.covariance(k, k) / (bounds(k) * bounds(k));
    if (fit.seen[static_cast<std::size_t>(k)] && !(ratio >= 0.0 && ratio <= most) &&
        !surely_off(fit, given, k)) {
      most = ratio;
      worst = k;
    }
  }
  return worst;
}

}  // namespace

double misfit(std::span<const RigPart> windows, const RigParameters& theta) {
  double out = 0.0;
  for (const RigPart& window : windows) {
    const RigParameters d = theta - window.theta;
    out += d.dot(window.information * d);
  }
  return out;
}

RigFit fit_rig(std::span<const RigPart> windows, const RigParameters& given, const RigParameters& bounds) {
  if (windows.empty()) {
    throw std::invalid_argument("fit_rig: no window");
  }
  const Sum sum = sum_of(windows, given);
  RigAxes seen;
  for (Index k = 0; k < 6; ++k) {  // else not even with all others known
    seen[static_cast<std::size_t>(k)] = sum.information(k, k) * bounds(k) * bounds(k) > 1.0;
  }
  for (;;) {
    RigFit fit = solve(sum, given, seen);
    fit.spread = spread_of(windows, fit);
    if (const std::vector<Index> free = axes_of(seen); !free.empty()) {
      const Eigen::MatrixXd inverse = fit.covariance(free, free);
      fit.covariance(free, free) = widened(fit.spread * inverse, by_cells(windows, free, inverse));
    }
    const std::optional<Index> worst = worst_axis(fit, given, bounds);
    if (!worst) {
      add_left_alone(sum, bounds, fit);
      return fit;
    }
    seen.reset(static_cast<std::size_t>(*worst));
  }
}

HeldOut held_out(std::span<const RigPart> windows, const RigParameters& given, const RigParameters& bounds) {
  HeldOut out;
  if (windows.size() < 2) {
    return out;
  }
  std::array<std::vector<RigPart>, 2> halves;
  for (std::size_t k = 0; k < windows.size(); ++k) {
    halves[k % 2].push_back(windows[k]);
  }
  for (std::size_t half = 0; half < 2; ++half) {
    const RigFit fit = fit_rig(halves[half], given, bounds);
    out.given += misfit(halves[1 - half], given);
    out.fitted += misfit(halves[1 - half], fit.theta);
  }
  return out;
}

}  // namespace limber
