// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/navigate/method.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/simulate/decalibration.hpp"
#include "limber/simulate/fault.hpp"
#include "limber/state/initial_sigma.hpp"

/// What is simulated. The defaults are the paper's case (i): its numbers where it gives them
/// (paper, 4.1-4.2), else those of the shipped scenario files. SI units; angles in radians (files: degrees,
/// see scenario_file.hpp).
namespace limber {

/// Cubic spline in all six dimensions through random control poses. The vehicle frame is x forward, y left, z
/// up.
struct RandomSplineTrajectory {
  Eigen::Vector3d half_extent{12.0, 12.0, 3.0};  ///< control points lie in this box around the origin [m]
  /// Largest roll, pitch and yaw of a control pose, in R = Rz(yaw) Ry(pitch) Rx(roll) [rad].
  Eigen::Vector3d max_angles{10.0 * detail::kDegree, 10.0 * detail::kDegree, 180.0 * detail::kDegree};
  double knot_spacing = 4.0;      ///< [s]
  double max_speed = 3.0;         ///< never exceeded [m/s]
  double max_angular_rate = 0.5;  ///< never exceeded [rad/s]
  double rest = 0.0;              ///< the vehicle stands still that long before it sets off [s]
};

/// Figure-eight (lemniscate of Bernoulli, the crossing at the origin, 2.8 times as long as wide), the vehicle
/// looking along the path; it sets off anywhere on it.
struct FigureEightTrajectory {
  double half_length = 6.0;             ///< [m]
  double height = 0.5;                  ///< amplitude of the vertical motion, once a lap [m]
  double min_speed = 2.0;               ///< horizontal speed swings between the two [m/s]
  double max_speed = 3.0;               ///< [m/s]
  double tilt = 5.0 * detail::kDegree;  ///< amplitude of roll and pitch [rad]
  double rest = 0.0;                    ///< stands still that long, then gathers speed within 2 s [s]
};

/// Poses of the body in a z-up world, from a TUM file; between them a cubic spline that uses them as control
/// poses, so that it smooths them.
struct FileTrajectory {
  /// TUM file, relative to the scenario's folder
  std::filesystem::path path;
  double start = 0.0;         ///< time since the file's first pose at which the recording starts [s]
  double knot_spacing = 0.1;  ///< [s]
};

/// All kinds of trajectories.
using TrajectoryScenario = std::variant<RandomSplineTrajectory, FigureEightTrajectory, FileTrajectory>;

/// Where points are put: at a random instant of the trajectory,
enum class PointPlacement {
  kAround,  ///< in any direction from the body up to max_elevation, at a distance drawn uniformly
  kInView   ///< at a pixel of the left image and a depth, drawn uniformly: as many points ahead at any time
};

/// A rigid body that moves on a horizontal circle, with some of the points on it: p(t) = p(0) + r (cos, sin).
struct MovingBodyScenario {
  double share = 0.4;   ///< each point belongs to it with this probability
  double speed = 1.0;   ///< [m/s]
  double radius = 2.0;  ///< of the circle [m]
  double start = 0.0;   ///< it stands still that long [s]
};

/// Where the points of the world are, and from how far they are seen.
struct WorldScenario {
  /// in the world
  int points = 380;
  /// how they are put there
  PointPlacement placement = PointPlacement::kAround;
  double min_distance = 4.0;                      ///< from the body, or depth, at the drawn instant [m]
  double max_distance = 80.0;                     ///< [m]
  double max_elevation = 60.0 * detail::kDegree;  ///< kAround: of the direction, up or down [rad]
  double min_range = 0.5;                         ///< a camera sees points at depths (z) between the two [m]
  double max_range = 100.0;                       ///< [m]
  bool left_only = false;  ///< also report points that the left camera alone sees; else both must see a point
  /// nothing: all points stand still
  std::optional<MovingBodyScenario> moving_body;
};

/// The nominal rig, which estimators may assume.
struct RigScenario {
  /// left camera, nominal
  Camera cam0{300.0, 300.0, 240.0, 320.0, 480, 640, NoDistortion{}};
  /// right camera, nominal
  Camera cam1{300.0, 300.0, 240.0, 320.0, 480, 640, NoDistortion{}};
  RigParameters theta = (RigParameters() << 0.0, 0.0, 0.0, -2.0, 0.0, 0.0).finished();  ///< [rad, m]
  BodyFrame body = BodyFrame::kImu;  ///< what the trajectory moves, where IMU and odometry sit
  Pose T_imu_cam0;  ///< identity (the paper: the IMU sits in the left camera) unless body is kImu
};

/// Noise of the sensors. IMU noise is per sample, as the paper has it at 100 Hz; the continuous density is
/// the per-sample value divided by the square root of the rate.
struct NoiseScenario {
  double pixel = 0.5;                   ///< sigma of each of u0, v0, u1, v1 [px]
  double accel = 0.1;                   ///< sigma of each accelerometer sample [m/s^2]
  double gyro = 0.5 * detail::kDegree;  ///< sigma of each gyro sample [rad/s]
  double accel_walk = 0.0;              ///< of the accelerometer bias [m/s^3/sqrt(Hz)]
  double gyro_walk = 0.0;               ///< of the gyro bias [rad/s^2/sqrt(Hz)]
  bool stated = true;  ///< false: the recording does not say the noise of its pixels and its odometry
};

/// What the errors of real pixels have beyond white noise (NoiseScenario::pixel). Sigmas are those of each of
/// u0, v0, u1, v1 [px]. Every part is drawn on its own.
struct PixelScenario {
  double per_track = 0.0;               ///< constant along a track
  double correlated = 0.0;              ///< AR(1) along a track, stationary
  double correlated_coefficient = 0.9;  ///< of that, from one frame to the next, in [0, 1)
  /// Rms over the image of a smooth field that each lens has for the whole recording: what the model of the
  /// lens leaves.
  double field = 0.0;
  /// Probability that a point is mismatched in a frame: one of its pixels, of either camera, is at a random
  /// place of the image or on another point.
  double mismatches = 0.0;
};

/// Wheels, or any odometer: velocity and rate in the body frame.
struct OdometryScenario {
  double rate = 50.0;          ///< [Hz]
  double velocity = 0.1;       ///< sigma per sample and axis [m/s]
  double angular_rate = 0.02;  ///< sigma per sample and axis [rad/s]
};

/// What goes missing, each as a probability in [0, 1].
struct DropoutScenario {
  double right_detections = 0.0;  ///< the right camera misses a point: its u1, v1 are empty
  double frames = 0.0;            ///< a stereo frame is lost (never the first)
  double imu_samples = 0.0;       ///< an IMU sample is lost (never the first or the last)
};

/// What estimators should assume in this scenario.
struct FilterScenario {
  /// standard deviations of the first state
  InitialSigma initial;
  RigParameters theta_sigma = plausible_error(2.0);  ///< ekf-full, soft, consider: initial sigma [rad, m]
  /// ekf-full: random walk of theta, variance per second [rad^2/s, m^2/s]. Table 1, 'well estimated': 1e-6
  /// rad^2 and 1 mm^2 in every prediction step of 10 ms.
  RigParameters theta_walk = RigParameters::Constant(1e-6 * 100.0);
  double acceleration_noise = 0.5;  ///< of the constant-velocity model [m/s^2/sqrt(Hz)]
  double angular_noise = 0.2;       ///< of the constant-velocity model [rad/s^2/sqrt(Hz)]
  bool gate = false;                ///< refuse points whose residual is too large; matching is perfect here
  int max_landmarks = 400;          ///< size of the map; those unseen for longest go
};

/// Everything that a simulated recording follows from, but for seed and run.
struct Scenario {
  /// unique in a study
  std::string name = "paper_i";
  double duration = 35.0;               ///< [s]
  double imu_rate = 100.0;              ///< IMU samples, ground truth and prediction steps [Hz]
  double stereo_rate = 20.0;            ///< [Hz]
  bool use_imu = true;                  ///< false: vision only, or with odometry
  bool same_world_in_all_runs = false;  ///< trajectory and points depend on the seed alone, not on the run
  double gravity = 9.81;                ///< [m/s^2], along -z of the world
  /// of the body
  TrajectoryScenario trajectory = RandomSplineTrajectory{};
  /// its points
  WorldScenario world;
  /// nominal; `decalibration` bends it
  RigScenario rig;
  /// of IMU and pixels
  NoiseScenario noise;
  /// nothing: there is no odometer
  std::optional<OdometryScenario> odometry;
  InitialSigma initial;  ///< true biases at the start and errors of the initial state are drawn from these
  /// what goes missing
  DropoutScenario dropout;
  /// errors of pixels beyond white noise
  PixelScenario pixels;
  /// of the inputs, in the order of their kinds
  std::vector<Fault> faults;
  std::vector<DecalibrationSignal> decalibration;  ///< theta_true(t) - rig.theta
  /// what estimators are told
  FilterScenario filter;
};

}  // namespace limber
