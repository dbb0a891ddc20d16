// SPDX-License-Identifier: MIT
#include "clean/exchanged_pictures.hpp"

#include <vector>

#include "limber/core/median.hpp"
#include "limber/core/time.hpp"

namespace limber::detail {
namespace {

constexpr std::size_t kFewestShared = 8;  // points
constexpr double kLongest = 1.0;          // [s] after which the pictures are taken as they are
constexpr double kClearly = 0.8;          // of the way as it is
constexpr double kLeast = 4.0;            // [px] both ways together; less is no exchange to speak of

}  // namespace

/// The ways of the left and the right pixel since the frame before, together: |a| + |b|. With parallax d they
/// would be |a - d| + |b + d| if the pictures were exchanged, which is no shorter where both cameras see the
/// same motion (a = b); whatever the rig is.
bool ExchangedPictures::is_exchanged(const StereoFrame& frame) {
  std::vector<double> as_it_is, exchanged;
  for (const StereoObservation& point : frame.observations) {
    const auto it = before_.find(point.track_id);
    if (!point.in_cam0 || !point.in_cam1 || it == before_.end()) {
      continue;
    }
    const StereoObservation& was = it->second;
    as_it_is.push_back((point.uv_cam0 - was.uv_cam0).norm() + (point.uv_cam1 - was.uv_cam1).norm());
    exchanged.push_back((point.uv_cam0 - was.uv_cam1).norm() + (point.uv_cam1 - was.uv_cam0).norm());
  }
  if (as_it_is.size() >= kFewestShared && seconds_between(*t_ns_, frame.t_ns) <= kLongest) {
    const double way = upper_median(as_it_is);
    if (way > kLeast && upper_median(exchanged) < kClearly * way) {
      return true;
    }
  }
  t_ns_ = frame.t_ns;
  before_.clear();
  for (const StereoObservation& point : frame.observations) {
    if (point.in_cam0 && point.in_cam1) {
      before_.emplace(point.track_id, point);
    }
  }
  return false;
}

}  // namespace limber::detail
