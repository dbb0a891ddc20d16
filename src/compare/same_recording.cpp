// SPDX-License-Identifier: MIT
#include "same_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace limber::detail {
namespace {

using Frames = std::vector<std::pair<std::size_t, std::size_t>>;

constexpr double kSameLength = 1e-6;  // [m], and as a share

/// Frames of `run` from one time to another.
std::size_t frames_within(const RunFolder& run, std::int64_t from_ns, std::int64_t to_ns) {
  return static_cast<std::size_t>(
      std::count_if(run.trajectory.begin(), run.trajectory.end(),
                    [&](const TrajectoryRow& row) { return row.t_ns >= from_ns && row.t_ns <= to_ns; }));
}

bool same_stamps(const RunFolder& a, const RunFolder& b) {
  const std::int64_t from = std::max(a.trajectory.front().t_ns, b.trajectory.front().t_ns);
  const std::int64_t to = std::min(a.trajectory.back().t_ns, b.trajectory.back().t_ns);
  const std::size_t common = common_frames(a, b).size();
  return common > 0 && common == frames_within(a, from, to) && common == frames_within(b, from, to);
}

/// Distances between true positions, which no alignment changes.
bool same_truth(const RunFolder& a, const RunFolder& b) {
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> both;
  for (auto at = b.matched.begin(); const MatchedPose& pose : a.matched) {
    at = std::find_if(at, b.matched.end(), [&](const MatchedPose& other) { return other.t_ns >= pose.t_ns; });
    if (at != b.matched.end() && at->t_ns == pose.t_ns) {
      both.emplace_back(pose.truth.p, at->truth.p);
    }
  }
  return std::all_of(both.begin(), both.end(), [&](const auto& pair) {
    const double length = (pair.first - both.front().first).norm();
    return std::abs(length - (pair.second - both.front().second).norm()) <= kSameLength * (1.0 + length);
  });
}

const Json& at(const Json& json, const char* key) {
  static const Json kNull;
  const auto it = json.is_object() ? json.find(key) : json.end();
  return json.is_object() && it != json.end() ? *it : kNull;
}

std::string in_words(const Json& value) {
  return value.is_null() ? "by default" : value.is_string() ? value.get<std::string>() : value.dump();
}

bool sees_the_same_points(const RunFolder& a, const RunFolder& b) {
  const Frames frames = common_frames(a, b);
  return std::all_of(frames.begin(), frames.end(), [&](const auto& pair) {
    return a.frames[pair.first].observed == b.frames[pair.second].observed;
  });
}

}  // namespace

Frames common_frames(const RunFolder& a, const RunFolder& b) {
  Frames out;
  std::size_t m = 0;
  for (std::size_t n = 0; n < a.trajectory.size(); ++n) {
    while (m < b.trajectory.size() && b.trajectory[m].t_ns < a.trajectory[n].t_ns) {
      ++m;
    }
    if (m < b.trajectory.size() && b.trajectory[m].t_ns == a.trajectory[n].t_ns) {
      out.emplace_back(n, m);
    }
  }
  return out;
}

bool same_recording(const RunFolder& a, const RunFolder& b) {
  const auto frames = [](const RunFolder& run) { return number_at(run.summary, {"frames_of_recording"}); };
  return at(a.summary, "dataset") == at(b.summary, "dataset") && frames(a) == frames(b) &&
         same_stamps(a, b) && same_truth(a, b);
}

std::vector<std::string> different_assumptions(const RunFolder& a, const RunFolder& b) {
  std::vector<std::string> out;
  const Json &of_a = at(a.summary, "options"), &of_b = at(b.summary, "options");
  std::vector<const char*> keys = {"assume_error", "sigma_px", "init", "clean", "max_points"};
  if (in_words(at(of_a, "init")) == "groundtruth" && in_words(at(of_b, "init")) == "groundtruth") {
    keys.insert(keys.end(), {"seed", "run"});
  }
  for (const char* const key : keys) {
    if (at(of_a, key) != at(of_b, key)) {
      out.push_back(fmt::format("{} ({}, {})", key, in_words(at(of_a, key)), in_words(at(of_b, key))));
    }
  }
  if (out.empty() && at(a.summary, "theta_assumed") != at(b.summary, "theta_assumed")) {
    out.emplace_back("the calibration");
  }
  if (out.empty() && !sees_the_same_points(a, b)) {
    out.emplace_back("the points seen: another front end or calibration");
  }
  return out;
}

}  // namespace limber::detail
