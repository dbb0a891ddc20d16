// SPDX-License-Identifier: MIT
#include "clean/thin_points.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace limber::detail {
namespace {

constexpr std::size_t kColumns = 8, kRows = 6;

std::size_t place(double value, int size, std::size_t cells) {
  const double share = size > 0 ? value / size : 0.0;
  return static_cast<std::size_t>(std::clamp(share, 0.0, 0.999) * static_cast<double>(cells));
}

}  // namespace

PointThinner::PointThinner(const StereoCalibration& assumed, std::size_t most)
    : cam0_(assumed.cam0), cam1_(assumed.cam1), most_(most) {}

std::size_t PointThinner::cell_of(const StereoObservation& point) const {
  const Camera& camera = point.in_cam0 ? cam0_ : cam1_;
  const Eigen::Vector2d& uv = point.in_cam0 ? point.uv_cam0 : point.uv_cam1;
  return place(uv.y(), camera.height, kRows) * kColumns + place(uv.x(), camera.width, kColumns);
}

std::size_t PointThinner::thin(StereoFrame& frame) {
  std::vector<StereoObservation>& points = frame.observations;
  const std::size_t given = points.size();
  if (given > most_) {
    // Points of the last frame first; then, cell by cell in turn, in the order in which the front end has
    // them.
    std::array<std::size_t, kColumns * kRows> held{};
    std::vector<std::pair<std::size_t, std::size_t>> order;  // (place in its cell, index)
    for (const bool old : {true, false}) {
      for (std::size_t k = 0; k < given; ++k) {
        if (kept_.contains(points[k].track_id) == old) {
          const std::size_t in_cell = held[cell_of(points[k])]++;
          order.emplace_back(old ? 0 : 1 + in_cell, k);
        }
      }
    }
    std::stable_sort(order.begin(), order.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    order.resize(most_);
    std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    std::vector<StereoObservation> chosen;
    for (const auto& [rank, k] : order) {
      chosen.push_back(points[k]);
    }
    points = std::move(chosen);
  }
  kept_.clear();
  for (const StereoObservation& point : points) {
    kept_.insert(point.track_id);
  }
  return given - points.size();
}

}  // namespace limber::detail
