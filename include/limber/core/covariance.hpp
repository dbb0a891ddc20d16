// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>

namespace limber {

/// The state comes in triplets (position, attitude, landmark, ...): every block of x is 3 wide.
inline constexpr Eigen::Index kTriplet = 3;

/// @brief Symmetric n×n matrix that grows and shrinks by triplets without moving what stays.
///
/// Only the lower triangle is stored and kept up to date; every accessor gives the symmetric value, so that
/// symmetry cannot be lost. Storage has spare capacity: appending is O(n), a rank-k update touches n²k/2
/// products.
class Covariance {
 public:
  /// Of nothing: 0×0.
  Covariance() = default;
  /// Copies what is in use: a checkpoint of a map costs half a matrix, not its spare storage.
  Covariance(const Covariance& other) { *this = other; }
  /// The same; keeps its own storage where that is large enough.
  Covariance& operator=(const Covariance& other);
  /// Takes the storage over; the other one may only be assigned to or destroyed.
  Covariance(Covariance&&) = default;
  /// The same.
  Covariance& operator=(Covariance&&) = default;
  ~Covariance() = default;

  /// Rows and columns, n.
  [[nodiscard]] Eigen::Index size() const { return size_; }

  /// Full symmetric copy, n×n.
  [[nodiscard]] Eigen::MatrixXd dense() const;

  /// Copy of rows [row, row + rows) and columns [col, col + cols).
  [[nodiscard]] Eigen::MatrixXd block(Eigen::Index row, Eigen::Index col, Eigen::Index rows,
                                      Eigen::Index cols) const;

  /// The 3×3 block of two triplets; cheap.
  [[nodiscard]] Eigen::Matrix3d triplet_block(Eigen::Index row, Eigen::Index col) const {
    if (row == col) {
      return diagonal_block<kTriplet>(row);
    }
    if (row > col) {
      return data_.block<kTriplet, kTriplet>(row, col);
    }
    return data_.block<kTriplet, kTriplet>(col, row).transpose();
  }

  /// The diagonal block that starts at `start`.
  template <int N>
  [[nodiscard]] Eigen::Matrix<double, N, N> diagonal_block(Eigen::Index start) const {
    return data_.template block<N, N>(start, start).template selfadjointView<Eigen::Lower>();
  }

  /// Sets the diagonal block that starts at `start`; only the lower triangle of `value` is read.
  void set_diagonal_block(Eigen::Index start, const Eigen::Ref<const Eigen::MatrixXd>& value);

  /// P := value, n×n of any size; only the lower triangle of `value` is read.
  void assign(const Eigen::Ref<const Eigen::MatrixXd>& value);

  /// P X, X: n×k.
  [[nodiscard]] Eigen::MatrixXd times(const Eigen::Ref<const Eigen::MatrixXd>& X) const;

  /// Columns of the triplets that start at `starts`, side by side: n × 3|starts|.
  void gather(std::span<const Eigen::Index> starts, Eigen::MatrixXd& columns) const;

  /// Replaces row and column of the triplets at `starts`; `columns` is n × 3|starts| and symmetric where it
  /// meets itself.
  void scatter(std::span<const Eigen::Index> starts, const Eigen::Ref<const Eigen::MatrixXd>& columns);

  /// P -= W Wᵀ, W: n×k.
  void subtract_outer(const Eigen::Ref<const Eigen::MatrixXd>& W);

  /// P += W Wᵀ, W: n×k.
  void add_outer(const Eigen::Ref<const Eigen::MatrixXd>& W);

  /// P += U Vᵀ + V Uᵀ, U and V: n×k.
  void add_symmetric_product(const Eigen::Ref<const Eigen::MatrixXd>& U,
                             const Eigen::Ref<const Eigen::MatrixXd>& V);

  /// Applies x' = M x to the triplet at `start`, M: 3×3.
  void transform_triplet(Eigen::Index start, const Eigen::Matrix3d& M);

  /// Applies x' = Phi x + w to the leading block: P_aa = Phi P_aa Phiᵀ + Q, P_ba = P_ba Phiᵀ. Phi, Q: k×k, k
  /// <= n.
  void propagate_leading(const Eigen::Ref<const Eigen::MatrixXd>& Phi,
                         const Eigen::Ref<const Eigen::MatrixXd>& Q);

  /// P_ba = P_ba Phiᵀ for the rows b below the leading k×k block, which stays as it is.
  void propagate_cross(const Eigen::Ref<const Eigen::MatrixXd>& Phi);

  /// Applies x_a' = x_a + U x_c, a: the leading k, c: the triplet at `from`, behind them. U: k×3.
  void couple_leading(const Eigen::Ref<const Eigen::MatrixXd>& U, Eigen::Index from);

  /// Two triplets change places.
  void swap_triplets(Eigen::Index a, Eigen::Index b);

  /// Appends `count` zero rows and columns; returns the index of the first.
  Eigen::Index append(Eigen::Index count);

  /// Removes the triplet at `start` by moving the last one into its place.
  /// @return where the moved triplet came from (== start if it was the last).
  Eigen::Index remove_triplet(Eigen::Index start);

 private:
  void reserve(Eigen::Index size);

  Eigen::Index size_ = 0;
  Eigen::MatrixXd data_;  // capacity × capacity; lower triangle of the leading size_ × size_ is valid
};

}  // namespace limber
