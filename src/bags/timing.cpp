// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "limber/bags/bag_contents.hpp"
#include "limber/core/median.hpp"
#include "limber/core/time.hpp"

namespace limber {
namespace {

constexpr double kGap = 1.5;                           // medians
constexpr double kShareOfInterval = 1.0 / 3.0;         // that partners may be apart
constexpr std::int64_t kFarthestPartner = 20'000'000;  // [ns]

}  // namespace

Timing timing_of(const std::vector<std::int64_t>& t_ns) {
  Timing out;
  out.count = t_ns.size();
  if (t_ns.empty()) {
    return out;
  }
  std::int64_t latest = t_ns.front();
  for (std::size_t k = 1; k < t_ns.size(); ++k) {
    out.repeated += t_ns[k] == t_ns[k - 1] ? 1 : 0;
    if (t_ns[k] < latest) {
      ++out.backward;
      if (const double step_s = seconds_between(t_ns[k], latest); step_s > out.largest_step_back_s) {
        out.largest_step_back_s = step_s;
        out.stepped_back_at_ns = latest;
      }
    }
    latest = std::max(latest, t_ns[k]);
  }
  std::vector<std::int64_t> sorted = t_ns;
  std::sort(sorted.begin(), sorted.end());
  out.first_ns = sorted.front();
  out.last_ns = sorted.back();
  std::vector<double> intervals;
  for (std::size_t k = 1; k < sorted.size(); ++k) {
    intervals.push_back(seconds_between(sorted[k - 1], sorted[k]));
    if (intervals.back() > out.longest_gap_s) {
      out.longest_gap_s = intervals.back();
      out.longest_gap_at_ns = sorted[k - 1];
    }
  }
  if (!intervals.empty()) {
    out.median_interval_s = upper_median(intervals);
    out.gaps =
        static_cast<std::size_t>(std::count_if(intervals.begin(), intervals.end(), [&](double interval) {
          return interval > kGap * out.median_interval_s;
        }));
  }
  return out;
}

PairedTimes pair_times(const std::vector<std::int64_t>& left, const std::vector<std::int64_t>& right) {
  PairedTimes out;
  if (left.empty() || right.empty()) {
    return out;
  }
  const double interval = timing_of(left).median_interval_s;
  const std::int64_t farthest =
      interval > 0.0
          ? std::min(kFarthestPartner, static_cast<std::int64_t>(interval * kShareOfInterval * 1e9))
          : kFarthestPartner;
  std::vector<double> differences;
  std::size_t r = 0;
  for (std::size_t l = 0; l < left.size() && r < right.size(); ++l) {
    while (r + 1 < right.size() && std::abs(right[r + 1] - left[l]) < std::abs(right[r] - left[l])) {
      ++r;
    }
    if (std::abs(right[r] - left[l]) <= farthest) {
      differences.push_back(seconds_between(left[l], right[r]));
      out.pairs.emplace_back(l, r++);
    }
  }
  if (!differences.empty()) {
    out.median_difference_s = upper_median(differences);
    for (const double difference : differences) {
      out.spread_s = std::max(out.spread_s, std::abs(difference - out.median_difference_s));
    }
  }
  return out;
}

}  // namespace limber
