// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <numbers>
#include <string>
#include <variant>
#include <vector>

#include "limber/sensors/calibration.hpp"

namespace limber::detail {

inline constexpr double kDegree = std::numbers::pi / 180.0;  // [rad]

}  // namespace limber::detail

/// How a rig departs from its nominal calibration: theta_true(t) = theta_nominal + delta(t), delta(t) the sum
/// of signals, each an amplitude times a shape. Times are seconds since the start of the recording.
namespace limber {

/// 1 at any time. Paper, case (ii).
struct ConstantShape {};

/// sin(angular_frequency t + phase). Paper, case (iii).
struct SinusShape {
  double angular_frequency = 1.0;  ///< [rad/s]
  double phase = 0.0;              ///< [rad]
};

/// Sum of Heaviside functions: 0, and from each instant on its value. Paper, case (iv).
struct StepsShape {
  /// From an instant on, a value.
  struct Step {
    double at = 0.0;     ///< [s]
    double value = 0.0;  ///< from `at` on, until the next step [-]
  };
  std::vector<Step> steps = {{10.0, 1.0}, {20.0, 0.0}, {27.0, -1.0}};  ///< in increasing time
};

/// +1 in the first half of each period, -1 in the second. Paper, case (v).
struct SquareWaveShape {
  double period = 1.0;  ///< [s], at least 1 ms
};

/// 0 until start, then linear, 1 from end on.
struct RampShape {
  double start = 0.0;  ///< [s]
  double end = 0.0;    ///< [s], later than start
};

/// Wiener process, 0 at the start, each of the six parameters on its own: standard deviation sigma sqrt(t).
struct RandomWalkShape {
  double sigma = 1.0;  ///< [1/sqrt(s)]
};

/// Standard normal, drawn anew at every instant and for each of the six parameters: a rig that shakes faster
/// than the frame rate.
struct WhiteNoiseShape {};

/// All shapes over time.
using DecalibrationShape = std::variant<ConstantShape, SinusShape, StepsShape, SquareWaveShape, RampShape,
                                        RandomWalkShape, WhiteNoiseShape>;

/// How the rig departs from its calibration: an amplitude times a shape over time.
struct DecalibrationSignal {
  RigParameters amplitude = RigParameters::Zero();  ///< [rad, m]
  /// over time
  DecalibrationShape shape;
};

/// delta = [0.01 deg, -0.05 deg, 0.1 deg, 0.1 m, -0.01 m, 0.005 m]: what the paper (4.2) multiplies its
/// shapes by.
[[nodiscard]] RigParameters paper_decalibration();

/// @brief delta(t), a function of time alone: the draws of random shapes are fixed at construction.
class Decalibration {
 public:
  /// @param duration how far random walks are drawn [s]; they stay constant after that
  /// @throws std::invalid_argument for a shape that makes no sense: steps not in order, ramp that ends before
  /// it starts,
  ///         period below 1 ms, numbers that are not finite
  Decalibration(std::vector<DecalibrationSignal> signals, double duration, std::uint64_t seed,
                std::uint64_t run);

  /// delta [rad, m] at `t_ns` since the start, t_ns >= 0. Instants of steps and half periods are rounded to 1
  /// ns.
  [[nodiscard]] RigParameters at(std::int64_t t_ns) const;

  /// The instants in (0, end_ns] [ns] at which delta jumps, in increasing order: the value is the new one
  /// there.
  [[nodiscard]] std::vector<std::int64_t> jumps(std::int64_t end_ns) const;

 private:
  struct Source {
    DecalibrationSignal signal;
    std::string stream;               // of its random draws
    std::vector<RigParameters> walk;  // of a random walk, every 10 ms
  };

  std::vector<Source> sources_;
  std::uint64_t seed_, run_;
};

}  // namespace limber
