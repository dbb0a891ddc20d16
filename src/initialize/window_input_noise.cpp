// SPDX-License-Identifier: MIT
// How noisy an IMU is, by how far a solution stands off what it measured: docs/derivations/start.md.
#include <algorithm>
#include <cmath>
#include <utility>

#include "limber/core/factors.hpp"
#include "limber/health/learned_imu_noise.hpp"
#include "start_window.hpp"
#include "window_pixels.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double kFarOff = 9.0;   // of the expected square: an interval says no more than that
constexpr double kAllowed = 1.5;  // of it, where pixels may err alike from frame to frame
constexpr double kFewest = 2.0;   // degrees of freedom that images leave to the inputs
// Standard deviations by which more noise than stated has to be certain: else, and where images and inputs
// contradicted each other before.
constexpr double kSureness = 4.0, kSurenessInDoubt = 1.0;
constexpr double kSettledFactor = 0.1;  // of the logarithm
constexpr int kRounds = 6;
constexpr int kSteps = 3;  // of a solution, from one that is near

// How far an accelerometer's biases may be off (standard deviation): of a good one, of the cheapest [m/s^2].
constexpr double kGoodAccel = WindowPrior{}.bias_accel, kCheapAccel = 0.6;
/// A component counts that the window knows to this share of a good one's.
constexpr double kKnownTo = 0.5;

/// From when on a misfit is more noise than stated.
struct Doubt {
  double allowed = 1.0;   ///< of the expected square
  double sureness = 0.0;  ///< standard deviations beside that
};

/// Squared residuals of the inputs in their noise, and what is expected of them.
struct Misfit {
  double square = 0.0, expected = 0.0;

  void add(const VectorXd& e, const MatrixXd& Q, const MatrixXd& C) {
    const MatrixXd information = Cholesky(Q).inverse();
    const double of_rows = static_cast<double>(e.size()) - information.cwiseProduct(C).sum();
    if (of_rows > 0.0) {
      expected += of_rows;
      square += std::min(e.dot(information * e), kFarOff * of_rows);
    }
  }
  /// Of the noise's standard deviation; 1 where it may as well be as stated. @param now  what is assumed
  [[nodiscard]] double factor(double now, const Doubt& doubt) const {
    if (expected < kFewest) {
      return 1.0;
    }
    const double ratio = square / expected, by_chance = doubt.sureness * std::sqrt(2.0 / expected);
    return now != 1.0 || ratio > doubt.allowed + by_chance ? std::sqrt(ratio) : 1.0;
  }
};

/// How much noisier an IMU is than assumed, by how far a solution stands off what it measured: squared
/// residuals over what is expected of them, n - tr(Q^-1 C) with C their covariance in the solution. 1 where
/// the noise may as well be as stated.
/// @param covariance  of the frames' errors
ImuNoiseFactors misfit_of_imu(const WindowModel& model, const WindowState& state, const MatrixXd& covariance,
                              const Doubt& doubt) {
  Misfit gyro, accel;
  for (std::size_t k = 1; k < state.frames.size(); ++k) {
    const MotionResidual motion = motion_residual(model, state, k);
    const Index a = static_cast<Index>(k - 1) * model.frame_size(), b = a + model.frame_size();
    const MatrixXd C = covariance_of(motion, covariance, a, b);
    gyro.add(motion.e.segment<3>(StateLayout::kAttitude),
             motion.Q.block<3, 3>(StateLayout::kAttitude, StateLayout::kAttitude),
             C.block<3, 3>(StateLayout::kAttitude, StateLayout::kAttitude));
    accel.add(motion.e.segment<3>(StateLayout::kVelocity),
              motion.Q.block<3, 3>(StateLayout::kVelocity, StateLayout::kVelocity),
              C.block<3, 3>(StateLayout::kVelocity, StateLayout::kVelocity));
  }
  return {gyro.factor(model.imu_noise.gyro, doubt), accel.factor(model.imu_noise.accel, doubt)};
}

/// @param next  what is assumed of the IMU from now on, over what was stated
void assume(WindowModel& model, const ImuNoiseFactors& next) {
  model.options.imu_noise.gyro_density *= next.gyro / model.imu_noise.gyro;
  model.options.imu_noise.accel_density *= next.accel / model.imu_noise.accel;
  model.imu_noise = next;
}

bool are_alike(const ImuNoiseFactors& a, const ImuNoiseFactors& b) {
  return std::abs(std::log(a.gyro / b.gyro)) + std::abs(std::log(a.accel / b.accel)) < kSettledFactor;
}

/// How much noisier than stated an IMU is, by a window's solution with pixels as good as they show themselves
/// from frame to frame: beside the noise that a filter assumes, which stands for errors that last, inputs
/// would hardly be seen.
ImuNoiseFactors shown_noise(WindowModel model, WindowState state, const Doubt& doubt) {
  for (int round = 0; round < kRounds; ++round) {
    const WindowModel shown = with_shown_pixels(model, state);
    const MatrixXd covariance = frame_covariance(solve_window(shown, state, kSteps));
    if (covariance.size() == 0) {
      break;
    }
    const ImuNoiseFactors misfit = misfit_of_imu(shown, state, covariance, doubt);
    const ImuNoiseFactors now = model.imu_noise;
    assume(model, LearnedImuNoise::bounded({now.gyro * misfit.gyro, now.accel * misfit.accel}));
    if (are_alike(now, model.imu_noise)) {
      break;
    }
  }
  return model.imu_noise;
}

/// How large the biases of this accelerometer may be, by those of their components that the window tells
/// whatever was expected of them.
/// @param bias, P  of the first frame, as they were solved with what is expected now
double shown_bias(const WindowModel& model, const Vector3d& bias, const Matrix3d& P) {
  const double expected = std::pow(model.prior.bias_accel, -2);
  const SymmetricEigen known = symmetric_eigen(P);
  double square = 0.0;
  int components = 0;
  for (Index k = 0; k < bias.size(); ++k) {
    const double information = 1.0 / known.values(k) - expected;  // of the window alone
    if (information * std::pow(kKnownTo * kGoodAccel, 2) > 1.0) {
      square += std::pow(known.vectors.col(k).dot(bias) * (1.0 + expected / information), 2);
      ++components;
    }
  }
  return components == 0 ? model.prior.bias_accel
                         : std::clamp(std::sqrt(square / components), kGoodAccel, kCheapAccel);
}

}  // namespace

/// A cheap accelerometer shows by what it measures along the vertical. Then its other biases, and so the
/// tilt, are less known.
bool StartWindow::learn_accel_bias() {
  if (model.options.motion != MotionModel::kImu || !solution) {
    return false;
  }
  const Matrix3d P = covariance.block<3, 3>(StateLayout::kBiasAccel, StateLayout::kBiasAccel);
  const double shown = shown_bias(model, solution->frames.front().nav.bias_accel, P);
  if (std::abs(std::log(shown / model.prior.bias_accel)) < kSettledFactor) {
    return false;
  }
  StartWindow other = *this;
  other.model.prior.bias_accel = shown;
  other.settle_solution();
  if (!other.solution) {
    return false;
  }
  *this = std::move(other);
  return true;
}

/// The noise in the model becomes as large as the solution says. The rig has to be free: a wrong one would be
/// taken for noise of the IMU. A solution that is lost with more noise stays what it was.
bool StartWindow::learn_imu_noise() {
  if (!model.options.learn_imu_noise || !is_over_by_motion() || !solution || !unused.empty()) {
    return false;
  }
  const ImuNoiseFactors shown = shown_noise(
      model, *solution,
      {model.options.learn_pixel_noise ? kAllowed : 1.0, stepped_before_ns ? kSurenessInDoubt : kSureness});
  if (are_alike(shown, model.imu_noise)) {
    return false;
  }
  StartWindow noisier = *this;
  assume(noisier.model, shown);
  noisier.settle_solution();
  if (!noisier.solution) {
    return false;
  }
  *this = std::move(noisier);
  return true;
}

}  // namespace limber::detail
