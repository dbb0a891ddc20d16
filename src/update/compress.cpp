// SPDX-License-Identifier: MIT
#include "limber/update/compress.hpp"

#include <Eigen/Householder>
#include <Eigen/QR>
#include <algorithm>
#include <map>
#include <utility>
#include <vector>

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index kStereoRows = 4;
constexpr double kRounding =
    1e-13;  // share of a row's largest entry that an orthogonal change may leave of zero
using StereoRows = Eigen::Matrix<double, kStereoRows, Eigen::Dynamic>;
using Block = SparseJacobian::Block;

/// One group of rows with its blocks of H.
struct Point {
  RowGroup group;
  std::vector<const Block*> blocks;
};

std::vector<Point> points_of(const LinearMeasurement& z) {
  std::vector<Point> points;
  std::vector<std::size_t> point_of_row;
  for (const RowGroup& group : z.groups) {
    point_of_row.insert(point_of_row.end(), static_cast<std::size_t>(group.rows), points.size());
    points.push_back({group, {}});
  }
  for (const Block& block : z.H.blocks) {
    points[point_of_row[static_cast<std::size_t>(block.row)]].blocks.push_back(&block);
  }
  return points;
}

/// Columns of the triplets that more than half of the points look at, in order.
std::vector<Index> shared_triplets(const std::vector<Point>& points) {
  std::map<Index, std::vector<bool>> users;  // by column
  for (std::size_t k = 0; k < points.size(); ++k) {
    for (const Block* block : points[k].blocks) {
      users.try_emplace(block->col, points.size(), false).first->second[k] = true;
    }
  }
  std::vector<Index> shared;
  for (const auto& [column, use] : users) {
    if (2 * static_cast<std::size_t>(std::count(use.begin(), use.end(), true)) > points.size()) {
      shared.push_back(column);
    }
  }
  return shared;
}

/// The triplet that a point with four rows does not share, if it is the only one; else -1.
Index own_triplet(const Point& point, const std::vector<Index>& shared) {
  Index own = -1;
  for (const Block* block : point.blocks) {
    if (block->col != own && !std::binary_search(shared.begin(), shared.end(), block->col)) {
      if (own >= 0) {
        return -1;
      }
      own = block->col;
    }
  }
  return point.group.rows == kStereoRows ? own : -1;
}

/// A: 4×w := Qᵀ A, Q orthogonal, such that the first three columns are upper triangular.
void triangularise(Eigen::Ref<StereoRows> A) {
  Eigen::RowVectorXd workspace(A.cols());
  for (Index k = 0; k < kTriplet; ++k) {
    double tau = 0.0, beta = 0.0;
    auto column = A.col(k).tail(kStereoRows - k);
    column.makeHouseholderInPlace(tau, beta);
    A.bottomRightCorner(kStereoRows - k, A.cols() - k - 1)
        .applyHouseholderOnTheLeft(column.tail(kStereoRows - k - 1).eval(), tau, workspace.data());
    column.setZero();
    column(0) = beta;
  }
}

/// Builds the compressed measurement. Rows are written dense as [triplets | D | r].
class Compression {
 public:
  explicit Compression(const LinearMeasurement& z)
      : z_(z), points_(points_of(z)), shared_(shared_triplets(points_)) {
    for (const Point& point : points_) {
      own_.push_back(own_triplet(point, shared_));
      compressible_ += own_.back() >= 0 ? 1 : 0;
    }
  }

  [[nodiscard]] bool pays() const { return compressible_ > shared_width(); }

  LinearMeasurement result() {
    const Index most = z_.rows() - compressible_ + shared_width();
    out_.residual.resize(most);
    out_.D.resize(z_.D.cols() > 0 ? most : 0, z_.D.cols());
    pool_.resize(compressible_, shared_width() + 1);
    Index pooled = 0;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      if (own_[k] < 0) {
        copy(points_[k]);
        continue;
      }
      StereoRows A = dense(points_[k], own_[k]);
      triangularise(A);
      std::vector<Index> triplets = {own_[k]};
      triplets.insert(triplets.end(), shared_.begin(), shared_.end());
      write(A.topRows<kTriplet>(), triplets);
      const double zero = kRounding * A.leftCols(A.cols() - 1).cwiseAbs().maxCoeff();
      auto rest = A.bottomRightCorner<1, Eigen::Dynamic>(1, pool_.cols());
      pool_.row(pooled++) = (rest.array().abs() > zero).select(rest, 0.0);
    }
    compress_pool();
    out_.residual.conservativeResize(written_);
    out_.D.conservativeResize(z_.D.cols() > 0 ? written_ : 0, Eigen::NoChange);
    out_.sigma.setOnes(written_);
    return std::move(out_);
  }

 private:
  /// Columns of [shared triplets | D].
  [[nodiscard]] Index shared_width() const {
    return kTriplet * static_cast<Index>(shared_.size()) + z_.D.cols();
  }

  /// [own | shared triplets | D | r] of a point, whitened.
  [[nodiscard]] StereoRows dense(const Point& point, Index own) const {
    StereoRows A = StereoRows::Zero(kStereoRows, kTriplet + shared_width() + 1);
    const Index first = point.group.row;
    for (const Block* block : point.blocks) {
      const auto place = std::lower_bound(shared_.begin(), shared_.end(), block->col) - shared_.begin();
      A.block(block->row - first, block->col == own ? 0 : kTriplet * (1 + place), block->value.rows(),
              kTriplet) += block->value;
    }
    if (z_.D.cols() > 0) {
      A.middleCols(A.cols() - 1 - z_.D.cols(), z_.D.cols()) = z_.D.middleRows<kStereoRows>(first);
    }
    A.rightCols<1>() = z_.residual.segment<kStereoRows>(first);
    A.array().colwise() /= z_.sigma.segment<kStereoRows>(first).array();
    return A;
  }

  void copy(const Point& point) {
    const auto [first, rows] = point.group;
    const VectorXd weight = z_.sigma.segment(first, rows).cwiseInverse();
    for (const Block* block : point.blocks) {
      Block& written = out_.H.blocks.emplace_back(*block);
      written.row += written_ - first;
      written.value.array().colwise() *= weight.segment(block->row - first, block->value.rows()).array();
    }
    if (z_.D.cols() > 0) {
      out_.D.middleRows(written_, rows) = weight.asDiagonal() * z_.D.middleRows(first, rows);
    }
    out_.residual.segment(written_, rows) = weight.cwiseProduct(z_.residual.segment(first, rows));
    written_ += rows;
  }

  /// @param rows  at most three
  void write(const Eigen::Ref<const MatrixXd>& rows, const std::vector<Index>& triplets) {
    for (std::size_t k = 0; k < triplets.size(); ++k) {
      out_.H.blocks.push_back(
          {written_, triplets[k], rows.middleCols<kTriplet>(kTriplet * static_cast<Index>(k))});
    }
    if (z_.D.cols() > 0) {
      out_.D.middleRows(written_, rows.rows()) = rows.middleCols(rows.cols() - 1 - z_.D.cols(), z_.D.cols());
    }
    out_.residual.segment(written_, rows.rows()) = rows.rightCols<1>();
    written_ += rows.rows();
  }

  /// Of the rows that see nothing but what is shared, keeps as many as that has dimensions.
  void compress_pool() {
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(pool_.leftCols(shared_width()));
    VectorXd r = pool_.rightCols<1>();
    r.applyOnTheLeft(qr.householderQ().adjoint());
    MatrixXd kept = MatrixXd::Zero(qr.rank(), pool_.cols());
    kept.leftCols(shared_width()) = qr.matrixR().topRows(qr.rank()).triangularView<Eigen::Upper>();
    kept.leftCols(shared_width()) *= qr.colsPermutation().transpose();
    kept.rightCols<1>() = r.head(qr.rank());
    for (Index row = 0; row < kept.rows(); row += kTriplet) {
      write(kept.middleRows(row, std::min(kTriplet, kept.rows() - row)), shared_);
    }
    out_.noise.rows = z_.noise.rows + r.size() - qr.rank();
    out_.noise.squared_norm = z_.noise.squared_norm + r.tail(r.size() - qr.rank()).squaredNorm();
  }

  const LinearMeasurement& z_;
  std::vector<Point> points_;
  std::vector<Index> shared_;  // columns of the triplets that most points look at
  std::vector<Index> own_;     // by point: the triplet of its own, -1 where it cannot be compressed
  Index compressible_ = 0;
  MatrixXd pool_;  // by compressible point: [shared triplets | D | r] of the row without a triplet of its own
  LinearMeasurement out_;
  Index written_ = 0;  // rows of out_
};

}  // namespace

LinearMeasurement compressed(const LinearMeasurement& z) {
  Compression compression(z);
  return compression.pays() ? compression.result() : z;
}

}  // namespace limber
