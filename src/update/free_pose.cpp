// SPDX-License-Identifier: MIT
#include "free_pose.hpp"

#include <algorithm>

#include "limber/core/factors.hpp"
#include "limber/update/consensus.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Groups that agree on another pose and other parameters by no chance: three these fit exactly.
constexpr std::size_t kEnoughElsewhere = 8;

/// Mismatched groups are further than that many times their threshold (in squared distance) from there: five
/// times the noise that is assumed may be noise.
constexpr double kBeyondNoise = 25.0;

/// How far a pose may be off, in a pixel's noise.
constexpr double kAnywhere = 1000.0;

constexpr double kRankCut = 1e-9;  // of the largest singular value

constexpr Index kPose = 6;  // rows of the state: it comes first

/// The directions of a column space, each of a pixel's noise a row: how well a pose is known makes none weak.
MatrixXd pixels_in_each_direction(const MatrixXd& columns) {
  const RightSingular svd = right_singular(householder_qr(columns).R());
  const Index rank = (svd.values.array() > kRankCut * svd.values.maxCoeff()).count();
  const VectorXd scale =
      std::sqrt(static_cast<double>(columns.rows())) * svd.values.head(rank).cwiseInverse();
  return multiply(columns, svd.V.leftCols(rank)) * scale.asDiagonal();
}

}  // namespace

Judged with_free_pose(const Judged& judged, const Innovation& innovation) {
  Judged out = judged;
  const Index pose = std::min<Index>(kPose, innovation.PHt.rows()), m = judged.S.rows();
  const MatrixXd by_pose = pixels_in_each_direction(innovation.PHt.topRows(pose).transpose());
  out.DC.conservativeResize(Eigen::NoChange, judged.DC.cols() + by_pose.cols());
  out.DC.rightCols(by_pose.cols()).setZero();
  out.DC.topRightCorner(m, by_pose.cols()) = by_pose;
  return out;
}

bool are_two_bodies(const Judged& judged, const GateReport& report, const GateThresholds& thresholds) {
  if (report.all_accepted()) {
    return false;
  }
  std::vector<bool> refused = report.accepted;
  refused.flip();
  const Judged without = judged.subset(refused);
  const Judge of_all(judged), of_others(without);
  if (!of_all.valid() || !of_others.valid()) {
    return false;
  }
  const Distance all = of_all.joint(), others = of_others.joint();
  return all.dof > others.dof &&
         all.squared - others.squared > kGrossOutlier * thresholds.of(all.dof - others.dof);
}

Judged with_free_everything(const Judged& judged, const Innovation& innovation, const MatrixXd& by_pose) {
  const Index m = innovation.r.size(), q = innovation.stateless.residual.size(), c = innovation.D.cols();
  MatrixXd anything = MatrixXd::Zero(m + q, by_pose.cols() + c);
  anything.topLeftCorner(m, by_pose.cols()) = by_pose;
  anything.topRightCorner(m, c) = innovation.D;
  anything.bottomRightCorner(q, c) = innovation.stateless.D;
  return {judged.r, judged.S, pixels_in_each_direction(anything), judged.groups, false};
}

bool are_mismatched(const Judged& free, const GateThresholds& thresholds) {
  const WhiteGroups white = white_groups(free.r, free.S, free.DC, free.groups);
  const Consensus consensus = find_consensus(white, kAnywhere);
  std::size_t near = 0;
  for (std::size_t g = 0; g < white.groups.size(); ++g) {
    near += consensus.distance[g] <= kBeyondNoise * thresholds.of(white.groups[g].rows) ? 1 : 0;
  }
  return near < std::max(kEnoughElsewhere, (white.groups.size() + 1) / 2);
}

}  // namespace limber::detail
