// SPDX-License-Identifier: MIT
#include "limber/update/gate.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <utility>

#include "limber/core/chi_square.hpp"
#include "limber/update/constraint.hpp"
#include "white_covariance.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// A residual whose variance the constraint cuts to less than this share is used up: it says nothing any
/// more.
constexpr double kUsedUp = 1e-9;

struct Distance {
  double squared = 0.0;
  Index dof = 0;
};

/// eᵀ B⁺ e, where B is what the constraint leaves of S. In units of S, so that a huge variance in one
/// direction (a new landmark's depth) does not hide what the others say.
Distance mahalanobis(const VectorXd& e, const MatrixXd& B, const MatrixXd& S) {
  const Eigen::LLT<MatrixXd> root(S);
  const VectorXd white_e = root.matrixL().solve(e);
  const MatrixXd half = root.matrixL().solve(B);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(root.matrixL().solve(half.transpose()));
  Distance out;
  for (Index k = 0; k < e.size(); ++k) {
    if (eigen.eigenvalues()(k) > kUsedUp) {
      const double component = eigen.eigenvectors().col(k).dot(white_e);
      out.squared += component * component / eigen.eigenvalues()(k);
      ++out.dof;
    }
  }
  return out;
}

/// Judges the groups still in play with S⁻¹ and the directions DC that the gain must not see; rows that were
/// dropped are zero in both.
class Judge {
 public:
  Judge(const Innovation& innovation, const MatrixXd& S, MatrixXd DC, double probability)
      : r_(innovation.r), S_(S), DC_(std::move(DC)), probability_(probability), llt_(S) {
    A_ = strong_directions(DC_);
    SinvA_ = A_.cols() > 0 ? MatrixXd(llt_.solve(A_)) : A_;  // Eigen solves for no column at its peril
    Sinvr_ = llt_.solve(r_);
  }

  [[nodiscard]] bool valid() const { return llt_.info() == Eigen::Success; }

  /// Judges the accepted groups; returns the one that exceeds its threshold most, or -1.
  Index worst(const std::vector<RowGroup>& groups, GateReport& report) {
    VectorXd delta(A_.cols());
    MatrixXd Minv(A_.cols(), A_.cols());
    if (A_.cols() > 0) {
      const Eigen::CompleteOrthogonalDecomposition<MatrixXd> M(A_.transpose() * SinvA_);
      delta = M.solve(A_.transpose() * Sinvr_);
      Minv = M.pseudoInverse();
    }
    Index worst = -1;
    double worst_ratio = 1.0;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (!report.accepted[g]) {
        continue;
      }
      const Index row = groups[g].row, rows = groups[g].rows;
      const MatrixXd A = A_.middleRows(row, rows);
      const MatrixXd S = S_.block(row, row, rows, rows);
      const Distance d = mahalanobis(r_.segment(row, rows) - A * delta, S - A * Minv * A.transpose(), S);
      report.distance[g] = d.squared;
      report.threshold[g] = quantile(d.dof);
      if (d.dof > 0 && d.squared > worst_ratio * report.threshold[g]) {
        worst_ratio = d.squared / report.threshold[g];
        worst = static_cast<Index>(g);
      }
    }
    return worst;
  }

  /// Takes the rows of a group out: block elimination in S⁻¹. What is left of D C may have fewer directions.
  void drop(const RowGroup& group) {
    if (Sinv_.size() == 0) {
      Sinv_ = llt_.solve(MatrixXd::Identity(S_.rows(), S_.cols()));
    }
    const MatrixXd column = Sinv_.middleCols(group.row, group.rows);
    const MatrixXd pivot = Sinv_.block(group.row, group.row, group.rows, group.rows);
    const MatrixXd scaled = pivot.llt().solve(column.transpose());  // V_ii⁻¹ V_i:
    Sinvr_ -= scaled.transpose() * Sinvr_.segment(group.row, group.rows).eval();
    Sinv_.noalias() -= column * scaled;
    DC_.middleRows(group.row, group.rows).setZero();
    A_ = strong_directions(DC_);
    SinvA_.noalias() = Sinv_ * A_;
  }

 private:
  double quantile(Index dof) {
    if (dof == 0) {
      return 0.0;
    }
    const auto [it, fresh] = quantiles_.try_emplace(dof, 0.0);
    if (fresh) {
      it->second = chi_square_quantile(probability_, static_cast<double>(dof));
    }
    return it->second;
  }

  const VectorXd& r_;
  const MatrixXd& S_;
  MatrixXd DC_;
  double probability_;
  Eigen::LLT<MatrixXd> llt_;
  MatrixXd A_;  // basis of the columns of DC_ without the weak directions
  MatrixXd SinvA_, Sinv_;
  VectorXd Sinvr_;
  std::map<Index, double> quantiles_;
};

}  // namespace

bool GateReport::all_accepted() const {
  return std::find(accepted.begin(), accepted.end(), false) == accepted.end();
}

GateReport gate(const Innovation& innovation, const std::vector<RowGroup>& groups,
                const ParameterErrorModel& treatment, double probability) {
  GateReport report{std::vector<bool>(groups.size(), true), std::vector<double>(groups.size(), 0.0),
                    std::vector<double>(groups.size(), 0.0)};
  const MatrixXd S = with_white_covariance(innovation, treatment);
  Judge judge(innovation, S,
              treatment.constrained.cols() > 0 ? MatrixXd(innovation.D * treatment.constrained)
                                               : MatrixXd(S.rows(), 0),
              probability);
  if (!judge.valid()) {
    return report;  // the update will say that S is singular
  }
  std::size_t dropped = 0;
  for (Index worst = judge.worst(groups, report); worst >= 0; worst = judge.worst(groups, report)) {
    if (2 * ++dropped > groups.size()) {
      report.accepted.assign(groups.size(), true);
      report.overruled = true;
      return report;
    }
    report.accepted[static_cast<std::size_t>(worst)] = false;
    judge.drop(groups[static_cast<std::size_t>(worst)]);
  }
  return report;
}

}  // namespace limber
