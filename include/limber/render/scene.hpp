// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/render/texture.hpp"

namespace limber {

/// A rectangle in the world that is seen from one side: corner + a u + b v with 0 <= a <= width, 0 <= b <=
/// height.
struct Wall {
  Eigen::Vector3d corner;            ///< [m]
  Eigen::Vector3d u, v;              ///< unit vectors, orthogonal; u x v points to the side that is seen
  double width = 0.0, height = 0.0;  ///< [m]
  /// index into Scene::textures()
  std::size_t texture = 0;
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();  ///< of the texture [texels]
};

/// A box that swings to and fro past a place, and turns about the vertical.
struct MovingBox {
  Eigen::Vector3d half_size;       ///< [m]
  Eigen::Vector3d middle, swing;   ///< of its centre: middle + swing sin(angular_frequency (t - at)) [m]
  double angular_frequency = 0.0;  ///< [rad/s]
  double at = 0.0;                 ///< when it passes the middle [s]
  double yaw = 0.0;                ///< then [rad]
  double yaw_rate = 0.0;           ///< [rad/s]

  /// T_world_box at t [s] since the start of the recording.
  [[nodiscard]] Pose pose(double t) const;
};

/// What worlds there are.
enum class SceneKind {
  kRoom,   ///< a closed room around the trajectory, with boxes standing along its walls
  kHall,   ///< a larger one, with pillars
  kStreet  ///< ground, two rows of houses with gaps, sky
};

/// @throws std::invalid_argument, whose message lists the names
[[nodiscard]] SceneKind scene_from_string(const std::string& text);

/// A place on a wall of the world or of a moving box, when it was seen.
struct Place {
  Eigen::Vector3d p;               ///< in the world, at t [m]
  double t = 0.0;                  ///< [s]
  std::optional<std::size_t> box;  ///< the moving box that carries it
};

/// @brief A textured world of planes, made from a seed around where the cameras will be, and boxes that move
/// in it.
class Scene {
 public:
  /// @param free         where cameras may be: nothing stands there [m]
  /// @param low_texture  share of the area whose walls are nearly plain, 0 to 1
  Scene(SceneKind kind, const Eigen::AlignedBox3d& free, std::uint64_t seed, double low_texture = 0.0);

  /// One box more, painted from the seed.
  void add(const MovingBox& box);

  /// Where a ray from `origin` along `direction` (any length) first meets a wall at time t [s]; nothing for
  /// the sky.
  [[nodiscard]] std::optional<Place> hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                         double t = 0.0) const;

  /// Where a place is at another time [s]: in the world [m].
  [[nodiscard]] Eigen::Vector3d moved(const Place& place, double t) const;

  [[nodiscard]] const std::vector<Wall>& walls() const { return walls_; }  ///< those that stand
  /// In the order in which they were added.
  [[nodiscard]] const std::vector<MovingBox>& boxes() const { return boxes_; }
  /// Of boxes()[box], in the frame of that box.
  [[nodiscard]] const std::vector<Wall>& walls_of_box(std::size_t box) const { return box_walls_[box]; }
  /// Those that Wall::texture counts.
  [[nodiscard]] const std::vector<Texture>& textures() const { return textures_; }
  [[nodiscard]] double texel() const { return texel_; }  ///< [m]
  [[nodiscard]] bool is_plain(const Wall& wall) const;   ///< has nearly no texture

 private:
  void build_street(const Eigen::AlignedBox3d& free);
  void build_inside(bool hall, const Eigen::AlignedBox3d& free);
  [[nodiscard]] Wall painted(const Eigen::Vector3d& corner, const Eigen::Vector3d& along_u,
                             const Eigen::Vector3d& along_v, std::uint64_t number) const;
  void add_wall(const Eigen::Vector3d& corner, const Eigen::Vector3d& along_u,
                const Eigen::Vector3d& along_v);
  void add_box(const Eigen::AlignedBox3d& box);
  void add_inside(const Eigen::AlignedBox3d& box);
  void make_plain(double share);

  std::uint64_t seed_;
  double texel_ = 0.008;
  std::vector<Wall> walls_;
  std::vector<MovingBox> boxes_;
  std::vector<std::vector<Wall>> box_walls_;  ///< in the frame of each box
  std::vector<Texture> textures_;             ///< the plain ones last
};

}  // namespace limber
