// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "limber/core/factors.hpp"
#include "limber/update/gate.hpp"
#include "limber/update/innovation.hpp"
#include "limber/update/white_groups.hpp"

/// Groups of rows judged beside each other, each on its projected residual: see gate().
namespace limber::detail {

struct Distance {
  double squared = 0.0;  ///< Mahalanobis [-]
  Eigen::Index dof = 0;
};

/// What is judged: residual, its covariance, and the directions that the gain must not see.
struct Judged {
  Eigen::VectorXd r;   ///< rows of S, then rows that no state moves: their covariance is the identity
  Eigen::MatrixXd S;   ///< of the first
  Eigen::MatrixXd DC;  ///< of all
  std::vector<RowGroup> groups;
  bool asks_others = false;  ///< a group has to be near where the others expect it, however little they know

  [[nodiscard]] Eigen::Index stateless() const { return r.size() - S.rows(); }

  /// The same without the groups that are not kept.
  [[nodiscard]] Judged subset(const std::vector<bool>& kept) const;
};

/// Rows of an innovation as they are judged. What is white in time correlates all of them.
[[nodiscard]] Judged judged_rows(const Innovation& innovation, const std::vector<RowGroup>& groups,
                                 const ParameterErrorModel& model);

/// The same beside what all groups say of the pose: where it is hardly known, S alone would let pass whatever
/// some motion explains, though the others tell of another one.
/// @param P_pose  6×6, positive definite, of the state that comes first
[[nodiscard]] Judged beside_the_pose(Judged judged, const Innovation& innovation,
                                     const Eigen::MatrixXd& P_pose);

/// Judges the groups still in play. Dropping a group is block elimination in V = S⁻¹, of which only the
/// products that the judgement needs are kept, as V = S⁻¹ − U Uᵀ: O(m²) each.
class Judge {
 public:
  /// @param judged  must outlive this
  explicit Judge(const Judged& judged);

  /// Whether S has an inverse.
  [[nodiscard]] bool valid() const { return llt_.succeeded(); }
  [[nodiscard]] const WhiteGroups& white() const { return white_; }

  /// How far the accepted groups are off, beside each other: a Mahalanobis distance. Where others are asked:
  /// or a tenth of the squared distance in a group's own noise, if that is more, both beside what the others
  /// say of what is constrained and beside what they say of as much as is plausible of it.
  void measure(GateReport& report) const;

  /// Squared distance of all rows, before any is dropped, after what is constrained has explained what it
  /// can.
  [[nodiscard]] Distance joint() const;

  /// Takes the rows of a group out. What is left of D C may have fewer directions.
  void drop(const RowGroup& group);

 private:
  struct Known {
    Eigen::MatrixXd A;  // of all white groups
    Eigen::VectorXd delta;
    Eigen::MatrixXd covariance;
  };
  [[nodiscard]] Known known(const Eigen::MatrixXd& T) const;
  [[nodiscard]] Known known_plausibly() const;
  [[nodiscard]] Eigen::MatrixXd information(const Eigen::MatrixXd& T) const;
  [[nodiscard]] Eigen::VectorXd seen(const Eigen::MatrixXd& T) const;
  [[nodiscard]] Eigen::MatrixXd solved(Eigen::MatrixXd X) const;

  const Judged& z_;
  WhiteGroups white_;
  Cholesky llt_;
  Eigen::MatrixXd DC_;   // rows that were dropped are zero
  Eigen::MatrixXd U_;    // of what was dropped
  Eigen::VectorXd Vr_;   // V r
  Eigen::MatrixXd VDC_;  // V D C
};

}  // namespace limber::detail
