// SPDX-License-Identifier: MIT
#include "smoothing.hpp"

#include <ceres/iteration_callback.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "limber/core/chi_square.hpp"
#include "limber/core/time.hpp"
#include "limber/measure/stereo_model.hpp"
#include "limber/predict/input_checks.hpp"
#include "limber/predict/motion_between.hpp"
#include "limber/smooth/unsolvable_error.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// A point of which more than this share of the pixels is refused is left out.
constexpr double kRefusedShare = 0.5;
constexpr int kRoundsOfRefusal = 3;
constexpr double kFunctionTolerance = 1e-6;
constexpr int kFirstIterations = 8;  // robust, before anything is refused
constexpr int kRigSize = static_cast<int>(kBlockSize);

class Progress : public ceres::IterationCallback {
 public:
  Progress(const std::function<void(int)>& told, int before) : told_(told), done_(before) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*summary*/) override {
    if (told_) {
      told_(++done_);
    }
    return ceres::SOLVER_CONTINUE;
  }

 private:
  const std::function<void(int)>& told_;
  int done_;
};

InputBuffer buffer_of(const SmootherInput& input, MotionModel motion) {
  InputBuffer out;
  InputChecks checks(limits_of(motion));
  if (motion == MotionModel::kImu) {
    for (const ImuSample& s : input.imu) {
      checks.add({s.t_ns, s.omega_imu, s.accel_imu}, out);
    }
  } else if (motion == MotionModel::kOdometry) {
    for (const OdometrySample& s : input.odometry) {
      checks.add({s.t_ns, s.omega_body, s.v_body}, out);
    }
  }
  return out;
}

}  // namespace

void check(const SmootherInput& input, const SmootherOptions& options) {
  if (input.frames.empty() || input.start.size() != input.frames.size()) {
    throw std::invalid_argument("smoother: expected frames and a start for each of them");
  }
  const Index n = StateLayout{options.motion}.body_size();
  if (input.prior.body_covariance.rows() != n || input.prior.body_covariance.cols() != n) {
    throw std::invalid_argument("smoother: the prior's covariance does not fit the motion model");
  }
  if ((options.motion == MotionModel::kImu && input.imu.empty()) ||
      (options.motion == MotionModel::kOdometry && input.odometry.empty())) {
    throw std::invalid_argument("smoother: no samples of the sensor that drives the motion model");
  }
}

Smoothing::Smoothing(const SmootherInput& input, const StereoCalibration& calibration,
                     const SmootherOptions& options, const std::function<void(int)>& progress,
                     const KnownState* known)
    : input_(input), calibration_(calibration), options_(options), progress_(progress), known_(known) {
  const MountedRig rig = mount(calibration);
  tracks_ = gather_tracks(input.frames, rig, options.forget_after_s, options.rig != RigModel::kTrusted);
  place_states();
  place_rigs();
  place_landmarks(rig);
  cut_inputs();
}

double Smoothing::cost() {
  problem_ = std::make_unique<LeastSquares>(input_, calibration_, options_, between_, unknowns_, tracks_,
                                            RobustLoss::kCauchy, known_);
  double out = 0.0;
  problem_->problem().Evaluate({}, &out, nullptr, nullptr, nullptr);
  return out;
}

void Smoothing::solve() {
  const bool robust = options_.loss != RobustLoss::kNone;
  if (robust) {
    solve_under(RobustLoss::kCauchy, std::min(kFirstIterations, options_.max_iterations));
  }
  for (int round = 0; robust && round < kRoundsOfRefusal; ++round) {
    if (!refuse_pixels() && round > 0) {
      break;
    }
    sum_up_inputs();
    solve_under(options_.loss, options_.max_iterations);
  }
  if (!robust) {
    solve_under(RobustLoss::kNone, options_.max_iterations);
  }
}

void Smoothing::place_states() {
  for (const NavigationState& state : input_.start) {
    PoseBlock& pose = unknowns_.pose.emplace_back();
    write_pose(state.T_world_body, pose.data());
    unknowns_.motion.push_back(motion_block_of(options_.motion, state));
  }
}

void Smoothing::place_rigs() {
  const std::int64_t begin = known_ != nullptr ? known_->origin_ns : input_.frames.front().t_ns;
  const auto pieces_until = [&](std::int64_t t_ns) {
    return static_cast<std::size_t>(seconds_between(begin, t_ns) / options_.piece_s);
  };
  const std::size_t gone = pieces_until(input_.frames.front().t_ns);
  std::size_t pieces = 1;
  for (std::size_t k = 0; k < input_.frames.size(); ++k) {
    std::size_t piece = 0;
    if (options_.rig == RigModel::kWalk || options_.rig == RigModel::kFree) {
      piece = k;
    } else if (options_.rig == RigModel::kPiecewise) {
      piece = pieces_until(input_.frames[k].t_ns) - gone;
    }
    pieces = std::max(pieces, piece + 1);
    unknowns_.theta_of.push_back(piece);
  }
  const bool is_known = known_ != nullptr && outlives_a_frame(options_.rig);
  unknowns_.theta.assign(pieces, is_known ? known_->theta : calibration_.theta);
  if (known_ != nullptr) {
    unknowns_.more = known_->more;
  }
}

void Smoothing::place_landmarks(const MountedRig& rig) {
  std::vector<Pose> poses;
  for (const NavigationState& state : input_.start) {
    poses.push_back(state.T_world_body);
  }
  for (Track& track : tracks_) {
    triangulate(track, poses, rig, options_.rig == RigModel::kTrusted);
  }
}

void Smoothing::cut_inputs() {
  InputBuffer buffer = buffer_of(input_, options_.motion);
  sample_interval_s_ = buffer.usual_interval_s();
  for (std::size_t k = 0; k + 1 < input_.frames.size(); ++k) {
    steps_.push_back(buffer.steps(input_.frames[k].t_ns, input_.frames[k + 1].t_ns));
  }
  sum_up_inputs();
}

/// With the biases as they are now.
void Smoothing::sum_up_inputs() {
  between_.clear();
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    between_.push_back(motion_between(
        options_.motion, seconds_between(input_.frames[k].t_ns, input_.frames[k + 1].t_ns), steps_[k],
        state_of(options_.motion, unknowns_.pose[k].data(), unknowns_.motion[k].data()), options_.noise,
        sample_interval_s_, options_.gravity));
  }
}

void Smoothing::solve_under(RobustLoss loss, int max_iterations) {
  problem_ = std::make_unique<LeastSquares>(input_, calibration_, options_, between_, unknowns_, tracks_,
                                            loss, known_);
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_SCHUR;
  solver.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  solver.num_threads = options_.threads;
  solver.max_num_iterations = max_iterations;
  solver.function_tolerance = kFunctionTolerance;
  solver.logging_type = ceres::SILENT;
  solver.update_state_every_iteration = false;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (double* block : problem_->columns().landmarks) {
    ordering->AddElementToGroup(block, 0);
  }
  for (const auto* blocks : {&problem_->columns().chain, &problem_->columns().kept}) {
    for (double* block : *blocks) {
      ordering->AddElementToGroup(block, 1);
    }
  }
  solver.linear_solver_ordering = ordering;
  Progress progress(progress_, iterations_);
  solver.callbacks.push_back(&progress);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem_->problem(), &summary);
  if (!summary.IsSolutionUsable()) {
    throw UnsolvableError("smoother: " + summary.message);
  }
  iterations_ += static_cast<int>(summary.iterations.size());
  converged_ = summary.termination_type == ceres::CONVERGENCE;
  problem_->judge_pixels();
}

/// @return whether anything changed
bool Smoothing::refuse_pixels() {
  const double limit = chi_square_quantile(options_.gate_probability, 2.0);
  bool changed = false;
  for (Track& track : tracks_) {
    const std::size_t before = track.used();
    if (before < 2) {
      continue;
    }
    for (Sight& sight : track.sights) {
      sight.refused = sight.refused || sight.distance > limit;
    }
    const auto kept = static_cast<double>(track.used());
    if (kept < (1.0 - kRefusedShare) * static_cast<double>(track.sights.size())) {
      for (Sight& sight : track.sights) {
        sight.refused = true;
      }
    }
    changed = changed || track.used() != before;
  }
  return changed;
}

SmootherResult Smoothing::result() {
  SmootherResult out;
  out.iterations = iterations_;
  out.converged = converged_;
  for (std::size_t k = 0; k < input_.frames.size(); ++k) {
    SmoothedFrame& frame = out.frames.emplace_back();
    frame.nav = state_of(options_.motion, unknowns_.pose[k].data(), unknowns_.motion[k].data());
    frame.nav.t_ns = input_.frames[k].t_ns;
    frame.theta = unknowns_.theta[unknowns_.theta_of[k]];
    frame.observed = input_.frames[k].observations.size();
    frame.pose_covariance.setZero();
    frame.theta_covariance.setZero();
    frame.error.tail<kMoreParameters>() = unknowns_.more;
  }
  count_pixels(out);
  if (options_.covariance) {
    add_covariances(out);
  }
  return out;
}

void Smoothing::count_pixels(SmootherResult& out) {
  for (const Track& track : tracks_) {
    for (const Sight& sight : track.sights) {
      SmoothedFrame& frame = out.frames[sight.frame];
      if (sight.refused) {
        out.refused.push_back({sight.frame, track.landmark.track_id, sight.camera, sight.distance});
      } else {
        frame.rows += 2;
        frame.squared_residuals += sight.distance;
        frame.used += sight.camera == 0 ? 1 : 0;
      }
    }
    if (track.used() >= 2) {
      Anchor anchor;
      anchor.T_world_body = out.frames[track.anchor].nav.T_world_body;
      anchor.T_body_cam0 = body_from_cam0(calibration_);
      out.landmarks[track.landmark.track_id] = world_position(track.landmark, &anchor);
    }
  }
  double cost = 0.0;
  problem_->problem().Evaluate({}, &cost, nullptr, nullptr, nullptr);
  out.squared_residuals = 2.0 * cost;
  const Columns& columns = problem_->columns();
  out.dof = problem_->problem().NumResiduals() - problem_->vague_rows();
  for (const auto* blocks : {&columns.landmarks, &columns.chain, &columns.kept}) {
    for (const double* block : *blocks) {
      out.dof -= problem_->problem().ParameterBlockTangentSize(block);
    }
  }
}

void Smoothing::add_covariances(SmootherResult& out) {
  const Marginals marginals(reduce(problem_->problem(), problem_->columns()));
  const std::vector<MatrixXd> of_motion = marginals.of_chain(motion_size(options_.motion));
  for (std::size_t k = 0; k < of_motion.size(); ++k) {
    out.frames[k].motion_covariance = of_motion[k];
  }
  for (std::size_t k = 0; k < out.frames.size(); ++k) {
    add_covariances(marginals, k, out.frames[k]);
  }
  if (options_.rig == RigModel::kConstant) {
    const double* const theta = unknowns_.theta.front().data();
    const Eigen::Matrix<double, 6, 6> information = out.frames.front().theta_covariance.inverse();
    for (const auto& [cell, part] : marginals.cells()) {
      out.theta_scores[cell] = {-information * marginals.of_step(theta, kRigSize, part.gradient), part.rig};
    }
  }
}

/// Those of what is kept.
void Smoothing::add_covariances(const Marginals& marginals, std::size_t k, SmoothedFrame& frame) const {
  frame.pose_covariance = marginals.of(unknowns_.pose[k].data(), kPoseTangent);
  if (k + 1 == unknowns_.pose.size() && motion_size(options_.motion) > 0) {
    frame.motion_covariance = marginals.of(unknowns_.motion[k].data(), motion_size(options_.motion));
  }
  if (options_.rig != RigModel::kTrusted) {
    frame.theta_covariance = marginals.of(unknowns_.theta[unknowns_.theta_of[k]].data(), kRigSize);
  }
  const std::vector<Index> free = free_parameters(options_);
  if (!free.empty()) {
    const MatrixXd covariance = marginals.of(unknowns_.more.data(), static_cast<int>(free.size()));
    for (std::size_t i = 0; i < free.size(); ++i) {
      const auto at = static_cast<Index>(i);
      frame.error_sigma(kBlockSize + free[i]) = std::sqrt(covariance(at, at));
    }
  }
}

KnownState Smoothing::newest(SmoothedFrame& frame) {
  const Marginals marginals(reduce(problem_->problem(), problem_->columns()));
  const std::size_t last = unknowns_.pose.size() - 1;
  add_covariances(marginals, last, frame);
  std::vector<Block> blocks = {{unknowns_.pose[last].data(), kPoseTangent}};
  if (const int extra = motion_size(options_.motion); extra > 0) {
    blocks.push_back({unknowns_.motion[last].data(), extra});
  }
  if (outlives_a_frame(options_.rig)) {
    blocks.push_back({unknowns_.theta[unknowns_.theta_of[last]].data(), kRigSize});
  }
  if (const std::vector<Index> free = free_parameters(options_); !free.empty()) {
    blocks.push_back({unknowns_.more.data(), static_cast<int>(free.size())});
  }
  return {frame.nav, frame.theta, unknowns_.more, marginals.of(blocks),
          known_ != nullptr ? known_->origin_ns : input_.frames.front().t_ns};
}

}  // namespace limber::detail
