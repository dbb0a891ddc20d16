// SPDX-License-Identifier: MIT
// Navigator's monitor: what an update tells it of the rig, and what theta and the witness make of its answer.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <optional>

#include "limber/navigator.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;

/// What the witness has gathered against the assumed rig; nothing without one.
std::optional<ParameterEvidence> Navigator::gathered(const ParameterTreatment& how) const {
  if (!how.witness) {
    return std::nullopt;
  }
  const Index k = how.watched.cols();
  const MatrixXd P = estimate_.P.diagonal_block<kWitnessSize>(how.witness->at);
  const MatrixXd information = P.llt().solve(MatrixXd::Identity(kWitnessSize, kWitnessSize));
  ParameterEvidence out{information.topLeftCorner(k, k), (information * estimate_.witness).head(k)};
  out.information.diagonal().array() -= 1.0 / (kWidestErrors * kWidestErrors);
  return out;
}

void Navigator::learn_from(const ParameterTreatment& how, const UpdateReport& update, double dt,
                           FrameReport& report) {
  const MatrixXd watched = how.watched.topRows<kBlockSize>();
  HealthInput input{report.t_ns,   watched,    update.evidence,
                    gathered(how), update.nis, static_cast<double>(update.dof)};
  if (!how.witness && !update.evidence.empty()) {
    // Of a filter that trusts theta, NIS also counts what theta would explain.
    const EvidenceStatistic explained = statistic(update.evidence, 1.0 / (kWidestErrors * kWidestErrors));
    input.nis -= explained.value;
    input.dof -= static_cast<double>(explained.dof);
  }
  report.evidence = input;
  if (how.white_covariance.size() > 0 && !how.witness && !input.frame.empty()) {
    const MatrixXd inverse = watched.inverse();
    const MatrixXd white = how.white_covariance.topLeftCorner<kBlockSize, kBlockSize>();
    input.frame = without_white(input.frame, inverse * white * inverse.transpose());
  }
  if (!fresh_.is_zero() && !input.frame.empty()) {
    fresh_.learn(input.frame, dt);
  }
  report.health = monitor_->judge(input);
  if (how.witness && monitor_->restarts()) {
    estimate_.restart_witness(kWidestErrors);
  }
}

}  // namespace limber
