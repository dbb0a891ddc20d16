// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <map>
#include <tuple>
#include <vector>

#include "limber/health/tolerance.hpp"

/// @file
/// Whether a rig changed: steps between windows, against chance and against what matters.
namespace limber {

/// A change matters from this share of what is ok.
inline constexpr double kRelevantShare = 0.5;

/// A way in which a rig can change.
struct ChangeWay {
  /// its size is |along · beta|
  NormalEquations::Vector along = NormalEquations::Vector::Zero();
  double relevant = 0.0;  ///< size from which it matters
};

/// In depth, and in the four main ways to leave the epipolar lines.
using ChangeWays = std::array<ChangeWay, 5>;

/// @brief What changes are looked for: half of what the tolerance calls ok, or more.
/// @param epipolar  as in BetaEstimate
[[nodiscard]] ChangeWays ways_of_change(const NormalEquations::Matrix& epipolar, const RigParameters& theta,
                                        bool metric, const Tolerance& tolerance);

/// What is known of how a change scatters that is none.
struct Scatter {
  double factor = 1.0;  ///< variance by stated variance
  double dof = 1.0;     ///< degrees of freedom of Student's t
};

/// The same for each way.
using Scatters = std::array<Scatter, std::tuple_size_v<ChangeWays>>;

/// One of the ways is large enough to matter.
[[nodiscard]] bool matters(const BetaEstimate& change, const ChangeWays& ways);

/// The least p-value (Student's t, two-sided) of the ways that matter. Infinite where none does.
[[nodiscard]] double least_chance(const BetaEstimate& change, const ChangeWays& ways,
                                  const Scatters& scatters);

inline constexpr std::size_t kShortestStep = 2;  ///< windows that a state has to last to be one
inline constexpr std::size_t kLongestStep = 5;   ///< windows within which a step is seen, if it is

/// @brief How many independent tests one window's steps are worth: 4 lengths, 5 ways.
///
/// Of independent Gaussian windows the steps of one length overlap from window to window, and those of one
/// window overlap each other: alarms a window by p-value are 9.2 at 1e-3, 10.9 at 3e-4, 10.4 at 1e-4 (the
/// test StepScatter.AsManyAlarmsAsAskedFor holds them to it).
inline constexpr double kTestsOfAWindow = 10.0;

/// By length, from the shortest one on.
using ScattersByLength = std::array<Scatters, kLongestStep - kShortestStep + 1>;

/// @brief What steps scattered by that were looked at earlier, as seen from one window.
///
/// The covariance of a step says what windows vary by that have nothing to do with each other. They have: a
/// drone that flies laps comes back to the same errors, neighbours share tracks. What that does to a step
/// depends on its length, and earlier steps of the same length show it; they also show how often there are
/// large ones.
/// @note docs/derivations/health.md
class StepScatter {
 public:
  /// @brief By steps that ended before so many windows.
  /// @param windows  of the state that is asked about and the one between: what changed does not count
  [[nodiscard]] const ScattersByLength& before(std::size_t windows);

 private:
  friend class EarlierSteps;
  struct Squares {
    std::size_t age;  // windows since: 1 is the one before
    std::array<double, std::tuple_size_v<ChangeWays>> by_variance;
  };
  std::array<std::vector<Squares>, std::tuple_size_v<ScattersByLength>> squares_;  // the youngest last
  std::map<std::size_t, ScattersByLength> known_;
};

/// Steps that were looked at, of the last ten minutes at 2.5 s.
class EarlierSteps {
 public:
  /// The next window: steps that are added belong to it.
  void begin_window() { ++window_; }
  /// @param length  windows after the step
  void add(std::size_t length, const BetaEstimate& step);
  /// As seen from this window.
  [[nodiscard]] StepScatter along(const ChangeWays& ways) const;

 private:
  struct Step {
    std::size_t window;
    NormalEquations::Vector beta;
    NormalEquations::Matrix covariance;
  };
  std::size_t window_ = 0;
  std::array<std::deque<Step>, std::tuple_size_v<ScattersByLength>> steps_;
};

}  // namespace limber
