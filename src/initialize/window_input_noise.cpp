// SPDX-License-Identifier: MIT
// How noisy an IMU is, by how far a solution stands off what it measured: docs/derivations/start.md.
#include <algorithm>
#include <cmath>
#include <utility>

#include "limber/core/factors.hpp"
#include "limber/health/learned_imu_noise.hpp"
#include "start_window.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kFarOff = 9.0;  // of the expected square: an interval says no more than that
constexpr double kFewest = 2.0;  // degrees of freedom that images leave to the inputs
// Standard deviations by which more noise than stated has to be certain: else, and where images and inputs
// contradicted each other before.
constexpr double kSureness = 4.0, kSurenessInDoubt = 1.0;
constexpr double kSettledFactor = 0.1;  // of the logarithm
constexpr int kRounds = 6;

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
  [[nodiscard]] double factor(double now, double sureness) const {
    if (expected < kFewest) {
      return 1.0;
    }
    const double ratio = square / expected;
    return now != 1.0 || ratio - 1.0 > sureness * std::sqrt(2.0 / expected) ? std::sqrt(ratio) : 1.0;
  }
};

}  // namespace

ImuNoiseFactors misfit_of_imu(const WindowModel& model, const WindowState& state, const MatrixXd& covariance,
                              double sureness) {
  Misfit gyro, accel;
  const Index n = model.body_size();
  for (std::size_t k = 1; k < state.frames.size(); ++k) {
    const MotionResidual motion = motion_residual(model, state, k);
    const Index a = static_cast<Index>(k - 1) * model.frame_size(), b = a + model.frame_size();
    const MatrixXd FP = multiply(motion.F, covariance.block(a, b, n, n).eval());
    const MatrixXd C = congruence(motion.F, covariance.block(a, a, n, n).eval()) +
                       congruence(motion.J, covariance.block(b, b, n, n).eval()) -
                       multiply(FP, transposed(motion.J)) - multiply(motion.J, transposed(FP));
    gyro.add(motion.e.segment<3>(StateLayout::kAttitude),
             motion.Q.block<3, 3>(StateLayout::kAttitude, StateLayout::kAttitude),
             C.block<3, 3>(StateLayout::kAttitude, StateLayout::kAttitude));
    accel.add(motion.e.segment<3>(StateLayout::kVelocity),
              motion.Q.block<3, 3>(StateLayout::kVelocity, StateLayout::kVelocity),
              C.block<3, 3>(StateLayout::kVelocity, StateLayout::kVelocity));
  }
  return {gyro.factor(model.imu_noise.gyro, sureness), accel.factor(model.imu_noise.accel, sureness)};
}

/// The noise in the model becomes as large as the solution says. The rig has to be free: a wrong one would be
/// taken for noise of the IMU. A solution that is lost with more noise stays what it was.
bool StartWindow::learn_imu_noise() {
  if (!model.options.learn_imu_noise || !is_over_by_motion() || !solution || !unused.empty()) {
    return false;
  }
  const double sureness = stepped_before_ns ? kSurenessInDoubt : kSureness;
  bool changed = false;
  for (int round = 0; round < kRounds; ++round) {
    const ImuNoiseFactors misfit = misfit_of_imu(model, *solution, covariance, sureness);
    const ImuNoiseFactors now = model.imu_noise;
    const ImuNoiseFactors next = LearnedImuNoise::bounded({now.gyro * misfit.gyro, now.accel * misfit.accel});
    const ImuNoiseFactors by{next.gyro / now.gyro, next.accel / now.accel};
    if (std::abs(std::log(by.gyro)) + std::abs(std::log(by.accel)) < kSettledFactor) {
      break;
    }
    StartWindow noisier = *this;
    noisier.model.options.imu_noise.gyro_density *= by.gyro;
    noisier.model.options.imu_noise.accel_density *= by.accel;
    noisier.model.imu_noise = next;
    noisier.settle_solution();
    if (!noisier.solution) {
      break;
    }
    *this = std::move(noisier);
    changed = true;
  }
  return changed;
}

}  // namespace limber::detail
