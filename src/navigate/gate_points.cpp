// SPDX-License-Identifier: MIT
// StereoFilter: which points of a frame it believes.
#include "limber/navigate/stereo_filter.hpp"
#include "limber/update/gate.hpp"

namespace limber {

using Eigen::MatrixXd;

namespace {

constexpr double kKnownTurn = 0.05;  // [rad] at 1 sigma: beside such a prediction a majority may be wrong

}  // namespace

/// In doubt about theta each point for itself may be anywhere, and only beside the others is it wrong: they
/// are judged after what theta can explain of all of them.
ParameterErrorModel StereoFilter::gate_model(const ParameterErrorModel& model) const {
  ParameterErrorModel out = model;
  if (!fresh_.is_zero()) {
    out.constrained = MatrixXd::Zero(model.white_covariance.rows(), kBlockSize);
    out.constrained.topRows<kBlockSize>() = scale_.asDiagonal();
  }
  return out;
}

std::vector<bool> StereoFilter::gate_points(const StackedFrame& stacked, const FrameInnovation& seen,
                                            const ParameterErrorModel& model, FrameReport& report) const {
  std::vector<bool> accepted(stacked.track_ids.size(), true);
  if (!options_.gate || accepted.empty()) {
    return accepted;
  }
  const bool darkness = is_after_darkness(report.t_ns);
  const bool known =
      report.inputs.status == InputStatus::kSound && blind_turn_ <= kKnownTurn * kKnownTurn && !darkness;
  PredictedPose predicted{known, {}, {}, {}};
  if (options_.motion == MotionModel::kImu) {
    predicted.by_pose = seen.by_pose;
  }
  if (options_.motion == MotionModel::kConstantVelocity || darkness) {
    predicted.P = estimate_.P().diagonal_block<6>(0);
    predicted.rig = MatrixXd::Zero(seen.innovation.D.cols(), kBlockSize);
    predicted.rig.topRows<kBlockSize>() = scale_.asDiagonal();
  }
  const GateReport gated = gate(seen.innovation, seen.groups, gate_model(model), gate_thresholds_, predicted);
  report.gate_overruled = gated.overruled;
  report.most_mismatched = gated.most_mismatched;
  report.most_move = known && gated.most_refused() && !gated.most_mismatched;
  for (std::size_t g = 0; g < accepted.size(); ++g) {
    accepted[g] = gated.accepted[g];
    if (!accepted[g]) {
      report.refused.push_back(
          {stacked.track_ids[g], RefusalReason::kGate, gated.distance[g], gated.threshold[g]});
    }
  }
  return accepted;
}

}  // namespace limber
