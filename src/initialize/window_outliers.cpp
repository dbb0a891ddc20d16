// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "limber/core/median.hpp"
#include "window_problem.hpp"

namespace limber::detail {

using Eigen::Vector2d;

namespace {

/// Standard deviations, of the pixels as they scatter here: beyond, a mismatch.
constexpr double kGross = 6.0;
constexpr double kMedianOfNorm = 1.1774;  // of a two-dimensional Gaussian of unit variance
constexpr double kNotProjected = 1e9;
constexpr double kFinePixels = 0.15;                    // [px]
constexpr double kFewBeyond = 0.1;                      // of all pixels
constexpr double kShareFarOff = 0.1;                    // of an image
constexpr double kFewFarOff = 0.02, kMostFarOff = 0.6;  // of all pixels
constexpr double kMany = 0.25;                          // of a frame's
// Inverse depths times the baseline: nearer than it, or that far behind the camera, is no point.
constexpr double kNearestPoint = 1.0, kFarBehind = -0.1;
/// The same from a camera that sees it: what is on the camera is in any of its pixels.
constexpr double kOnCamera = 10.0;
/// Baselines to the usual point, at least: a map whose scale nothing tells may have shrunk to any size.
constexpr double kUsualDepth = 20.0;

/// One pixel that may be dropped.
struct View {
  bool* used;
  double norm;  // of its residual, whitened
  std::size_t frame;
};

std::vector<View> views(const WindowModel& model, WindowState& state) {
  const std::vector<MountedRig> rigs = rigs_of(model, state);
  std::vector<View> out;
  for (WindowPoint& point : state.points) {
    for (WindowSighting& sighting : point.seen) {
      StereoObservation& o = sighting.observation;
      const auto add = [&](std::size_t cam, bool& used) {
        if (!used || (cam == 1 && !model.right)) {
          return;
        }
        const MountedRig& rig = rigs[sighting.frame];
        const auto projection =
            project_point(rig[cam], point_in_body(state, rig, cam, point, sighting.frame));
        const Vector2d sigma = model.options.sigma_px.segment<2>(2 * static_cast<Eigen::Index>(cam));
        const Vector2d& uv = cam == 0 ? o.uv_cam0 : o.uv_cam1;
        const double norm = projection ? (uv - projection->uv).cwiseQuotient(sigma).norm() : kNotProjected;
        out.push_back({&used, norm, sighting.frame});
      };
      add(0, o.in_cam0);
      add(1, o.in_cam1);
    }
  }
  return out;
}

/// By the left camera: the right one alone says nothing of a point where the rig is open in every frame.
bool is_seen(const WindowPoint& point) {
  return std::ranges::any_of(point.seen, [](const WindowSighting& s) { return s.observation.in_cam0; });
}

/// What lengths are compared to: the baseline, or less in a map that is small.
double unit_of_length(const WindowModel& model, const WindowState& state) {
  const double usual = median_inverse_depth(state);
  const double baseline = model.calibration.baseline();
  return usual * baseline * kUsualDepth > 1.0 ? 1.0 / (usual * kUsualDepth) : baseline;
}

std::vector<double> pixels_of_frames(const WindowState& state) {
  std::vector<double> out(state.frames.size(), 0.0);
  for (const WindowPoint& point : state.points) {
    for (const WindowSighting& sighting : point.seen) {
      const StereoObservation& o = sighting.observation;
      out[sighting.frame] += (o.in_cam0 ? 1.0 : 0.0) + (o.in_cam1 ? 1.0 : 0.0);
    }
  }
  return out;
}

/// The largest inverse distance from the left camera, of all images in which it is used.
double nearest(const WindowState& state, const std::vector<MountedRig>& rigs, const WindowPoint& point) {
  double out = 0.0;
  for (const WindowSighting& sighting : point.seen) {
    if (sighting.observation.in_cam0) {
      const MountedRig& rig = rigs[sighting.frame];
      const BodyPoint at = point_in_body(state, rig, 0, point, sighting.frame);
      const Pose& T = rig[0].T_cam_body;
      out = std::max(out, std::abs(at.w) / (T.R * at.Y + at.w * T.p).norm());
    }
  }
  return out;
}

/// Of mismatches alone points can be made that fit, somewhere: they tell nothing, and make the equations
/// singular.
/// @param nearest  see there
bool can_be(const WindowPoint& point, double nearest, double unit) {
  const double disparity = point.landmark.value.z() * unit;
  return disparity > kFarBehind && disparity < kNearestPoint && nearest * unit < kOnCamera;
}

/// @param share  of an image, by which they are off
/// @return whether they are between the two shares of all. Else nothing is done: more, and the guess is
/// wrong, not the points
bool drop_beyond(const WindowModel& model, double share, double least, double most, WindowState& state) {
  const Camera& camera = model.calibration.cam0;
  const double limit = share * std::hypot(camera.width, camera.height) / model.options.sigma_px.minCoeff();
  const std::vector<View> all = views(model, state);
  const auto is_beyond = [&](const View& view) { return view.norm > limit; };
  const auto beyond = static_cast<double>(std::ranges::count_if(all, is_beyond));
  const auto pixels = static_cast<double>(all.size());
  if (beyond < least * pixels || beyond > most * pixels) {
    return false;
  }
  for (const View& view : all) {
    *view.used = *view.used && !is_beyond(view);
  }
  return true;
}

}  // namespace

double median_inverse_depth(const WindowState& state) {
  std::vector<double> rho = {0.0};
  for (const WindowPoint& point : state.points) {
    rho.push_back(point.landmark.value.z());
  }
  return upper_median(std::move(rho));
}

double fine_pixels(const WindowModel& model) {
  return kFinePixels / root_mean_square(model.options.sigma_px);
}

void drop_unreachable(const WindowModel& model, WindowState& state) {
  (void)drop_beyond(model, 1.0, 0.0, kFewBeyond, state);
}

bool drop_far_off(const WindowModel& model, WindowState& state) {
  return drop_beyond(model, kShareFarOff, kFewFarOff, kMostFarOff, state);
}

std::size_t contradicted_from(const WindowState& whole, const WindowState& without_mismatches) {
  const std::size_t frames = whole.frames.size();
  const std::vector<double> before = pixels_of_frames(whole), after = pixels_of_frames(without_mismatches);
  std::size_t from = frames;
  while (from > 0 && after[from - 1] < (1.0 - kMany) * before[from - 1]) {
    --from;
  }
  const auto sum = [from](const std::vector<double>& of) {
    return std::accumulate(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(from), 0.0);
  };
  const bool most_before = 2 * from >= frames;
  return most_before && sum(after) > (1.0 - kFewBeyond) * sum(before) ? from : frames;
}

std::size_t drop_mismatches(const WindowModel& model, WindowState& state, std::size_t end) {
  const std::vector<View> all = views(model, state);
  if (all.empty()) {
    return 0;
  }
  std::vector<double> norms;
  for (const View& view : all) {
    norms.push_back(view.norm);
  }
  const double least = model.options.learn_pixel_noise ? std::min(fine_pixels(model), 1.0) : 1.0;
  const double limit = kGross * std::max(upper_median(norms) / kMedianOfNorm, least);
  std::size_t dropped = 0;
  for (const View& view : all) {
    if (view.norm > limit && view.frame < end) {
      *view.used = false;
      ++dropped;
    }
  }
  const double unit = unit_of_length(model, state);
  const std::vector<MountedRig> rigs = rigs_of(model, state);
  dropped += std::erase_if(state.points, [&](const WindowPoint& point) {
    return !is_seen(point) || !can_be(point, nearest(state, rigs, point), unit);
  });
  return dropped;
}

}  // namespace limber::detail
