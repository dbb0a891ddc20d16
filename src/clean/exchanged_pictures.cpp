// SPDX-License-Identifier: MIT
#include "clean/exchanged_pictures.hpp"

#include <utility>
#include <vector>

#include "clean/spread.hpp"
#include "limber/core/median.hpp"
#include "limber/core/time.hpp"

namespace limber::detail {
namespace {

constexpr double kLongest = 1.0;  // [s] after which the pictures are taken as they are
constexpr double kClearly = 0.8;  // of what it is the other way
constexpr double kLeast = 4.0;    // [px] both ways together; less is no exchange to speak of

}  // namespace

/// How far the left and the right pixel are from where they were to come, together: |a| + |b|. With parallax
/// d it would be |a - d| + |b + d| if the pictures were exchanged, which is no less where both cameras are
/// off alike (a = b). A rig that bends within a frame puts them off differently (b = a + c), and c may hide
/// the sign of d; but c is the same for all points and d is not: what tells them apart is how the offsets of
/// the points, d + c, compare with each other, before and now.
std::optional<FrameContinuity> ExchangedPictures::continuity(const StereoFrame& frame) const {
  const double dt = t_ns_ ? seconds_between(*t_ns_, frame.t_ns) : 0.0;
  if (before_.size() < kFewestToJudgeOrder || dt > kLongest) {
    return std::nullopt;
  }
  std::vector<double> as_it_is, exchanged;
  std::vector<Eigen::Vector2d> same, opposite;
  for (const StereoObservation& point : frame.observations) {
    const auto it = before_.find(point.track_id);
    if (!point.in_cam0 || !point.in_cam1 || it == before_.end()) {
      continue;
    }
    const Seen& was = it->second;
    const Eigen::Vector2d left = was.left + dt * was.left_speed, right = was.right + dt * was.right_speed;
    as_it_is.push_back((point.uv_cam0 - left).norm() + (point.uv_cam1 - right).norm());
    exchanged.push_back((point.uv_cam0 - right).norm() + (point.uv_cam1 - left).norm());
    const Eigen::Vector2d offset = point.uv_cam1 - point.uv_cam0;
    same.emplace_back(offset - (was.right - was.left));
    opposite.emplace_back(offset + (was.right - was.left));
  }
  FrameContinuity out{before_.size(), as_it_is.size()};
  if (out.shared > 0) {
    out.off = upper_median(std::move(as_it_is));
    out.exchanged = upper_median(std::move(exchanged));
    out.same = spread(std::move(same));
    out.opposite = spread(std::move(opposite));
  }
  return out;
}

bool looks_exchanged(const FrameContinuity& now) {
  return now.shared >= kFewestToJudgeOrder && now.off > kLeast && now.exchanged < kClearly * now.off &&
         now.same >= kClearly * now.opposite;
}

bool ExchangedPictures::is_exchanged(const StereoFrame& frame) {
  const std::optional<FrameContinuity> now = continuity(frame);
  if (now && looks_exchanged(*now)) {
    return true;
  }
  remember(frame);
  return false;
}

void ExchangedPictures::remember(const StereoFrame& frame) {
  std::unordered_map<std::int64_t, Seen> now;
  for (const StereoObservation& point : frame.observations) {
    if (point.in_cam0 && point.in_cam1) {
      Seen& seen = now[point.track_id];
      seen.left = point.uv_cam0;
      seen.right = point.uv_cam1;
      const auto it = before_.find(point.track_id);
      if (it != before_.end()) {
        const double dt = seconds_between(*t_ns_, frame.t_ns);
        seen.left_speed = (seen.left - it->second.left) / dt;
        seen.right_speed = (seen.right - it->second.right) / dt;
      }
    }
  }
  before_ = std::move(now);
  t_ns_ = frame.t_ns;
}

}  // namespace limber::detail
