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

/// Rest by rest, the lower triangle of what A holds of it.
MatrixXd of_the_rest(const MatrixXd& A, const FrameLayout& layout) {
  const Index p = layout.pose, t = layout.theta, size = layout.size();
  MatrixXd out(layout.rest_size(), layout.rest_size());
  for (Index l = 0; l < layout.frames; ++l) {
    const Index pose_l = l * size, theta_l = pose_l + size - t;
    for (Index k = 0; k < layout.frames; ++k) {
      const Index pose_k = k * size, theta_k = pose_k + size - t;
      auto theta_pose = out.block(layout.theta_in_rest(k), layout.pose_in_rest(l), t, p);
      if (k < l) {
        theta_pose = A.block(pose_l, theta_k, p, t).transpose();
        continue;
      }
      theta_pose = A.block(theta_k, pose_l, t, p);
      out.block(layout.pose_in_rest(k), layout.pose_in_rest(l), p, p) = A.block(pose_k, pose_l, p, p);
      out.block(layout.theta_in_rest(k), layout.theta_in_rest(l), t, t) = A.block(theta_k, theta_l, t, t);
    }
  }
  return out;
}

/// `count` unknowns of each frame, the first of them given.
void add_of_frames(const FrameLayout& layout, Index first, Index count, std::vector<Index>& out) {
  for (Index k = 0; k < layout.frames; ++k) {
    for (Index i = 0; i < count; ++i) {
      out.push_back(k * layout.size() + first + i);
    }
  }
}

}  // namespace

std::vector<Index> FrameLayout::rest() const {
  std::vector<Index> out;
  add_of_frames(*this, 0, pose, out);
  add_of_frames(*this, pose + chain, theta, out);
  return out;
}

std::vector<Index> FrameLayout::chains() const {
  std::vector<Index> out;
  add_of_frames(*this, pose, chain, out);
  return out;
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
  MatrixXd D = of_the_rest(A, layout);
  D.diagonal() *= 1.0 + damping;
  D.triangularView<Eigen::Lower>() -= of_rest;
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

/// X := L⁻¹ X, L: of the chains.
void FramesFactor::solve_chain(MatrixXd& X) const {
  const Index c = layout_.chain;
  for (Index k = 0; k < layout_.frames; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (k > 0) {
      add_product(X.middleRows(k * c, c), -1.0, links_[i], X.middleRows((k - 1) * c, c));
    }
    solve_lower(chain_[i].factor(), X.middleRows(k * c, c));
  }
}

/// X := L⁻ᵀ X.
void FramesFactor::solve_chain_transposed(MatrixXd& X) const {
  const Index c = layout_.chain;
  for (Index k = layout_.frames - 1; k >= 0; --k) {
    const auto i = static_cast<std::size_t>(k);
    if (k + 1 < layout_.frames) {
      add_product(X.middleRows(k * c, c), -1.0, transposed(links_[i + 1]), X.middleRows((k + 1) * c, c));
    }
    solve_lower(transposed(chain_[i].factor()), X.middleRows(k * c, c));
  }
}

VectorXd FramesFactor::solve(const VectorXd& g) const {
  const std::vector<Index> chains = layout_.chains();
  MatrixXd z = g(chains);
  solve_chain(z);
  VectorXd rest = g(rest_);
  rest.head(Y_.rows()) -= Y_ * z;
  rest = dense_->solve(rest);
  z -= Y_.transpose() * rest.head(Y_.rows());
  solve_chain_transposed(z);
  VectorXd out(g.size());
  out(rest_) = rest;
  out(chains) = z;
  return out;
}

MatrixXd FramesFactor::inverse() const {
  const Index poses = Y_.rows(), chain_size = Y_.cols();
  const MatrixXd rest = dense_->inverse();
  MatrixXd Z = Y_.transpose();
  solve_chain_transposed(Z);
  MatrixXd chain = MatrixXd::Identity(chain_size, chain_size);
  solve_chain(chain);
  solve_chain_transposed(chain);
  const MatrixXd chain_rest = multiply(Z, rest.topRows(poses));  // up to its sign
  add_product(chain, 1.0, chain_rest.leftCols(poses), transposed(Z));
  const std::vector<Index> chains = layout_.chains();
  const Index n = layout_.frames * layout_.size();
  MatrixXd out(n, n);
  out(rest_, rest_) = rest;
  out(chains, chains) = chain;
  out(chains, rest_) = -chain_rest;
  out(rest_, chains) = -chain_rest.transpose();
  return out;
}

}  // namespace limber::detail
