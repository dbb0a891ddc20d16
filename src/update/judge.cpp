// SPDX-License-Identifier: MIT
#include "judge.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "kept_rows.hpp"
#include "limber/update/constraint.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// A residual whose variance the constraint cuts to less than this share is used up: it says nothing any
/// more.
constexpr double kUsedUp = 1e-9;

/// How many times its noise [in variance] a group may be from where the others expect it, however little
/// they know of that. A point much nearer than all others may be anywhere for them: what it alone says of the
/// parameters nobody can check.
constexpr double kUnchecked = 10.0;

/// How far a group is from where the others expect it.
struct Deviation {
  Distance distance;  ///< beside what they leave open
  double away = 0.0;  ///< squared, in its own noise
};

/// eᵀ B⁺ e and |B⁺ e|², where B is what the constraint leaves of the identity: in units of S, so that a huge
/// variance in one direction (a new landmark's depth) does not hide what the others say.
Deviation deviation(const VectorXd& e, const MatrixXd& B) {
  const Cholesky root(B);
  // No eigenvalue exceeds one, so that none is smaller than the determinant.
  const double diagonal = root.factor().diagonal().prod();
  if (root.succeeded() && diagonal * diagonal > 10.0 * kUsedUp) {
    const VectorXd away = root.solve(e);
    return {{e.dot(away), e.size()}, away.squaredNorm()};
  }
  const SymmetricEigen eigen = symmetric_eigen(B);
  Deviation out;
  for (Index k = 0; k < e.size(); ++k) {
    if (eigen.values(k) > kUsedUp) {
      const double component = eigen.vectors.col(k).dot(e);
      out.distance.squared += component * component / eigen.values(k);
      out.away += component * component / (eigen.values(k) * eigen.values(k));
      ++out.distance.dof;
    }
  }
  return out;
}

}  // namespace

Judged Judged::subset(const std::vector<bool>& kept) const {
  KeptRows rows = kept_rows(groups, kept, S.rows(), stateless());
  Judged out{VectorXd(), S(rows.moved, rows.moved), MatrixXd(), std::move(rows.groups), asks_others};
  for (const Index row : rows.stateless) {
    rows.moved.push_back(S.rows() + row);
  }
  out.r = r(rows.moved);
  out.DC = DC(rows.moved, Eigen::all);
  return out;
}

/// Rows of an innovation as they are judged. What is white in time correlates all of them.
Judged judged_rows(const Innovation& innovation, const std::vector<RowGroup>& groups,
                   const ParameterErrorModel& model) {
  const Index m = innovation.r.size(), q = innovation.stateless.residual.size();
  Judged out{VectorXd(m + q), innovation.S, MatrixXd(m + q, model.constrained.cols()), groups, false};
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

Judged beside_the_pose(Judged judged, const Innovation& innovation, const MatrixXd& P_pose) {
  const Cholesky root(P_pose);
  MatrixXd moved = innovation.PHt.topRows(P_pose.rows());
  solve_lower(root.factor(), moved);  // by errors of the pose that are plausible
  const Index m = moved.cols(), c = judged.DC.cols();
  add_product(judged.S.topLeftCorner(m, m), -1.0, transposed(moved), moved);
  judged.DC.conservativeResize(Eigen::NoChange, c + moved.rows());
  judged.DC.rightCols(moved.rows()).setZero();
  judged.DC.topRightCorner(m, moved.rows()) = moved.transpose();
  return judged;
}

Judge::Judge(const Judged& judged)
    : z_(judged),
      white_(white_groups(judged.r, judged.S, judged.DC, judged.groups)),
      llt_(judged.S),
      DC_(judged.DC),
      U_(judged.r.size(), 0) {
  Vr_ = solved(z_.r);
  VDC_ = solved(DC_);
}

/// What all groups say of combinations of what is constrained.
Judge::Known Judge::known(const MatrixXd& T) const {
  PseudoInverse pseudo = pseudo_inverse(information(T), seen(T));
  return {multiply(white_.A, T), std::move(pseudo.x), std::move(pseudo.matrix)};
}

/// The same where each is off by no more than is plausible.
Judge::Known Judge::known_plausibly() const {
  const MatrixXd I = MatrixXd::Identity(DC_.cols(), DC_.cols());
  MatrixXd covariance = Cholesky(information(I) + I).inverse();
  VectorXd delta = covariance * seen(I);
  return {white_.A, std::move(delta), std::move(covariance)};
}

void Judge::measure(GateReport& report) const {
  const MatrixXd T = strong_combinations(DC_);
  std::optional<Known> of_groups, plausible;
  if (T.cols() > 0) {
    of_groups = known(T);
  }
  for (std::size_t g = 0; g < z_.groups.size(); ++g) {
    if (!report.accepted[g]) {
      continue;
    }
    const Index row = white_.groups[g].row, rows = white_.groups[g].rows;
    const VectorXd r = white_.r.segment(row, rows);
    const auto beside = [&](const Known& known) {
      const MatrixXd A = known.A.middleRows(row, rows);
      return deviation(r - A * known.delta, MatrixXd::Identity(rows, rows) - congruence(A, known.covariance));
    };
    Distance d{r.squaredNorm(), rows};
    if (of_groups && !of_groups->A.middleRows(row, rows).isZero(0.0)) {
      const Deviation off = beside(*of_groups);
      d = off.distance;
      if (z_.asks_others && off.away > kUnchecked * d.squared) {
        if (!plausible) {
          plausible = known_plausibly();
        }
        d.squared = std::max(d.squared, std::min(off.away, beside(*plausible).away) / kUnchecked);
      }
    }
    report.distance[g] = d.squared;
    report.dof[g] = d.dof;
  }
}

Distance Judge::joint() const {
  Distance out{z_.r.dot(Vr_), z_.r.size()};
  const MatrixXd T = strong_combinations(DC_);
  if (T.cols() > 0) {
    const VectorXd b = seen(T);
    out.squared -= b.dot(pseudo_inverse(information(T), b).x);
    out.dof -= T.cols();
  }
  return out;
}

void Judge::drop(const RowGroup& group) {
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

/// Of combinations of what is constrained: Tᵀ (D C)ᵀ V D C T, and Tᵀ (D C)ᵀ V r.
MatrixXd Judge::information(const MatrixXd& T) const {
  return congruence(transposed(T), multiply(transposed(DC_), VDC_));
}

VectorXd Judge::seen(const MatrixXd& T) const { return T.transpose() * (DC_.transpose() * Vr_); }

/// S⁻¹ X.
MatrixXd Judge::solved(MatrixXd X) const {
  X.topRows(z_.S.rows()) = llt_.solve(X.topRows(z_.S.rows()));
  return X;
}

}  // namespace limber::detail
