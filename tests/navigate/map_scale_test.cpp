// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "check_covariance.hpp"
#include "limber/core/median.hpp"
#include "limber/core/so3.hpp"
#include "limber/measure/triangulate.hpp"
#include "limber/navigate/stereo_filter.hpp"
#include "random_geometry.hpp"
#include "scene.hpp"

/// A filter that distrusts its rig, or has one camera, learns how long a metre is from accelerations alone.
/// Where there are none, what it knows of the scale must stay what it was, however often it linearises.
namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using testing::Generator;

constexpr std::int64_t kInputNs = 5'000'000, kFrameNs = 50'000'000;
constexpr double kGravity = 9.81;

constexpr double kSwingRate = 0.6;  // [rad/s]

/// A way at a constant velocity [m/s] and rate [rad/s], without acceleration but for a slow swing [m].
struct Way {
  Vector3d v;
  double yaw_rate = 0.0;
  Vector3d swing = Vector3d::Zero();

  [[nodiscard]] Vector3d place(double t) const { return v * t + swing * std::sin(kSwingRate * t); }
  [[nodiscard]] Vector3d velocity(double t) const {
    return v + kSwingRate * std::cos(kSwingRate * t) * swing;
  }
  [[nodiscard]] Vector3d acceleration(double t) const {
    return -kSwingRate * kSwingRate * std::sin(kSwingRate * t) * swing;
  }
};

struct Pixels {
  std::int64_t t_ns;
  Pose T_world_body;
};

/// Points in a wide tube about the way, in every direction, each seen at 3 to 30 m.
class World {
 public:
  World(std::uint64_t seed, const Way& way, double duration_s) : generator_(seed) {
    const Vector3d end = way.v * duration_s;
    for (int k = 0; k < 900; ++k) {
      const Vector3d ahead = testing::random_scalar(generator_, -0.2, 1.2) * end;
      points_.push_back(ahead + Vector3d(testing::random_vector(generator_, 20.0)));
    }
  }

  StereoFrame seen(std::int64_t t_ns, const Pose& T_world_body, const StereoCalibration& rig) {
    StereoFrame frame;
    frame.t_ns = t_ns;
    const MountedRig mounted = mount(rig);
    for (std::size_t id = 0; id < points_.size() && frame.observations.size() < 50; ++id) {
      Landmark landmark;
      landmark.kind = LandmarkKind::kCartesian;
      landmark.value = points_[id];
      StereoObservation o;
      o.track_id = static_cast<std::int64_t>(id);
      const BodyPoint point = body_point(T_world_body, landmark, nullptr);
      const auto left = project_point(mounted[0], point), right = project_point(mounted[1], point);
      const auto inside = [](const Camera& camera, const Eigen::Vector2d& uv) {
        return uv.x() > 0 && uv.y() > 0 && uv.x() < camera.width && uv.y() < camera.height;
      };
      const double distance = (points_[id] - T_world_body.p).norm();
      if (!left || !right || distance < 3.0 || distance > 30.0 || !inside(rig.cam0, left->uv) ||
          !inside(rig.cam1, right->uv)) {
        continue;
      }
      o.uv_cam0 = left->uv + 0.5 * testing::random_normal(generator_, 2);
      o.uv_cam1 = right->uv + 0.5 * testing::random_normal(generator_, 2);
      frame.observations.push_back(o);
    }
    return frame;
  }

  [[nodiscard]] const Vector3d& place(std::int64_t id) const { return points_[static_cast<std::size_t>(id)]; }

  Vector3d noise(double sigma) { return sigma * testing::random_normal(generator_, 3); }

 private:
  Generator generator_;
  std::vector<Vector3d> points_;
};

/// A first map of what the first frame shows: depths of its own to 5 %, and all of them and the velocity to
/// `share`, by which they are wrong.
void give_map(InitialState& initial, const StereoFrame& frame, const StereoCalibration& rig, double share) {
  const auto n = static_cast<Eigen::Index>(frame.observations.size());
  Eigen::VectorXd of_map = Eigen::VectorXd::Zero(3 * n), own = Eigen::VectorXd::Zero(3 * n);
  const MountedRig mounted = mount(rig);
  for (Eigen::Index k = 0; k < n; ++k) {
    const StereoObservation& o = frame.observations[static_cast<std::size_t>(k)];
    Landmark landmark;
    landmark.track_id = o.track_id;
    const Vector3d d0 = *unproject(rig.cam0, o.uv_cam0), d1 = *unproject(rig.cam1, o.uv_cam1);
    landmark.R_cam0_chart.col(2) = d0;
    landmark.R_cam0_chart.col(0) = d0.unitOrthogonal();
    landmark.R_cam0_chart.col(1) = d0.cross(landmark.R_cam0_chart.col(0));
    const double rho =
        inverse_depth_along(d0, d1, mounted[1].T_cam_body * mounted[0].T_cam_body.inverse()).value_or(1e-3);
    landmark.value << 0.0, 0.0, std::max(rho, 1e-2) / (1.0 + share);
    of_map(3 * k + 2) = -share * landmark.value.z();
    own.segment<3>(3 * k) << 1e-6, 1e-6, std::pow(0.05 * landmark.value.z(), 2) + 1e-5;
    initial.landmarks.push_back(landmark);
  }
  Eigen::VectorXd of_body = Eigen::VectorXd::Zero(initial.body_covariance.rows());
  of_body.segment<3>(StateLayout::kVelocity) = share / (1.0 + share) * initial.nav.v_world_body;
  initial.body_covariance.diagonal().segment<3>(StateLayout::kVelocity).setConstant(1e-4);
  initial.body_covariance += of_body * of_body.transpose();
  initial.landmarks_covariance = MatrixXd(own.asDiagonal()) + of_map * of_map.transpose();
  initial.landmarks_body = of_map * of_body.transpose();
}

/// What the best known depth says of the scale, at the end [-]; beside it, the velocity's. How much too long
/// the velocity is, and the usual depth.
struct Known {
  double of_map = 1e9, of_velocity = 1e9, off = 0.0, depths_off = 0.0;
};

Known fly(std::uint64_t seed, const Way& way, Method method, double duration_s) {
  const StereoCalibration rig = testing::scene_rig();
  NavigatorOptions options;
  options.method = method;
  options.health.reset();
  options.imu_noise = {1e-3, 1e-5, 1e-2, 1e-4};
  World world(seed, way, duration_s);
  InitialSigma sigma;
  sigma.attitude = 1e-3;
  sigma.velocity = 0.01;
  NavigationState truth;
  truth.v_world_body = way.velocity(0.0);
  InitialState initial = make_initial_state(truth, options.motion, sigma);
  const double share = truth.v_world_body.norm() > 0.0 ? 0.1 : 0.5;
  initial.nav.v_world_body *= 1.0 + share;  // one sigma off, and the map with it
  give_map(initial, world.seen(0, {}, rig), rig, share);
  StereoFilter filter(options, rig, initial);
  for (std::int64_t t_ns = 0; 1e-9 * static_cast<double>(t_ns) <= duration_s; t_ns += kInputNs) {
    const double t = 1e-9 * static_cast<double>(t_ns);
    const Pose T{so3_exp(Vector3d(0.0, 0.0, way.yaw_rate * t)), way.place(t)};
    const double per_sample = 1.0 / std::sqrt(1e-9 * static_cast<double>(kInputNs));
    filter.add_imu({t_ns, Vector3d(0.0, 0.0, way.yaw_rate) + world.noise(1e-3 * per_sample),
                    T.R.transpose() * (way.acceleration(t) + Vector3d(0.0, 0.0, kGravity)) +
                        world.noise(1e-2 * per_sample)});
    if (t_ns > 0 && t_ns % kFrameNs == 0) {
      (void)filter.process(world.seen(t_ns, T, rig));
    }
  }
  const Estimate& estimate = filter.estimate();
  Known out;
  std::vector<double> longer;
  for (const Landmark& landmark : estimate.landmarks()) {
    if (!landmark.passive && landmark.kind == LandmarkKind::kInverseDepth && landmark.value.z() > 0.0) {
      const double of_depth =
          std::sqrt(estimate.P().diagonal_block<3>(landmark.at)(2, 2)) / landmark.value.z();
      out.of_map = std::min(out.of_map, of_depth);
      longer.push_back((estimate.landmark_position(landmark) - estimate.nav().T_world_body.p).norm() /
                       (world.place(landmark.track_id) - way.place(duration_s)).norm());
    }
  }
  out.depths_off = upper_median(std::move(longer)) - 1.0;
  const Vector3d v = estimate.nav().v_world_body;
  const double speed = way.velocity(duration_s).norm();
  if (speed > 0.0) {
    const Vector3d along = v.normalized();
    out.of_velocity =
        std::sqrt(along.dot(estimate.P().diagonal_block<3>(StateLayout::kVelocity) * along)) / v.norm();
    out.off = v.norm() / speed - 1.0;
  }
  return out;
}

// 9.1 % at the start, 7.5 to 7.7 % after ten seconds, and lengths 8 to 17 % too long, which were 10 % at the
// start. Where the accelerometer's noise is learned from it is 7.0 to 7.2 %, and 20 to 27 %; where the
// covariance is not carried along 0.9 to 1.1 %.
void expect_vague_at_constant_velocity(std::initializer_list<std::uint64_t> seeds) {
  for (const Method method : {Method::kLcekf, Method::kMonoLeft}) {
    for (const std::uint64_t seed : seeds) {
      const Known known = fly(seed, {{3.0, 0.5, 0.0}}, method, 10.0);
      EXPECT_GE(known.of_velocity, 0.073) << to_string(method) << ", seed " << seed;
      EXPECT_LE(std::abs(known.off), 0.2) << to_string(method) << ", seed " << seed;
    }
  }
}

TEST(MapScale, StaysVagueAtConstantVelocity) { expect_vague_at_constant_velocity({1}); }

TEST(FullMapScale, StaysVagueAtConstantVelocity) { expect_vague_at_constant_velocity({2, 3}); }

// 35 % at the start, 35 % at rest and 22 to 24 % in rotation after ten seconds; where the accelerometer's
// noise is learned from 19 to 24 % and 14 to 15 %, else 3.2 to 4.8 %.
void expect_vague_in_place(std::initializer_list<std::uint64_t> seeds) {
  for (const double yaw_rate : {0.0, 0.3}) {
    for (const std::uint64_t seed : seeds) {
      const Known known = fly(seed, {Vector3d::Zero(), yaw_rate}, Method::kLcekf, 10.0);
      EXPECT_GE(known.of_map, yaw_rate > 0.0 ? 0.2 : 0.3) << "rate " << yaw_rate << ", seed " << seed;
    }
  }
}

// Of what it gains over half a second the accelerometer's noise is three times as much as the body. Where
// that is learned from, depths 10 % too long are 38 to 69 % too long after half a minute, and known to 6 %.
TEST(MapScale, OfABodyThatCreepsDoesNotDrift) {
  for (const std::uint64_t seed : {1, 2}) {
    const Known known = fly(seed, {Vector3d::Zero(), 0.0, {0.07, 0.0, 0.0}}, Method::kLcekf, 30.0);
    EXPECT_NEAR(known.depths_off, 0.1, 0.03) << "seed " << seed;
    EXPECT_GE(known.of_map, 0.09) << "seed " << seed;
  }
}

TEST(MapScale, StaysVagueAtRestAndInRotation) { expect_vague_in_place({1}); }

TEST(FullMapScale, StaysVagueAtRestAndInRotation) { expect_vague_in_place({2, 3}); }

}  // namespace
}  // namespace limber
