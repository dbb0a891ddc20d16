// SPDX-License-Identifier: MIT
#include "limber/render/scene.hpp"

#include <limits>
#include <stdexcept>

#include "limber/core/random.hpp"

namespace limber {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr std::size_t kTextures = 3;

AlignedBox3d grown(const AlignedBox3d& box, const Vector3d& by) { return {box.min() - by, box.max() + by}; }

}  // namespace

SceneKind scene_from_string(const std::string& text) {
  if (text == "room") return SceneKind::kRoom;
  if (text == "hall") return SceneKind::kHall;
  if (text == "street") return SceneKind::kStreet;
  throw std::invalid_argument("expected room, hall or street, found '" + text + "'");
}

void Scene::add_wall(const Vector3d& corner, const Vector3d& along_u, const Vector3d& along_v) {
  const RandomStream stream(seed_, 0, "walls");
  const Vector3d draw = stream.uniform3(walls_.size());
  walls_.push_back({corner, along_u.normalized(), along_v.normalized(), along_u.norm(), along_v.norm(),
                    static_cast<std::size_t>(draw.x() * kTextures), Texture::kSide * draw.tail<2>()});
}

/// Six faces seen from outside.
void Scene::add_box(const AlignedBox3d& box) {
  const Vector3d s = box.sizes();
  const Vector3d x(s.x(), 0, 0), y(0, s.y(), 0), z(0, 0, s.z());
  add_wall(box.min(), z, y);
  add_wall(box.min() + x, y, z);
  add_wall(box.min(), x, z);
  add_wall(box.min() + y, z, x);
  add_wall(box.min(), y, x);
  add_wall(box.min() + z, x, y);
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

Scene::Scene(SceneKind kind, const AlignedBox3d& free, std::uint64_t seed) : seed_(seed) {
  const RandomStream stream(seed, 0, "scene");
  for (std::uint64_t k = 0; k < kTextures; ++k) textures_.emplace_back(kTextures * seed + k);
  if (kind == SceneKind::kStreet) {
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
    return;
  }
  const bool hall = kind == SceneKind::kHall;
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

std::optional<Vector3d> Scene::hit(const Vector3d& origin, const Vector3d& direction) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Wall& wall : walls_) {
    const Vector3d normal = wall.u.cross(wall.v);
    const double towards = normal.dot(direction);
    if (towards >= 0.0) continue;
    const double t = normal.dot(wall.corner - origin) / towards;
    const Vector3d at = origin + t * direction - wall.corner;
    const double a = wall.u.dot(at), b = wall.v.dot(at);
    if (t > 0.0 && t < nearest && a >= 0.0 && b >= 0.0 && a <= wall.width && b <= wall.height) nearest = t;
  }
  return nearest < std::numeric_limits<double>::infinity()
             ? std::optional<Vector3d>(origin + nearest * direction)
             : std::nullopt;
}

}  // namespace limber
