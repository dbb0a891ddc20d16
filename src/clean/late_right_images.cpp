// SPDX-License-Identifier: MIT
#include "clean/late_right_images.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "clean/spread.hpp"
#include "limber/core/time.hpp"

namespace limber::detail {
namespace {

constexpr std::size_t kFewestPoints = 8;
constexpr std::size_t kFewestFrames = 3;  // until it is known what is usual
constexpr double kLeastUsual = 0.3;       // [px]
constexpr double kNewest = 0.1;           // of what is usual: weight of a frame
constexpr double kFits = 2.0;             // times what is usual: the largest miss that says nothing
constexpr double kOff = 2.0;              // times that: the picture is not of the frame
constexpr double kClearlyLess = 0.5;      // of the other miss
constexpr double kLongestDoubt = 5.0;     // [s]
constexpr double kRegular = 1.5;          // times the shortest time between frames: longer, one is missing

}  // namespace

/// From the left to the right pixel a point's offset hardly changes from frame to frame. If the right picture
/// is late, that holds from the left pixel of the earlier frame. A jump of the rig may put all right pixels
/// there by chance. Then one of both stops fitting as soon as the image moves on otherwise than it did; until
/// then, or some seconds at most, the right pixels wait.
std::size_t LateRightImages::lag(const StereoFrame& frame) {
  follow(frame);
  const std::optional<Misses> miss = misses(frame);
  offsets_show_ = picture_ == Picture::kOfTheFrame;
  if (miss) {
    judge(*miss, frame.t_ns);
  }
  learn_offsets(frame);
  return lag_;
}

void LateRightImages::follow(const StereoFrame& frame) {
  const std::int64_t dt = t_ns_ ? frame.t_ns - *t_ns_ : 0;
  period_ns_ = period_ns_ == 0 ? dt : std::min(period_ns_, dt);
  const bool missing = static_cast<double>(dt) > kRegular * static_cast<double>(period_ns_);
  std::unordered_map<std::int64_t, Track> now;
  for (const StereoObservation& point : frame.observations) {
    if (!point.in_cam0) {
      continue;
    }
    Track& track = now[point.track_id];
    const auto before = tracks_.find(point.track_id);
    if (before != tracks_.end()) {
      track = std::move(before->second);
      track.seen = missing ? 0 : track.seen;
      std::shift_right(track.left.begin(), track.left.end(), 1);
    }
    track.left.front() = point.uv_cam0;
    track.seen = std::min(track.seen + 1, track.left.size());
  }
  tracks_ = std::move(now);
  t_ns_ = frame.t_ns;
}

std::optional<LateRightImages::Misses> LateRightImages::misses(const StereoFrame& frame) const {
  std::array<std::vector<Eigen::Vector2d>, kLongestLag + 1> late;
  std::vector<Eigen::Vector2d> as_by_then, jumped;
  for (const StereoObservation& point : frame.observations) {
    if (!point.in_cam0 || !point.in_cam1) {
      continue;
    }
    const Track& track = tracks_.at(point.track_id);
    if (!track.offset || track.seen < track.left.size()) {
      continue;
    }
    for (std::size_t lag = 0; lag <= kLongestLag; ++lag) {
      late[lag].emplace_back(point.uv_cam1 - track.left[lag] - *track.offset);
    }
    if (track.jumped) {
      as_by_then.emplace_back(point.uv_cam1 - track.left[lag_] - *track.before);
      jumped.emplace_back(point.uv_cam1 - track.left.front() - *track.jumped);
    }
  }
  if (late.front().size() < kFewestPoints) {
    return std::nullopt;
  }
  Misses out{};
  for (std::size_t lag = 0; lag <= kLongestLag; ++lag) {
    out.late[lag] = median_norm(late[lag]);
    out.apart[lag] = spread(std::move(late[lag]));
  }
  if (jumped.size() >= kFewestPoints) {
    out.as_by_then = median_norm(as_by_then);
    out.jumped = median_norm(jumped);
  }
  return out;
}

double LateRightImages::largest_fit() const { return kFits * std::max(usual_, kLeastUsual); }

void LateRightImages::judge(const Misses& miss, std::int64_t t_ns) {
  switch (picture_) {
    case Picture::kOfTheFrame:
      judge_of_the_frame(miss, t_ns);
      break;
    case Picture::kInDoubt:
      judge_in_doubt(miss, t_ns);
      break;
    case Picture::kLate:
      judge_late(miss);
      break;
  }
}

void LateRightImages::judge_of_the_frame(const Misses& miss, std::int64_t t_ns) {
  const auto best = std::min_element(miss.late.begin() + 1, miss.late.end());
  const double now = miss.late.front();
  if (in_step_ >= kFewestFrames && now > kOff * largest_fit() && *best <= largest_fit()) {
    picture_ = miss.apart.front() > largest_fit() ? Picture::kLate : Picture::kInDoubt;
    lag_ = static_cast<std::size_t>(best - miss.late.begin());
    doubted_ns_ = t_ns;
    return;
  }
  usual_ += in_step_ == 0 ? now : kNewest * (std::min(now, kOff * largest_fit()) - usual_);
  ++in_step_;
}

/// Both guesses come to miss as depths change: that alone tells nothing.
void LateRightImages::judge_in_doubt(const Misses& miss, std::int64_t t_ns) {
  const double now = miss.late.front();
  const bool tells = std::max(miss.as_by_then, miss.jumped) > largest_fit();
  offsets_show_ = true;
  if (now <= largest_fit() && now < kClearlyLess * miss.late[lag_]) {
    is_of_the_frame();
  } else if (tells && miss.as_by_then < kClearlyLess * miss.jumped) {
    picture_ = Picture::kLate;
  } else if ((tells && miss.jumped < kClearlyLess * miss.as_by_then) ||
             seconds_between(doubted_ns_, t_ns) > kLongestDoubt) {
    is_of_the_frame();
  }
}

/// Where the rig jumps meanwhile, what all have in common says nothing: how they differ does.
void LateRightImages::judge_late(const Misses& miss) {
  const double now = miss.late.front();
  const auto best = std::min_element(miss.late.begin() + 1, miss.late.end());
  if (*best <= largest_fit() && *best < kClearlyLess * now) {
    lag_ = static_cast<std::size_t>(best - miss.late.begin());
    offsets_show_ = true;
  } else if (now < kClearlyLess * miss.late[lag_]) {
    is_of_the_frame();
  } else if (now > largest_fit()) {
    offsets_show_ = true;
    if (miss.apart[lag_] > std::min(miss.apart.front(), largest_fit())) {
      is_of_the_frame();
    }
  }
}

void LateRightImages::is_of_the_frame() {
  picture_ = Picture::kOfTheFrame;
  lag_ = 0;
  offsets_show_ = true;
}

/// Where the image hardly moves a late picture looks like any other: known offsets stay.
void LateRightImages::learn_offsets(const StereoFrame& frame) {
  for (const StereoObservation& point : frame.observations) {
    if (!point.in_cam0 || !point.in_cam1) {
      continue;
    }
    Track& track = tracks_.at(point.track_id);
    if (picture_ != Picture::kInDoubt) {
      track.before.reset();
      track.jumped.reset();
    } else if (doubted_ns_ == frame.t_ns && track.offset) {
      track.before = track.offset;
      track.jumped = point.uv_cam1 - track.left.front();
    }
    if (track.seen > lag_ && (offsets_show_ || !track.offset)) {
      track.offset = point.uv_cam1 - track.left[lag_];
    }
  }
}

}  // namespace limber::detail
