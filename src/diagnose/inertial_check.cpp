// SPDX-License-Identifier: MIT
#include "limber/diagnose/inertial_check.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>

#include "diagnose/surest_part.hpp"
#include "limber/core/time.hpp"
#include "run/samples_as_taken.hpp"

namespace limber {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kFramesOfStretch = 32;
constexpr double kStretch = 5.0;  // [s]
constexpr std::array kFactors = {InertialFactor::kMountTurn,  InertialFactor::kLeverArm,
                                 InertialFactor::kAccelScale, InertialFactor::kAccelTurn,
                                 InertialFactor::kGyroScale,  InertialFactor::kClock,
                                 InertialFactor::kAccelScales};

/// Frames with the states that the run found there.
struct Stretch {
  std::vector<StereoFrame> frames;
  std::vector<NavigationState> states;
  bool sound = true;  ///< images and inputs agree
};

/// Gaps are noise to a stretch, too.
bool is_sound(const FrameReport& report) {
  return !report.reset && report.status != UpdateStatus::kSingularInnovation && !report.inputs.contradiction;
}

NavigationState state_of(const TrajectoryRow& row) {
  NavigationState out;
  out.t_ns = row.t_ns;
  out.T_world_body = row.T_world_body;
  out.v_world_body = row.v_world_body.value_or(Vector3d::Zero());
  out.bias_gyro = row.bias_gyro.value_or(Vector3d::Zero());
  out.bias_accel = row.bias_accel.value_or(Vector3d::Zero());
  return out;
}

/// So many that the cost is bounded, the first and the last among them, and no fewer than are needed.
void thin(Stretch& stretch) {
  const std::size_t n = stretch.frames.size();
  const std::size_t stride = std::min((n + kFramesOfStretch - 1) / kFramesOfStretch,
                                      (n - 1) / (InertialEvidence::kFewestFrames - 1));
  std::size_t kept = 0;
  for (std::size_t k = 0; k < n; ++k) {
    if (k == 0 || (n - 1 - k) % stride == 0) {
      if (kept != k) {
        stretch.frames[kept] = std::move(stretch.frames[k]);
      }
      stretch.states[kept++] = stretch.states[k];
    }
  }
  stretch.frames.resize(kept);
  stretch.states.resize(kept);
}

/// Of equal length, five seconds or more.
std::vector<Stretch> stretches_of(const RunRecord& record) {
  const std::deque<StereoFrame>& frames = record.last_frames;
  const double length = seconds_between(frames.front().t_ns, frames.back().t_ns);
  const double count = std::max(1.0, std::floor(length / kStretch));
  std::vector<Stretch> out(static_cast<std::size_t>(count));
  auto row = record.trajectory.begin();
  for (const StereoFrame& frame : frames) {
    row = std::find_if(row, record.trajectory.end(),
                       [&](const TrajectoryRow& r) { return r.t_ns >= frame.t_ns; });
    if (row == record.trajectory.end() || row->t_ns != frame.t_ns) {
      continue;
    }
    const double share = seconds_between(frames.front().t_ns, frame.t_ns) / std::max(length, 1e-9);
    Stretch& stretch = out[static_cast<std::size_t>(std::min(share * count, count - 1.0))];
    stretch.frames.push_back(frame);
    stretch.states.push_back(state_of(*row));
    stretch.sound =
        stretch.sound &&
        is_sound(record.frames[static_cast<std::size_t>(std::distance(record.trajectory.begin(), row))]);
  }
  return out;
}

/// Noise of the inputs as they show themselves, over what is stated; at least 1.
double shown_noise(const InertialEvidence& all) {
  return all.dof > 0.0 ? std::max(1.0, all.misfit / all.dof) : 1.0;
}

/// Chi-square over degrees of freedom of one factor.
/// @param of  its directions
double sureness_of(const InertialEvidence& all, const MatrixXd& of) {
  const MatrixXd I = of.transpose() * all.information * of;
  const VectorXd s = of.transpose() * all.score;
  return s.dot(I.ldlt().solve(s)) / (static_cast<double>(of.cols()) * shown_noise(all));
}

/// What is left of it where the clock may be off by as much as nobody mentions, stated or learned.
InertialEvidence beside_clock(InertialEvidence all) {
  const VectorXd at = directions_of(InertialFactor::kClock);
  const VectorXd by_clock = all.information * at;
  const double known = at.dot(by_clock) + shown_noise(all) / (kLeastClock * kLeastClock);
  all.score -= by_clock * (at.dot(all.score) / known);
  all.information -= by_clock * by_clock.transpose() / known;
  return all;
}

InertialOffset offset_of(InertialFactor factor, const std::vector<InertialEvidence>& each,
                         const InertialEvidence& all) {
  const auto asked = [=](const InertialEvidence& some) {
    return factor == InertialFactor::kClock ? some : beside_clock(some);
  };
  const MatrixXd at = directions_of(factor);
  InertialOffset out;
  out.of = factor;
  const InertialEvidence whole = asked(all);
  const MatrixXd inverse = MatrixXd(at.transpose() * whole.information * at).inverse();
  const detail::SurestPart surest =
      detail::surest_part(inverse * at.transpose() * whole.score, shown_noise(all) * inverse);
  out.value.head(at.cols()) = surest.value;
  out.sigma = surest.sigma;
  out.sureness = sureness_of(whole, at);
  for (const InertialEvidence& one : each) {
    if (each.size() > 1) {
      InertialEvidence others = all;
      out.sureness = std::min(out.sureness, sureness_of(asked(others -= one), at));
    }
  }
  if (!std::isfinite(out.sureness)) {  // what no motion tells at all
    out.sureness = 0.0;
  }
  return out;
}

/// With what the run has learned of it beyond the rig, which is free here.
StereoCalibration as_found(const StereoCalibration& assumed, const RunRecord& record) {
  if (record.calibration.empty()) {
    return assumed;
  }
  ParameterVector error = record.calibration.back().estimate.error;
  error.head(kBlockSize).setZero();
  return corrected(assumed, error);
}

std::optional<InertialEvidence> evidence_in(const Stretch& stretch, const NavigatorOptions& options,
                                            const StereoCalibration& calibration,
                                            const std::vector<ImuSample>& imu) {
  const auto from = std::ranges::lower_bound(imu, stretch.frames.front().t_ns - detail::kInputsBefore, {},
                                             &ImuSample::t_ns);
  return inertial_evidence(options, calibration, stretch.frames, std::span(from, imu.end()), stretch.states);
}

InertialEvidence sum_of(InertialEvidence a, const InertialEvidence& b) { return a += b; }

}  // namespace

std::optional<InertialCheck> check_inertial(const Recording& recording, const RunOptions& options,
                                            const RunRecord& record) {
  if (record.motion != MotionModel::kImu || record.last_frames.empty()) {
    return std::nullopt;
  }
  const RunSetup setup = set_up_run(recording, options);
  const StereoCalibration calibration = as_found(setup.calibration, record);
  const std::vector<ImuSample> imu =
      detail::samples_as_taken(recording, record, record.last_frames.front().t_ns);
  std::vector<Stretch> stretches = stretches_of(record);
  InertialCheck out;
  out.learned = record.imu_noise.value_or(ImuNoiseFactors{});
  out.contradicted = std::ranges::none_of(stretches, &Stretch::sound);
  std::vector<InertialEvidence> each;
  for (Stretch& stretch : stretches) {
    if ((!stretch.sound && !out.contradicted) || stretch.frames.size() < InertialEvidence::kFewestFrames) {
      continue;
    }
    thin(stretch);
    const auto evidence = evidence_in(stretch, setup.navigator, calibration, imu);
    out.unexplained += evidence ? 0 : 1;
    if (evidence) {
      each.push_back(*evidence);
    }
  }
  out.stretches = each.size();
  if (!each.empty()) {
    const InertialEvidence all = std::accumulate(each.begin() + 1, each.end(), each.front(), sum_of);
    for (const InertialFactor factor : kFactors) {
      out.offsets.push_back(offset_of(factor, each, all));
    }
  }
  return out;
}

}  // namespace limber
