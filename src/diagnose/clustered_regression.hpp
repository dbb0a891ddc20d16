// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

namespace limber::detail {

/// Rows of y = A x + noise; rows of one cluster share their noise. Z are the instruments: the same as A, but
/// where A is measured with noise, something that goes with it and has noise of its own. Without them noise
/// in A would make x too small.
struct ClusteredRows {
  std::vector<Eigen::VectorXd> A, Z;
  std::vector<double> y;
  std::vector<std::int64_t> cluster;
};

struct ClusteredSolution {
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance;  ///< of x
  /// Of the sigma of each of x, in the sense of Student's law: one less than there would be clusters if all
  /// told as much of it.
  Eigen::VectorXd dof;

  [[nodiscard]] double sigma(Eigen::Index k) const { return std::sqrt(covariance(k, k)); }
  [[nodiscard]] double last() const { return x(x.size() - 1); }
  [[nodiscard]] double sigma_of_last() const { return sigma(x.size() - 1); }
  [[nodiscard]] double dof_of_last() const { return dof(x.size() - 1); }
};

/// @brief Instrumental variables with Huber weights. The covariance is the jackknife's: how the
/// solution changes as each cluster in turn is left out. It sees the clusters that alone decide, which a
/// sandwich covariance does not.
/// @param rows  not empty
/// @return nothing where x is not determined, or rests on one cluster
[[nodiscard]] std::optional<ClusteredSolution> solve(const ClusteredRows& rows);

/// @brief Whether chance puts a value that many sigmas off more seldom than that, by Student's law with one
/// degree of freedom at least. Always where sigma is known (infinite dof): its number is the judge then.
[[nodiscard]] bool is_rarer_than(double chance, double sigmas, double dof);

}  // namespace limber::detail
