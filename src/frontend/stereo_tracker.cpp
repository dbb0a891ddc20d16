// SPDX-License-Identifier: MIT
#include "limber/frontend/stereo_tracker.hpp"

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "frontend/image_file.hpp"
#include "frontend/left_tracker.hpp"
#include "frontend/picture_order.hpp"
#include "frontend/pyramid.hpp"
#include "frontend/right_matcher.hpp"
#include "limber/frontend/image_reader.hpp"

namespace limber {
namespace {

using frontend::size_text;

constexpr int kMinSidePx = 64;  ///< below it the coarse levels of the pyramid hold nothing

void require_resolution(const GreyImage& image, const Camera& camera, const std::string& name) {
  if (image.width != camera.width || image.height != camera.height) {
    throw std::invalid_argument(name + ": expected an image of " + size_text(camera.width, camera.height) +
                                " (the calibration's resolution), got " +
                                size_text(image.width, image.height));
  }
  if (image.data == nullptr || image.stride < image.width) {
    throw std::invalid_argument(name + ": expected pixels, in rows at least as far apart as they are long");
  }
}

void require_usable(const Camera& camera, const std::string& name) {
  if (camera.width < kMinSidePx || camera.height < kMinSidePx || !(camera.fu > 0.0) || !(camera.fv > 0.0)) {
    throw std::invalid_argument(
        "StereoTracker: expected " + name + " with positive focal lengths and at least " +
        size_text(kMinSidePx, kMinSidePx) + ", got " + size_text(camera.width, camera.height));
  }
}

void require_sensible(const TrackerOptions& options) {
  const auto require = [](bool holds, const std::string& what) {
    if (!holds) throw std::invalid_argument("StereoTracker: expected " + what);
  };
  require(options.max_tracks > 0, "max_tracks > 0");
  require(options.min_distance_px > 0.0, "min_distance_px > 0");
  require(options.min_corner_strength > 0.0, "min_corner_strength > 0");
  require(options.min_ncc > 0.0 && options.min_ncc < 1.0, "0 < min_ncc < 1");
  require(options.max_forward_backward_px > 0.0, "max_forward_backward_px > 0");
  require(options.max_epipolar_px > 0.0, "max_epipolar_px > 0");
  require(options.nearest_baselines > 0.0, "nearest_baselines > 0");
  require(options.search_margin_degrees >= 0.0 && options.search_margin_degrees < 90.0,
          "0 <= search_margin_degrees < 90");
}

}  // namespace

class StereoTracker::Impl {
 public:
  Impl(const StereoCalibration& assumed, const TrackerOptions& options)
      : reader0(assumed.cam0),
        reader1(assumed.cam1),
        assumed_(assumed),
        tracks_{{assumed.cam0, options}, {assumed, options}} {}

  [[nodiscard]] const StereoCalibration& assumed() const { return assumed_; }
  void require_later(std::int64_t t_ns) const;
  StereoFrame process(std::int64_t t_ns, const cv::Mat& image0, const cv::Mat& image1);

  ImageReader reader0, reader1;

 private:
  /// What a pair is tracked with. Patches and pictures are shared, so that a copy costs little.
  struct Tracks {
    frontend::LeftTracker left;
    frontend::RightMatcher right;
  };
  [[nodiscard]] static StereoFrame follow(Tracks& tracks, std::int64_t t_ns, const frontend::Pyramid& left,
                                          const frontend::Pyramid& right);

  StereoCalibration assumed_;
  Tracks tracks_;
  frontend::PictureOrder order_;
  std::optional<std::int64_t> t_ns_;
};

void StereoTracker::Impl::require_later(std::int64_t t_ns) const {
  if (t_ns_ && t_ns <= *t_ns_) {
    throw std::invalid_argument("StereoTracker: expected a time after " + std::to_string(*t_ns_) +
                                " ns, got " + std::to_string(t_ns) + " ns");
  }
}

StereoFrame StereoTracker::Impl::process(std::int64_t t_ns, const cv::Mat& image0, const cv::Mat& image1) {
  const frontend::Pyramid pyramid0 = frontend::pyramid_of(image0), pyramid1 = frontend::pyramid_of(image1);
  t_ns_ = t_ns;
  Tracks untouched = tracks_;
  StereoFrame frame = follow(tracks_, t_ns, pyramid0, pyramid1);
  if (order_.doubts(frame)) {
    StereoFrame put_back = follow(untouched, t_ns, frontend::pyramid_of(image1.clone()), pyramid0);
    if (order_.prefers(put_back, frame)) {
      put_back.put_back = true;
      tracks_ = std::move(untouched);
      frame = std::move(put_back);
    }
  }
  order_.remember(frame);
  return frame;
}

StereoFrame StereoTracker::Impl::follow(Tracks& tracks, std::int64_t t_ns, const frontend::Pyramid& left,
                                        const frontend::Pyramid& right) {
  tracks.left.follow(left);
  StereoFrame frame{t_ns, {}};
  for (const frontend::LeftTrack& track : tracks.left.tracks()) {
    StereoObservation& observation = frame.observations.emplace_back();
    observation.track_id = track.id;
    observation.uv_cam0 = track.uv();
    observation.in_cam1 = false;
  }
  tracks.right.match(left, right, frame);
  return frame;
}

StereoTracker::StereoTracker(const StereoCalibration& assumed, const TrackerOptions& options) {
  require_usable(assumed.cam0, "cam0");
  require_usable(assumed.cam1, "cam1");
  require_sensible(options);
  impl_ = std::make_unique<Impl>(assumed, options);
}
StereoTracker::~StereoTracker() = default;
StereoTracker::StereoTracker(StereoTracker&&) noexcept = default;
StereoTracker& StereoTracker::operator=(StereoTracker&&) noexcept = default;

StereoFrame StereoTracker::process(std::int64_t t_ns, const std::filesystem::path& image0,
                                   const std::filesystem::path& image1) {
  impl_->require_later(t_ns);
  const GreyPixels left = impl_->reader0.read(image0), right = impl_->reader1.read(image1);
  return process(t_ns, left.view(), right.view());
}

StereoFrame StereoTracker::process(std::int64_t t_ns, const GreyImage& image0, const GreyImage& image1) {
  impl_->require_later(t_ns);
  require_resolution(image0, impl_->assumed().cam0, "left image");
  require_resolution(image1, impl_->assumed().cam1, "right image");
  const auto borrowed = [](const GreyImage& image) {
    return cv::Mat(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
                   static_cast<std::size_t>(image.stride));
  };
  // The left image is needed again for the next pair, when the caller's may be gone.
  return impl_->process(t_ns, borrowed(image0).clone(), borrowed(image1));
}

}  // namespace limber
