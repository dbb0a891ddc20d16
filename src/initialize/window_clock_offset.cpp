// SPDX-License-Identifier: MIT
// A clock that is off all along: docs/derivations/start.md.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "inertial_offsets.hpp"
#include "limber/core/factors.hpp"
#include "navigate/parameter_roles.hpp"
#include "start_window.hpp"
#include "window_pixels.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kPlausibleClock = 0.05, kLargestClock = 0.25;  // [s]
constexpr int kClockRounds = 6;
constexpr int kNearSteps = 6, kShiftSteps = 10;  // of a solution, from one that is near
constexpr double kTellsClock = 3e-3;             // [s], of a sigma
constexpr double kSurely = 5.0;                  // sigmas
constexpr double kSmallClock = 2e-4;             // [s]: less changes nothing
constexpr double kWithin = 0.25;                 // of its sigma, the same
/// Of the cost: pixels are worth less in it than they show themselves to be.
constexpr double kNoWorse = 1.02;

/// What a calibration is usually off by beside the clock (standard deviations): a clock is not to blame for
/// that.
VectorXd usual_offsets() {
  VectorXd out = VectorXd::Constant(InertialEvidence::kOffsets, 5e-3);
  const OffsetPlace lever = place_of(InertialFactor::kLeverArm);
  out.segment(lever.first, lever.size).setConstant(0.02);
  out(place_of(InertialFactor::kClock).first) = kPlausibleClock;
  return out;
}

/// How much later still samples are stamped.
struct LaterBy {
  double seconds = 0.0, sigma = 0.0;
};

std::optional<LaterBy> later_by(const WindowModel& model, WindowState state) {
  const WindowModel shown = with_shown_pixels(model, state);
  const WindowNormal normal = solve_window(shown, state, kNearSteps);
  const MatrixXd covariance = frame_covariance(normal);
  if (covariance.size() == 0) {
    return std::nullopt;
  }
  const InertialEvidence evidence = evidence_of(shown, state, normal, covariance);
  const double noise = evidence.dof > 0.0 ? std::max(evidence.misfit / evidence.dof, 1.0) : 1.0;
  MatrixXd information = evidence.information / noise;
  information.diagonal() += usual_offsets().cwiseAbs2().cwiseInverse();
  const Cholesky factor(information);
  const Index clock = place_of(InertialFactor::kClock).first;
  return LaterBy{factor.solve(VectorXd(evidence.score / noise))(clock),
                 std::sqrt(factor.inverse()(clock, clock))};
}

/// A window that waits for more is too short for what hardly tells: mismatches and scales of a gyro look like
/// a clock by several of its sigmas, and a clock that is wrong is defended by all that was fitted to it.
bool is_surely_off(const LaterBy& later) {
  return later.sigma <= kTellsClock && std::abs(later.seconds) > kSurely * later.sigma;
}

}  // namespace

/// The same window where samples are stamped later by so much; its solution is where it was.
StartWindow StartWindow::with_clock(double later_s) const {
  StartWindow out = *this;
  StampJump clock = clock_step.value_or(StampJump{});
  const std::int64_t by_ns = std::llround(1e9 * later_s);
  clock.offset_ns += by_ns;
  clock.offset_before_ns += by_ns;
  out.clock_step = clock;
  out.read_inputs_anew();
  out.take_inputs(*out.solution);
  return out;
}

bool StartWindow::may_learn_clock() const {
  return model.options.learn_imu_clock && model.options.motion == MotionModel::kImu && solution &&
         !(clock_step && clock_step->jumps()) && !estimates_time_offset(model.options);
}

bool StartWindow::learn_clock(Asked asked) {
  StartWindow best = *this;
  for (int round = 0; round < kClockRounds; ++round) {
    const std::optional<LaterBy> later = later_by(best.model, *best.solution);
    if (!later) {
      break;
    }
    best.clock_sigma = later->sigma;
    if (round == 0 && asked == Asked::kMeanwhile && !is_surely_off(*later)) {
      break;
    }
    if (std::abs(later->seconds) < std::max(kSmallClock, kWithin * later->sigma)) {
      break;
    }
    StartWindow there = best.with_clock(later->seconds);
    there.settle_solution();
    if (!there.solution || there.normal.cost > kNoWorse * best.normal.cost ||
        std::abs(there.clock_step->offset_ns) > std::llround(1e9 * kLargestClock)) {
      break;
    }
    best = std::move(there);
  }
  clock_sigma = best.clock_sigma;
  if (!best.clock_step || best.clock_step->offset_ns == (clock_step ? clock_step->offset_ns : 0)) {
    return false;
  }
  *this = std::move(best);
  return true;
}

/// Once the start is over: what its solution owes to what it takes for exact.
void StartWindow::shift_parameters() {
  shifted = shifted_solutions(model, *solution);
  shifted_by_clock.reset();
  if (clock_sigma == 0.0) {
    return;
  }
  StartWindow there = with_clock(clock_sigma);
  (void)solve_window(there.model, *there.solution, kShiftSteps);
  shifted_by_clock = ShiftedSolution{0, clock_sigma, there.model, std::move(*there.solution)};
}

}  // namespace limber::detail
