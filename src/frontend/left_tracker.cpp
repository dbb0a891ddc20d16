// SPDX-License-Identifier: MIT
#include "frontend/left_tracker.hpp"

#include <algorithm>
#include <opencv2/video/tracking.hpp>
#include <utility>

#include "frontend/corners.hpp"
#include "frontend/epipolar.hpp"

namespace limber::frontend {
namespace {

constexpr int kBorder = 12;               ///< [px] along the edges of the image where nothing is followed
const cv::Size kFlowWindow(21, 21);       ///< of the pyramidal KLT
constexpr std::size_t kLongLag = 8;       ///< [frames] over which slow sliding shows
constexpr double kMaxAlignShiftPx = 3.0;  ///< between KLT and the final alignment
constexpr double kStillAlikeNcc = 0.9;    ///< below it a track's reference patch is renewed

cv::Point2f to_cv(const Eigen::Vector2d& uv) {
  return {static_cast<float>(uv.x()), static_cast<float>(uv.y())};
}

}  // namespace

void LeftTracker::follow(const Pyramid& image) {
  std::vector<LeftTrack> kept;
  const auto places = optical_flow(image);
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (places[i] && advance(tracks_[i], *places[i], image)) kept.push_back(std::move(tracks_[i]));
  }
  tracks_ = std::move(kept);
  image_ = image;
  drop_contradicted(1);
  drop_contradicted(kLongLag);
  drop_crowded();
  add_corners();
}

/// How far the track moved in the latest frame; for a new one, what its nearest elder did.
Eigen::Vector2d LeftTracker::expected_flow(const LeftTrack& track) const {
  const LeftTrack* model = nullptr;
  double least = 0.0;
  for (const LeftTrack& other : tracks_) {
    const double distance = (other.uv() - track.uv()).norm();
    if (other.path.size() < 2 || (model != nullptr && distance >= least)) continue;
    model = &other;
    least = distance;
  }
  return model ? Eigen::Vector2d(model->uv() - model->path[model->path.size() - 2]) : Eigen::Vector2d::Zero();
}

/// Where KLT finds the tracks in the next image; nothing where the way back ends elsewhere.
std::vector<std::optional<Eigen::Vector2d>> LeftTracker::optical_flow(const Pyramid& next) const {
  if (tracks_.empty()) return {};
  std::vector<cv::Point2f> from, to;
  for (const LeftTrack& track : tracks_) {
    from.push_back(to_cv(track.uv()));
    to.push_back(to_cv(track.uv() + expected_flow(track)));
  }
  std::vector<cv::Point2f> back = from;
  std::vector<std::uint8_t> found, found_back;
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.02);
  cv::calcOpticalFlowPyrLK(image_[0], next[0], from, to, found, cv::noArray(), kFlowWindow,
                           kPyramidLevels - 1, until, cv::OPTFLOW_USE_INITIAL_FLOW);
  cv::calcOpticalFlowPyrLK(next[0], image_[0], to, back, found_back, cv::noArray(), kFlowWindow,
                           kPyramidLevels - 1, until, cv::OPTFLOW_USE_INITIAL_FLOW);
  std::vector<std::optional<Eigen::Vector2d>> places(tracks_.size());
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (!found[i] || !found_back[i] || cv::norm(back[i] - from[i]) > options_.max_forward_backward_px)
      continue;
    places[i] = Eigen::Vector2d(to[i].x, to[i].y);
  }
  return places;
}

/// Moves a track to its sub-pixel place near `start` in the next image; false if it is lost.
bool LeftTracker::advance(LeftTrack& track, const Eigen::Vector2d& start, const Pyramid& next) const {
  const GreyImage image = view_of(next[0]);
  // The reference holds the track in place; it gives way to the latest view once it no longer resembles.
  auto fit = track.reference.find(image, {start, track.shape}, PatchMotion::kAffine, kMaxAlignShiftPx);
  if (!fit || fit->ncc < kStillAlikeNcc) {
    const auto latest = Patch::cut(view_of(image_[0]), track.uv());
    if (!latest) return false;
    fit = latest->find(image, {start}, PatchMotion::kAffine, kMaxAlignShiftPx);
    if (!fit || fit->ncc < options_.min_ncc) return false;
    track.reference = *latest;
  }
  if (!in_image(camera_, fit->uv, kBorder)) return false;
  track.shape = fit->A;
  track.path.push_back(fit->uv);
  if (track.path.size() > kLongLag + 1) track.path.erase(track.path.begin());
  return true;
}

/// Drops the tracks that disagree with the camera motion that most of them show over `lag` frames.
void LeftTracker::drop_contradicted(std::size_t lag) {
  std::vector<BearingPair> pairs;
  std::vector<std::int64_t> owners;
  for (const LeftTrack& track : tracks_) {
    if (track.path.size() <= lag) continue;
    const auto before = unproject(camera_, track.path[track.path.size() - 1 - lag]);
    const auto now = unproject(camera_, track.uv());
    if (!before || !now) continue;
    pairs.push_back({*before, *now});
    owners.push_back(track.id);
  }
  const double threshold = options_.max_epipolar_px / camera_.fu;
  const auto motion = fit_epipolar(pairs, threshold);
  if (!motion) return;  // too few, or no majority: nothing to judge by
  const std::vector<bool> agrees = epipolar_inliers(*motion, pairs, threshold);
  std::erase_if(tracks_, [&](const LeftTrack& track) {
    const auto owner = std::lower_bound(owners.begin(), owners.end(), track.id);
    return owner != owners.end() && *owner == track.id &&
           !agrees[static_cast<std::size_t>(owner - owners.begin())];
  });
}

/// Of tracks that have run into each other only the oldest stays.
void LeftTracker::drop_crowded() {
  std::vector<LeftTrack> kept;
  for (LeftTrack& track : tracks_) {
    const bool crowded = std::any_of(kept.begin(), kept.end(), [&](const LeftTrack& older) {
      return (older.uv() - track.uv()).norm() < 0.5 * options_.min_distance_px;
    });
    if (!crowded) kept.push_back(std::move(track));
  }
  tracks_ = std::move(kept);
}

void LeftTracker::add_corners() {
  std::vector<Eigen::Vector2d> taken;
  for (const LeftTrack& track : tracks_) taken.push_back(track.uv());
  const CornerOptions options{options_.max_tracks, options_.min_distance_px, options_.min_corner_strength,
                              kBorder};
  for (const Eigen::Vector2d& uv : new_corners(image_[0], taken, options)) {
    if (const auto patch = Patch::cut(view_of(image_[0]), uv)) tracks_.push_back({next_id_++, {uv}, *patch});
  }
}

}  // namespace limber::frontend
