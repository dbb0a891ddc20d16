// SPDX-License-Identifier: MIT
#include "diagnose/clustered_regression.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "limber/core/chi_square.hpp"
#include "limber/core/median.hpp"

namespace limber::detail {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kHuber = 2.0;  // robust standard deviations
constexpr int kReweightings = 5;

/// Sums of Z Aᵀ and Z times the residual.
struct Sums {
  MatrixXd A;
  VectorXd b;
  explicit Sums(Eigen::Index n) : A(MatrixXd::Zero(n, n)), b(VectorXd::Zero(n)) {}
};

struct WeightedSums {
  Sums all;
  std::map<std::int64_t, Sums> of_cluster;
};

double robust_sigma(std::vector<double> residuals) {
  for (double& r : residuals) {
    r = std::abs(r);
  }
  return sigma_of_magnitudes(std::move(residuals));
}

/// The equations of a change of x, with the weights that x gives.
WeightedSums weighted_sums(const ClusteredRows& rows, const VectorXd& x) {
  std::vector<double> residuals;
  residuals.reserve(rows.y.size());
  for (std::size_t k = 0; k < rows.y.size(); ++k) {
    residuals.push_back(rows.y[k] - rows.A[k].dot(x));
  }
  const double limit = kHuber * robust_sigma(residuals);
  WeightedSums out{Sums(x.size()), {}};
  for (std::size_t k = 0; k < rows.y.size(); ++k) {
    const double size = std::abs(residuals[k]);
    const double weight = size <= limit || size == 0.0 ? 1.0 : limit / size;
    Sums& sums = out.of_cluster.try_emplace(rows.cluster[k], x.size()).first->second;
    sums.A += weight * rows.Z[k] * rows.A[k].transpose();
    sums.b += weight * residuals[k] * rows.Z[k];
  }
  for (const auto& [cluster, sums] : out.of_cluster) {
    out.all.A += sums.A;
    out.all.b += sums.b;
  }
  return out;
}

std::optional<VectorXd> step(const MatrixXd& A, const VectorXd& b) {
  const Eigen::FullPivLU<MatrixXd> factor(A);
  return factor.isInvertible() ? std::optional<VectorXd>(factor.solve(b)) : std::nullopt;
}

/// Covariance of x, by leaving out each cluster in turn.
std::optional<MatrixXd> jackknife(const WeightedSums& sums) {
  std::vector<VectorXd> left;
  VectorXd mean = VectorXd::Zero(sums.all.b.size());
  for (const auto& [cluster, part] : sums.of_cluster) {
    const auto without = step(sums.all.A - part.A, sums.all.b - part.b);
    if (!without) {
      return std::nullopt;
    }
    left.push_back(*without);
    mean += left.back() / static_cast<double>(sums.of_cluster.size());
  }
  MatrixXd squares = MatrixXd::Zero(mean.size(), mean.size());
  for (const VectorXd& value : left) {
    squares += (value - mean) * (value - mean).transpose();
  }
  const auto n = static_cast<double>(left.size());
  return MatrixXd(squares * ((n - 1.0) / n));
}

/// What equations say of each unknown beside the others.
VectorXd informations(const MatrixXd& A) { return A.inverse().diagonal().cwiseInverse(); }

/// One second of turning among ten at rest decides alone, and then nothing tells its error.
VectorXd degrees_of_freedom(const WeightedSums& sums) {
  const VectorXd all = informations(sums.all.A);
  VectorXd sum = VectorXd::Zero(all.size()), squares = sum;
  for (const auto& [cluster, part] : sums.of_cluster) {
    const VectorXd told = (all - informations(sums.all.A - part.A)).cwiseMax(0.0);
    sum += told;
    squares += told.cwiseAbs2();
  }
  return (sum.cwiseAbs2().array() / squares.array() - 1.0).matrix();
}

}  // namespace

std::optional<ClusteredSolution> solve(const ClusteredRows& rows) {
  VectorXd x = VectorXd::Zero(rows.A.front().size());
  for (int i = 0; i < kReweightings; ++i) {
    const WeightedSums sums = weighted_sums(rows, x);
    const auto change = step(sums.all.A, sums.all.b);
    if (!change) {
      return std::nullopt;
    }
    x += *change;
  }
  const WeightedSums sums = weighted_sums(rows, x);
  const auto covariance = jackknife(sums);
  if (!covariance) {
    return std::nullopt;
  }
  return ClusteredSolution{x, *covariance, degrees_of_freedom(sums)};
}

bool is_rarer_than(double chance, double sigmas, double dof) {
  constexpr double kLeastDof = 1.0;  // for less the law has no use
  return std::isinf(dof) || student_survival(sigmas, std::max(dof, kLeastDof)) < chance;
}

}  // namespace limber::detail
