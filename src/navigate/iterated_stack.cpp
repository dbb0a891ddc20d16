// SPDX-License-Identifier: MIT
// StereoFilter's frames after a time without inputs or images: linearised where the images put the body.
#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "limber/core/so3.hpp"
#include "limber/core/time.hpp"
#include "limber/navigate/stereo_filter.hpp"
#include "limber/state/world_turn.hpp"

namespace limber {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using L = StateLayout;

namespace {

constexpr int kRounds = 12;
constexpr double kDarkness = 1.0;      // [s]
constexpr double kSettled = 1e-3;      // [m], [rad]: further rounds would change nothing
constexpr double kTurnAtOnce = 0.2;    // [rad] a round: beyond, rows are not linear
constexpr double kFarthestTurn = 1.0;  // [rad]: images that say more than that are not understood

/// As Estimate::retract corrects it.
Pose shifted(const Pose& pose, const Vector6& shift) {
  return {so3_normalized(pose.R * so3_exp(shift.tail<3>())),
          pose.p + turned_with_world(shift.head<3>(), pose.R * shift.tail<3>())};
}

/// Rows that are linear at the pose `shift` away from the prediction, as rows of the prediction's error: of
/// the right-invariant one, which is the same at both (the inverse of what Estimate::retract does to P).
/// @param R  attitude of the prediction
void refer_to_prediction(LinearMeasurement& rows, const Matrix3d& R, const Vector6& shift) {
  const Matrix3d turned_back = so3_exp(-shift.tail<3>());
  const Matrix3d moved_by_turn = -skew(turned_with_world(shift.head<3>(), R * shift.tail<3>())) * R;
  std::vector<SparseJacobian::Block> further;
  for (SparseJacobian::Block& block : rows.H.blocks) {
    auto residual = rows.residual.segment(block.row, block.value.rows());
    if (block.col == L::kPosition) {
      further.push_back({block.row, L::kAttitude, block.value * moved_by_turn});
      residual += block.value * shift.head<3>() + further.back().value * shift.tail<3>();
    } else if (block.col == L::kAttitude) {
      block.value = (block.value * turned_back).eval();
      residual += block.value * shift.tail<3>();
    }
  }
  rows.H.blocks.insert(rows.H.blocks.end(), further.begin(), further.end());
}

}  // namespace

/// No image showed a point for so long that a prediction by inputs alone is not linear in the pixels.
bool StereoFilter::is_after_darkness(std::int64_t t_ns) const {
  return last_points_ns_ != std::numeric_limits<std::int64_t>::min() &&
         seconds_between(last_points_ns_, t_ns) > kDarkness;
}

/// @brief Iterated EKF [Bell1993] for frames before which inputs or images were missing: their prediction may
/// be far off, and depths that are corrected along a wrong motion are lost. New landmarks wait for the next
/// frame. Where they are not understood, this one is linearised at the prediction.
StackedFrame StereoFilter::stack_where_seen(const StereoFrame& frame, const LinearizationPoint& at,
                                            NewLandmarks new_landmarks, const ParameterErrorModel& model,
                                            FrameReport& report) {
  for (auto& [id, rows] : new_landmarks) {
    rows = RemainingRows::kNone;
  }
  const NavigationState predicted = estimate_.nav();
  const auto stacked_at = [&](const Vector6& shift, FrameReport& said) {
    NavigationState nav = predicted;
    nav.T_world_body = shifted(predicted.T_world_body, shift);
    estimate_.set_nav(nav);
    StackedFrame out = stack(frame, at, new_landmarks, said);
    estimate_.set_nav(predicted);
    refer_to_prediction(out.measurement, predicted.T_world_body.R, shift);
    return out;
  };
  Vector6 shift = Vector6::Zero();
  for (int round = 0; round < kRounds; ++round) {
    FrameReport said = report;
    StackedFrame stacked = stacked_at(shift, said);
    FrameReport gated = said;
    Covariance P = estimate_.P();
    FrameInnovation seen = form_frame_innovation(P, stacked.measurement);
    const std::vector<bool> accepted = gate_points(stacked, seen, model, gated);
    const UpdateReport updated = update(P, compressed(std::move(seen), accepted), model);
    const Vector6 step = updated.dx.head<6>() - shift;
    if (updated.status == UpdateStatus::kUpdated && step.cwiseAbs().maxCoeff() < kSettled) {
      report.refused = said.refused;
      return stacked;
    }
    const Vector6 next = shift + std::min(1.0, kTurnAtOnce / step.tail<3>().norm()) * step;
    if (updated.status != UpdateStatus::kUpdated || next.tail<3>().norm() > kFarthestTurn) {
      return stacked_at(Vector6::Zero(), report);
    }
    shift = next;
  }
  return stacked_at(shift, report);
}

}  // namespace limber
