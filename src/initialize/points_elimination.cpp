// SPDX-License-Identifier: MIT
#include "points_elimination.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <numeric>
#include <tuple>

#include "limber/core/dense.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr std::size_t kPointsAtATime =
    16;  // wide enough for a fast product, narrow enough to leave zeros out

}  // namespace

PointsElimination::PointsElimination(const WindowNormal& normal, double damping) : normal_(normal) {
  for (Matrix3d V : normal.V) {
    V.diagonal() *= 1.0 + damping;
    inverse_.push_back(V.inverse());
  }
}

MatrixXd PointsElimination::from_matrix() const {
  MatrixXd out = MatrixXd::Zero(normal_.W.rows(), normal_.W.rows());
  std::vector<std::size_t> order(inverse_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const FrameSpan &of_a = normal_.seen[a], &of_b = normal_.seen[b];
    return std::tie(of_a.first, of_a.last, a) < std::tie(of_b.first, of_b.last, b);
  });
  for (std::size_t k = 0; k < order.size(); k += kPointsAtATime) {
    const auto begin = order.begin() + static_cast<std::ptrdiff_t>(k);
    const auto count = static_cast<std::ptrdiff_t>(std::min(kPointsAtATime, order.size() - k));
    add_group({begin, begin + count}, out);
  }
  return out;
}

void PointsElimination::add_group(const std::vector<std::size_t>& points, MatrixXd& out) const {
  const FrameLayout& layout = normal_.layout;
  FrameSpan span = normal_.seen[points.front()];
  for (const std::size_t j : points) {
    span.first = std::min(span.first, normal_.seen[j].first);
    span.last = std::max(span.last, normal_.seen[j].last);
  }
  const Index frames = span.last - span.first + 1;
  const Index p = frames * layout.pose, at_p = layout.pose_in_rest(span.first);
  const Index t = frames * layout.theta, at_t = layout.theta_in_rest(span.first);
  MatrixXd W(p + t, static_cast<Index>(3 * points.size())), WV(W.rows(), W.cols());
  for (std::size_t k = 0; k < points.size(); ++k) {
    const auto of_point = normal_.W.middleCols<3>(static_cast<Index>(3 * points[k]));
    auto columns = W.middleCols<3>(static_cast<Index>(3 * k));
    columns.topRows(p) = of_point.middleRows(at_p, p);
    columns.bottomRows(t) = of_point.middleRows(at_t, t);
    WV.middleCols<3>(static_cast<Index>(3 * k)).noalias() = columns * inverse_[points[k]];
  }
  add_lower_product(out.block(at_p, at_p, p, p), WV.topRows(p), transposed(W.topRows(p)));
  if (t > 0) {
    add_product(out.block(at_t, at_p, t, p), 1.0, WV.bottomRows(t), transposed(W.topRows(p)));
    add_lower_product(out.block(at_t, at_t, t, t), WV.bottomRows(t), transposed(W.bottomRows(t)));
  }
}

VectorXd PointsElimination::times_inverse(VectorXd x) const {
  for (std::size_t j = 0; j < inverse_.size(); ++j) {
    const auto at = static_cast<Index>(3 * j);
    x.segment<3>(at) = inverse_[j] * x.segment<3>(at).eval();
  }
  return x;
}

VectorXd PointsElimination::from_gradient() const { return normal_.W * step_alone(); }

VectorXd PointsElimination::step_alone() const { return times_inverse(normal_.g_points); }

VectorXd PointsElimination::step(const VectorXd& rest) const {
  return times_inverse(normal_.g_points - normal_.W.transpose() * rest);
}

}  // namespace limber::detail
