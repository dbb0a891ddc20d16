// SPDX-License-Identifier: MIT
#include "frames_factor.hpp"

#include <algorithm>
#include <utility>

namespace limber::detail {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index kFramesAtATime = 8;  // of a product: wide enough to be fast, narrow enough to leave zeros out

/// Row and column in the lower triangle of all unknowns of what stands in row i, column j of the rest.
std::pair<Index, Index> in_lower(const std::vector<Index>& rest, Index i, Index j) {
  const auto [low, high] = std::minmax(rest[static_cast<std::size_t>(i)], rest[static_cast<std::size_t>(j)]);
  return {high, low};
}

}  // namespace

std::vector<Index> FrameLayout::rest() const {
  std::vector<Index> out;
  const auto add = [&](Index first, Index count) {
    for (Index k = 0; k < frames; ++k) {
      for (Index i = 0; i < count; ++i) {
        out.push_back(k * size() + first + i);
      }
    }
  };
  add(0, pose);
  add(pose + chain, theta);
  return out;
}

void subtract_of_rest(MatrixXd& S, const MatrixXd& of_rest, const FrameLayout& layout) {
  const std::vector<Index> rest = layout.rest();
  for (Index j = 0; j < of_rest.cols(); ++j) {
    for (Index i = j; i < of_rest.rows(); ++i) {
      const auto [row, col] = in_lower(rest, i, j);
      S(row, col) -= of_rest(i, j);
    }
  }
}

FramesFactor::FramesFactor(const MatrixXd& A, double damping, const MatrixXd& of_rest,
                           const FrameLayout& layout)
    : layout_(layout), rest_(layout.rest()) {
  Y_ = MatrixXd::Zero(layout.frames * layout.pose, layout.frames * layout.chain);
  for (Index k = 0; k < layout.frames; ++k) {
    factor_chain(A, damping, k);
    if (!chain_.back().succeeded()) {
      return;
    }
  }
  const Index n = layout.rest_size();
  MatrixXd D(n, n);
  for (Index j = 0; j < n; ++j) {
    for (Index i = j; i < n; ++i) {
      const auto [row, col] = in_lower(rest_, i, j);
      D(i, j) = A(row, col) * (i == j ? 1.0 + damping : 1.0) - of_rest(i, j);
    }
  }
  for (Index k = 0; k < layout.frames; k += kFramesAtATime) {
    const Index count = std::min(kFramesAtATime, layout.frames - k);
    const Index filled = std::min(k + count + 1, layout.frames) * layout.pose;
    add_outer(D.topLeftCorner(filled, filled), -1.0,
              Y_.block(0, k * layout.chain, filled, count * layout.chain));
  }
  dense_.emplace(std::move(D));
}

/// The columns of L that belong to a frame's chain.
void FramesFactor::factor_chain(const MatrixXd& A, double damping, Index frame) {
  const Index c = layout_.chain, p = layout_.pose, size = layout_.size();
  const Index at = frame * size + p;
  const Index filled = std::min(frame + 2, layout_.frames) * p;
  MatrixXd B = A.block(at, at, c, c);
  B.diagonal() *= 1.0 + damping;
  MatrixXd G;
  auto Y = Y_.block(0, frame * c, filled, c);
  Y.middleRows(frame * p, p) = A.block(at, frame * size, c, p).transpose();
  if (frame + 1 < layout_.frames) {
    Y.bottomRows(p) = A.block((frame + 1) * size, at, p, c);
  }
  if (frame > 0) {
    Y.middleRows((frame - 1) * p, p) = A.block(at, (frame - 1) * size, c, p).transpose();
    G = A.block(at, at - size, c, c);
    solve_lower_from_right(transposed(chain_.back().factor()), G);
    add_outer(B, -1.0, G);
    const Index before = (frame + 1) * p;
    add_product(Y.topRows(before), -1.0, Y_.block(0, (frame - 1) * c, before, c), transposed(G));
  }
  chain_.emplace_back(std::move(B));
  links_.push_back(std::move(G));
  solve_lower_from_right(transposed(chain_.back().factor()), Y);
}

VectorXd FramesFactor::solve(const VectorXd& g) const {
  const Index c = layout_.chain;
  const Index poses = Y_.rows();
  const auto chain_at = [&](Index frame) { return frame * layout_.size() + layout_.pose; };
  VectorXd z(Y_.cols());
  for (Index k = 0; k < layout_.frames; ++k) {
    const auto i = static_cast<std::size_t>(k);
    z.segment(k * c, c) = g.segment(chain_at(k), c);
    if (k > 0) {
      z.segment(k * c, c) -= links_[i] * z.segment((k - 1) * c, c);
    }
    solve_lower(chain_[i].factor(), z.segment(k * c, c));
  }
  VectorXd rest = g(rest_);
  rest.head(poses) -= Y_ * z;
  rest = dense_->solve(rest);
  z -= Y_.transpose() * rest.head(poses);
  VectorXd out(g.size());
  out(rest_) = rest;
  for (Index k = layout_.frames - 1; k >= 0; --k) {
    const auto i = static_cast<std::size_t>(k);
    VectorXd x = z.segment(k * c, c);
    if (k + 1 < layout_.frames) {
      x -= links_[i + 1].transpose() * out.segment(chain_at(k + 1), c);
    }
    chain_[i].factor().triangularView<Eigen::Lower>().transpose().solveInPlace(x);
    out.segment(chain_at(k), c) = x;
  }
  return out;
}

}  // namespace limber::detail
