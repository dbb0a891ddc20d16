// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "limber/render/texture.hpp"

namespace limber {

/// A rectangle in the world that is seen from one side: corner + a u + b v with 0 <= a <= width, 0 <= b <=
/// height.
struct Wall {
  Eigen::Vector3d corner;            ///< [m]
  Eigen::Vector3d u, v;              ///< unit vectors, orthogonal; u x v points to the side that is seen
  double width = 0.0, height = 0.0;  ///< [m]
  std::size_t texture = 0;
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();  ///< of the texture [texels]
};

/// What worlds there are.
enum class SceneKind {
  kRoom,   ///< a closed room around the trajectory, with boxes standing along its walls
  kHall,   ///< a larger one, with pillars
  kStreet  ///< ground, two rows of houses with gaps, sky
};

/// @throws std::invalid_argument, whose message lists the names
[[nodiscard]] SceneKind scene_from_string(const std::string& text);

/// @brief A textured world of planes, made from a seed around where the cameras will be.
class Scene {
 public:
  /// @param free  where cameras may be: nothing stands there [m]
  Scene(SceneKind kind, const Eigen::AlignedBox3d& free, std::uint64_t seed);

  /// Where a ray from `origin` along `direction` (any length) first meets a wall [m]; nothing for the sky.
  [[nodiscard]] std::optional<Eigen::Vector3d> hit(const Eigen::Vector3d& origin,
                                                   const Eigen::Vector3d& direction) const;

  [[nodiscard]] const std::vector<Wall>& walls() const { return walls_; }
  [[nodiscard]] const std::vector<Texture>& textures() const { return textures_; }
  [[nodiscard]] double texel() const { return texel_; }  ///< [m]

 private:
  void add_wall(const Eigen::Vector3d& corner, const Eigen::Vector3d& along_u,
                const Eigen::Vector3d& along_v);
  void add_box(const Eigen::AlignedBox3d& box);
  void add_inside(const Eigen::AlignedBox3d& box);

  std::uint64_t seed_;
  double texel_ = 0.008;
  std::vector<Wall> walls_;
  std::vector<Texture> textures_;
};

}  // namespace limber
