// SPDX-License-Identifier: MIT
#include "limber/sensors/spread_points.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>

namespace limber {
namespace {

constexpr std::size_t kFieldColumns = 8, kFieldRows = 6;

std::size_t field_along(double value, int size, std::size_t fields) {
  const double share = size > 0 ? value / size : 0.0;
  return static_cast<std::size_t>(std::clamp(share, 0.0, 0.999) * static_cast<double>(fields));
}

std::size_t field_of(const StereoObservation& point, const StereoCalibration& assumed) {
  const Camera& camera = point.in_cam0 ? assumed.cam0 : assumed.cam1;
  const Eigen::Vector2d& uv = point.in_cam0 ? point.uv_cam0 : point.uv_cam1;
  return field_along(uv.y(), camera.height, kFieldRows) * kFieldColumns +
         field_along(uv.x(), camera.width, kFieldColumns);
}

}  // namespace

std::vector<std::size_t> spread_points(const StereoFrame& frame, const StereoCalibration& assumed,
                                       std::size_t most, const std::vector<PointRank>& ranks) {
  std::vector<std::size_t> chosen(frame.observations.size());
  std::iota(chosen.begin(), chosen.end(), std::size_t{0});
  if (chosen.size() <= most) {
    return chosen;
  }
  std::ranges::stable_sort(chosen, {},
                           [&](std::size_t k) { return std::tie(ranks[k].group, ranks[k].order); });
  std::array<std::size_t, kFieldColumns * kFieldRows> held{};
  std::vector<std::size_t> place(chosen.size());  // in its field, those of lower groups counted
  for (const std::size_t k : chosen) {
    place[k] = held[field_of(frame.observations[k], assumed)]++;
  }
  std::ranges::stable_sort(chosen, {}, [&](std::size_t k) { return std::tie(ranks[k].group, place[k]); });
  chosen.resize(most);
  std::ranges::sort(chosen);
  return chosen;
}

StereoFrame points_at(const StereoFrame& frame, const std::vector<std::size_t>& chosen) {
  StereoFrame out = frame;
  out.observations.clear();
  for (const std::size_t k : chosen) {
    out.observations.push_back(frame.observations[k]);
  }
  return out;
}

}  // namespace limber
