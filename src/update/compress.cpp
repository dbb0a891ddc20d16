// SPDX-License-Identifier: MIT
#include "limber/update/compress.hpp"

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
constexpr double kRounding = 1e-10;  // share of a block's largest entry that stands for zero
using StereoBlock = Eigen::Matrix<double, kStereoRows, kTriplet>;
using StereoRows = Eigen::Matrix<double, kStereoRows, Eigen::Dynamic>;
using Block = SparseJacobian::Block;

/// One group of rows with its blocks of H.
struct Point {
  RowGroup group;
  std::vector<const Block*> blocks;
};

bool is_compressible(const RowGroup& group) { return group.rows == kStereoRows && group.own >= 0; }

std::vector<Point> points_of(const LinearMeasurement& z) {
  std::vector<Point> points;
  std::vector<std::size_t> point_of_row;
  points.reserve(z.groups.size());
  point_of_row.reserve(static_cast<std::size_t>(z.rows()));
  for (const RowGroup& group : z.groups) {
    point_of_row.insert(point_of_row.end(), static_cast<std::size_t>(group.rows), points.size());
    points.push_back({group, {}});
  }
  for (const Block& block : z.H.blocks) {
    points[point_of_row[static_cast<std::size_t>(block.row)]].blocks.push_back(&block);
  }
  return points;
}

/// The rows of a point, whitened, as columns of triplets: its own first.
struct WholePoint {
  struct Triplet {
    Index col;
    StereoBlock value;
  };
  std::vector<Triplet> triplets;
  StereoRows D;
  Eigen::Vector4d r;

  WholePoint(const LinearMeasurement& z, const Point& point) {
    const Index first = point.group.row;
    const Eigen::Vector4d weight = z.sigma.segment<kStereoRows>(first).cwiseInverse();
    triplets.push_back({point.group.own, StereoBlock::Zero()});
    for (const Block* block : point.blocks) {
      at(block->col).middleRows(block->row - first, block->value.rows()) += block->value;
    }
    for (Triplet& triplet : triplets) {
      triplet.value.array().colwise() *= weight.array();
    }
    D.resize(kStereoRows, z.D.cols());
    if (z.D.cols() > 0) {
      D = weight.asDiagonal() * z.D.middleRows<kStereoRows>(first);
    }
    r = weight.cwiseProduct(z.residual.segment<kStereoRows>(first));
  }

  StereoBlock& at(Index col) {
    const auto it =
        std::find_if(triplets.begin(), triplets.end(), [&](const Triplet& t) { return t.col == col; });
    return it != triplets.end() ? it->value : triplets.emplace_back(Triplet{col, StereoBlock::Zero()}).value;
  }

  /// All rows := Qᵀ rows, such that the point moves the first three alone; entries of the fourth that are
  /// rounding become zero.
  void turn() {
    const Eigen::HouseholderQR<StereoBlock> qr(triplets.front().value);
    const Eigen::Matrix4d Qt = Eigen::Matrix4d(qr.householderQ()).transpose();
    for (Triplet& triplet : triplets) {
      triplet.value = (Qt * triplet.value).eval();
      const double zero = kRounding * triplet.value.cwiseAbs().maxCoeff();
      auto last = triplet.value.bottomRows<1>();
      last = (last.array().abs() > zero).select(last, 0.0);
    }
    triplets.front().value = qr.matrixQR().triangularView<Eigen::Upper>();
    D = (Qt * D).eval();
    r = (Qt * r).eval();
  }
};

/// Builds the compressed measurement.
class Compression {
 public:
  explicit Compression(const LinearMeasurement& z) : z_(z) {}

  LinearMeasurement result() {
    out_.residual.resize(z_.rows());
    out_.D.resize(z_.D.cols() > 0 ? z_.rows() : 0, z_.D.cols());
    out_.H.blocks.reserve(z_.H.blocks.size());
    out_.noise = z_.noise;
    for (const Point& point : points_of(z_)) {
      if (is_compressible(point.group)) {
        turned_.emplace_back(z_, point).turn();
      } else {
        copy(point);
      }
    }
    find_pool_columns();
    MatrixXd pool(static_cast<Index>(turned_.size()), pool_width() + 1);
    Index pooled = 0;
    for (const WholePoint& point : turned_) {
      if (only_the_pool_sees(point)) {
        write(point, kTriplet);
        pool.row(pooled++) = pool_row(point);
      } else {
        write(point, kStereoRows);
      }
    }
    compress_pool(pool.topRows(pooled));
    out_.residual.conservativeResize(written_);
    out_.D.conservativeResize(z_.D.cols() > 0 ? written_ : 0, Eigen::NoChange);
    out_.sigma.setOnes(written_);
    return std::move(out_);
  }

 private:
  void copy(const Point& point) {
    const Index first = point.group.row, rows = point.group.rows;
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

  /// The first three rows of a point, or all four.
  void write(const WholePoint& point, Index rows) {
    for (const WholePoint::Triplet& triplet : point.triplets) {
      out_.H.blocks.push_back({written_, triplet.col, triplet.value.topRows<kTriplet>()});
      if (rows > kTriplet && !triplet.value.bottomRows<1>().isZero(0.0)) {
        out_.H.blocks.push_back({written_ + kTriplet, triplet.col, triplet.value.bottomRows<1>()});
      }
    }
    if (z_.D.cols() > 0) {
      out_.D.middleRows(written_, rows) = point.D.topRows(rows);
    }
    out_.residual.segment(written_, rows) = point.r.head(rows);
    written_ += rows;
  }

  /// Triplets that the fourth rows of most points see: theta, where it is a state, else none.
  void find_pool_columns() {
    std::map<Index, std::size_t> users;
    for (const WholePoint& point : turned_) {
      for (const WholePoint::Triplet& triplet : point.triplets) {
        users[triplet.col] += triplet.value.bottomRows<1>().isZero(0.0) ? 0 : 1;
      }
    }
    for (const auto& [column, count] : users) {
      if (2 * count > turned_.size()) {
        pool_columns_.push_back(column);
      }
    }
  }

  [[nodiscard]] Index pool_states() const { return kTriplet * static_cast<Index>(pool_columns_.size()); }
  [[nodiscard]] Index pool_width() const { return pool_states() + z_.D.cols(); }

  [[nodiscard]] bool only_the_pool_sees(const WholePoint& point) const {
    return std::all_of(point.triplets.begin(), point.triplets.end(), [&](const WholePoint::Triplet& triplet) {
      return triplet.value.bottomRows<1>().isZero(0.0) ||
             std::binary_search(pool_columns_.begin(), pool_columns_.end(), triplet.col);
    });
  }

  /// The fourth row as [triplets of the pool | D | r].
  [[nodiscard]] Eigen::RowVectorXd pool_row(const WholePoint& point) const {
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(pool_width() + 1);
    for (const WholePoint::Triplet& triplet : point.triplets) {
      const auto it = std::lower_bound(pool_columns_.begin(), pool_columns_.end(), triplet.col);
      if (it != pool_columns_.end() && *it == triplet.col) {
        row.segment<kTriplet>(kTriplet * (it - pool_columns_.begin())) = triplet.value.bottomRows<1>();
      }
    }
    row.segment(pool_states(), z_.D.cols()) = point.D.bottomRows<1>();
    row(pool_width()) = point.r(kTriplet);
    return row;
  }

  /// Of the pool's rows, keeps as many as what they see has dimensions.
  void compress_pool(const Eigen::Ref<const MatrixXd>& pool) {
    VectorXd r = pool.rightCols<1>();
    MatrixXd kept(0, pool_width());
    if (pool.rows() > 0 && pool_width() > 0) {  // Eigen factorises an empty matrix at its peril
      const Eigen::ColPivHouseholderQR<MatrixXd> qr(pool.leftCols(pool_width()));
      r.applyOnTheLeft(qr.householderQ().adjoint());
      kept.setZero(qr.rank(), pool_width());
      kept.triangularView<Eigen::Upper>() = qr.matrixR().topRows(qr.rank());
      kept *= qr.colsPermutation().transpose();
    }
    const Index noise = r.size() - kept.rows();
    out_.noise.rows += noise;
    out_.noise.squared_norm += r.tail(noise).squaredNorm();
    if (pool_columns_.empty()) {
      out_.stateless = {r.head(kept.rows()), kept};
    } else {
      write_pool(kept, r.head(kept.rows()));
    }
  }

  void write_pool(const MatrixXd& rows, const VectorXd& r) {
    for (Index row = 0; row < rows.rows(); row += kTriplet) {
      const Index count = std::min(kTriplet, rows.rows() - row);
      for (std::size_t k = 0; k < pool_columns_.size(); ++k) {
        out_.H.blocks.push_back({written_ + row, pool_columns_[k],
                                 rows.block(row, kTriplet * static_cast<Index>(k), count, kTriplet)});
      }
    }
    if (z_.D.cols() > 0) {
      out_.D.middleRows(written_, rows.rows()) = rows.rightCols(z_.D.cols());
    }
    out_.residual.segment(written_, rows.rows()) = r;
    written_ += rows.rows();
  }

  const LinearMeasurement& z_;
  std::vector<WholePoint> turned_;
  std::vector<Index> pool_columns_;
  LinearMeasurement out_;
  Index written_ = 0;  // rows of out_
};

}  // namespace

LinearMeasurement compressed(const LinearMeasurement& z) {
  const bool pays = std::any_of(z.groups.begin(), z.groups.end(), is_compressible);
  return pays ? Compression(z).result() : z;
}

}  // namespace limber
