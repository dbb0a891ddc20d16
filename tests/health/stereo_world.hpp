// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <functional>
#include <random>
#include <unordered_map>
#include <utility>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

/// A rig of EuRoC's size that flies along a wall of points, seen without any filter.
namespace limber::testing {

struct WorldOptions {
  double speed = 1.0;         ///< to the right [m/s]
  double white_px = 0.3;      ///< of every pixel of a frame
  double per_track_px = 0.0;  ///< one draw a track, of its right pixel
  double wandering_px = 0.0;  ///< of its left pixel: 0.93 of it stays from frame to frame
  double per_cell_px = 0.0;   ///< one draw a place of the right image (150 x 120 px)
  double mismatches = 0.0;    ///< share of right pixels that are anywhere within 40 px
  std::size_t points = 60;    ///< of a frame
  double seconds = 10.0;
  unsigned seed = 1;
  bool above = false;                          ///< cam1 stands below cam0, in place of beside it
  std::function<RigParameters(double)> error;  ///< of theta, true minus assumed, over time [s]
};

inline StereoCalibration world_calibration() {
  StereoCalibration out;
  out.cam0 = out.cam1 = Camera{458.0, 458.0, 376.0, 240.0, 752, 480, NoDistortion{}};
  out.theta << 0.01, -0.02, 0.005, -0.11, 0.001, 0.002;
  out.body = BodyFrame::kCam0;
  return out;
}

struct World {
  StereoCalibration assumed = world_calibration();
  std::vector<StereoFrame> frames;
  std::vector<Pose> poses;  ///< T_world_cam0
};

inline World fly_past(const WorldOptions& options) {
  constexpr double kRate = 20.0;
  World out;
  if (options.above) {
    out.assumed.theta.tail<3>() << 0.001, -0.11, 0.002;
  }
  std::mt19937 random(options.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  struct Point {
    Eigen::Vector3d at;
    Eigen::Vector2d own, wandering;
  };
  std::unordered_map<std::int64_t, Point> points;
  std::unordered_map<int, Eigen::Vector2d> cells;
  const auto draw = [&](double sigma) {
    return Eigen::Vector2d(sigma * normal(random), sigma * normal(random));
  };
  std::int64_t next = 0;
  for (int n = 0; n < static_cast<int>(options.seconds * kRate); ++n) {
    const double t = n / kRate;
    Pose T_world_cam0;
    T_world_cam0.p = Eigen::Vector3d(options.speed * t, 0.1 * options.speed * std::sin(2.0 * t), 0.0);
    StereoCalibration truth = out.assumed;
    truth.theta += options.error ? options.error(t) : RigParameters(RigParameters::Zero());
    const Pose rig = pose_from_rig(truth.theta);
    StereoFrame frame{static_cast<std::int64_t>(n) * 50'000'000 + 1'000'000'000, {}};
    for (int tries = 0; frame.observations.size() < options.points && tries < 4000; ++tries) {
      auto known = points.begin();
      std::int64_t id = next;
      if (tries == 0) {  // those that are still in view
        for (auto it = points.begin(); it != points.end();) {
          const Eigen::Vector3d X = it->second.at - T_world_cam0.p;
          it = project(truth.cam0, X) && in_image(truth.cam0, project(truth.cam0, X)->uv, 5.0)
                   ? std::next(it)
                   : points.erase(it);
        }
        while (points.size() < options.points) {
          const double z = 2.0 + 10.0 * uniform(random);
          const Eigen::Vector3d ray((752.0 * uniform(random) - 376.0) / 458.0,
                                    (480.0 * uniform(random) - 240.0) / 458.0, 1.0);
          points[next++] = {T_world_cam0.p + z * ray, draw(options.per_track_px), Eigen::Vector2d::Zero()};
        }
      }
      if (static_cast<std::size_t>(tries) >= points.size()) {
        break;
      }
      known = std::next(points.begin(), tries);
      id = known->first;
      const Eigen::Vector3d X = known->second.at - T_world_cam0.p;
      const auto left = project(truth.cam0, X), right = project(truth.cam1, rig * X);
      if (!left || !right || !in_image(truth.cam0, left->uv, 0.0) || !in_image(truth.cam1, right->uv, 0.0)) {
        continue;
      }
      const int cell =
          static_cast<int>(right->uv.x() / 150.0) + 100 * static_cast<int>(right->uv.y() / 120.0);
      const auto lens = cells.try_emplace(cell, draw(options.per_cell_px)).first->second;
      if (options.wandering_px > 0.0) {
        constexpr double kStays = 0.93;
        known->second.wandering =
            kStays * known->second.wandering + draw(std::sqrt(1.0 - kStays * kStays) * options.wandering_px);
      }
      StereoObservation o{id, left->uv + draw(options.white_px) + known->second.wandering,
                          right->uv + draw(options.white_px) + known->second.own + lens};
      if (uniform(random) < options.mismatches) {
        o.uv_cam1 += 40.0 * Eigen::Vector2d(uniform(random) - 0.5, uniform(random) - 0.5);
      }
      frame.observations.push_back(o);
    }
    out.frames.push_back(std::move(frame));
    out.poses.push_back(T_world_cam0);
  }
  return out;
}

}  // namespace limber::testing
