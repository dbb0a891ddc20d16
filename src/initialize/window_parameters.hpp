// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "window_problem.hpp"

namespace limber::detail {

/// The solution of a window, had one parameter of the calibration been assumed off by its standard deviation.
struct ShiftedSolution {
  Eigen::Index parameter = 0;  ///< of kParameters; of a clock none
  double sigma = 0.0;          ///< by which it is off
  WindowModel model;
  WindowState state;
};

/// @brief Of all parameters beyond theta that are estimated: a window takes them for exact, and what they are
/// off by is in its solution. @param state  the solution with the parameters as assumed
[[nodiscard]] std::vector<ShiftedSolution> shifted_solutions(const WindowModel& model,
                                                             const WindowState& state);

/// By how much a body that is taken for `from` is off if it is `to`, in the layout of a frame's state.
[[nodiscard]] Eigen::VectorXd body_error(MotionModel motion, const NavigationState& from,
                                         const NavigationState& to);

/// What is handed over, for a parameter that is off by one: errors of the body and of the points, in the
/// order of InitialState's covariances.
[[nodiscard]] Eigen::VectorXd by_one(const ShiftedSolution& shifted, const WindowModel& model,
                                     const InitialState& initial);

/// What is handed over, for each parameter that is off by one: InitialState::by_parameters.
[[nodiscard]] Eigen::MatrixXd by_parameters(const std::vector<ShiftedSolution>& shifted,
                                            const WindowModel& model, const InitialState& initial);

}  // namespace limber::detail
