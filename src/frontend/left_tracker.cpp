// SPDX-License-Identifier: MIT
#include "frontend/left_tracker.hpp"

#include <algorithm>
#include <utility>

#include "frontend/corners.hpp"
#include "frontend/epipolar.hpp"
#include "limber/core/median.hpp"

namespace limber::frontend {
namespace {

constexpr int kBorder = 12;                ///< [px] along the edges of the image where nothing is followed
constexpr double kMaxCoarseShiftPx = 6.0;  ///< on each level of the pyramid
constexpr std::size_t kLongLag = 8;        ///< [frames] over which slow sliding shows
constexpr double kMostRest = 3.0;          ///< times what most first views leave unexplained
constexpr double kLeastRest = 1.0;         ///< [grey levels]; what is below is taken for rounding
constexpr double kMaxAlignShiftPx = 3.0;   ///< between the search and the final alignment

}  // namespace

void LeftTracker::follow(const Pyramid& image) {
  std::vector<LeftTrack> kept;
  kept.reserve(tracks_.size());
  std::vector<Eigen::Vector2d> places;  // all before any track moves: they are each other's prediction
  for (const LeftTrack& track : tracks_) places.push_back(coarse_place(track, image));
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (advance(tracks_[i], places[i], image)) kept.push_back(std::move(tracks_[i]));
  }
  tracks_ = std::move(kept);
  image_ = image;
  drop_changed();
  drop_contradicted(1, motion_);
  drop_contradicted(kLongLag, long_motion_);
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

/// Where the track is in the next image, to a fraction of a pixel: its latest view, looked for from coarse to
/// fine. A level that does not find it leaves it to the next one.
Eigen::Vector2d LeftTracker::coarse_place(const LeftTrack& track, const Pyramid& next) const {
  Eigen::Vector2d uv = track.uv() + expected_flow(track);
  for (std::size_t level = kPyramidLevels - 1; level > 0; --level) {
    const double scale = 1.0 / (1 << level);
    const auto latest = ShiftPatch::cut(view_of(image_[level]), track.uv() * scale);
    if (!latest) continue;
    const auto fit = latest->find(view_of(next[level]), {uv * scale}, PatchMotion::kShift, kMaxCoarseShiftPx);
    if (fit) uv = fit->uv / scale;
  }
  return uv;
}

/// Moves a track to its sub-pixel place near `start` in the next image; false if it is lost.
bool LeftTracker::advance(LeftTrack& track, const Eigen::Vector2d& start, const Pyramid& next) const {
  const GreyImage image = view_of(next[0]);
  // The first view holds the track in place. Followed from view to view beyond it, points slide along edges
  // of things by more than a pixel in the end, and the filter takes that for motion.
  const auto fit = track.reference->find(image, {start, track.shape}, PatchMotion::kAffine, kMaxAlignShiftPx);
  if (!fit || fit->ncc < options_.min_ncc) return false;
  if (!in_image(camera_, fit->uv, kBorder)) return false;
  track.shape = fit->A;
  track.rest = fit->rest;
  track.path.push_back(fit->uv);
  if (track.path.size() > kLongLag + 1) track.path.erase(track.path.begin());
  return true;
}

/// Drops the tracks that look less like their first view than most do: their patch shows things at different
/// distances, which move against each other, and no shape of it holds the point in place.
void LeftTracker::drop_changed() {
  std::vector<double> rests;
  for (const LeftTrack& track : tracks_) rests.push_back(track.rest);
  if (rests.empty()) return;
  const double most = kMostRest * std::max(upper_median(std::move(rests)), kLeastRest);
  std::erase_if(tracks_, [most](const LeftTrack& track) { return track.rest > most; });
}

/// Drops the tracks that disagree with the camera motion that most of them show over `lag` frames.
/// @param motion  what it was a frame ago; is renewed
void LeftTracker::drop_contradicted(std::size_t lag, std::optional<EpipolarGeometry>& motion) {
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
  motion = fit_epipolar(pairs, threshold, motion);
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
    if (const auto patch = Patch::cut(view_of(image_[0]), uv)) {
      tracks_.push_back({next_id_++, {uv}, std::make_shared<const Patch>(*patch)});
    }
  }
}

}  // namespace limber::frontend
