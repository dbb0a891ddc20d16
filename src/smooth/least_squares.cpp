// SPDX-License-Identifier: MIT
#include "least_squares.hpp"

#include <ceres/manifold.h>

#include <algorithm>
#include <cmath>

#include "factors.hpp"
#include "limber/core/time.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/image_cell.hpp"
#include "pose_manifold.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kHuberWidth = 3.0, kCauchyWidth = 2.0;  // [standard deviations of a pixel]
/// Plausible errors that a free rig may be off by: none that pixels can tell from any number of them.
constexpr double kFreeErrors = 1e4;
constexpr double kTrustedLength = 1e-6;  // of the baseline

std::unique_ptr<ceres::LossFunction> make_loss(RobustLoss loss) {
  switch (loss) {
    case RobustLoss::kHuber:
      return std::make_unique<ceres::HuberLoss>(kHuberWidth);
    case RobustLoss::kCauchy:
      return std::make_unique<ceres::CauchyLoss>(kCauchyWidth);
    case RobustLoss::kNone:
      break;
  }
  return nullptr;
}

ceres::Problem::Options problem_options(ceres::EvaluationCallback* callback) {
  ceres::Problem::Options out;
  out.evaluation_callback = callback;
  out.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  return out;
}

/// What is known of theta before anything is seen; one more row where the length is trusted.
MatrixXd rig_prior(const StereoCalibration& calibration, const SmootherOptions& options) {
  const RigParameters sigma = sigma_of_rig(options, calibration.baseline());
  const Index rows = options.trust_length ? 7 : 6;
  MatrixXd A = MatrixXd::Zero(rows, 6);
  A.topRows<6>() = sigma.cwiseInverse().asDiagonal();
  if (options.trust_length) {
    const double length = calibration.baseline();
    A.row(6).tail<3>() = calibration.theta.tail<3>().transpose() / (length * kTrustedLength * length);
  }
  return A;
}

BodyMotion motion_of(const NavigationState& state, bool in_body_axes) {
  return {in_body_axes ? Eigen::Vector3d(state.T_world_body.R.transpose() * state.v_world_body)
                       : state.v_world_body,
          state.omega_body};
}

/// How a state lies in its blocks: how wide they are, and their values one behind the other.
std::vector<int> sizes_of_state(MotionModel motion) {
  std::vector<int> out = {kPoseBlock};
  if (const int extra = motion_size(motion); extra > 0) {
    out.push_back(extra);
  }
  return out;
}

VectorXd state_in_blocks(MotionModel motion, const NavigationState& nav) {
  const int extra = motion_size(motion);
  VectorXd out(kPoseBlock + extra);
  write_pose(nav.T_world_body, out.data());
  const MotionBlock block = motion_block_of(motion, nav);
  std::copy_n(block.begin(), extra, out.data() + kPoseBlock);
  return out;
}

}  // namespace

std::vector<Index> free_parameters(const SmootherOptions& options) {
  std::vector<Index> out;
  for (Index k = 0; k < kMoreParameters; ++k) {
    if (options.estimated(kBlockSize + k) > 0.0) {
      out.push_back(k);
    }
  }
  return out;
}

RigParameters sigma_of_rig(const SmootherOptions& options, double baseline) {
  if (options.rig == RigModel::kFree) {
    return kFreeErrors * plausible_error(baseline);
  }
  return options.rig_sigma.isZero(0.0) ? RigParameters(kWidestErrors * plausible_error(baseline))
                                       : options.rig_sigma;
}

Rigs::Rigs(const StereoCalibration& given, const Unknowns& unknowns, bool with_parameters)
    : given_(given), unknowns_(unknowns), with_parameters_(with_parameters), rigs_(unknowns.theta.size()) {
  PrepareForEvaluation(true, true);
}

void Rigs::PrepareForEvaluation(bool /*evaluate_jacobians*/, bool new_evaluation_point) {
  if (!new_evaluation_point) {
    return;
  }
  ParameterVector error = ParameterVector::Zero();
  error.tail<kMoreParameters>() = unknowns_.more;
  StereoCalibration calibration = with_parameters_ ? corrected(given_, error) : given_;
  for (std::size_t k = 0; k < rigs_.size(); ++k) {
    calibration.theta = unknowns_.theta[k];
    rigs_[k] = mount(calibration);
    for (MountedCamera& camera : rigs_[k]) {
      camera.with_parameters = with_parameters_;
    }
  }
}

LeastSquares::LeastSquares(const SmootherInput& input, const StereoCalibration& calibration,
                           const SmootherOptions& options, std::span<const MotionBetween> between,
                           Unknowns& unknowns, std::vector<Track>& tracks, RobustLoss loss,
                           const KnownState* known)
    : calibration_(calibration),
      options_(options),
      unknowns_(unknowns),
      tracks_(tracks),
      known_(known),
      with_theta_(options.rig != RigModel::kTrusted),
      with_more_(!options.estimated.tail<kMoreParameters>().isZero(0.0)),
      rigs_(calibration, unknowns, with_more_),
      loss_(make_loss(loss)),
      problem_(std::make_unique<ceres::Problem>(problem_options(&rigs_))) {
  add_states(between);
  if (with_theta_) {
    add_rigs(input.frames);
  }
  if (with_more_) {
    add_parameters();
  }
  if (known_ != nullptr) {
    add_known();
  } else {
    add_prior(input.prior);
  }
  for (Track& track : tracks_) {
    if (track.used() >= 2) {
      add_track(track, input);
    }
  }
}

std::vector<double*> LeastSquares::blocks_of(std::size_t frame) {
  std::vector<double*> out = {unknowns_.pose[frame].data()};
  if (motion_size(options_.motion) > 0) {
    out.push_back(unknowns_.motion[frame].data());
  }
  return out;
}

void LeastSquares::add_states(std::span<const MotionBetween> between) {
  const int extra = motion_size(options_.motion);
  const std::size_t frames = unknowns_.pose.size();
  for (std::size_t k = 0; k < frames; ++k) {
    problem_->AddParameterBlock(unknowns_.pose[k].data(), kPoseBlock, new PoseManifold);
    columns_.kept.push_back(unknowns_.pose[k].data());
    if (extra > 0) {
      problem_->AddParameterBlock(unknowns_.motion[k].data(), extra);
      (k + 1 < frames ? columns_.chain : columns_.kept).push_back(unknowns_.motion[k].data());
    }
  }
  for (std::size_t k = 0; k + 1 < frames; ++k) {
    std::vector<double*> blocks = blocks_of(k);
    const std::vector<double*> next = blocks_of(k + 1);
    blocks.insert(blocks.end(), next.begin(), next.end());
    problem_->AddResidualBlock(new MotionFactor(between[k], options_.gravity), nullptr, blocks);
  }
}

void LeastSquares::add_prior(const InitialState& prior) {
  const MatrixXd A = whitener_of(prior.body_covariance);
  problem_->AddResidualBlock(
      new BlockPrior(sizes_of_state(options_.motion), state_in_blocks(options_.motion, prior.nav), A,
                     VectorXd::Zero(A.rows())),
      nullptr, blocks_of(0));
}

void LeastSquares::add_known() {
  std::vector<double*> blocks = blocks_of(0);
  std::vector<int> sizes = sizes_of_state(options_.motion);
  VectorXd x0 = state_in_blocks(options_.motion, known_->nav);
  const auto append = [&](double* block, const VectorXd& value) {
    blocks.push_back(block);
    sizes.push_back(static_cast<int>(value.size()));
    x0.conservativeResize(x0.size() + value.size());
    x0.tail(value.size()) = value;
  };
  const MatrixXd whitener = whitener_of(known_->covariance);
  MatrixXd A = whitener;
  if (outlives_a_frame(options_.rig)) {
    append(unknowns_.theta.front().data(), known_->theta);
  }
  if (with_more_) {
    append(unknowns_.more.data(), known_->more);
    const std::vector<Index> free = free_parameters(options_);
    const Index before = whitener.cols() - static_cast<Index>(free.size());
    A = MatrixXd::Zero(whitener.rows(), before + kMoreParameters);
    A.leftCols(before) = whitener.leftCols(before);
    for (std::size_t i = 0; i < free.size(); ++i) {
      A.col(before + free[i]) = whitener.col(before + static_cast<Index>(i));
    }
  }
  problem_->AddResidualBlock(new BlockPrior(sizes, x0, A, VectorXd::Zero(A.rows())), nullptr, blocks);
}

void LeastSquares::add_rigs(std::span<const StereoFrame> frames) {
  const MatrixXd A = rig_prior(calibration_, options_);
  const bool walks = options_.rig == RigModel::kWalk;
  for (std::size_t k = 0; k < unknowns_.theta.size(); ++k) {
    double* theta = unknowns_.theta[k].data();
    problem_->AddParameterBlock(theta, kBlockSize);
    columns_.kept.push_back(theta);
    columns_.rig = options_.rig == RigModel::kConstant ? theta : nullptr;
    if (walks && k > 0) {
      const double dt = seconds_between(frames[k - 1].t_ns, frames[k].t_ns);
      problem_->AddResidualBlock(new WalkFactor((dt * options_.rig_walk).cwiseSqrt()), nullptr,
                                 unknowns_.theta[k - 1].data(), theta);
    } else if (k > 0 || known_ == nullptr || !outlives_a_frame(options_.rig)) {
      problem_->AddResidualBlock(
          new BlockPrior({kBlockSize}, calibration_.theta, A, VectorXd::Zero(A.rows())), nullptr, theta);
      vague_rows_ += static_cast<int>(kBlockSize);
    }
  }
  // A walk that never leaves the length of the baseline: one row per frame.
  if (walks && options_.trust_length) {
    const MatrixXd length = A.bottomRows<1>();
    for (std::size_t k = 1; k < unknowns_.theta.size(); ++k) {
      problem_->AddResidualBlock(new BlockPrior({kBlockSize}, calibration_.theta, length, VectorXd::Zero(1)),
                                 nullptr, unknowns_.theta[k].data());
    }
  }
}

void LeastSquares::add_parameters() {
  const auto sigma = options_.estimated.tail<kMoreParameters>();
  std::vector<int> fixed;
  MatrixXd A = MatrixXd::Zero(kMoreParameters, kMoreParameters);
  for (Index k = 0; k < kMoreParameters; ++k) {
    if (sigma(k) > 0.0) {
      A(k, k) = 1.0 / sigma(k);
    } else {
      fixed.push_back(static_cast<int>(k));
    }
  }
  constexpr int kSize = static_cast<int>(kMoreParameters);
  problem_->AddParameterBlock(unknowns_.more.data(), kSize);
  if (!fixed.empty()) {
    problem_->SetManifold(unknowns_.more.data(), new ceres::SubsetManifold(kSize, fixed));
  }
  columns_.kept.push_back(unknowns_.more.data());
  if (known_ != nullptr) {
    return;
  }
  problem_->AddResidualBlock(new BlockPrior({kSize}, VectorXd::Zero(kSize), A, VectorXd::Zero(kSize)),
                             nullptr, unknowns_.more.data());
  vague_rows_ += kSize;
}

void LeastSquares::add_track(Track& track, const SmootherInput& input) {
  const bool both_move = calibration_.body == BodyFrame::kMiddleOfBaseline;
  double* value = track.landmark.value.data();
  problem_->AddParameterBlock(value, kTriplet);
  columns_.landmarks.push_back(value);
  columns_.cells.push_back(image_cell(calibration_.cam0, track.first_left()));
  PointSight sight;
  sight.landmark = track.landmark;
  sight.T_body_cam0 = body_from_cam0(calibration_);
  for (Sight& pixel : track.sights) {
    if (pixel.refused) {
      continue;
    }
    const std::size_t piece = unknowns_.theta_of[pixel.frame];
    sight.camera = &rigs_.of_piece(piece)[static_cast<std::size_t>(pixel.camera)];
    sight.in_anchor = pixel.frame == track.anchor;
    sight.theta = with_theta_ && (pixel.camera == 1 || both_move);
    sight.more = with_more_;
    sight.motion = motion_of(input.start[pixel.frame], sight.in_anchor);
    sight.uv = pixel.uv;
    sight.sigma_px = options_.sigma_px.segment<2>(2 * pixel.camera);
    std::vector<double*> blocks;
    if (!sight.in_anchor) {
      blocks = {unknowns_.pose[pixel.frame].data(), unknowns_.pose[track.anchor].data()};
    }
    blocks.push_back(value);
    if (sight.theta) {
      blocks.push_back(unknowns_.theta[piece].data());
    }
    if (sight.more) {
      blocks.push_back(unknowns_.more.data());
    }
    pixels_.emplace_back(problem_->AddResidualBlock(new PointFactor(sight), loss_.get(), blocks), &pixel);
  }
}

void LeastSquares::judge_pixels() {
  rigs_.PrepareForEvaluation(false, true);
  for (auto& [block, pixel] : pixels_) {
    Eigen::Vector2d r;
    problem_->EvaluateResidualBlockAssumingParametersUnchanged(block, false, nullptr, r.data(), nullptr);
    pixel->distance = r.squaredNorm();
  }
}

}  // namespace limber::detail
