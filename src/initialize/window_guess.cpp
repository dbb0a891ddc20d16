// SPDX-License-Identifier: MIT
#include "window_guess.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "limber/core/factors.hpp"
#include "limber/core/median.hpp"
#include "limber/core/so3.hpp"
#include "limber/core/time.hpp"
#include "limber/initialize/stereo_motion.hpp"
#include "limber/measure/triangulate.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix36 = Eigen::Matrix<double, 3, 6>;

constexpr std::size_t kMostPoints = 250;
constexpr std::size_t kFewestOfFrame = 8;
constexpr double kFarthestBaselines = 300.0;  // beyond, the rig's disparity says nothing
constexpr double kNearest = 0.3;              // [m]
constexpr double kSomeAcceleration = 2.0;     // [m/s^2], of the body, mean over the window
constexpr double kSomeSpeed = 10.0;           // [m/s]
constexpr double kBearingNoise = 0.01;        // [rad], of bearings and turned gyro, roughly
constexpr int kReweightings = 3;

/// The longest tracks, but of every frame as many as there can be: where all tracks end at once, those of one
/// side alone would leave the frames of the other without any. A frame is promised twice as many from round
/// to round.
std::vector<WindowPoint> longest_of_every_frame(std::vector<WindowPoint> points, std::size_t frames) {
  std::ranges::stable_sort(
      points, [](const WindowPoint& a, const WindowPoint& b) { return a.seen.size() > b.seen.size(); });
  std::vector<std::size_t> of_frame(frames, 0);
  std::vector<WindowPoint> out;
  for (std::size_t promised = kFewestOfFrame; !points.empty(); promised *= 2) {
    std::vector<WindowPoint> later;
    for (WindowPoint& point : points) {
      const bool wanted = std::ranges::any_of(
          point.seen, [&](const WindowSighting& sighting) { return of_frame[sighting.frame] < promised; });
      if (!wanted) {
        later.push_back(std::move(point));
        continue;
      }
      for (const WindowSighting& sighting : point.seen) {
        ++of_frame[sighting.frame];
      }
      out.push_back(std::move(point));
      if (out.size() == kMostPoints) {
        return out;
      }
    }
    points = std::move(later);
  }
  return out;
}

/// States that the inputs alone give from the first one on.
void integrate(const WindowModel& model, std::vector<WindowFrame>& frames) {
  for (std::size_t k = 1; k < frames.size(); ++k) {
    frames[k].nav = frames[k - 1].nav;
    (void)predict_over(model.options, frames[k], frames[k].nav);
  }
}

/// The same without gravity, from rest at the origin: what is known before velocity and tilt are.
std::vector<WindowFrame> weightless(WindowModel model, std::vector<WindowFrame> frames,
                                    const Vector3d& bias_gyro) {
  model.options.gravity = 0.0;
  const std::int64_t begin_ns = frames.front().nav.t_ns;
  frames.front().nav = NavigationState{};
  frames.front().nav.t_ns = begin_ns;
  frames.front().nav.bias_gyro = bias_gyro;
  integrate(model, frames);
  return frames;
}

/// Mean specific force in the first body frame: points up where the body does not gain speed.
Vector3d mean_force(const std::vector<WindowFrame>& fall) {
  const double T = seconds_between(fall.front().nav.t_ns, fall.back().nav.t_ns);
  return T > 0.0 ? Vector3d(fall.back().nav.v_world_body / T) : Vector3d::UnitZ();
}

struct VelocityAndForce {
  Vector3d v;   // of the body at the first frame, in its body frame [m/s]
  Vector3d up;  // minus gravity, there [m/s^2]
};

/// Normal equations of v and gravity, depths eliminated: every later bearing of a point is parallel to the
/// line from where the camera is by then to where the point is.
struct Rays {
  Matrix6d A = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
};

/// @param depth  of the point from its anchor [m], for the weights; if `known`, for good
void add_rays(const MountedRig& rig, const std::vector<WindowFrame>& fall, const WindowPoint& point,
              double depth, bool known, Rays& rays) {
  const Pose T_body_cam0 = rig[0].T_cam_body.inverse();
  const auto camera = [&](std::size_t k) { return fall[k].nav.T_world_body * T_body_cam0; };
  const auto time = [&](std::size_t k) { return seconds_between(fall.front().nav.t_ns, fall[k].nav.t_ns); };
  const Pose anchor = camera(point.anchor());
  const double ta = time(point.anchor());
  const Vector3d ray = anchor.R * point.landmark.R_cam0_chart.col(2);
  Matrix6d A = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero(), c = Vector6d::Zero();  // c: cross term with the depth
  double dd = 0.0, db = 0.0;
  for (const WindowSighting& sighting : point.seen) {
    const std::optional<Vector3d> bearing = unproject(rig[0].camera, sighting.observation.uv_cam0);
    if (!sighting.observation.in_cam0 || !bearing || sighting.frame == point.anchor()) {
      continue;
    }
    const Pose now = camera(sighting.frame);
    const double t = time(sighting.frame);
    const Matrix3d cross = skew(now.R * *bearing) / (depth * kBearingNoise);
    Matrix36 J;
    J << cross * (ta - t), cross * (0.5 * (ta * ta - t * t));
    const Vector3d of_depth = cross * ray;
    const Vector3d r = -cross * (anchor.p - now.p) - (known ? Vector3d(of_depth * depth) : Vector3d::Zero());
    A += J.transpose() * J;
    b += J.transpose() * r;
    c += J.transpose() * of_depth;
    dd += of_depth.squaredNorm();
    db += of_depth.dot(r);
  }
  if (!known && dd > 0.0) {
    A -= c * c.transpose() / dd;
    b -= c * (db / dd);
  }
  rays.A += A;
  rays.b += b;
}

VelocityAndForce solve_rays(const WindowModel& model, const std::vector<WindowFrame>& fall,
                            const std::vector<WindowPoint>& points, bool depths_known) {
  const MountedRig rig = mount(model.calibration);
  Rays rays;
  const Vector3d gravity = -mean_force(fall).normalized() * model.options.gravity;
  rays.A.diagonal() << Vector3d::Constant(1.0 / (kSomeSpeed * kSomeSpeed)),
      Vector3d::Constant(1.0 / (kSomeAcceleration * kSomeAcceleration));
  rays.b.tail<3>() = gravity / (kSomeAcceleration * kSomeAcceleration);
  for (const WindowPoint& point : points) {
    const double rho = point.landmark.value.z();
    if (rho > 0.0 || !depths_known) {
      add_rays(rig, fall, point, 1.0 / (rho > 0.0 ? rho : kSomeInverseDepth), depths_known, rays);
    }
  }
  const Vector6d x = solve_symmetric(rays.A, rays.b);
  return {x.head<3>(), -x.tail<3>()};
}

void depths_of_all(const WindowModel& model, WindowState& state) {
  for (WindowPoint& point : state.points) {
    point.landmark.value.z() = 0.0;
  }
  fill_depths_from_motion(model, state);
}
void set_first(const WindowModel& model, const VelocityAndForce& start, const Vector3d& bias_gyro,
               WindowState& state) {
  NavigationState& first = state.frames.front().nav;
  first.T_world_body = {level_attitude(model, start.up), Vector3d::Zero()};
  first.v_world_body = first.T_world_body.R * start.v;
  first.bias_gyro = bias_gyro;
  first.bias_accel.setZero();
  integrate(model, state.frames);
}

/// Median of the inverse depths that the rig shows.
double usual_inverse_depth(const std::vector<WindowPoint>& points) {
  std::vector<double> rho;
  for (const WindowPoint& point : points) {
    if (point.landmark.value.z() > 0.0) {
      rho.push_back(point.landmark.value.z());
    }
  }
  if (rho.empty()) {
    return kSomeInverseDepth;
  }
  return upper_median(std::move(rho));
}

void fill_depths(std::vector<WindowPoint>& points) {
  const double usual = usual_inverse_depth(points);
  for (WindowPoint& point : points) {
    if (point.landmark.value.z() <= 0.0) {
      point.landmark.value.z() = usual;
    }
  }
}

/// Gyro bias that makes the integrated turn agree with the stereo motion's, first order.
Vector3d gyro_bias_from(const WindowModel& model, const std::vector<WindowFrame>& frames,
                        const std::vector<StampedPose>& motion) {
  if (motion.size() < 3) {
    return Vector3d::Zero();
  }
  const std::vector<WindowFrame> fall = weightless(model, frames, Vector3d::Zero());
  const std::size_t last = motion.size() - 1;
  const double T = seconds_between(motion.front().t_ns, motion.back().t_ns);
  const Vector3d bias = so3_log(motion.back().T_world_body.R.transpose() * fall[last].nav.T_world_body.R) / T;
  return bias.norm() < 0.3 ? bias : Vector3d::Zero();
}

std::vector<WindowState> inertial_guesses(const WindowModel& model, const std::vector<WindowFrame>& frames,
                                          const std::vector<StereoFrame>& raw) {
  const Vector3d bias = gyro_bias_from(model, frames, stereo_motion(raw, model.calibration));
  const std::vector<WindowFrame> fall = weightless(model, frames, bias);
  WindowState state{frames, points_of(model, raw)};
  std::vector<WindowState> out;
  {
    WindowState by_rig = state;
    set_first(model, solve_rays(model, fall, by_rig.points, true), bias, by_rig);
    fill_depths(by_rig.points);
    out.push_back(std::move(by_rig));
  }
  {
    WindowState by_left = state;
    for (int i = 0; i < kReweightings; ++i) {
      set_first(model, solve_rays(model, fall, by_left.points, false), bias, by_left);
      depths_of_all(model, by_left);
    }
    out.push_back(std::move(by_left));
  }
  for (WindowPoint& point : state.points) {
    point.landmark.value.z() = kSomeInverseDepth;
  }
  set_first(model, {Vector3d::Zero(), mean_force(weightless(model, frames, Vector3d::Zero()))},
            Vector3d::Zero(), state);
  out.push_back(std::move(state));
  return out;
}

std::vector<WindowState> visual_guesses(const WindowModel& model, const std::vector<WindowFrame>& frames,
                                        const std::vector<StereoFrame>& raw) {
  WindowState still{frames, points_of(model, raw)};
  still.frames.front().nav.T_world_body = {model.R_first, Vector3d::Zero()};
  integrate(model, still.frames);
  fill_depths(still.points);
  WindowState moving = still;
  const std::vector<StampedPose> motion = stereo_motion(raw, model.calibration);
  for (std::size_t k = 1; k < moving.frames.size(); ++k) {
    NavigationState& before = moving.frames[k - 1].nav;
    NavigationState& nav = moving.frames[k].nav;
    if (k < motion.size()) {
      nav.T_world_body = Pose{model.R_first, Vector3d::Zero()} * motion[k].T_world_body;
      const double dt = seconds_between(before.t_ns, nav.t_ns);
      before.v_world_body = (nav.T_world_body.p - before.T_world_body.p) / dt;
      before.omega_body = so3_log(before.T_world_body.R.transpose() * nav.T_world_body.R) / dt;
      nav.v_world_body = before.v_world_body;
      nav.omega_body = before.omega_body;
    } else {
      nav = before;
      (void)predict_over(model.options, moving.frames[k], nav);
    }
  }
  return {moving, still};
}

}  // namespace

Matrix3d level_attitude(const WindowModel& model, const Vector3d& up_body) {
  const Matrix3d R = rotation_between(up_body.normalized(), Vector3d::UnitZ());
  const Vector3d forward = R * body_from_cam0(model.calibration).R.col(2);
  return so3_exp(Vector3d(0.0, 0.0, -std::atan2(forward.y(), forward.x()))) * R;
}

std::vector<WindowPoint> points_of(const WindowModel& model, const std::vector<StereoFrame>& raw) {
  const MountedRig rig = mount(model.calibration);
  const Pose T_cam1_cam0 = rig[1].T_cam_body * rig[0].T_cam_body.inverse();
  const double lowest = 1.0 / (kFarthestBaselines * T_cam1_cam0.p.norm());
  std::map<std::int64_t, WindowPoint> points;
  for (std::size_t k = 0; k < raw.size(); ++k) {
    for (const StereoObservation& o : raw[k].observations) {
      const auto it = points.find(o.track_id);
      if (it != points.end()) {
        it->second.seen.push_back({k, o});
        continue;
      }
      const std::optional<Vector3d> d0 =
          o.in_cam0 ? unproject(rig[0].camera, o.uv_cam0) : std::optional<Vector3d>{};
      if (!d0) {
        continue;
      }
      WindowPoint point;
      point.landmark.track_id = o.track_id;
      point.landmark.R_cam0_chart.col(2) = *d0;
      point.landmark.R_cam0_chart.col(0) = d0->unitOrthogonal();
      point.landmark.R_cam0_chart.col(1) = d0->cross(point.landmark.R_cam0_chart.col(0));
      if (o.in_cam1) {
        const std::optional<Vector3d> d1 = unproject(rig[1].camera, o.uv_cam1);
        const double rho = d1 ? inverse_depth_along(*d0, *d1, T_cam1_cam0).value_or(0.0) : 0.0;
        point.landmark.value.z() = rho > lowest ? std::min(rho, 1.0 / kNearest) : 0.0;
      }
      point.seen.push_back({k, o});
      points[o.track_id] = std::move(point);
    }
  }
  std::vector<WindowPoint> out;
  for (auto& [id, point] : points) {
    if (point.seen.size() >= 2) {
      out.push_back(std::move(point));
    }
  }
  if (out.size() > kMostPoints) {
    out = longest_of_every_frame(std::move(out), raw.size());
  }
  return out;
}

std::vector<WindowState> guesses(const WindowModel& model, const std::vector<WindowFrame>& frames,
                                 const std::vector<StereoFrame>& raw) {
  return model.options.motion == MotionModel::kImu ? inertial_guesses(model, frames, raw)
                                                   : visual_guesses(model, frames, raw);
}

void fill_depths_from_motion(const WindowModel& model, WindowState& state) {
  const MountedRig rig = mount(model.calibration);
  const Pose T_body_cam0 = rig[0].T_cam_body.inverse();
  for (WindowPoint& point : state.points) {
    if (point.landmark.value.z() != 0.0) {
      continue;
    }
    const Pose anchor = state.frames[point.anchor()].nav.T_world_body * T_body_cam0;
    double num = 0.0, den = 1e-6;
    for (const WindowSighting& sighting : point.seen) {
      const std::optional<Vector3d> bearing = unproject(rig[0].camera, sighting.observation.uv_cam0);
      if (!sighting.observation.in_cam0 || !bearing) {
        continue;
      }
      const Pose T = (state.frames[sighting.frame].nav.T_world_body * T_body_cam0).inverse() * anchor;
      const Vector3d turned = bearing->cross(T.R * point.landmark.R_cam0_chart.col(2));
      const Vector3d shifted = bearing->cross(T.p);
      num -= shifted.dot(turned);
      den += shifted.squaredNorm();
    }
    const double rho = num / den;
    point.landmark.value.z() = std::clamp(rho, 1e-3, 1.0 / kNearest);
  }
}

}  // namespace limber::detail
