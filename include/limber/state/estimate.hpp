// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "limber/core/covariance.hpp"
#include "limber/core/linear_measurement.hpp"
#include "limber/measure/camera_pose.hpp"
#include "limber/measure/stereo_model.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/parameters.hpp"
#include "limber/state/passive_block.hpp"
#include "limber/state/state.hpp"

namespace limber {

/// @brief Mean and covariance of everything the filter knows: body, parameters (if in the state), anchors,
/// landmarks. Keeps mean and covariance in step while the map grows and shrinks.
///
/// Landmarks out of view can be made passive: they leave P and cost nothing until they are recalled, and the
/// result is the same (PassiveBlock). While any are passive, P also holds a clone of the body, and landmarks
/// of the current epoch are frozen: they are corrected, but not redefined or taken out of P before it ends.
class Estimate {
 public:
  /// @param body_covariance   layout.body_size() wide
  /// @param theta_covariance  6×6 [rad, m]; read only if layout.has_theta
  /// @throws std::invalid_argument if shapes disagree
  Estimate(StateLayout layout, const NavigationState& nav, const Eigen::MatrixXd& body_covariance,
           const RigParameters& theta, const Eigen::Matrix<double, 6, 6>& theta_covariance);

  /// Mean of the body's state.
  [[nodiscard]] const NavigationState& nav() const { return nav_; }
  /// What the filter takes for the rig: an estimate if it is in the state, else assumed [rad, m].
  [[nodiscard]] const RigParameters& theta() const { return theta_; }
  /// Parameters beyond theta, true minus assumed, as far as they are in the state.
  [[nodiscard]] const Eigen::Matrix<double, kMoreParameters, 1>& more() const { return more_; }
  /// Mean of the witness [plausible errors]; zero without one.
  [[nodiscard]] const Eigen::Matrix<double, 6, 1>& witness() const { return witness_; }
  /// Covariance of the error state: n×n, in the order of layout(), then the map.
  [[nodiscard]] const Covariance& P() const { return P_; }
  /// The same, to correct it; who does keeps it positive semidefinite.
  [[nodiscard]] Covariance& mutable_P() { return P_; }

  /// The mount's rotation times `kept` in 0 to 1, mean and covariance. For layouts that have the mount in the
  /// state.
  void shrink_mount_rotation(double kept);
  /// Another mean of the body, with the same covariance.
  void set_nav(const NavigationState& nav) { nav_ = nav; }
  /// @brief The body stands there, as something says that has nothing to do with all else that is known: pose
  /// and velocity are no more correlated with it. The velocity's mean stays.
  /// @param position, attitude, velocity  standard deviations of each axis [m], [rad], [m/s]
  void place_body(const Pose& there, double position, double attitude, double velocity);
  /// Another time of the body; nothing else changes.
  void set_time(std::int64_t t_ns) { nav_.t_ns = t_ns; }
  /// Another rig is taken for true. For layouts that do not have theta in the state.
  void assume_theta(const RigParameters& theta) { theta_ = theta; }

  /// Where things stand in the error state.
  [[nodiscard]] const StateLayout& layout() const { return layout_; }
  /// Size n of the error state that P covers; passive landmarks are not in it.
  [[nodiscard]] Eigen::Index size() const { return P_.size(); }
  /// Of the whole map, active and passive, in no order.
  [[nodiscard]] const std::vector<Landmark>& landmarks() const { return landmarks_; }
  /// The same, to change them; who moves one has to keep P right.
  [[nodiscard]] std::vector<Landmark>& landmarks() { return landmarks_; }

  /// The landmark of a track; null if it is not in the map. Invalidated where the map changes.
  [[nodiscard]] const Landmark* find(std::int64_t track_id) const;
  /// The same, to change it.
  [[nodiscard]] Landmark* find(std::int64_t track_id);
  /// The landmark's anchor; null for Cartesian landmarks.
  [[nodiscard]] const Anchor* anchor_of(const Landmark& landmark) const;

  /// What of a length grows with the map's scale, between nothing and all of it [-].
  struct ScaleShares {
    double position = 1.0;  ///< of the body, from the centre of growth; anchors and world vectors alike
    double velocity = 1.0;  ///< of the body
  };
  /// By what errors have in common with that of the scale: where all landmarks are new, nothing. All where
  /// the layout has no scale, or its corrections are applied as they stand.
  [[nodiscard]] ScaleShares scale_shares() const;

  /// @brief x := x ⊕ dx, dx: size(). Parameters move only if they are in the state.
  ///
  /// The covariance is carried along: it keeps its meaning as that of the right-invariant error (Exp(phi)
  /// acting on all world vectors), so that what nobody can observe, position and heading of the world, stays
  /// unobserved though the Jacobians are taken at a new point every time. Without, the filter learns a
  /// heading from nothing. [Barrau2015], [Hao2022]. Frozen and passive landmarks are carried along when their
  /// epoch ends.
  ///
  /// With has_map_scale the same is done for a common factor of all lengths, and a correction of it is
  /// applied as a factor, by which lengths grow about the centre. See docs/derivations/scale.md.
  /// @param grows  as it was before the update that says dx
  void retract(const Eigen::VectorXd& dx, const ScaleShares& grows);
  /// The same where all lengths have the map's scale.
  void retract(const Eigen::VectorXd& dx) { retract(dx, {}); }
  /// @brief Derivatives by the errors that retract(dx) would leave, turned into derivatives by the errors as
  /// they are: the inverse of what it does to P. Called before it.
  void refer_back(const Eigen::VectorXd& dx, SparseJacobian& H) const;

  /// Where lengths grow about, a position in the world [m]: its origin until this is called.
  void set_centre_of_growth(const Eigen::Vector3d& centre) { centre_of_growth_ = centre; }
  /// The same, read [m].
  [[nodiscard]] const Eigen::Vector3d& centre_of_growth() const { return centre_of_growth_; }

  /// @brief Takes the map's scale anew from the landmarks that are active: the mean error of their log
  /// depths, those that are known best before others; nil without landmarks. Nothing without has_map_scale.
  void refresh_map_scale();

  /// A state that an update is not to correct, and what moves with it.
  struct Considered {
    Eigen::Index at = 0;    ///< in the error state
    Eigen::VectorXd along;  ///< covariances with it over its variance, size()
    double variance = 0.0;  ///< of it
  };
  /// As it is now. @param at  in the error state: the map's scale, or that of odometry
  [[nodiscard]] Considered considered(Eigen::Index at) const;

  /// @brief After an update of P, before retract(): the state stays what it was, and as unsure (Schmidt), and
  /// what is beside it is corrected. @param before  the update  @param dx  what retract() is going to do
  void hold(const Considered& before, Eigen::VectorXd& dx);

  /// How far off the odometry's scale may be: a standard deviation [-], before anything moves. For layouts
  /// that have one.
  void set_odometry_scale_sigma(double sigma);
  /// Carries the covariance along with a prediction that odometry moved the body's position by [m]. For
  /// layouts that have its scale.
  void move_with_odometry_scale(const Eigen::Vector3d& by);

  /// Steps of an IMU: gyro bias [rad/s], accelerometer bias [m/s^2], and of its clock: how much later than
  /// taken samples are stamped [s].
  using Steps = Eigen::Matrix<double, 7, 1>;
  /// What the innovations say of steps since the last restart, in information form. Of a clock that is open
  /// (suppose_steps) nothing.
  struct SupposedSteps {
    Eigen::Matrix<double, 7, 7> information;  ///< inverse covariance
    Steps evidence;                           ///< information times the steps that explain them best
  };
  /// For layouts that have them. The statistic of a likelihood ratio test of jumps [WillskyJones1976].
  [[nodiscard]] SupposedSteps supposed_steps() const;
  /// Steps of the biases are supposed to begin now; of those before nothing is left. For layouts that have
  /// them.
  void restart_bias_steps();
  /// The same of the clock's.
  void restart_clock_step();
  /// Of the clock.
  struct ClockStep {
    double mean;   ///< how much later than taken samples are stamped [s]
    double sigma;  ///< its standard deviation [s]
  };
  /// The clock's step as it is known. For layouts that have steps.
  [[nodiscard]] ClockStep clock_step() const;
  /// Another mean of it [s]; nothing else changes.
  void set_clock_step(double mean) { steps_(6) = mean; }
  /// It may begin now, with that standard deviation [s], and is corrected like any state then, until it is
  /// restarted.
  void open_clock_step(double sigma);
  /// Carries mean and covariance along with a prediction that moves the body by that much for each second of
  /// the clock's step [unit/s]. For layouts that have steps.
  void move_with_clock_step(const Eigen::Matrix<double, 15, 1>& by);
  /// A predicted state as that moves it.
  [[nodiscard]] NavigationState moved_with_clock_step(NavigationState nav,
                                                      const Eigen::Matrix<double, 15, 1>& by) const;
  /// @brief Opens everything along what steps since the last restart did to it: biases, velocity, attitude,
  /// the map and its scale. To first order that is the covariance that the state has if there was a step
  /// which no gain knew of: the supposed steps as well, which are corrected like any state then, until they
  /// are restarted. See docs/derivations/faults.md.
  /// @param sigma  of each step
  void suppose_steps(const Steps& sigma);

  /// The witness forgets what it has learned: mean zero, standard deviation `sigma` [plausible errors] each,
  /// correlated with nothing. For layouts that have one.
  void restart_witness(double sigma);

  /// The witness becomes theta: theta gains `directions` times its mean, 6×k, k <= 6, and the layout says so.
  void promote_witness(const Eigen::MatrixXd& directions);

  /// Clones the body's pose into the state as a new anchor; returns its index. Jitter (1 µm, 0.1
  /// µrad) keeps P positive definite while clone and pose are otherwise the same.
  int add_anchor(const Pose& T_body_cam0);

  /// The same with the pose of the left camera instead of the body's, whose errors include those of mount and
  /// time offset: what is seen from it does not depend on them, however its depth is corrected later on.
  int add_camera_anchor(const CameraPose& pose);

  /// Removes an anchor that no landmark came to stand on; -1 is nobody.
  void drop_unused_anchor(int anchor);

  /// @brief Ends the epoch and begins the next: the landmarks `retired` go passive, and with them the anchors
  /// that only they stand on.
  void change_epoch(const std::vector<std::int64_t>& retired);

  /// Once a frame: some of the work that the end of an epoch puts off. Changes nothing but by rounding.
  void settle() { passive_.settle(); }
  /// All of that work, where a call may take long anyway.
  void settle_all() { passive_.settle_all(); }
  /// The passive landmarks `recalled` and their anchors come back, frozen for the rest of the epoch.
  void recall(const std::vector<std::int64_t>& recalled);

  /// Something is or was passive in this epoch.
  [[nodiscard]] bool has_frozen() const { return frozen_end_ > layout_.map_begin(); }
  /// By how many states P has grown since the epoch began: landmarks that are new or came back.
  [[nodiscard]] Eigen::Index grown_in_epoch() const { return P_.size() - size_as_epoch_began_; }
  /// Time of the last change of epoch.
  [[nodiscard]] std::int64_t epoch_began_ns() const { return epoch_began_ns_; }
  /// A frozen landmark must not be redefined (convert_to_cartesian) now; it may be right after change_epoch.
  [[nodiscard]] bool is_frozen(const Landmark& landmark) const {
    return landmark.at < frozen_end_ && !drift_.isZero(0.0);
  }

  /// @brief Turns a projection's derivatives with respect to the errors as they are now into those with
  /// respect to the errors in P. They differ for a frozen landmark that was corrected since its epoch began:
  /// P holds its error as it was defined then (see retract). Without, a heading is learned from nothing until
  /// the epoch ends.
  void refer_to_epoch(const Landmark& landmark, PointProjection& projection) const;

  /// Appends a landmark with covariance P_ll (3×3) and cross-covariance P_xl (n×3, n the size before; zero
  /// rows: none).
  Landmark& add_landmark(Landmark landmark, const Eigen::Matrix3d& P_ll, const Eigen::MatrixXd& P_xl = {});

  /// Removes a landmark and its anchor if nobody else stands on it. Nothing else changes.
  void remove_landmark(std::int64_t track_id);

  /// Rewrites an inverse-depth landmark as a Cartesian one: same point, covariance by its Jacobian.
  void convert_to_cartesian(Landmark& landmark);

  /// Position of a landmark and its covariance [m²]. @param[out] covariance may be null
  [[nodiscard]] Eigen::Vector3d landmark_position(const Landmark& landmark,
                                                  Eigen::Matrix3d* covariance = nullptr) const;

  /// Positions of all landmarks [m], in the order of landmarks(); cheaper than one by one.
  [[nodiscard]] std::vector<Eigen::Vector3d> landmark_positions() const;

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using More = Eigen::Matrix<double, kMoreParameters, 1>;
  enum class Owner : std::uint8_t { kLandmark, kAnchorPosition, kAnchorAttitude, kBodyClone, kBuried };
  struct StateBlock {
    Owner owner;
    std::size_t index;
  };

  /// Carries the covariance along with the correction dx: see retract.
  void transport(const Eigen::VectorXd& dx);
  [[nodiscard]] Eigen::Vector3d displacement_in_epoch(Eigen::Index at) const;
  void add_couplings(const Eigen::MatrixXd& U);
  void add_couplings(const Eigen::MatrixXd& U, std::span<const Eigen::Index> to);

  // The common factor of all lengths: src/state/map_scale.cpp.
  /// A correction of lengths: of their logarithm, and the factor that it stands for.
  struct Factor {
    double log = 0.0, factor = 1.0;
    /// What the factor moves a length by beyond the linear correction, as a share of it.
    [[nodiscard]] double beyond_linear() const { return factor - 1.0 - log; }
    /// The same of an inverse depth.
    [[nodiscard]] double beyond_linear_inverse() const { return 1.0 / factor - 1.0 + log; }
    void operator+=(const Factor& next) { *this = {log + next.log, factor * next.factor}; }
  };
  /// What a correction does to the whole world.
  struct WorldChange {
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();  ///< of the body's attitude, in the world [rad]
    double log = 0.0;                                ///< of the scale
    Factor depths, positions, velocity{};            ///< of all that grows with it
    void operator+=(const WorldChange& next) {
      turn += next.turn;
      log += next.log;
      depths += next.depths;
      positions += next.positions;
      velocity += next.velocity;
    }
  };
  struct LogDepth {
    Eigen::Index at;
    Eigen::Vector3d of_landmark, of_body;
    double variance;
  };
  [[nodiscard]] std::vector<LogDepth> log_depths() const;
  [[nodiscard]] WorldChange world_change(const Eigen::VectorXd& dx, const ScaleShares& grows) const;
  [[nodiscard]] Eigen::VectorXd displacements(const Eigen::VectorXd& dx, const WorldChange& by) const;
  [[nodiscard]] Eigen::Vector3d displacement_of_frozen(Eigen::Index at, const Eigen::Vector3d& dx,
                                                       const WorldChange& by) const;
  [[nodiscard]] Eigen::Vector3d displacement(StateBlock block, const Eigen::Vector3d& dx,
                                             const WorldChange& by) const;
  void add_displacements(const Eigen::VectorXd& dx, const Eigen::VectorXd& moved);
  [[nodiscard]] Eigen::Vector3d scaled(StateBlock block, const Eigen::Vector3d& dx,
                                       const WorldChange& by) const;
  [[nodiscard]] Eigen::Vector3d grown(StateBlock block, const Eigen::Vector3d& displacement) const;
  void couple_scale(Eigen::MatrixXd& U, Eigen::Index at, const Eigen::Vector3d& grown) const;
  [[nodiscard]] Eigen::Index coupled_columns() const {
    return layout_.has_map_scale ? 2 * kTriplet : kTriplet;
  }
  int append_anchor(const Pose& T_world_frame, const Pose& T_frame_cam0);
  void add_jitter(const Anchor& anchor, Eigen::MatrixXd& columns) const;
  Eigen::Index append_triplet(StateBlock block);
  void remove_triplet(Eigen::Index at, bool passive);
  void move_in(StateBlock block, Eigen::Index at, bool passive);
  void remove_anchor(int anchor);
  void release_anchor(int anchor);
  [[nodiscard]] std::size_t slot(Eigen::Index at) const {
    return static_cast<std::size_t>((at - layout_.map_begin()) / kTriplet);
  }

  // Epochs: src/state/epoch.cpp.
  struct Move {
    StateBlock block;
    Eigen::Vector3d displacement;  // since the covariance was last carried along
  };
  void retract_parameters(const Eigen::VectorXd& dx);
  void retract_triplet(StateBlock block, const Eigen::Vector3d& dx);
  [[nodiscard]] bool is_world_vector(StateBlock block) const;
  [[nodiscard]] std::vector<bool> anchors_in_use(const std::vector<bool>& resting) const;
  void carry_active(const std::vector<Move>& kept);
  void carry_passive(const std::vector<Move>& passive);
  [[nodiscard]] std::vector<Eigen::Index> rows_of(const std::vector<std::int64_t>& passive) const;
  [[nodiscard]] Eigen::Matrix3d joint_block(Eigen::Index row, bool row_passive, Eigen::Index col,
                                            bool col_passive) const;
  [[nodiscard]] Landmark current(const Landmark& landmark) const;
  [[nodiscard]] Anchor current(const Anchor& anchor) const;
  [[nodiscard]] Eigen::Vector3d passive_displacement(Eigen::Index row) const;
  [[nodiscard]] static Landmark corrected(Landmark landmark, const Eigen::Vector3d& correction);
  [[nodiscard]] static Anchor corrected(Anchor anchor, const Eigen::Vector3d& dp,
                                        const Eigen::Vector3d& dtheta);

  NavigationState nav_;
  RigParameters theta_;
  Eigen::Vector3d centre_of_growth_ = Eigen::Vector3d::Zero();
  More more_ = More::Zero();
  Vector6 witness_ = Vector6::Zero();
  Covariance P_;
  StateLayout layout_;
  Steps steps_ = Steps::Zero();  // supposed ones, mean
  std::vector<Anchor> anchors_;
  std::vector<int> free_anchors_;
  std::vector<Landmark> landmarks_;
  std::unordered_map<std::int64_t, std::size_t> index_of_;
  std::vector<StateBlock> active_blocks_;   // who lives in each triplet of the map, in state order
  std::vector<StateBlock> passive_blocks_;  // who lives in each triplet of the passive block
  PassiveBlock passive_;
  Eigen::Index frozen_end_ = 0;  // P is [body | frozen | initialised since]; map_begin if nothing is frozen
  Eigen::VectorXd drift_;        // sum of the corrections of the frozen part since the epoch began
  Eigen::VectorXd moved_;        // what it was moved by: see displacements()
  WorldChange changed_;          // since then
  Eigen::Index size_as_epoch_began_ = 0;
  std::int64_t epoch_began_ns_ = 0;
};

/// Derivative of an inverse-depth landmark's world position: with respect to anchor position, anchor attitude
/// and the landmark's triplet, side by side (3×9).
[[nodiscard]] Eigen::Matrix<double, 3, 9> world_position_jacobian(const Landmark& landmark,
                                                                  const Anchor& anchor);

}  // namespace limber
