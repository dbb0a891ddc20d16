// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "limber/core/time.hpp"
#include "limber/initialize/sensor_start.hpp"
#include "limber/predict/input_checks.hpp"
#include "window_parameters.hpp"
#include "window_problem.hpp"

namespace limber::detail {

inline constexpr double kUnknown = std::numeric_limits<double>::infinity();
/// Misfit over the least of all solutions: of one that is no worse than any.
inline constexpr double kAgrees = 1.4;
inline constexpr double kSeenParallax = 0.02;  // [rad], of the usual point
/// Of the cost, still to come: no unknown is off by more than 0.2 sigma.
inline constexpr double kSettled = 0.02;

/// How far the body went from where the window begins [m].
[[nodiscard]] double way_of(const WindowState& state);
/// Angle under which the usual point sees the way that the body went [rad].
[[nodiscard]] double parallax(const WindowState& state);

/// The problem that a navigator's start solves, before anything was seen.
[[nodiscard]] WindowModel window_model(const NavigatorOptions& options, const StereoCalibration& calibration);

/// A solution that images and inputs agreed upon, and how many frames had been there.
struct Agreed {
  std::size_t frames = 0;
  WindowState solution;
  WindowNormal normal;
  Eigen::MatrixXd covariance;
};

/// What a window says now of frames about which it said something else when it dropped those before them.
struct RestSeenSince {
  double growth = 1.0;  ///< of the way that the body went
  double apart = 0.0;   ///< mean square of what is left beside that [m^2]
};

/// What a start has seen, and its solution so far.
struct StartWindow {
  StartWindow(const NavigatorOptions& options, const StereoCalibration& calibration,
              const StartOptions& start);

  WindowModel model;
  StartOptions options;
  InputBuffer inputs;
  InputChecks checks;
  std::vector<InputSample> samples;     // all of them, as they came
  std::optional<StampJump> clock_step;  // corrected in `inputs`
  double clock_sigma = 0.0;             // [s], of that; 0: taken for known
  std::vector<SmoothedState> rested;    // at frames that the window has dropped
  std::vector<SmoothedState> stayed;    // what was said then of those that stayed
  /// Covariance of the window's origin, seen from the first frame of all: position and yaw.
  Eigen::Matrix4d origin = Eigen::Matrix4d::Zero();
  bool rests = false;  // the last solution awaits a motion
  std::vector<StereoFrame> raw;
  std::vector<WindowFrame> frames;  // with inputs, without states
  std::optional<WindowState> solution;
  std::optional<Eigen::Matrix3d> R_first;  // of the last solution
  WindowNormal normal;
  Eigen::MatrixXd covariance;
  std::vector<ShiftedSolution> shifted;  // of `solution`, once the start is over
  std::optional<ShiftedSolution> shifted_by_clock;
  double solved_s = 0.0;
  StartReport report{StartStatus::kWaiting, 0.0, kUnknown, kUnknown, "more frames", {}};
  double least_misfit = kUnknown;  // of all solutions, squared residuals over rows
  std::optional<Agreed> agreed;
  bool failed_before = false;                     // the solution before disagreed
  std::optional<std::int64_t> stepped_before_ns;  // the biases, in the interval that holds this
  std::vector<StereoFrame> unused;                // after images and inputs agreed last
  bool scale_told = true;                         // by the end of the start, to some of it
  std::shared_ptr<const StartWindow> of_rig;      // if not: with the rig as it is, if the pixels allow it

  /// Where the body is taken to stand if nothing tells: level, or the left camera looking horizontally.
  [[nodiscard]] Eigen::Matrix3d assumed_attitude() const;
  [[nodiscard]] bool is_due() const;
  [[nodiscard]] double length() const {
    return raw.empty() ? 0.0 : seconds_between(raw.front().t_ns, raw.back().t_ns);
  }
  /// Since the first frame, whether it is still there or not [s].
  [[nodiscard]] double waited_s() const {
    return rested.empty() ? length() : seconds_between(rested.front().nav.t_ns, raw.back().t_ns);
  }
  /// @return on the inputs since the frame before
  InputReport push(const StereoFrame& frame);
  struct Frames {
    std::vector<WindowFrame> frames;
    std::vector<StereoFrame> raw;
  };
  [[nodiscard]] Frames kept() const;
  [[nodiscard]] WindowState continued(const WindowState& from, const Frames& now) const;
  [[nodiscard]] std::vector<WindowState> continuations(const Frames& now) const;
  /// A body's covariance, which is one against the window's origin.
  [[nodiscard]] Eigen::MatrixXd seen_from_first(const RestSeenSince& since, const NavigationState& nav,
                                                const Eigen::MatrixXd& P) const;
  [[nodiscard]] std::vector<SmoothedState> trajectory() const;
  [[nodiscard]] SensorStartResult unsolved() const;
  void solve();
  [[nodiscard]] WindowNormal settled(WindowState& guess) const;
  [[nodiscard]] double good_fit() const;
  /// Where a guess settles.
  struct Place {
    WindowState state;
    WindowNormal normal;
  };
  [[nodiscard]] Place without_mismatches(Place from) const;
  [[nodiscard]] bool take_if_it_fits(const WindowState& guess, const Place& without);
  enum class Tried {
    kFits,
    kSamePlace,  ///< it settles where the best guess before does
    kNoBetter
  };
  [[nodiscard]] Tried try_guess(WindowState guess);
  void try_guesses(const Frames& now);
  void settle_solution();
  void shift_parameters();
  void clean(std::size_t end);
  void clean_and_cover();
  /// @return whether the solution is another one, because the accelerometer's biases may be larger, or not as
  /// large, as they were expected to be
  bool learn_accel_bias();
  /// @return whether the solution is another one, because the IMU is noisier than it was taken for
  bool learn_imu_noise();
  /// The rig says nothing about how long a metre is.
  [[nodiscard]] bool leaves_scale_open() const {
    return !model.right ||
           !(model.directions.bottomRows<3>().transpose() * model.calibration.theta.tail<3>()).isZero();
  }
  [[nodiscard]] StartReport judged() const;
  [[nodiscard]] bool still_refines(const StartReport& now, double scale_before, double solved_before_s) const;
  StartReport solve_and_judge();
  [[nodiscard]] bool moves() const { return solution && parallax(*solution) > kSeenParallax; }
  /// Only a motion tells the scale, and an IMU would.
  [[nodiscard]] bool is_over_by_motion() const {
    return leaves_scale_open() && has_scale(model.options.motion);
  }
  [[nodiscard]] bool awaits_motion() const;
  /// Not to a factor of e.
  [[nodiscard]] bool knows_no_scale() const { return solution && leaves_scale_open() && scale_sigma() > 1.0; }
  [[nodiscard]] bool is_out_of_time() const { return waited_s() >= options.longest_still_s; }
  [[nodiscard]] bool still_rests() const;
  void forget_rest();
  [[nodiscard]] RestSeenSince rest_seen_since() const;
  [[nodiscard]] std::vector<SmoothedState> rested_by_scale(const RestSeenSince& since) const;
  [[nodiscard]] StartWindow with_open(const std::vector<Eigen::Index>& open) const;
  void take_scale_of_rig();
  [[nodiscard]] bool move_to(const StartWindow& other, const std::vector<Eigen::Index>& open);
  [[nodiscard]] std::optional<StartWindow> trusting(StartStatus status) const;
  bool explain_by_step();
  bool explain_by_clock();
  /// Well enough as long as the start waits.
  [[nodiscard]] bool knows_clock() const { return clock_sigma > 0.0 && clock_sigma < 1e-3; }
  /// While a window waits for more, the clock moves where it is surely off alone.
  enum class Asked { kMeanwhile, kAtTheEnd };
  /// @return whether the solution is another one, because the clock is off
  bool learn_clock(Asked asked);
  [[nodiscard]] bool may_learn_clock() const;
  bool learn_clock_or_step(Asked asked);
  [[nodiscard]] StartWindow with_clock(double later_s) const;
  WindowState solved_with(const StampJump& step, WindowState state, WindowNormal& there);
  void read_inputs_anew();
  void take_inputs(WindowState& state) const;
  void add_by_clock(InputSample sample);
  [[nodiscard]] double misfit() const;
  [[nodiscard]] bool disagrees();
  void go_back();
  [[nodiscard]] InputReport report_inputs(std::int64_t t_ns);
  [[nodiscard]] double tilt_sigma() const;
  [[nodiscard]] InitialState handed_over() const;
  [[nodiscard]] double scale_sigma() const;
};

}  // namespace limber::detail
