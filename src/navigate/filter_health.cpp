// SPDX-License-Identifier: MIT
// What an update tells StereoFilter of the rig and of its pixels.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "limber/core/chi_square.hpp"
#include "limber/core/factors.hpp"
#include "limber/core/time.hpp"
#include "limber/navigate/stereo_filter.hpp"
#include "parameter_roles.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// A gap in the inputs [s] after which the state is open for what happened.
constexpr double kLongGap = 0.1;

/// Chance that a sound rig is accused by a frame; and how long a filter that trusts it is held for misled
/// after that [s], though not every frame shows it.
constexpr double kAccusedByChance = 1e-6;
constexpr double kMisled = 0.5;

/// Points of which that much noise [px] is learned contradict each other (things that move, mismatches). Who
/// then believes the inputs less follows the wrong ones.
constexpr double kPointsQuarrel = 2.5;
constexpr double kContested = 0.15;  // of the points: so many are on another body, say

/// A speed tells a scale where it is that many of its sigmas: to 5 %, as a start asks for.
constexpr double kCertainMotion = 20.0;

/// A scale is known no better than to that many times the share that noise has in what tells it.
constexpr double kNoiseShares = 2.0;

/// Of a filter that trusts theta, NIS also counts what theta would explain: without that.
struct Innovations {
  double nis, dof;
  EvidenceStatistic explained;
};

Innovations without_rig(const ParameterErrorModel& model, const UpdateReport& update) {
  Innovations out{update.nis, static_cast<double>(update.dof), {}};
  if (!model.witness && !update.evidence.empty()) {
    out.explained = statistic(update.evidence, 1.0 / (kWidestErrors * kWidestErrors));
    out.nis -= out.explained.value;
    out.dof -= static_cast<double>(out.explained.dof);
  }
  return out;
}

/// Noise enlarges all rows alike; a wrong rig those that it explains, and what it has done to the map and to
/// the pose shows in the others, too. @param scatter  NIS per degree of freedom of the others
bool accuses_rig(const EvidenceStatistic& explained, double scatter) {
  const auto dof = static_cast<double>(explained.dof);
  return explained.dof > 0 &&
         explained.value > std::max(scatter, 1.0) * chi_square_quantile(1.0 - kAccusedByChance, dof);
}

}  // namespace

/// What the witness has gathered against the assumed rig; nothing without one.
std::optional<ParameterEvidence> StereoFilter::gathered(const ParameterErrorModel& model) const {
  if (!model.witness) {
    return std::nullopt;
  }
  const Index k = model.watched.cols();
  const MatrixXd P = estimate_.P().diagonal_block<kWitnessSize>(model.witness->at);
  const MatrixXd information = Cholesky(P).inverse();
  ParameterEvidence out{information.topLeftCorner(k, k), (information * estimate_.witness()).head(k)};
  out.information.diagonal().array() -= 1.0 / (kWidestErrors * kWidestErrors);
  return out;
}

bool StereoFilter::seems_misled(std::int64_t t_ns) const {
  return rig_accused_ns_ && seconds_between(*rig_accused_ns_, t_ns) <= kMisled;
}

/// Whether points contradict each other: what they say against the inputs is not to be believed.
bool StereoFilter::points_quarrel(const FrameReport& report) const {
  return report.gate_overruled || report.most_move || report.most_mismatched || report.led_astray ||
         input_alarm_.points_quarrel() ||
         static_cast<double>(report.refused.size()) > kContested * static_cast<double>(report.observed) ||
         (pixel_noise_ && pixel_noise_->report().sigma_px > kPointsQuarrel);
}

/// What is learned of pixels and inputs. Nothing where a filter that trusts the rig is misled by it: what is
/// off then is neither.
void StereoFilter::learn_noise(const ParameterErrorModel& model, const UpdateReport& update,
                               const PoseCorrection& correction, const FrameReport& report) {
  if (!pixel_noise_ && !imu_noise_ && !motion_noise_) {
    return;
  }
  const Innovations rest = without_rig(model, update);
  PoseCorrection counted = correction;
  counted.nis = rest.nis;
  counted.dof = rest.dof;
  const double scatter = scatter_beside(counted);
  if (motion_noise_) {  // also where points seem to contradict the state: that it moves more looks like it
    motion_noise_->learn(counted);
  }
  if (accuses_rig(rest.explained, scatter)) {
    rig_accused_ns_ = correction.t_ns;
  }
  if (seems_misled(correction.t_ns)) {
    return;
  }
  if (pixel_noise_) {
    pixel_noise_->learn(scatter * rest.dof, rest.dof);
  }
  const bool learns = imu_noise_ && options_.method != Method::kAdaptive;  // it is told: share_imu_noise
  if (learns && !points_quarrel(report) && !input_alarm_.active(correction.t_ns) &&
      report.inputs.gap_s <= kLongGap) {
    imu_noise_->learn(counted, !is_blind_to_rig() && !detail::estimates_theta(options_));
  }
}

/// A body that certainly moves tells how long a metre is. What was gathered of the length of the baseline
/// until then was compared to nothing.
void StereoFilter::notice_motion() {
  if (excitation_) {
    excitation_->add(estimate_.nav().t_ns, estimate_.nav().v_world_body);
  }
  if (scale_told_) {
    return;
  }
  const Eigen::Vector3d v = estimate_.nav().v_world_body;
  const Eigen::Matrix3d P = estimate_.P().diagonal_block<3>(StateLayout::kVelocity);
  scale_told_ = v.squaredNorm() * v.squaredNorm() > kCertainMotion * kCertainMotion * v.dot(P * v);
  if (scale_told_ && detail::has_witness(options_)) {
    estimate_.restart_witness(kWidestErrors);
  }
}

std::optional<Estimate::Considered> StereoFilter::scale_to_hold() const {
  const StateLayout& layout = estimate_.layout();
  if (layout.has_odometry_scale) {
    return estimate_.considered(layout.odometry_scale());
  }
  if (!excitation_) {
    return std::nullopt;
  }
  const double variance = estimate_.P().diagonal_block<kTriplet>(layout.map_scale())(0, 0);
  return std::sqrt(variance) < kNoiseShares * excitation_->noise_share()
             ? std::optional(estimate_.considered(layout.map_scale()))
             : std::nullopt;
}

void StereoFilter::learn_from(const ParameterErrorModel& model, const UpdateReport& update, double dt,
                              FrameReport& report) {
  const MatrixXd watched = model.watched.topRows<kBlockSize>();
  const Innovations rest = without_rig(model, update);
  HealthInput input{report.t_ns, watched, update.evidence, gathered(model), rest.nis, rest.dof};
  // A rig that bends makes the points of a filter that trusts it quarrel, too.
  const bool quarrel = is_blind_to_rig() && input_alarm_.points_quarrel();
  if (quarrel || input_alarm_.active(report.t_ns) || report.inputs.gap_s > kLongGap) {
    // An input that fails is not the rig's fault: what this frame says of the rig is not counted.
    if (model.witness) {
      estimate_.restart_witness(kWidestErrors);
    }
    report.health = last_health_.value_or(HealthReport{});
    report.health->t_ns = report.t_ns;
    report.health->alarm = false;
    return;
  }
  report.evidence = input;
  if (model.white_covariance.size() > 0 && !model.witness && !input.frame.empty()) {
    const MatrixXd inverse = watched.inverse();
    const MatrixXd white = model.white_covariance.topLeftCorner<kBlockSize, kBlockSize>();
    input.frame = without_white(input.frame, inverse * white * inverse.transpose());
  }
  if (!fresh_.is_zero() && !input.frame.empty()) {
    fresh_.learn(input.frame, dt);
  }
  report.health = last_health_ = monitor_->judge(input);
  if (model.witness && monitor_->restarts()) {
    estimate_.restart_witness(kWidestErrors);
  }
}

}  // namespace limber
