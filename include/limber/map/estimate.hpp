// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "limber/core/covariance.hpp"
#include "limber/core/state.hpp"
#include "limber/measure/stereo_model.hpp"
#include "limber/sensors/calibration.hpp"

namespace limber {

/// @brief Mean and covariance of everything the filter knows: body, theta (if in the state), anchors,
/// landmarks. Keeps mean and covariance in step while the map grows and shrinks.
class Estimate {
 public:
  /// @param body_covariance   layout.body_size() wide
  /// @param theta_covariance  6×6 [rad, m]; read only if layout.has_theta
  /// @throws std::invalid_argument if shapes disagree
  Estimate(StateLayout layout, const NavigationState& nav, const Eigen::MatrixXd& body_covariance,
           const RigParameters& theta, const Eigen::Matrix<double, 6, 6>& theta_covariance);

  [[nodiscard]] const StateLayout& layout() const { return layout_; }
  [[nodiscard]] Eigen::Index size() const { return P.size(); }
  [[nodiscard]] const std::vector<Landmark>& landmarks() const { return landmarks_; }
  [[nodiscard]] std::vector<Landmark>& landmarks() { return landmarks_; }

  [[nodiscard]] const Landmark* find(std::int64_t track_id) const;
  [[nodiscard]] Landmark* find(std::int64_t track_id);
  /// The landmark's anchor; null for Cartesian landmarks.
  [[nodiscard]] const Anchor* anchor_of(const Landmark& landmark) const;

  /// @brief x := x ⊕ dx, dx: size(). Theta moves only if it is in the state.
  ///
  /// The covariance is carried along: it keeps its meaning as that of the right-invariant error (Exp(phi)
  /// acting on all world vectors), so that what nobody can observe, position and heading of the world, stays
  /// unobserved though the Jacobians are taken at a new point every time. Without, the filter learns a
  /// heading from nothing. [Barrau2015], [Hao2022].
  void retract(const Eigen::VectorXd& dx);

  /// Clones the body's pose into the state as a new anchor; returns its index. A whisker of noise (1 µm, 0.1
  /// µrad) keeps P positive definite while clone and pose are otherwise the same.
  int add_anchor(const Pose& T_body_cam0);

  /// Removes an anchor that no landmark came to stand on; -1 is nobody.
  void drop_unused_anchor(int anchor);

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

  NavigationState nav;
  RigParameters theta;  ///< what the filter takes for the rig: an estimate if in the state, else assumed
  Covariance P;

 private:
  enum class Owner : std::uint8_t { kLandmark, kAnchorPosition, kAnchorAttitude };
  struct Tenant {
    Owner owner;
    std::size_t index;
  };

  /// Carries the covariance along with the correction dx: see retract.
  void transport(const Eigen::VectorXd& dx);
  Eigen::Index append_triplet(Tenant tenant);
  void remove_triplet(Eigen::Index at);
  void remove_anchor(int anchor);
  void release_anchor(int anchor);

  StateLayout layout_;
  std::vector<Anchor> anchors_;
  std::vector<int> free_anchors_;
  std::vector<Landmark> landmarks_;
  std::unordered_map<std::int64_t, std::size_t> index_of_;
  std::vector<Tenant> tenants_;  // who lives in each triplet of the map, in state order
};

/// Derivative of an inverse-depth landmark's world position: with respect to anchor position, anchor attitude
/// and the landmark's triplet, side by side (3×9).
[[nodiscard]] Eigen::Matrix<double, 3, 9> world_position_jacobian(const Landmark& landmark,
                                                                  const Anchor& anchor);

}  // namespace limber
