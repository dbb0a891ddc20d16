// SPDX-License-Identifier: MIT
#include "render/place_boxes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "limber/core/random.hpp"

namespace limber::detail {
namespace {

using Eigen::Vector3d;

constexpr int kTries = 2000;            ///< places tried for a box
constexpr double kLookEvery = 0.05;     ///< [s]: no box moves further than its own size meanwhile
constexpr double kLeastToCamera = 0.3;  ///< [m]
constexpr double kLeastSwing = 0.4;     ///< [m]
constexpr double kFastestSwing = 2.0;   ///< [rad/s]

/// From the least to the most.
struct Range {
  double least, most;
  [[nodiscard]] double at(double share) const { return least + share * (most - least); }
};

/// What boxes are like.
struct Habit {
  Range half_size, distance, speed, swing;  ///< [m], [m], [m/s], [m]
};

Habit habit_of(SceneKind kind) {
  if (kind == SceneKind::kStreet) return {{0.5, 1.0}, {5.0, 14.0}, {2.0, 5.0}, {3.0, 10.0}};
  if (kind == SceneKind::kHall) return {{0.25, 0.6}, {2.5, 7.0}, {0.5, 1.5}, {1.0, 4.0}};
  return {{0.15, 0.4}, {1.5, 3.5}, {0.3, 1.0}, {0.5, 2.0}};
}

double distance_to_wall(const Wall& wall, const Vector3d& p) {
  const Vector3d from = p - wall.corner;
  const double a = std::clamp(wall.u.dot(from), 0.0, wall.width),
               b = std::clamp(wall.v.dot(from), 0.0, wall.height);
  return (from - a * wall.u - b * wall.v).norm();
}

/// A box which crosses the left camera's view at some instant of its part of the recording; later tries swing
/// less.
MovingBox draw(const Habit& habit, const Visit& visit, int box, int count, int attempt,
               const RandomStream& stream) {
  const auto draws = [&](std::uint32_t j) {
    return stream.uniform3(static_cast<std::uint64_t>(box * kTries + attempt), j);
  };
  const Vector3d size = draws(0), where = draws(1), how = draws(2), turn = draws(3);
  const double at = visit.duration * (box + turn.x()) / count;
  const Pose T_world_cam = visit.cameras(at)[0];
  MovingBox made;
  made.half_size = size.unaryExpr([&](double share) { return habit.half_size.at(share); });
  made.middle = T_world_cam *
                (habit.distance.at(where.z()) * Vector3d(0.8 * where.x() - 0.4, 0.5 * where.y() - 0.25, 1.0));
  const double direction = 2.0 * M_PI * how.x();
  const double length =
      std::max(kLeastSwing, habit.swing.at(how.y()) * (1.0 - static_cast<double>(attempt) / kTries));
  made.swing = length * Vector3d(std::cos(direction), std::sin(direction), 0.1);
  made.angular_frequency = std::min(kFastestSwing, habit.speed.at(how.z()) / length);
  made.at = at;
  made.yaw = 2.0 * M_PI * turn.y();
  made.yaw_rate = turn.z() - 0.5;
  return made;
}

/// Whether a box touches nothing, at any time, and shows itself when it passes its middle.
bool fits(const MovingBox& box, const Scene& scene, const Visit& visit) {
  const double radius = box.half_size.norm();
  const Vector3d eye = visit.cameras(box.at)[0].p;
  const auto wall = scene.hit(eye, box.middle - eye, box.at);
  if (wall && (wall->p - eye).norm() < (box.middle - eye).norm()) return false;
  for (double t = 0.0; t <= visit.duration; t += kLookEvery) {
    const Vector3d p = box.pose(t).p;
    for (const Pose& camera : visit.cameras(t)) {
      if ((camera.p - p).norm() < radius + kLeastToCamera) return false;
    }
    for (const MovingBox& other : scene.boxes()) {
      if ((other.pose(t).p - p).norm() < radius + other.half_size.norm()) return false;
    }
    for (const Wall& near : scene.walls()) {
      if (distance_to_wall(near, p) < radius) return false;
    }
  }
  return true;
}

}  // namespace

void add_moving_boxes(Scene& scene, SceneKind kind, int count, const Visit& visit, std::uint64_t seed,
                      std::uint64_t run) {
  const RandomStream stream(seed, run, "moving boxes");
  const Habit habit = habit_of(kind);
  for (int box = 0; box < count; ++box) {
    bool placed = false;
    for (int attempt = 0; attempt < kTries && !placed; ++attempt) {
      const MovingBox made = draw(habit, visit, box, count, attempt, stream);
      placed = fits(made, scene, visit);
      if (placed) scene.add(made);
    }
    if (!placed) {
      throw std::invalid_argument(
          fmt::format("expected room for {} moving objects, found it for {}", count, box));
    }
  }
}

}  // namespace limber::detail
