// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "limber/core/covariance.hpp"
#include "limber/core/settling_covariance.hpp"
#include "limber/core/settling_matrix.hpp"

namespace limber {

/// What becomes of the triplets of the active state when an epoch ends. The body's leading block always
/// stays.
struct EpochChange {
  std::vector<Eigen::Index> kept;     ///< starts, in the order they are to have
  std::vector<Eigen::Index> retired;  ///< starts of those that go passive
  std::vector<Eigen::Index> dropped;  ///< starts of those that are forgotten
};

/// @brief The triplets of the state that no frame looks at, at no cost per frame: an exact compressed filter.
///
/// Let z be the part of the active state that does not move during an epoch: a clone of the body at its
/// beginning and the map's triplets that were active then. A passive triplet is x_d = G z + e, and its
/// remainder e is independent of everything active. However often z is corrected meanwhile, G and
/// E = Cov(e) stay as they are; mean and covariance of x_d follow from those of z when somebody asks.
/// The active covariance during an epoch is laid out as [body | z | what was initialised since]; z begins at
/// `body_size`. Method: the compressed filter of [Guivant2001] with the body's clone in the place
/// of their auxiliary matrices, which a body with many states and few corrections of the map would make
/// large.
class PassiveBlock {
 public:
  /// Number of scalar states, three per triplet.
  [[nodiscard]] Eigen::Index size() const { return E_.size(); }
  /// There is no passive landmark.
  [[nodiscard]] bool empty() const { return size() == 0; }
  /// Size of z; zero outside of an epoch.
  [[nodiscard]] Eigen::Index z_size() const { return Gt_.rows(); }

  /// @brief Ends an epoch and begins the next: z becomes (clone of the body now, change.kept).
  ///
  /// The retired triplets are appended to the block. If anything is passive afterwards, P becomes
  /// [body | clone | kept], else [body | kept].
  /// @param P          [body | z | new landmarks]; without an epoch z is empty
  /// @param body_size  width of the leading block
  /// @return false, and nothing changed, if the covariance of what is kept is not positive definite
  bool change_epoch(Covariance& P, Eigen::Index body_size, const EpochChange& change);

  /// @brief Makes the triplets at rows `rows` active again, at any time in an epoch: they go to the end of z
  /// in the given order. For that they are appended to P, and the k-th of them changes places with the k-th
  /// triplet behind z (that of a new landmark, or its own place if there are none). Their places in the block
  /// are taken as by remove(), the last row first.
  void recall(Covariance& P, Eigen::Index body_size, std::span<const Eigen::Index> rows);

  /// Forgets the triplet at `row`; the last one takes its place. @return where that one came from
  Eigen::Index remove(Eigen::Index row);

  /// Once a frame: some of the work that the last change_epoch() has put off.
  void settle();
  /// All of that work.
  void settle_all();

  /// Correction of the passive means that a correction dz of z implies.
  [[nodiscard]] Eigen::VectorXd correction(const Eigen::Ref<const Eigen::VectorXd>& dz) const;
  /// The same for one triplet.
  [[nodiscard]] Eigen::Vector3d correction(Eigen::Index row,
                                           const Eigen::Ref<const Eigen::VectorXd>& dz) const;

  /// Covariance of the triplets at two rows, P as during the epoch.
  [[nodiscard]] Eigen::Matrix3d triplet_block(const Covariance& P, Eigen::Index body_size, Eigen::Index row,
                                              Eigen::Index other) const;
  /// Cross-covariance of the triplet at `row` with all active states: 3 × P.size().
  [[nodiscard]] Eigen::MatrixXd cross(const Covariance& P, Eigen::Index body_size, Eigen::Index row) const;

  /// x_d := x_d + C z_k for the triplet at `row`, z_k the triplet of z at `column`.
  void couple_row(Eigen::Index row, Eigen::Index column, const Eigen::Matrix3d& C);
  /// x_d := M x_d for the triplet at `row`.
  void transform_row(Eigen::Index row, const Eigen::Matrix3d& M);

  /// z_k is from now on measured as z_k := M z_k, M invertible.
  void transform_column(Eigen::Index column, const Eigen::Matrix3d& M);
  /// z is from now on measured as z := z + C z_j, C: z_size × 3, zero in the rows of z_j.
  void couple_columns(Eigen::Index other, const Eigen::Ref<const Eigen::MatrixXd>& C);
  /// z_k is from now on measured as z_k := z_k + C z_j.
  void couple_column(Eigen::Index column, Eigen::Index other, const Eigen::Matrix3d& C);

 private:
  SettlingMatrix Gt_;     // Gᵀ: z_size × size
  SettlingCovariance E_;  // size × size
};

}  // namespace limber
