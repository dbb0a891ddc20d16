// SPDX-License-Identifier: MIT
#include "limber/update/gate.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "kept_rows.hpp"
#include "limber/core/chi_square.hpp"
#include "limber/core/factors.hpp"
#include "limber/update/consensus.hpp"
#include "limber/update/constraint.hpp"
#include "limber/update/white_groups.hpp"

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

/// Groups that agree with the prediction are no chance, and carry the state.
constexpr std::size_t kEnoughAgree = 5;

constexpr double kRankCut = 1e-9;  // of the largest singular value

constexpr Index kPose = 6;  // rows of the state: it comes first

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
  VectorXd r;   ///< rows of S, then rows that no state moves: their covariance is the identity
  MatrixXd S;   ///< of the first
  MatrixXd DC;  ///< of all
  std::vector<RowGroup> groups;

  [[nodiscard]] Index stateless() const { return r.size() - S.rows(); }

  /// The same without the groups that are not kept.
  [[nodiscard]] Judged subset(const std::vector<bool>& kept) const {
    KeptRows rows = kept_rows(groups, kept, S.rows(), stateless());
    Judged out{VectorXd(), S(rows.moved, rows.moved), MatrixXd(), std::move(rows.groups)};
    for (const Index row : rows.stateless) {
      rows.moved.push_back(S.rows() + row);
    }
    out.r = r(rows.moved);
    out.DC = DC(rows.moved, Eigen::all);
    return out;
  }
};

/// Rows of an innovation as they are judged. What is white in time correlates all of them.
Judged judged_rows(const Innovation& innovation, const std::vector<RowGroup>& groups,
                   const ParameterErrorModel& model) {
  const Index m = innovation.r.size(), q = innovation.stateless.residual.size();
  Judged out{VectorXd(m + q), innovation.S, MatrixXd(m + q, model.constrained.cols()), groups};
  out.r << innovation.r, innovation.stateless.residual;
  if (model.constrained.cols() > 0) {
    out.DC.topRows(m) = multiply(innovation.D, model.constrained);
    out.DC.bottomRows(q) = multiply(innovation.stateless.D, model.constrained);
  }
  if (model.white_covariance.size() > 0) {
    MatrixXd D(m + q, innovation.D.cols());
    D << innovation.D, innovation.stateless.D;
    out.S.setIdentity(m + q, m + q);
    out.S.topLeftCorner(m, m) = innovation.S;
    add_product(out.S, 1.0, D, multiply(model.white_covariance, transposed(D)));
  }
  return out;
}

/// Judges the groups still in play. Dropping a group is block elimination in V = S⁻¹, of which only the
/// products that the judgement needs are kept, as V = S⁻¹ − U Uᵀ: O(m²) each.
class Judge {
 public:
  Judge(const Judged& judged, const GateThresholds& thresholds)
      : z_(judged),
        white_(white_groups(judged.r, judged.S, judged.DC, judged.groups)),
        thresholds_(thresholds),
        llt_(judged.S),
        DC_(judged.DC),
        U_(judged.r.size(), 0) {
    Vr_ = solved(z_.r);
    VDC_ = solved(DC_);
  }

  [[nodiscard]] bool valid() const { return llt_.succeeded(); }
  [[nodiscard]] const WhiteGroups& white() const { return white_; }

  /// Judges the accepted groups; returns the one that exceeds its threshold most, or -1.
  Index worst(GateReport& report) {
    const MatrixXd T = strong_combinations(DC_);
    VectorXd delta(T.cols());
    MatrixXd Minv(T.cols(), T.cols());
    if (T.cols() > 0) {
      PseudoInverse pseudo = pseudo_inverse(information(T), seen(T));
      delta = std::move(pseudo.x);
      Minv = std::move(pseudo.matrix);
    }
    const MatrixXd white_A = multiply(white_.A, T);
    Index worst = -1;
    double worst_ratio = 1.0;
    for (std::size_t g = 0; g < z_.groups.size(); ++g) {
      if (!report.accepted[g]) {
        continue;
      }
      const Index row = white_.groups[g].row, rows = white_.groups[g].rows;
      const auto A = white_A.middleRows(row, rows);
      Distance d{white_.r.segment(row, rows).squaredNorm(), rows};
      if (!A.isZero(0.0)) {
        d = mahalanobis(white_.r.segment(row, rows) - A * delta,
                        MatrixXd::Identity(rows, rows) - congruence(A, Minv));
      }
      report.distance[g] = d.squared;
      report.threshold[g] = thresholds_.of(d.dof);
      if (d.dof > 0 && d.squared > worst_ratio * report.threshold[g]) {
        worst_ratio = d.squared / report.threshold[g];
        worst = static_cast<Index>(g);
      }
    }
    return worst;
  }

  /// Squared distance of all rows, before any is dropped, after what is constrained has explained what it
  /// can.
  [[nodiscard]] Distance joint() const {
    Distance out{z_.r.dot(Vr_), z_.r.size()};
    const MatrixXd T = strong_combinations(DC_);
    if (T.cols() > 0) {
      const VectorXd b = seen(T);
      out.squared -= b.dot(pseudo_inverse(information(T), b).x);
      out.dof -= T.cols();
    }
    return out;
  }

  /// Takes the rows of a group out. What is left of D C may have fewer directions.
  void drop(const RowGroup& group) {
    const Index rows = group.rows + (group.fourth >= 0 ? 1 : 0);
    MatrixXd column = MatrixXd::Zero(z_.r.size(), rows);  // of V
    column.middleRows(group.row, group.rows).leftCols(group.rows).setIdentity();
    if (group.fourth >= 0) {
      column(group.fourth, group.rows) = 1.0;
    }
    column = solved(std::move(column));
    add_product(column, -1.0, U_, transposed(rows_of(group, U_)));
    const Cholesky pivot(rows_of(group, column));
    solve_lower_from_right(transposed(pivot.factor()), column);  // V := V − column columnᵀ
    Vr_ -= column * (column.transpose() * z_.r);
    add_product(VDC_, -1.0, column, multiply(transposed(column), z_.DC));
    DC_.middleRows(group.row, group.rows).setZero();
    if (group.fourth >= 0) {
      DC_.row(group.fourth).setZero();
    }
    U_.conservativeResize(Eigen::NoChange, U_.cols() + rows);
    U_.rightCols(rows) = column;
  }

 private:
  /// Of combinations of what is constrained: Tᵀ (D C)ᵀ V D C T, and Tᵀ (D C)ᵀ V r.
  [[nodiscard]] MatrixXd information(const MatrixXd& T) const {
    return congruence(transposed(T), multiply(transposed(DC_), VDC_));
  }
  [[nodiscard]] VectorXd seen(const MatrixXd& T) const { return T.transpose() * (DC_.transpose() * Vr_); }

  /// S⁻¹ X.
  [[nodiscard]] MatrixXd solved(MatrixXd X) const {
    X.topRows(z_.S.rows()) = llt_.solve(X.topRows(z_.S.rows()));
    return X;
  }

  const Judged& z_;
  WhiteGroups white_;
  const GateThresholds& thresholds_;
  Cholesky llt_;
  MatrixXd DC_;   // rows that were dropped are zero
  MatrixXd U_;    // of what was dropped
  VectorXd Vr_;   // V r
  MatrixXd VDC_;  // V D C
};

/// Drops the worst group as long as one fails. @return false if more than `most` failed
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

/// The directions of a column space, each of a pixel's noise a row: how well a pose is known makes none weak.
MatrixXd pixels_in_each_direction(const MatrixXd& columns) {
  const RightSingular svd = right_singular(householder_qr(columns).R());
  const Index rank = (svd.values.array() > kRankCut * svd.values.maxCoeff()).count();
  const VectorXd scale =
      std::sqrt(static_cast<double>(columns.rows())) * svd.values.head(rank).cwiseInverse();
  return multiply(columns, svd.V.leftCols(rank)) * scale.asDiagonal();
}

/// What is judged, where the pose may be off by anything.
Judged with_free_pose(const Judged& judged, const Innovation& innovation) {
  Judged out = judged;
  const Index pose = std::min<Index>(kPose, innovation.PHt.rows()), m = judged.S.rows();
  const MatrixXd by_pose = pixels_in_each_direction(innovation.PHt.topRows(pose).transpose());
  out.DC.conservativeResize(Eigen::NoChange, judged.DC.cols() + by_pose.cols());
  out.DC.rightCols(by_pose.cols()).setZero();
  out.DC.topRightCorner(m, by_pose.cols()) = by_pose;
  return out;
}

/// The accepted groups and the others cannot be of one rigid world: no pose puts both where they are.
bool are_two_bodies(const Judged& judged, const std::vector<bool>& accepted,
                    const GateThresholds& thresholds) {
  std::vector<bool> refused = accepted;
  refused.flip();
  const Judged without = judged.subset(refused);
  const Judge of_all(judged, thresholds), of_others(without, thresholds);
  if (!of_all.valid() || !of_others.valid()) {
    return false;
  }
  const Distance all = of_all.joint(), others = of_others.joint();
  return all.dof > others.dof &&
         all.squared - others.squared > kGrossOutlier * thresholds.of(all.dof - others.dof);
}

GateReport nothing_refused(std::size_t groups) {
  return {std::vector<bool>(groups, true), std::vector<double>(groups, 0.0),
          std::vector<double>(groups, 0.0)};
}

/// Flags the groups that lie far from what most agree upon. @return how many
std::size_t flag_gross(const WhiteGroups& white, const GateThresholds& thresholds, GateReport& report) {
  const Consensus consensus = find_consensus(white, kWidestOffset);
  std::size_t gross = 0;
  for (std::size_t g = 0; g < white.groups.size(); ++g) {
    const double threshold = thresholds.of(white.groups[g].rows);
    if (consensus.distance[g] > kGrossOutlier * threshold) {
      report.accepted[g] = false;
      report.distance[g] = consensus.distance[g];
      report.threshold[g] = threshold;
      ++gross;
    }
  }
  return gross;
}

/// Goes on where more than `dropped` failed, as long as enough groups agree with the prediction.
bool leaves_enough(Judge& judge, const std::vector<RowGroup>& groups, std::size_t dropped,
                   GateReport& report) {
  return groups.size() >= dropped + kEnoughAgree &&
         eliminate(judge, groups, groups.size() - dropped - kEnoughAgree, report);
}

/// What became of the groups that are no gross outliers, among all.
GateReport with_inner(GateReport flagged, const GateReport& inner) {
  std::size_t k = 0;
  for (std::size_t g = 0; g < flagged.accepted.size(); ++g) {
    if (flagged.accepted[g]) {
      flagged.accepted[g] = inner.accepted[k];
      flagged.distance[g] = inner.distance[k];
      flagged.threshold[g] = inner.threshold[k];
      ++k;
    }
  }
  return flagged;
}

/// Tells whether those that are left are a world of their own; empty where most groups are right.
using Stands = std::function<bool(const GateReport&)>;

/// Without the gross outliers, the others in turn.
GateReport gate_robustly(const Judged& judged, const GateReport& flagged, std::size_t gross,
                         const GateThresholds& thresholds, const Stands& stands) {
  const Judged rest = judged.subset(flagged.accepted);
  Judge judge(rest, thresholds);
  GateReport inner = nothing_refused(rest.groups.size());
  const std::size_t half = judged.groups.size() / 2;
  const std::size_t most = gross <= half ? half - gross : rest.groups.size() / 4;
  if (!judge.valid() || eliminate(judge, rest.groups, most, inner)) {
    return with_inner(flagged, inner);
  }
  GateReport all = inner;
  all.accepted.assign(rest.groups.size(), true);
  if (stands && leaves_enough(judge, rest.groups, most, inner)) {
    GateReport minority = with_inner(flagged, inner);
    if (stands(minority)) {
      return minority;
    }
  }
  GateReport out = with_inner(flagged, all);
  out.overruled = true;
  return out;
}

}  // namespace

GateThresholds::GateThresholds(double probability) : probability_(probability), of_point_{} {
  for (std::size_t dof = 1; dof < of_point_.size(); ++dof) {
    of_point_[dof] = chi_square_quantile(probability, static_cast<double>(dof));
  }
}

double GateThresholds::of(Index dof) const {
  const auto at = static_cast<std::size_t>(dof);
  return at < of_point_.size() ? of_point_[at] : chi_square_quantile(probability_, static_cast<double>(dof));
}

bool GateReport::most_refused() const {
  return 2 * std::ranges::count(accepted, false) > std::ssize(accepted);
}

bool GateReport::all_accepted() const {
  return std::find(accepted.begin(), accepted.end(), false) == accepted.end();
}

GateReport gate(const Innovation& innovation, const std::vector<RowGroup>& groups,
                const ParameterErrorModel& model, const GateThresholds& thresholds, Majority majority) {
  const Judged judged = judged_rows(innovation, groups, model);
  GateReport report = nothing_refused(groups.size());
  Judge judge(judged, thresholds);
  if (!judge.valid()) {
    return report;  // the update will say that S is singular
  }
  const Index worst = judge.worst(report);
  if (worst < 0) {
    return report;
  }
  Stands stands;
  if (majority == Majority::kMayMove) {
    stands = [&](const GateReport& minority) {
      return are_two_bodies(with_free_pose(judged, innovation), minority.accepted, thresholds);
    };
  }
  GateReport flagged = nothing_refused(groups.size());
  const std::size_t gross = flag_gross(judge.white(), thresholds, flagged);
  // What is constrained cannot put most points far from each other; what is trusted can.
  const bool trusts = model.constrained.cols() == 0;
  if (gross > 0 && (trusts ? 2 : 3) * gross <= (trusts ? 1 : 2) * groups.size()) {
    return gate_robustly(judged, flagged, gross, thresholds, stands);
  }
  const std::size_t half = groups.size() / 2;
  if (!eliminate(judge, groups, half, report) &&
      !(stands && leaves_enough(judge, groups, half, report) && stands(report))) {
    report.accepted.assign(groups.size(), true);
    report.overruled = true;
  }
  return report;
}

}  // namespace limber
