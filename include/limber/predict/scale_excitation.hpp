// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>

namespace limber {

/// @brief How much of what an IMU tells about the length of a metre is its own noise.
///
/// A map without a scale is compared to the velocity that the accelerometer gains. Its noise is in both sides
/// of that comparison, so that a recursive filter finds lengths too long, by the share that noise has in the
/// squares of what is gained: errors in variables. Of a body that accelerates that is nothing; of one that
/// creeps it is all there is. docs/derivations/scale.md, "Noise that looks like motion".
class ScaleExcitation {
 public:
  /// @param accel_density  noise of the accelerometer [m/s^2/sqrt(Hz)], per axis
  explicit ScaleExcitation(double accel_density);

  /// The body's velocity [m/s], in the world, as a frame has left it; later than those before.
  void add(std::int64_t t_ns, const Eigen::Vector3d& v_world_body);

  /// The velocity is another one now, and none was gained by that.
  void jump() { last_.clear(); }

  /// What noise alone gains over what the body has gained in the last seconds, squared, in [0, 1]; 0 as long
  /// as nothing was seen.
  [[nodiscard]] double noise_share() const;

 private:
  struct Velocity {
    std::int64_t t_ns;
    Eigen::Vector3d v;
  };
  double density_;
  double seen_s_ = 0.0;       // how long, as far as it is remembered
  double mean_square_ = 0.0;  // of what was gained over half a second [m^2/s^2]
  std::deque<Velocity> last_;
};

}  // namespace limber
