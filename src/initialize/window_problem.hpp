// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "frames_factor.hpp"
#include "limber/measure/rig.hpp"
#include "limber/measure/stereo_model.hpp"
#include "limber/navigate/navigator_options.hpp"
#include "limber/predict/input_buffer.hpp"
#include "limber/predict/motion.hpp"
#include "limber/predict/motion_between.hpp"
#include "limber/state/initial_state.hpp"

/// @file
/// The first moments of a recording as one least-squares problem: docs/derivations/start.md.
namespace limber::detail {

constexpr double kJitter = 1e-7;  ///< [m, rad, m/s, ...]: keeps the process noise regular

/// What is known before the first frame: standard deviations of a state of mean zero.
struct WindowPrior {
  double position = 1e-3;   ///< [m], by convention the origin
  double yaw = 1e-4;        ///< [rad], by convention zero; without gravity the whole attitude
  double tilt = 1.0;        ///< [rad]
  double velocity = 30.0;   ///< [m/s]
  double rate = 3.0;        ///< [rad/s]
  double bias_gyro = 0.1;   ///< [rad/s]
  double bias_accel = 0.1;  ///< [m/s^2], unless the window shows larger ones
};

/// What stays the same while the problem is solved.
struct WindowModel {
  NavigatorOptions options;
  StereoCalibration calibration;
  Eigen::MatrixXd directions;  ///< 6×b: what of theta is free in every frame; no column: the rig is trusted
  bool right = true;           ///< the right pixels are used
  WindowPrior prior;
  ImuNoiseFactors imu_noise;                              ///< of the noise in `options` over what was stated
  Eigen::Matrix3d R_first = Eigen::Matrix3d::Identity();  ///< yaw of the first frame is that of this

  [[nodiscard]] Eigen::Index body_size() const { return StateLayout{options.motion}.body_size(); }
  [[nodiscard]] Eigen::Index frame_size() const { return body_size() + directions.cols(); }
  [[nodiscard]] FrameLayout layout(std::size_t frames) const {
    return {static_cast<Eigen::Index>(frames), StateLayout::kPoseSize, body_size() - StateLayout::kPoseSize,
            directions.cols()};
  }
};

/// The inputs to a frame, summed up.
struct SummedInputs {
  MotionBetween between;
  Eigen::Matrix3d R_from;  ///< attitude at the frame before
  double forgotten_s;      ///< samples are missing: for so long they depend on that attitude
};

/// One frame: state, theta along the free directions, and the inputs since the frame before.
struct WindowFrame {
  NavigationState nav;
  Eigen::VectorXd theta;  ///< b
  std::vector<InputStep> steps;
  Eigen::Vector3d omega = Eigen::Vector3d::Zero();  ///< [rad/s], of the body at the frame
  /// How far the biases may have stepped since the frame before, beside their walk (standard deviation)
  /// [rad/s], [m/s^2].
  double gyro_step = 0.0, accel_step = 0.0;
  std::shared_ptr<const SummedInputs> inputs{};  ///< `steps`, while a solver goes over them again and again

  [[nodiscard]] double duration() const;  ///< of the steps [s]
};

/// One sighting of a point.
struct WindowSighting {
  std::size_t frame = 0;
  StereoObservation observation;
};

/// A point, anchored in the first frame that saw it.
struct WindowPoint {
  Landmark landmark;
  std::vector<WindowSighting> seen;  ///< in time; the first is the anchor

  [[nodiscard]] std::size_t anchor() const { return seen.front().frame; }
};

/// The unknowns.
struct WindowState {
  std::vector<WindowFrame> frames;
  std::vector<WindowPoint> points;
};

/// The first frame that saw a point, and the last.
struct FrameSpan {
  Eigen::Index first = 0, last = 0;
};

/// @brief Normal equations at a state: [A W; Wᵀ V] dx = g, the frames' errors first, then three per point. Of
/// W only the rows of the layout's rest are there: no pixel tells of velocity and biases.
struct WindowNormal {
  double cost = 0.0;  ///< half the sum of squares, after the robust loss
  double left = 0.0;  ///< of a solution: how much lower the undamped step promises to come
  FrameLayout layout;
  Eigen::MatrixXd A, W;  ///< lower triangle of A; W: rest by points
  std::vector<Eigen::Matrix3d> V;
  std::vector<FrameSpan> seen;  ///< each point: other frames' rows of W are zero
  Eigen::VectorXd g, g_points;
};

/// How the first state disagrees with what is known before any frame.
struct PriorResidual {
  Eigen::VectorXd e;            ///< the state without what is known
  Eigen::MatrixXd J;            ///< of e, by the state
  Eigen::MatrixXd information;  ///< inverse covariance of e
};

[[nodiscard]] PriorResidual prior_residual(const WindowModel& model, const WindowFrame& first);

/// How the inputs to a frame disagree with the states on either side of them; IMU: position and velocity in
/// the axes of the earlier body.
struct MotionResidual {
  Eigen::VectorXd e;     ///< the later state without the predicted one
  Eigen::MatrixXd J, F;  ///< of e: by the later state, and minus that by the earlier one
  Eigen::MatrixXd Q;     ///< covariance of the inputs' noise
};

[[nodiscard]] MotionResidual motion_residual(const WindowModel& model, const WindowState& state,
                                             std::size_t frame);

/// Of a residual's error in a solution.
/// @param covariance  of the frames' errors
/// @param from, to    where those of the earlier frame and of the later one begin
[[nodiscard]] Eigen::MatrixXd covariance_of(const MotionResidual& motion, const Eigen::MatrixXd& covariance,
                                            Eigen::Index from, Eigen::Index to);

/// Sums up the inputs to each frame, where that was not done about these states or ones like them. As long as
/// they are kept neither the model's noise nor `steps` may change.
void sum_up_inputs(const WindowModel& model, WindowState& state);
void forget_sums(WindowState& state);

/// @param memory normal equations that are of no use any more: what they hold is written over
[[nodiscard]] WindowNormal linearise(const WindowModel& model, const WindowState& state,
                                     WindowNormal memory = {});

/// A point from the body, when a camera of the rig took a frame's image.
[[nodiscard]] BodyPoint point_in_body(const WindowState& state, const MountedRig& rig, std::size_t cam,
                                      const WindowPoint& point, std::size_t frame);

/// Of all points [1/m], 0 without any.
[[nodiscard]] double median_inverse_depth(const WindowState& state);

/// What any pixels come to err by, in standard deviations of those that are assumed: 0.15 px, rms. Patches
/// that fit better at first drift.
[[nodiscard]] double fine_pixels(const WindowModel& model);

/// @brief Takes out of a solution the pixels that are mismatched: the robust loss bounds what each pulls, but
/// they still pull, and count as information. Points of which nothing is left go, and those that can be none.
/// @param end  pixels of this frame and of those after it stay
/// @return how many pixels and points
std::size_t drop_mismatches(const WindowModel& model, WindowState& state, std::size_t end);

/// @brief The first of the frames at the end of a solution that lost more than a quarter of their pixels as
/// mismatches, where the others, half of all at least, lost few: it is the inputs that contradict them. Else
/// the number of frames.
[[nodiscard]] std::size_t contradicted_from(const WindowState& whole, const WindowState& without_mismatches);

/// @brief Takes out of a guess the pixels that are off by more than an image: a camera that is guessed to
/// pass a point sees it anywhere, and along such residuals no step is short enough. Not where many are.
void drop_unreachable(const WindowModel& model, WindowState& state);

/// @brief Takes out of a guess the pixels that are off by more than a tenth of an image. Of a point whose
/// first pixel is a mismatch that is all others.
/// @return whether these are between 2 % and six tenths of all. Else nothing is taken out: a guess settles
/// with fewer, and with more it is wrong
[[nodiscard]] bool drop_far_off(const WindowModel& model, WindowState& state);

/// A solution in which the biases step once.
struct BiasStep {
  std::int64_t before_ns = 0;  ///< the frame after it
  WindowState state;
  WindowNormal normal;
};

/// @brief Where biases that may step anywhere explain the window much better, and one step of theirs explains
/// most of that: the solution with it. Nothing else.
[[nodiscard]] std::optional<BiasStep> find_bias_step(const WindowModel& model, const WindowState& state,
                                                     const WindowNormal& normal);

/// Lets the biases step in the interval that ends with this frame.
void open_biases(WindowFrame& frame);

/// State plus a correction, in the layout of WindowNormal.
[[nodiscard]] WindowState moved(const WindowModel& model, WindowState state, const Eigen::VectorXd& dx,
                                const Eigen::VectorXd& dx_points);

/// Prediction over the steps to a frame: mean and linearised transition.
[[nodiscard]] Transition predict_over(const NavigatorOptions& options, const WindowFrame& frame,
                                      NavigationState& nav);

/// The rig as each frame of the window sees it.
[[nodiscard]] std::vector<MountedRig> rigs_of(const WindowModel& model, const WindowState& state);

/// @brief Levenberg-Marquardt until it no longer pays.
/// @return the normal equations at the solution
[[nodiscard]] WindowNormal solve_window(const WindowModel& model, WindowState& state, int iterations);

/// How much lower the cost is where the problem, as it is linearised, has its minimum.
[[nodiscard]] double promised_decrease(const WindowNormal& normal);

/// Covariance of the frames' errors, points eliminated. Empty if it is not positive definite.
[[nodiscard]] Eigen::MatrixXd frame_covariance(const WindowNormal& normal);

}  // namespace limber::detail
