// SPDX-License-Identifier: MIT
#include "limber/render/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "limber/core/nearest_word.hpp"
#include "limber/core/random.hpp"

namespace limber {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr std::size_t kTextures = 3;
constexpr std::uint64_t kFirstOfBoxes = 1'000'000;  ///< walls of moving boxes are numbered from here
constexpr float kPlainContrast = 0.03f;             ///< a standard deviation of about one grey level

AlignedBox3d grown(const AlignedBox3d& box, const Vector3d& by) { return {box.min() - by, box.max() + by}; }

/// A corner of a rectangle and two of its sides.
using Face = std::array<Vector3d, 3>;

/// Six faces seen from outside.
std::array<Face, 6> faces_of(const AlignedBox3d& box) {
  const Vector3d s = box.sizes();
  const Vector3d x(s.x(), 0, 0), y(0, s.y(), 0), z(0, 0, s.z());
  return {Face{box.min(), z, y},     Face{box.min() + x, y, z}, Face{box.min(), x, z},
          Face{box.min() + y, z, x}, Face{box.min(), y, x},     Face{box.min() + z, x, y}};
}

/// How many lengths of `direction` away a ray meets one of the walls; infinity if none.
double distance_to(const std::vector<Wall>& walls, const Vector3d& origin, const Vector3d& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Wall& wall : walls) {
    const Vector3d normal = wall.u.cross(wall.v);
    const double towards = normal.dot(direction);
    if (towards >= 0.0) continue;
    const double t = normal.dot(wall.corner - origin) / towards;
    const Vector3d at = origin + t * direction - wall.corner;
    const double a = wall.u.dot(at), b = wall.v.dot(at);
    if (t > 0.0 && t < nearest && a >= 0.0 && b >= 0.0 && a <= wall.width && b <= wall.height) nearest = t;
  }
  return nearest;
}

}  // namespace

SceneKind scene_from_string(const std::string& text) {
  const std::string word = in_lower_case(text);
  if (word == "room") return SceneKind::kRoom;
  if (word == "hall") return SceneKind::kHall;
  if (word == "street") return SceneKind::kStreet;
  throw std::invalid_argument("expected room, hall or street, found '" + text + "'");
}

Pose MovingBox::pose(double t) const {
  return {Eigen::AngleAxisd(yaw + yaw_rate * (t - at), Vector3d::UnitZ()).toRotationMatrix(),
          middle + swing * std::sin(angular_frequency * (t - at))};
}

Wall Scene::painted(const Vector3d& corner, const Vector3d& along_u, const Vector3d& along_v,
                    std::uint64_t number) const {
  const RandomStream stream(seed_, 0, "walls");
  const Vector3d draw = stream.uniform3(number);
  return {corner,
          along_u.normalized(),
          along_v.normalized(),
          along_u.norm(),
          along_v.norm(),
          static_cast<std::size_t>(draw.x() * kTextures),
          Texture::kSide * draw.tail<2>()};
}

void Scene::add_wall(const Vector3d& corner, const Vector3d& along_u, const Vector3d& along_v) {
  walls_.push_back(painted(corner, along_u, along_v, walls_.size()));
}

void Scene::add_box(const AlignedBox3d& box) {
  for (const auto& [corner, along_u, along_v] : faces_of(box)) add_wall(corner, along_u, along_v);
}

void Scene::add(const MovingBox& box) {
  std::uint64_t number = kFirstOfBoxes + 6 * boxes_.size();
  std::vector<Wall> walls;
  for (const auto& [corner, along_u, along_v] : faces_of({-box.half_size, box.half_size})) {
    walls.push_back(painted(corner, along_u, along_v, number++));
  }
  boxes_.push_back(box);
  box_walls_.push_back(std::move(walls));
}

/// Six faces seen from inside.
void Scene::add_inside(const AlignedBox3d& box) {
  const Vector3d s = box.sizes();
  const Vector3d x(s.x(), 0, 0), y(0, s.y(), 0), z(0, 0, s.z());
  add_wall(box.min(), y, z);
  add_wall(box.min() + x, z, y);
  add_wall(box.min(), z, x);
  add_wall(box.min() + y, x, z);
  add_wall(box.min(), x, y);
  add_wall(box.min() + z, y, x);
}

Scene::Scene(SceneKind kind, const AlignedBox3d& free, std::uint64_t seed, double low_texture) : seed_(seed) {
  for (std::uint64_t k = 0; k < kTextures; ++k) textures_.emplace_back(kTextures * seed + k);
  if (kind == SceneKind::kStreet) {
    build_street(free);
  } else {
    build_inside(kind == SceneKind::kHall, free);
  }
  if (low_texture > 0.0) make_plain(low_texture);
}

void Scene::build_street(const AlignedBox3d& free) {
  const RandomStream stream(seed_, 0, "scene");
  texel_ = 0.02;
  const AlignedBox3d street = grown(free, Vector3d(30.0, 4.0, 1.5));
  const Vector3d low = street.min();
  const double length = street.sizes().x(), width = street.sizes().y();
  add_wall(low - Vector3d(20, 40, 0), Vector3d(length + 40, 0, 0), Vector3d(0, width + 80, 0));
  std::uint64_t k = 0;
  for (double at = low.x(); at < street.max().x(); ++k) {
    const Vector3d left = stream.uniform3(k, 0), right = stream.uniform3(k, 1);
    const double front = 6.0 + 8.0 * left.x(), gap = 3.0 * right.x();
    add_box({Vector3d(at, low.y() - 12, low.z()),
             Vector3d(at + front, low.y() - 2.0 * left.y(), low.z() + 6 + 8 * left.z())});
    add_box({Vector3d(at, street.max().y() + 2.0 * right.y(), low.z()),
             Vector3d(at + front, street.max().y() + 12, low.z() + 6 + 8 * right.z())});
    at += front + gap;
  }
}

void Scene::build_inside(bool hall, const AlignedBox3d& free) {
  const RandomStream stream(seed_, 0, "scene");
  const AlignedBox3d space = grown(free, hall ? Vector3d(9.0, 9.0, 3.0) : Vector3d(3.0, 3.0, 1.5));
  add_inside(space);
  const int things = hall ? 12 : 8;
  for (int k = 0; k < things; ++k) {
    // Between the free space and the walls, all around.
    const Vector3d draw = stream.uniform3(static_cast<std::uint64_t>(k)),
                   size = stream.uniform3(static_cast<std::uint64_t>(k), 1);
    const double reach = hall ? 8.0 : 2.5;
    const Vector3d half = hall ? Vector3d(0.3 + 0.3 * size.x(), 0.3 + 0.3 * size.y(), 0.0)
                               : Vector3d(0.3 + 0.4 * size.x(), 0.3 + 0.4 * size.y(), 0.0);
    const double height = hall ? space.sizes().z() : (0.3 + 0.6 * size.z()) * space.sizes().z();
    const int side = k % 4;
    Vector3d centre = space.min() + draw.cwiseProduct(space.sizes());
    const int axis = side / 2;
    const double out = half[axis] + (reach - 2.0 * half[axis]) * draw.z() + 0.2;
    centre[axis] = side % 2 == 0 ? free.min()[axis] - out : free.max()[axis] + out;
    centre.z() = space.min().z();
    add_box({centre - half, centre + half + Vector3d(0, 0, height)});
  }
}

/// Walls in a drawn order, each if it brings their area nearer to the share.
void Scene::make_plain(double share) {
  const RandomStream stream(seed_, 0, "plain walls");
  for (std::size_t k = 0; k < kTextures; ++k) {
    textures_.push_back(textures_[k].faded(kPlainContrast, 96.0f + 32.0f * static_cast<float>(k)));
  }
  std::vector<std::size_t> order(walls_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return stream.uniform(a) < stream.uniform(b); });
  double left = 0.0;
  for (const Wall& wall : walls_) left += share * wall.width * wall.height;
  for (const std::size_t k : order) {
    const double area = walls_[k].width * walls_[k].height;
    if (std::abs(left - area) > std::abs(left)) continue;
    left -= area;
    walls_[k].texture += kTextures;
  }
}

bool Scene::is_plain(const Wall& wall) const { return wall.texture >= kTextures; }

std::optional<Place> Scene::hit(const Vector3d& origin, const Vector3d& direction, double t) const {
  double nearest = distance_to(walls_, origin, direction);
  std::optional<std::size_t> in_front;
  for (std::size_t k = 0; k < boxes_.size(); ++k) {
    const Pose T_box_world = boxes_[k].pose(t).inverse();
    const double distance = distance_to(box_walls_[k], T_box_world * origin, T_box_world.R * direction);
    if (distance >= nearest) continue;
    nearest = distance;
    in_front = k;
  }
  if (!std::isfinite(nearest)) return std::nullopt;
  return Place{origin + nearest * direction, t, in_front};
}

Vector3d Scene::moved(const Place& place, double t) const {
  if (!place.box) return place.p;
  const MovingBox& box = boxes_[*place.box];
  return box.pose(t) * (box.pose(place.t).inverse() * place.p);
}

}  // namespace limber
