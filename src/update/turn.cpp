// SPDX-License-Identifier: MIT
#include "limber/update/turn.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <map>
#include <numeric>
#include <span>
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
using Block = SparseJacobian::Block;

bool has_fourth_row(const RowGroup& group) { return group.rows == kStereoRows && group.own >= 0; }

/// Blocks of H in the order of the groups that their rows belong to.
struct BlocksByGroup {
  std::vector<const Block*> blocks;
  std::vector<std::size_t> begin;  ///< one more than groups

  explicit BlocksByGroup(const LinearMeasurement& z) : blocks(z.H.blocks.size()), begin(z.groups.size() + 1) {
    std::vector<std::size_t> group_of_row;
    group_of_row.reserve(static_cast<std::size_t>(z.rows()));
    for (std::size_t g = 0; g < z.groups.size(); ++g) {
      group_of_row.insert(group_of_row.end(), static_cast<std::size_t>(z.groups[g].rows), g);
    }
    const auto group_of = [&](const Block& block) {
      return group_of_row[static_cast<std::size_t>(block.row)];
    };
    for (const Block& block : z.H.blocks) {
      ++begin[group_of(block) + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::size_t> next = begin;
    for (const Block& block : z.H.blocks) {
      blocks[next[group_of(block)]++] = &block;
    }
  }

  [[nodiscard]] std::span<const Block* const> of(std::size_t group) const {
    return {blocks.data() + begin[group], begin[group + 1] - begin[group]};
  }
};

/// Points with four rows each, whitened and turned: of each, its triplet moves the first three alone.
class TurnedPoints {
 public:
  struct Triplet {
    Index col;
    StereoBlock value;
  };
  struct Point {
    std::size_t group;  ///< of the measurement
    std::size_t first;  ///< of its triplets: its own, then those of all others that move its rows
    std::size_t triplets;
    Index row;  ///< first of its rows in D and r
  };

  explicit TurnedPoints(const LinearMeasurement& z) : z_(z), D_(z.rows(), z.D.cols()), r_(z.rows()) {
    triplets_.reserve(z.H.blocks.size());
    points_.reserve(z.groups.size());
  }

  void add(std::size_t g, std::span<const Block* const> blocks) {
    const RowGroup& group = z_.groups[g];
    const Index first = group.row;
    const Eigen::Vector4d weight = z_.sigma.segment<kStereoRows>(first).cwiseInverse();
    Point point{g, triplets_.size(), 0, kStereoRows * static_cast<Index>(points_.size())};
    triplets_.push_back({group.own, StereoBlock::Zero()});
    for (const Block* block : blocks) {
      at(point, block->col).middleRows(block->row - first, block->value.rows()) += block->value;
    }
    point.triplets = triplets_.size() - point.first;
    for (Triplet& triplet : triplets_of(point)) {
      triplet.value.array().colwise() *= weight.array();
    }
    if (z_.D.cols() > 0) {
      D_.middleRows<kStereoRows>(point.row) = weight.asDiagonal() * z_.D.middleRows<kStereoRows>(first);
    }
    r_.segment<kStereoRows>(point.row) = weight.cwiseProduct(z_.residual.segment<kStereoRows>(first));
    turn(point);
    points_.push_back(point);
  }

  [[nodiscard]] const std::vector<Point>& points() const { return points_; }
  [[nodiscard]] std::span<const Triplet> triplets(const Point& point) const {
    return std::span(triplets_).subspan(point.first, point.triplets);
  }
  [[nodiscard]] auto D(const Point& point) const { return D_.middleRows<kStereoRows>(point.row); }
  [[nodiscard]] auto r(const Point& point) const { return r_.segment<kStereoRows>(point.row); }

 private:
  std::span<Triplet> triplets_of(const Point& point) {
    return std::span(triplets_).subspan(point.first, point.triplets);
  }

  /// The triplet of the newest point that starts at `col`, made if it is not there.
  StereoBlock& at(const Point& point, Index col) {
    const auto it = std::find_if(triplets_.begin() + static_cast<std::ptrdiff_t>(point.first),
                                 triplets_.end(), [&](const Triplet& triplet) { return triplet.col == col; });
    return it != triplets_.end() ? it->value
                                 : triplets_.emplace_back(Triplet{col, StereoBlock::Zero()}).value;
  }

  /// All rows := Qᵀ rows; entries of the fourth that are rounding become zero.
  void turn(const Point& point) {
    const std::span<Triplet> triplets = triplets_of(point);
    const Eigen::HouseholderQR<StereoBlock> qr(triplets.front().value);
    const Eigen::Matrix4d Qt = Eigen::Matrix4d(qr.householderQ()).transpose();
    for (Triplet& triplet : triplets) {
      triplet.value = (Qt * triplet.value).eval();
      const double zero = kRounding * triplet.value.cwiseAbs().maxCoeff();
      auto last = triplet.value.bottomRows<1>();
      last = (last.array().abs() > zero).select(last, 0.0);
    }
    triplets.front().value = qr.matrixQR().triangularView<Eigen::Upper>();
    for (Index column = 0; column < D_.cols(); ++column) {
      auto own = D_.col(column).segment<kStereoRows>(point.row);
      own = (Qt * own).eval();
    }
    auto own = r_.segment<kStereoRows>(point.row);
    own = (Qt * own).eval();
  }

  const LinearMeasurement& z_;
  std::vector<Triplet> triplets_;
  std::vector<Point> points_;
  MatrixXd D_;
  VectorXd r_;
};

using Point = TurnedPoints::Point;
using Triplet = TurnedPoints::Triplet;

/// Builds the turned measurement.
class Turning {
 public:
  explicit Turning(const LinearMeasurement& z) : z_(z), points_(z) {}

  TurnedMeasurement result() {
    LinearMeasurement& rows = out_.rows;
    rows.residual.resize(z_.rows());
    rows.D.resize(z_.D.cols() > 0 ? z_.rows() : 0, z_.D.cols());
    rows.H.blocks.reserve(z_.H.blocks.size());
    rows.noise = z_.noise;
    out_.groups.resize(z_.groups.size());
    const BlocksByGroup blocks(z_);
    for (std::size_t g = 0; g < z_.groups.size(); ++g) {
      has_fourth_row(z_.groups[g]) ? points_.add(g, blocks.of(g)) : copy(g, blocks.of(g));
    }
    find_pool_columns();
    std::vector<const Point*> pooled;
    for (const Point& point : points_.points()) {
      const bool leaves_one = only_the_pool_sees(point);
      write(point, leaves_one ? kTriplet : kStereoRows);
      if (leaves_one) {
        pooled.push_back(&point);
      }
    }
    write_fourth_rows(pooled);
    rows.residual.conservativeResize(written_);
    rows.D.conservativeResize(z_.D.cols() > 0 ? written_ : 0, Eigen::NoChange);
    rows.sigma.setOnes(written_);
    return std::move(out_);
  }

 private:
  void copy(std::size_t g, std::span<const Block* const> blocks) {
    const RowGroup& group = z_.groups[g];
    const Index first = group.row, rows = group.rows;
    const VectorXd weight = z_.sigma.segment(first, rows).cwiseInverse();
    for (const Block* block : blocks) {
      Block& written = out_.rows.H.blocks.emplace_back(*block);
      written.row += written_ - first;
      written.value.array().colwise() *= weight.segment(block->row - first, block->value.rows()).array();
    }
    if (z_.D.cols() > 0) {
      out_.rows.D.middleRows(written_, rows) = weight.asDiagonal() * z_.D.middleRows(first, rows);
    }
    out_.rows.residual.segment(written_, rows) = weight.cwiseProduct(z_.residual.segment(first, rows));
    out_.groups[g] = {written_, rows, group.own};
    written_ += rows;
  }

  /// The first three rows of a point, or all four.
  void write(const Point& point, Index rows) {
    for (const Triplet& triplet : points_.triplets(point)) {
      out_.rows.H.blocks.push_back({written_, triplet.col, triplet.value.topRows<kTriplet>()});
      if (rows > kTriplet && !triplet.value.bottomRows<1>().isZero(0.0)) {
        out_.rows.H.blocks.push_back({written_ + kTriplet, triplet.col, triplet.value.bottomRows<1>()});
      }
    }
    if (z_.D.cols() > 0) {
      out_.rows.D.middleRows(written_, rows) = points_.D(point).topRows(rows);
    }
    out_.rows.residual.segment(written_, rows) = points_.r(point).head(rows);
    out_.groups[point.group] = {written_, rows, z_.groups[point.group].own};
    written_ += rows;
  }

  /// Triplets that the fourth rows of most points see: theta, where it is a state, else none.
  void find_pool_columns() {
    std::map<Index, std::size_t> users;
    for (const Point& point : points_.points()) {
      for (const Triplet& triplet : points_.triplets(point)) {
        users[triplet.col] += triplet.value.bottomRows<1>().isZero(0.0) ? 0 : 1;
      }
    }
    for (const auto& [column, count] : users) {
      if (2 * count > points_.points().size()) {
        pool_columns_.push_back(column);
      }
    }
  }

  [[nodiscard]] bool only_the_pool_sees(const Point& point) const {
    const std::span<const Triplet> triplets = points_.triplets(point);
    return std::all_of(triplets.begin(), triplets.end(), [&](const Triplet& triplet) {
      return triplet.value.bottomRows<1>().isZero(0.0) ||
             std::binary_search(pool_columns_.begin(), pool_columns_.end(), triplet.col);
    });
  }

  /// The pool's columns of the fourth row.
  void fill_fourth_row(const Point& point,
                       Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> row) const {
    row.setZero();
    for (const Triplet& triplet : points_.triplets(point)) {
      const auto it = std::lower_bound(pool_columns_.begin(), pool_columns_.end(), triplet.col);
      if (it != pool_columns_.end() && *it == triplet.col) {
        row.segment<kTriplet>(kTriplet * (it - pool_columns_.begin())) = triplet.value.bottomRows<1>();
      }
    }
  }

  /// What states see joins the rows, behind all others; else it is stateless.
  void write_fourth_rows(const std::vector<const Point*>& pooled) {
    const auto q = static_cast<Index>(pooled.size());
    StatelessRows fourth{VectorXd(q), MatrixXd(q, z_.D.cols())};
    MatrixXd H(q, kTriplet * static_cast<Index>(pool_columns_.size()));
    for (Index k = 0; k < q; ++k) {
      const Point& point = *pooled[static_cast<std::size_t>(k)];
      fourth.residual(k) = points_.r(point)(kTriplet);
      fourth.D.row(k) = points_.D(point).bottomRows<1>();
      fill_fourth_row(point, H.row(k));
      out_.groups[point.group].fourth = written_ + k;
    }
    if (pool_columns_.empty()) {
      out_.rows.stateless = std::move(fourth);
      return;
    }
    for (std::size_t c = 0; c < pool_columns_.size(); ++c) {
      const auto column = H.middleCols<kTriplet>(kTriplet * static_cast<Index>(c));
      for (Index row = 0; row < q; row += kTriplet) {
        out_.rows.H.blocks.push_back(
            {written_ + row, pool_columns_[c], column.middleRows(row, std::min(kTriplet, q - row))});
      }
    }
    if (z_.D.cols() > 0) {
      out_.rows.D.middleRows(written_, q) = fourth.D;
    }
    out_.rows.residual.segment(written_, q) = fourth.residual;
    written_ += q;
    out_.seen_by_fourth = std::move(H);
  }

  const LinearMeasurement& z_;
  TurnedPoints points_;
  std::vector<Index> pool_columns_;
  TurnedMeasurement out_;
  Index written_ = 0;  // rows of out_
};

}  // namespace

TurnedMeasurement turned(const LinearMeasurement& z) {
  if (std::any_of(z.groups.begin(), z.groups.end(), has_fourth_row)) {
    return Turning(z).result();
  }
  TurnedMeasurement out{z, z.groups, {}};
  out.rows.groups.clear();
  return out;
}

}  // namespace limber
