// SPDX-License-Identifier: MIT
#include "limber/update/gate.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "limber/core/chi_square.hpp"
#include "limber/core/factors.hpp"
#include "limber/update/consensus.hpp"
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

/// How far what is constrained may be off, in plausible errors, for finding what most groups agree upon.
constexpr double kWidestOffset = 10.0;

struct Distance {
  double squared = 0.0;
  Index dof = 0;
};

/// eᵀ B⁺ e, where B is what the constraint leaves of the identity: in units of S, so that a huge variance in
/// one direction (a new landmark's depth) does not hide what the others say.
Distance mahalanobis(const VectorXd& e, const MatrixXd& B) {
  const Cholesky root(B);
  // No eigenvalue exceeds one, so that none is smaller than the determinant.
  const double diagonal = root.factor().diagonal().prod();
  if (root.succeeded() && diagonal * diagonal > 10.0 * kUsedUp) {
    VectorXd white = e;
    solve_lower(root.factor(), white);
    return {white.squaredNorm(), e.size()};
  }
  const SymmetricEigen eigen = symmetric_eigen(B);
  Distance out;
  for (Index k = 0; k < e.size(); ++k) {
    if (eigen.values(k) > kUsedUp) {
      const double component = eigen.vectors.col(k).dot(e);
      out.squared += component * component / eigen.values(k);
      ++out.dof;
    }
  }
  return out;
}

/// What is judged: residual, its covariance, and the directions that the gain must not see.
struct Judged {
  VectorXd r;
  MatrixXd S;
  MatrixXd DC;
  std::vector<RowGroup> groups;

  /// The same without the groups that are not kept.
  [[nodiscard]] Judged subset(const std::vector<bool>& kept) const {
    Judged out;
    std::vector<Index> rows;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (kept[g]) {
        out.groups.push_back({static_cast<Index>(rows.size()), groups[g].rows, groups[g].own});
        for (Index k = 0; k < groups[g].rows; ++k) {
          rows.push_back(groups[g].row + k);
        }
      }
    }
    out.r = r(rows);
    out.S = S(rows, rows);
    out.DC = DC(rows, Eigen::all);
    return out;
  }
};

/// Judges the groups still in play. Dropping a group is block elimination in V = S⁻¹, of which only the
/// products that the judgement needs are kept, as V = S⁻¹ − U Uᵀ: O(m²) each.
class Judge {
 public:
  Judge(const Judged& judged, double probability)
      : z_(judged), probability_(probability), llt_(judged.S), DC_(judged.DC), U_(judged.S.rows(), 0) {
    Vr_ = llt_.solve(z_.r);
    VDC_ = llt_.solve(DC_);
    white_r_ = z_.r;
    white_DC_ = DC_;
    for (const RowGroup& group : z_.groups) {
      const Cholesky root(z_.S.block(group.row, group.row, group.rows, group.rows));
      solve_lower(root.factor(), white_r_.segment(group.row, group.rows));
      solve_lower(root.factor(), white_DC_.middleRows(group.row, group.rows));
    }
  }

  [[nodiscard]] bool valid() const { return llt_.succeeded(); }

  /// Judges the accepted groups; returns the one that exceeds its threshold most, or -1.
  Index worst(GateReport& report) {
    const MatrixXd T = strong_combinations(DC_);
    VectorXd delta(T.cols());
    MatrixXd Minv(T.cols(), T.cols());
    if (T.cols() > 0) {
      const MatrixXd M = congruence(transposed(T), multiply(transposed(DC_), VDC_));
      PseudoInverse pseudo = pseudo_inverse(M, T.transpose() * (DC_.transpose() * Vr_));
      delta = std::move(pseudo.x);
      Minv = std::move(pseudo.matrix);
    }
    const MatrixXd white_A = multiply(white_DC_, T);
    Index worst = -1;
    double worst_ratio = 1.0;
    for (std::size_t g = 0; g < z_.groups.size(); ++g) {
      if (!report.accepted[g]) {
        continue;
      }
      const Index row = z_.groups[g].row, rows = z_.groups[g].rows;
      const auto A = white_A.middleRows(row, rows);
      Distance d{white_r_.segment(row, rows).squaredNorm(), rows};
      if (!A.isZero(0.0)) {
        d = mahalanobis(white_r_.segment(row, rows) - A * delta,
                        MatrixXd::Identity(rows, rows) - congruence(A, Minv));
      }
      report.distance[g] = d.squared;
      report.threshold[g] = quantile(d.dof);
      if (d.dof > 0 && d.squared > worst_ratio * report.threshold[g]) {
        worst_ratio = d.squared / report.threshold[g];
        worst = static_cast<Index>(g);
      }
    }
    return worst;
  }

  /// Takes the rows of a group out. What is left of D C may have fewer directions.
  void drop(const RowGroup& group) {
    MatrixXd column = MatrixXd::Zero(z_.r.size(), group.rows);  // of V
    column.middleRows(group.row, group.rows).setIdentity();
    column = llt_.solve(column);
    add_product(column, -1.0, U_, transposed(U_.middleRows(group.row, group.rows)));
    const Cholesky pivot(column.middleRows(group.row, group.rows));
    solve_lower_from_right(transposed(pivot.factor()), column);  // V := V − column columnᵀ
    Vr_ -= column * (column.transpose() * z_.r);
    add_product(VDC_, -1.0, column, multiply(transposed(column), z_.DC));
    DC_.middleRows(group.row, group.rows).setZero();
    U_.conservativeResize(Eigen::NoChange, U_.cols() + column.cols());
    U_.rightCols(column.cols()) = column;
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

  const Judged& z_;
  double probability_;
  Cholesky llt_;
  MatrixXd DC_;              // rows that were dropped are zero
  MatrixXd U_;               // of what was dropped
  VectorXd Vr_, white_r_;    // V r; r in units of the groups' own S
  MatrixXd VDC_, white_DC_;  // V D C; " D C
  std::map<Index, double> quantiles_;
};

/// Drops the worst group as long as one fails. @return false if more than half failed
bool eliminate(Judge& judge, const std::vector<RowGroup>& groups, std::size_t most, GateReport& report) {
  std::size_t dropped = 0;
  for (Index worst = judge.worst(report); worst >= 0; worst = judge.worst(report)) {
    if (++dropped > most) {
      return false;
    }
    report.accepted[static_cast<std::size_t>(worst)] = false;
    judge.drop(groups[static_cast<std::size_t>(worst)]);
  }
  return true;
}

GateReport nothing_refused(std::size_t groups) {
  return {std::vector<bool>(groups, true), std::vector<double>(groups, 0.0),
          std::vector<double>(groups, 0.0)};
}

/// Flags the groups that lie far from what most agree upon. @return how many
std::size_t flag_gross(const Judged& judged, double probability, GateReport& report) {
  const Consensus consensus = find_consensus(judged.r, judged.S, judged.groups, kWidestOffset * judged.DC);
  std::size_t gross = 0;
  for (std::size_t g = 0; g < judged.groups.size(); ++g) {
    const double threshold = chi_square_quantile(probability, static_cast<double>(judged.groups[g].rows));
    if (consensus.distance[g] > kGrossOutlier * threshold) {
      report.accepted[g] = false;
      report.distance[g] = consensus.distance[g];
      report.threshold[g] = threshold;
      ++gross;
    }
  }
  return gross;
}

/// Without the gross outliers, the others in turn.
GateReport gate_robustly(const Judged& judged, GateReport flagged, std::size_t gross, double probability) {
  const Judged rest = judged.subset(flagged.accepted);
  Judge judge(rest, probability);
  GateReport inner = nothing_refused(rest.groups.size());
  const std::size_t half = judged.groups.size() / 2;
  const std::size_t most = gross <= half ? half - gross : rest.groups.size() / 4;
  if (judge.valid() && !eliminate(judge, rest.groups, most, inner)) {
    inner.accepted.assign(rest.groups.size(), true);
    flagged.overruled = true;
  }
  std::size_t k = 0;
  for (std::size_t g = 0; g < judged.groups.size(); ++g) {
    if (flagged.accepted[g]) {
      flagged.accepted[g] = inner.accepted[k];
      flagged.distance[g] = inner.distance[k];
      flagged.threshold[g] = inner.threshold[k];
      ++k;
    }
  }
  return flagged;
}

}  // namespace

bool GateReport::all_accepted() const {
  return std::find(accepted.begin(), accepted.end(), false) == accepted.end();
}

GateReport gate(const Innovation& innovation, const std::vector<RowGroup>& groups,
                const ParameterErrorModel& treatment, double probability) {
  const Judged judged{innovation.r, with_white_covariance(innovation, treatment),
                      treatment.constrained.cols() > 0 ? multiply(innovation.D, treatment.constrained)
                                                       : MatrixXd(innovation.r.size(), 0),
                      groups};
  GateReport report = nothing_refused(groups.size());
  Judge judge(judged, probability);
  if (!judge.valid()) {
    return report;  // the update will say that S is singular
  }
  const Index worst = judge.worst(report);
  if (worst < 0) {
    return report;
  }
  GateReport flagged = nothing_refused(groups.size());
  const std::size_t gross = flag_gross(judged, probability, flagged);
  // What is constrained cannot put most points far from each other; what is trusted can.
  const bool trusts = treatment.constrained.cols() == 0;
  if (gross > 0 && (trusts ? 2 : 3) * gross <= (trusts ? 1 : 2) * groups.size()) {
    return gate_robustly(judged, std::move(flagged), gross, probability);
  }
  if (!eliminate(judge, groups, groups.size() / 2, report)) {
    report.accepted.assign(groups.size(), true);
    report.overruled = true;
  }
  return report;
}

}  // namespace limber
