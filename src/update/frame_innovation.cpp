// SPDX-License-Identifier: MIT
#include "limber/update/frame_innovation.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "kept_rows.hpp"
#include "limber/core/factors.hpp"
#include "limber/update/turn.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Of rows that see little, as many as what they see has dimensions: Qᵀ times the rows. The rest is noise.
struct Pool {
  MatrixXd Q;  ///< q×kept; 0×0 if no state moves the rows
  MatrixXd D;  ///< kept×c
  VectorXd r;  ///< kept
};

/// @param H  q×k and D: q×c, what the rows see
Pool compressed_pool(const Eigen::Ref<const MatrixXd>& H, const Eigen::Ref<const MatrixXd>& D, VectorXd r,
                     NoiseRows& noise) {
  Pool out{MatrixXd(0, 0), MatrixXd(0, D.cols()), VectorXd(0)};
  MatrixXd seen(r.size(), H.cols() + D.cols());
  seen << H, D;
  if (seen.size() > 0) {  // Eigen factorises an empty matrix at its peril
    const PivotedQr pivoted = pivoted_qr(seen);
    pivoted.qr.apply_Qt(r);
    out.D = pivoted.turned_rows(pivoted.rank).rightCols(D.cols());
    out.r = r.head(pivoted.rank);
    if (H.cols() > 0) {
      out.Q = pivoted.qr.Q().leftCols(pivoted.rank);
    }
  }
  const Index rest = r.size() - out.r.size();
  noise.rows += rest;
  noise.squared_norm += r.tail(rest).squaredNorm();
  return out;
}

/// The last rows, which see little, compressed.
void compress_tail(Innovation& innovation, const Eigen::Ref<const MatrixXd>& H) {
  const Index q = H.rows(), m = innovation.r.size() - q;
  const Pool pool = compressed_pool(H, innovation.D.bottomRows(q), innovation.r.tail(q), innovation.noise);
  const Index k = pool.r.size();
  innovation.r.conservativeResize(m + k);
  innovation.r.tail(k) = pool.r;
  innovation.D.conservativeResize(m + k, Eigen::NoChange);
  innovation.D.bottomRows(k) = pool.D;
  const MatrixXd PHt = multiply(innovation.PHt.rightCols(q), pool.Q);
  innovation.PHt.conservativeResize(Eigen::NoChange, m + k);
  innovation.PHt.rightCols(k) = PHt;
  const MatrixXd cross = multiply(innovation.S.topRightCorner(m, q), pool.Q);
  const MatrixXd own = congruence(transposed(pool.Q), innovation.S.bottomRightCorner(q, q));
  innovation.S.conservativeResize(m + k, m + k);
  innovation.S.topRightCorner(m, k) = cross;
  innovation.S.bottomLeftCorner(k, m) = cross.transpose();
  innovation.S.bottomRightCorner(k, k) = own;
}

/// Leaves out the groups that are not kept.
void leave_out(FrameInnovation& frame, const std::vector<bool>& kept) {
  Innovation& all = frame.innovation;
  const KeptRows rows = kept_rows(frame.groups, kept, all.r.size(), all.stateless.residual.size());
  std::vector<Index> fourth;
  const Index q = frame.seen_by_fourth.rows(), first_fourth = all.r.size() - q;
  std::copy_if(rows.moved.begin(), rows.moved.end(), std::back_inserter(fourth),
               [&](Index row) { return row >= first_fourth; });
  for (Index& row : fourth) {
    row -= first_fourth;
  }
  frame.seen_by_fourth = frame.seen_by_fourth(fourth, Eigen::all).eval();
  all.r = all.r(rows.moved).eval();
  all.D = all.D(rows.moved, Eigen::all).eval();
  all.PHt = all.PHt(Eigen::all, rows.moved).eval();
  all.S = all.S(rows.moved, rows.moved).eval();
  all.stateless.residual = all.stateless.residual(rows.stateless).eval();
  all.stateless.D = all.stateless.D(rows.stateless, Eigen::all).eval();
}

/// The columns of H that belong to the pose, whitened.
MatrixXd pose_columns(const LinearMeasurement& z) {
  constexpr Index kPose = 2 * kTriplet;
  MatrixXd out = MatrixXd::Zero(z.rows(), kPose);
  for (const SparseJacobian::Block& block : z.H.blocks) {
    if (block.col < kPose) {
      out.block(block.row, block.col, block.value.rows(), kTriplet) += block.value;
    }
  }
  return z.sigma.cwiseInverse().asDiagonal() * out;
}

}  // namespace

FrameInnovation form_frame_innovation(const Covariance& P, const LinearMeasurement& measurement) {
  check(P, measurement);
  TurnedMeasurement z = turned(measurement);
  return {form_innovation(P, z.rows), std::move(z.groups), std::move(z.seen_by_fourth), pose_columns(z.rows)};
}

Innovation compressed(FrameInnovation frame, const std::vector<bool>& kept) {
  if (std::find(kept.begin(), kept.end(), false) != kept.end()) {
    leave_out(frame, kept);
  }
  Innovation& innovation = frame.innovation;
  if (frame.seen_by_fourth.rows() > 0) {
    compress_tail(innovation, frame.seen_by_fourth);
  }
  StatelessRows& stateless = innovation.stateless;
  const MatrixXd no_state(stateless.residual.size(), 0);
  Pool pool = compressed_pool(no_state, stateless.D, std::move(stateless.residual), innovation.noise);
  stateless = {std::move(pool.r), std::move(pool.D)};
  return std::move(innovation);
}

Innovation compressed(FrameInnovation frame) { return compressed(std::move(frame), {}); }

}  // namespace limber
