// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "limber/navigate/stereo_filter.hpp"

/// A small world of its own: a rig that sways before a cloud of points. The true motion is integrated with
/// the filter's own motion model from noise-free inputs, so that without noise the filter can be exact.
namespace limber::testing {

inline constexpr std::int64_t kMs = 1000000;

/// What makes a scene.
struct SceneOptions {
  MotionModel motion = MotionModel::kImu;
  std::uint64_t seed = 1;
  double duration_s = 3.0;
  std::int64_t input_ms = 5, frame_ms = 50;
  std::int64_t frame_offset_ms = 0;  ///< frames fall between input samples if not a multiple of input_ms
  int points = 60;
  bool noise = true;
  double sigma_px = 0.5;
  /// True theta minus nominal, at time t [s].
  std::function<RigParameters(double)> theta_error = [](double) {
    return RigParameters(RigParameters::Zero());
  };
  double yaw = 0.0;                                 ///< the whole world turned about the vertical [rad] ...
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< ... and then moved
};

struct Scene {
  SceneOptions made_of;
  StereoCalibration calibration;  ///< nominal: what a filter assumes
  NavigatorOptions options;       ///< noise and motion model as simulated
  InitialState initial;
  std::vector<InputSample> inputs;
  std::vector<StereoFrame> frames;
  std::vector<NavigationState> truth;      ///< at the frames
  std::vector<RigParameters> theta_true;   ///< at the frames
  std::vector<Eigen::Vector3d> landmarks;  ///< by track id
};

StereoCalibration scene_rig();

Scene make_scene(const SceneOptions& options);

/// Half a degree and a tenth of the baseline, which the scene's rig of 0.3 m notices.
RigParameters scene_theta_error();

/// A scene on a rig that is constantly wrong by that much.
SceneOptions wrong_rig(std::uint64_t seed = 1);

/// A navigator that is being fed a scene.
class Feeder {
 public:
  Feeder(const Scene& scene, const NavigatorOptions& options);

  /// Inputs up to the first at or after t_ns.
  void feed_inputs(std::int64_t t_ns);

  FrameReport process(const StereoFrame& frame);

  StereoFilter navigator;

 private:
  const Scene& scene_;
  std::size_t next_ = 0;
};

/// Feeds all frames; `after` sees the navigator after each, with the frame's index and report.
void run(const Scene& scene, const NavigatorOptions& options,
         const std::function<void(StereoFilter&, std::size_t, const FrameReport&)>& after,
         const std::function<void(StereoFilter&, std::size_t)>& before = {});

NavigatorOptions with_method(const Scene& scene, Method method,
                             LandmarkKind kind = LandmarkKind::kInverseDepth);

/// true = estimate ⊕ error, of the pose.
Eigen::Matrix<double, 6, 1> pose_error(const StereoFilter& navigator, const NavigationState& truth);

double position_error(const StereoFilter& navigator, const NavigationState& truth);

}  // namespace limber::testing
