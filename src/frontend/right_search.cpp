// SPDX-License-Identifier: MIT
#include "frontend/right_search.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>

#include "frontend/patch.hpp"
#include "limber/core/angle.hpp"
#include "limber/core/so3.hpp"

namespace limber::frontend {
namespace {

constexpr std::size_t kCoarseLevel = 2;  ///< pyramid level of the search over the window
constexpr int kTemplateRadius = 5;       ///< [px] of that level
constexpr int kPeaks = 3;                ///< best places of the coarse search that are looked at closely
constexpr int kPeakRadius = 2;           ///< [px] of that level, around a peak that belong to it
constexpr double kMinCoarseNcc = 0.5;    ///< of such a place
constexpr double kBehindBestNcc = 0.25;  ///< a place that much less alike than the best one is no rival
constexpr double kMinShiftedNcc = 0.5;   ///< below it no change of shape makes two patches alike
constexpr double kMaxStretchBetween =
    1.6;                                ///< of a surface between the two cameras, and by the inverse at least
constexpr double kMaxShiftPx = 4.0;     ///< on each level of the pyramid
constexpr double kSamePlacePx = 3.0;    ///< peaks closer than this are one place
constexpr double kAmbiguousNcc = 0.03;  ///< two places whose correlation differs less cannot be told apart

/// What a point looks like on the levels of the pyramid: the full one with its shape, the coarse ones to be
/// shifted. Nothing where it is too near the edge, or plain.
class Views {
 public:
  Views(const Pyramid& image, const Eigen::Vector2d& uv, std::size_t coarsest)
      : full_(Patch::cut(view_of(image[0]), uv)) {
    if (!full_) return;
    for (std::size_t level = 1; level <= coarsest; ++level) {
      coarse_[level] = ShiftPatch::cut(view_of(image[level]), uv / (1 << level));
    }
  }

  /// Found near `start`, from coarse to fine.
  [[nodiscard]] std::optional<PatchFit> align(const Pyramid& image, const PatchFit& start) const {
    if (!full_) return std::nullopt;
    PatchFit fit{start.uv, start.A};
    for (std::size_t level = kCoarseLevel; level > 0; --level) {
      if (!coarse_[level]) continue;
      const double scale = 1.0 / (1 << level);
      const auto found =
          coarse_[level]->find(view_of(image[level]), {fit.uv * scale}, PatchMotion::kShift, kMaxShiftPx);
      if (found) fit.uv = found->uv / scale;  // where it is not found when coarse, it may be when fine
    }
    const GreyImage full = view_of(image[0]);
    if (start.A.isIdentity(0.0)) {
      const auto shifted = full_->find(full, fit, PatchMotion::kShift, kMaxShiftPx);
      if (shifted && shifted->ncc < kMinShiftedNcc) return std::nullopt;
      fit = shifted.value_or(fit);
    }
    return full_->find(full, fit, PatchMotion::kAffine, kMaxShiftPx);
  }

 private:
  std::optional<Patch> full_;
  std::array<std::optional<ShiftPatch>, kCoarseLevel + 1> coarse_;
};

/// Whether a surface that both cameras see may look like that. A patch that has settled on something else is
/// usually torn until it resembles it.
bool is_surface(const Eigen::Matrix2d& A) {
  // Singular values of a 2x2 matrix: sum and difference of these.
  const double turn = 0.5 * std::hypot(A(0, 0) + A(1, 1), A(1, 0) - A(0, 1));
  const double shear = 0.5 * std::hypot(A(0, 0) - A(1, 1), A(1, 0) + A(0, 1));
  return turn + shear < kMaxStretchBetween && std::abs(turn - shear) > 1.0 / kMaxStretchBetween;
}

/// Where the way back from `uv` in one image ends in the other, which it left at `start`.
std::optional<Eigen::Vector2d> way_back(const Pyramid& from, const Eigen::Vector2d& uv, const Pyramid& to,
                                        const Eigen::Vector2d& start) {
  PatchFit fit{start};
  for (std::size_t level = 2; level-- > 0;) {
    const double scale = 1.0 / (1 << level);
    const auto patch = ShiftPatch::cut(view_of(from[level]), uv * scale);
    const auto found =
        patch ? patch->find(view_of(to[level]), {fit.uv * scale}, PatchMotion::kShift, kMaxShiftPx)
              : std::nullopt;
    if (found) fit.uv = found->uv / scale;
    if (!found && level == 0) return std::nullopt;
  }
  return fit.uv;
}

float largest_in_row(const cv::Mat1f& map, int row) {
  return Eigen::Map<const Eigen::ArrayXf>(map[row], map.cols).maxCoeff();
}

/// Maxima of a correlation map, best first, of equal ones the upper left one. The map is spoilt.
std::vector<cv::Point> best_peaks(cv::Mat1f& map) {
  std::vector<float> largest;  // of each row
  for (int row = 0; row < map.rows; ++row) largest.push_back(largest_in_row(map, row));
  std::vector<cv::Point> peaks;
  double least = kMinCoarseNcc;
  for (int k = 0; k < kPeaks; ++k) {
    const auto best = std::max_element(largest.begin(), largest.end());
    if (*best < least) break;
    least = std::max(least, *best - kBehindBestNcc);
    const int row = static_cast<int>(best - largest.begin());
    const int column = static_cast<int>(std::find(map[row], map[row] + map.cols, *best) - map[row]);
    peaks.emplace_back(column, row);
    const cv::Rect around =
        cv::Rect(column - kPeakRadius, row - kPeakRadius, 2 * kPeakRadius + 1, 2 * kPeakRadius + 1) &
        cv::Rect({}, map.size());
    map(around).setTo(-1.0);
    for (int v = around.y; v < around.br().y; ++v) {
      largest[static_cast<std::size_t>(v)] = largest_in_row(map, v);
    }
  }
  return peaks;
}

}  // namespace

const CorrelationImage& SearchedImage::coarse() {
  if (!coarse_) {
    coarse_.emplace(pyramid_[kCoarseLevel], cv::Size(2 * kTemplateRadius + 1, 2 * kTemplateRadius + 1));
  }
  return *coarse_;
}

RightSearch::RightSearch(const StereoCalibration& assumed, const TrackerOptions& options)
    : assumed_(assumed), options_(options) {
  const double margin = options.search_margin_degrees / kToDegrees;
  for (const Eigen::Vector3d& axis : {Eigen::Vector3d::UnitX().eval(), Eigen::Vector3d::UnitY().eval()}) {
    turns_.push_back(so3_exp(margin * axis));
    turns_.push_back(so3_exp(-margin * axis));
  }
}

/// Where in the right image uv0 may be, if the assumed calibration is roughly right.
std::optional<cv::Rect2d> RightSearch::window(const Eigen::Vector2d& uv0) const {
  const auto bearing = unproject(assumed_.cam0, uv0);
  if (!bearing) return std::nullopt;
  const Pose T_cam1_cam0 = pose_from_rig(assumed_.theta);
  const double nearest = options_.nearest_baselines * assumed_.baseline();
  const Eigen::Vector3d far = T_cam1_cam0.R * *bearing, near = T_cam1_cam0 * (nearest * *bearing);
  const auto at_far = project(assumed_.cam1, far), at_near = project(assumed_.cam1, near);
  if (!at_far || !at_near) return std::nullopt;
  Eigen::AlignedBox2d box(at_far->uv);
  box.extend(at_near->uv);
  for (const Eigen::Matrix3d& turn : turns_) {
    for (const Eigen::Vector3d& point : {far, near}) {
      if (const auto turned = project(assumed_.cam1, turn * point)) box.extend(turned->uv);
    }
  }
  return cv::Rect2d(box.min().x(), box.min().y(), box.sizes().x(), box.sizes().y());
}

/// The places of the window that look most like uv0 when coarse.
std::vector<Eigen::Vector2d> RightSearch::candidates(const Pyramid& left, SearchedImage& right,
                                                     const Eigen::Vector2d& uv0) const {
  const auto where = window(uv0);
  if (!where) return {};
  const cv::Mat& from = left[kCoarseLevel];
  const CorrelationImage& to = right.coarse();
  constexpr int kScale = 1 << kCoarseLevel;
  const cv::Point radius(kTemplateRadius, kTemplateRadius), one(1, 1);
  const cv::Point centre = cv::Point2d(uv0.x(), uv0.y()) / kScale;  // rounds
  const cv::Rect square(centre - radius, centre + radius + one);
  // The templates that are compared have their centres in the window.
  const cv::Rect area =
      cv::Rect(cv::Point(where->tl() / kScale) - radius, cv::Point(where->br() / kScale) + radius + one) &
      cv::Rect({}, to.size());
  if ((square & cv::Rect({}, from.size())) != square || area.width < square.width ||
      area.height < square.height) {
    return {};
  }
  cv::Mat1f map = to.correlate(from(square), area);
  std::vector<Eigen::Vector2d> places;
  for (const cv::Point& peak : best_peaks(map)) {
    const cv::Point moved = (peak + area.tl() - square.tl()) * kScale;
    places.push_back(uv0 + Eigen::Vector2d(moved.x, moved.y));
  }
  return places;
}

/// Alike, not torn, and the way back ends where it began.
std::optional<PatchFit> RightSearch::verified(const PatchFit& there, const Pyramid& left,
                                              const Pyramid& right, const Eigen::Vector2d& uv0) const {
  if (there.ncc < options_.min_ncc || !is_surface(there.A)) return std::nullopt;
  const auto back = way_back(right, there.uv, left, uv0);
  if (!back || (*back - uv0).norm() > options_.max_forward_backward_px) return std::nullopt;
  return there;
}

std::optional<PatchFit> RightSearch::follow(const Pyramid& left, const Pyramid& right,
                                            const Eigen::Vector2d& uv0, const PatchFit& guess) const {
  const auto there = Views(left, uv0, 1).align(right, guess);
  return there ? verified(*there, left, right, uv0) : std::nullopt;
}

std::optional<PatchFit> RightSearch::find(const Pyramid& left, SearchedImage& right,
                                          const Eigen::Vector2d& uv0) const {
  const std::vector<Eigen::Vector2d> starts = candidates(left, right, uv0);
  if (starts.empty()) return std::nullopt;
  const Views views(left, uv0, kCoarseLevel);
  std::optional<PatchFit> best, rival;
  for (const Eigen::Vector2d& start : starts) {
    const auto there = views.align(right.pyramid(), {start});
    std::optional<PatchFit> fit = there ? verified(*there, left, right.pyramid(), uv0) : std::nullopt;
    if (!fit || (best && (fit->uv - best->uv).norm() < kSamePlacePx)) continue;
    if (!best || fit->ncc > best->ncc) std::swap(best, fit);
    if (fit && (!rival || fit->ncc > rival->ncc)) rival = fit;
  }
  if (!best || (rival && rival->ncc > best->ncc - kAmbiguousNcc)) return std::nullopt;
  return best;
}

}  // namespace limber::frontend
