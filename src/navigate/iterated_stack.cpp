// SPDX-License-Identifier: MIT
// StereoFilter's frames after a time without inputs or images: linearised where the images put the body.
#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "limber/core/time.hpp"
#include "limber/navigate/stereo_filter.hpp"

namespace limber {

using Eigen::VectorXd;
using L = StateLayout;

namespace {

constexpr int kRounds = 20;
constexpr std::ptrdiff_t kEnoughToFind = 10;  // points, of which few agree by chance
constexpr double kDarkness = 1.0;             // [s]
constexpr double kSettled = 1e-3;             // [m], [rad]: further rounds would change nothing
constexpr double kTurnAtOnce = 0.2;           // [rad] a round: beyond, rows are not linear
constexpr double kFarthestTurn = 1.0;         // [rad]: images that say more than that are not understood

/// What a correction does to the body and its map. Calibration and scales stay: rows are as linear in them
/// anywhere.
VectorXd of_body_and_map(const StateLayout& layout, VectorXd dx) {
  dx.segment(layout.body_size(), layout.map_begin() - layout.body_size()).setZero();
  return dx;
}

/// Most points agree upon where the body is.
bool explains(const std::vector<bool>& accepted) {
  const auto good = std::count(accepted.begin(), accepted.end(), true);
  return good >= kEnoughToFind && 2 * static_cast<std::size_t>(good) > accepted.size();
}

/// Rows that are linear where `shift` leads from the estimate, as rows of the estimate's errors.
void refer_back(const Estimate& estimate, const VectorXd& shift, LinearMeasurement& rows) {
  estimate.refer_back(shift, rows.H);
  for (const SparseJacobian::Block& block : rows.H.blocks) {
    rows.residual.segment(block.row, block.value.rows()) += block.value * shift.segment<kTriplet>(block.col);
  }
}

}  // namespace

/// No image showed a point for so long that a prediction by inputs alone is not linear in the pixels.
bool StereoFilter::is_after_darkness(std::int64_t t_ns) const {
  return last_points_ns_ != std::numeric_limits<std::int64_t>::min() &&
         seconds_between(last_points_ns_, t_ns) > kDarkness;
}

/// @brief Iterated EKF [Bell1993] for frames before which inputs or images were missing: their prediction may
/// be far off, and depths that are corrected along a wrong motion are lost. All of body and map is where the
/// images put it: what was seen first after the darkness goes with the body. New landmarks wait for the next
/// frame.
StereoFilter::Relocated StereoFilter::stack_where_seen(const StereoFrame& frame, const LinearizationPoint& at,
                                                       NewLandmarks new_landmarks,
                                                       const ParameterErrorModel& model,
                                                       FrameReport& report) const {
  for (auto& [id, rows] : new_landmarks) {
    rows = RemainingRows::kNone;
  }
  const auto stacked_at = [&](const VectorXd& there, FrameReport& said) {
    Estimate shifted = estimate_;
    shifted.retract(there);
    StackedFrame out = stack(shifted, frame, at, new_landmarks, said);
    refer_back(estimate_, there, out.measurement);
    return out;
  };
  VectorXd shift = VectorXd::Zero(estimate_.size());
  double share = 1.0, last = std::numeric_limits<double>::infinity();  // of a step; its size
  for (int round = 0; round < kRounds; ++round) {
    FrameReport said = report;
    StackedFrame stacked = stacked_at(shift, said);
    FrameReport gated = said;
    Covariance P = estimate_.P();
    FrameInnovation seen = form_frame_innovation(P, stacked.measurement);
    const std::vector<bool> accepted = gate_points(stacked, seen, model, gated);
    const UpdateReport updated = update(P, compressed(std::move(seen), accepted), model);
    if (updated.status != UpdateStatus::kUpdated) {
      break;
    }
    const VectorXd step = of_body_and_map(estimate_.layout(), updated.dx) - shift;
    const double size = step.head<L::kPoseSize>().cwiseAbs().maxCoeff();
    if (size < kSettled) {
      report.refused = said.refused;
      return {std::move(stacked), explains(accepted)};
    }
    share *= size < last ? 1.0 : 0.5;
    last = size;
    shift += std::min(share, kTurnAtOnce / step.segment<3>(L::kAttitude).norm()) * step;
    if (shift.segment<3>(L::kAttitude).norm() > kFarthestTurn) {
      shift.setZero();
      break;
    }
  }
  return {stacked_at(shift, report), false};
}

}  // namespace limber
