// SPDX-License-Identifier: MIT
// StereoFilter: which points of a frame it believes.
#include "limber/navigate/stereo_filter.hpp"
#include "limber/update/gate.hpp"

namespace limber {

using Eigen::MatrixXd;

namespace {

constexpr double kKnownTurn = 0.05;  // [rad] at 1 sigma: beside such a prediction a majority may be wrong

/// Of all parameters theta may be wrong, each in its plausible error.
MatrixXd theta_alone(const RigParameters& scale, Eigen::Index parameters) {
  MatrixXd out = MatrixXd::Zero(parameters, kBlockSize);
  out.topRows<kBlockSize>() = scale.asDiagonal();
  return out;
}

}  // namespace

/// In doubt about theta each point for itself may be anywhere, and only beside the others is it wrong: they
/// are judged after what theta can explain of all of them.
ParameterErrorModel StereoFilter::gate_model(const ParameterErrorModel& model) const {
  ParameterErrorModel out = model;
  if (!fresh_.is_zero()) {
    out.constrained = theta_alone(scale_, model.white_covariance.rows());
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
  PredictedPose predicted{known, {}, {}, {}, {}};
  if (options_.motion == MotionModel::kImu) {
    predicted.by_pose = seen.by_pose;
    predicted.usual_scatter = usual_scatter_.beside(report.sigma_px);
  }
  if (options_.motion == MotionModel::kConstantVelocity || darkness) {
    predicted.P = estimate_.P().diagonal_block<6>(0);
    predicted.rig = theta_alone(scale_, seen.innovation.D.cols());
  }
  const GateReport gated = gate(seen.innovation, seen.groups, gate_model(model), gate_thresholds_, predicted);
  report.scatter = gated.scatter;
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

void StereoFilter::record(const StackedFrame& stacked, const std::vector<bool>& accepted,
                          const NewLandmarks& new_landmarks, FrameReport& report) {
  for (std::size_t g = 0; g < stacked.track_ids.size(); ++g) {
    Landmark* landmark = estimate_.find(stacked.track_ids[g]);
    landmark->refusals = accepted[g] ? 0 : landmark->refusals + 1;
    landmark->last_seen_ns = report.t_ns;
    landmark->sightings += accepted[g] ? 1 : 0;
    report.used += accepted[g] && report.status == UpdateStatus::kUpdated ? 1 : 0;
  }
  for (const Refusal& refusal : report.refused) {
    Landmark* landmark = estimate_.find(refusal.track_id);
    if (refusal.reason == RefusalReason::kNotProjectable) {
      ++landmark->refusals;
    }
    // A new landmark that contradicts its own frame is none.
    if (new_landmarks.contains(refusal.track_id)) {
      estimate_.remove_landmark(refusal.track_id);
    }
  }
}

}  // namespace limber
