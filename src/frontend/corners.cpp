// SPDX-License-Identifier: MIT
#include "frontend/corners.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <tuple>

namespace limber::frontend {
namespace {

constexpr int kBlock = 7;        ///< [px] window of the structure tensor
constexpr int kPerCell = 3;      ///< points that a cell holds when the texture is even
constexpr int kMostPerCell = 6;  ///< and where it must stand in for empty ones

struct Corner {
  cv::Point2f at;
  float strength = 0.0f;
  int rank = 0;  ///< how many points its cell holds already
};

/// Division of the image into equal cells, nearly square.
struct Grid {
  int columns = 1, rows = 1;
  double cell_width = 1.0, cell_height = 1.0;

  Grid(const cv::Size& size, int cells) {
    const double side = std::sqrt(static_cast<double>(size.area()) / std::max(cells, 1));
    columns = std::max(1, static_cast<int>(std::lround(size.width / side)));
    rows = std::max(1, static_cast<int>(std::lround(size.height / side)));
    cell_width = static_cast<double>(size.width) / columns;
    cell_height = static_cast<double>(size.height) / rows;
  }
  [[nodiscard]] int cell(double u, double v) const {
    const int column = std::clamp(static_cast<int>(u / cell_width), 0, columns - 1);
    const int row = std::clamp(static_cast<int>(v / cell_height), 0, rows - 1);
    return row * columns + column;
  }
  [[nodiscard]] cv::Rect area(int cell) const {
    const int column = cell % columns, row = cell / columns;
    const cv::Point first(static_cast<int>(column * cell_width), static_cast<int>(row * cell_height));
    const cv::Point last(static_cast<int>((column + 1) * cell_width),
                         static_cast<int>((row + 1) * cell_height));
    return {first, last};
  }
};

/// Local maxima of the corner strength in `area`, strongest first.
std::vector<Corner> corners_in(const cv::Mat& image, const cv::Rect& area, double min_strength) {
  // OpenCV's scale for 8 bit images, Sobel of size 3: strength * (2 / 255)^2 in (grey level / px)^2.
  constexpr double kOpenCvScale = 4.0 / (255.0 * 255.0);
  cv::Mat strength, largest;
  cv::cornerMinEigenVal(image(area), strength, kBlock, 3);
  cv::dilate(strength, largest, {});
  std::vector<Corner> corners;
  for (int v = 1; v + 1 < area.height; ++v) {
    const auto* s = strength.ptr<float>(v);
    const auto* l = largest.ptr<float>(v);
    for (int u = 1; u + 1 < area.width; ++u) {
      if (s[u] == l[u] && s[u] > min_strength * kOpenCvScale) {
        corners.push_back(
            {cv::Point2f(static_cast<float>(area.x + u), static_cast<float>(area.y + v)), s[u]});
      }
    }
  }
  std::stable_sort(corners.begin(), corners.end(),
                   [](const Corner& x, const Corner& y) { return x.strength > y.strength; });
  return corners;
}

bool is_free(const cv::Point2f& at, const std::vector<cv::Point2f>& points, double min_distance) {
  return std::none_of(points.begin(), points.end(), [&](const cv::Point2f& p) {
    return std::hypot(p.x - at.x, p.y - at.y) < min_distance;
  });
}

}  // namespace

std::vector<Eigen::Vector2d> new_corners(const cv::Mat& image, const std::vector<Eigen::Vector2d>& taken,
                                         const CornerOptions& options) {
  const int missing = options.max_points - static_cast<int>(taken.size());
  if (missing <= 0) return {};
  const Grid grid(image.size(), options.max_points / kPerCell);
  const cv::Rect inner(options.border, options.border, image.cols - 2 * options.border,
                       image.rows - 2 * options.border);
  std::vector<int> held(static_cast<std::size_t>(grid.columns * grid.rows), 0);
  std::vector<cv::Point2f> points;
  for (const Eigen::Vector2d& uv : taken) {
    ++held[static_cast<std::size_t>(grid.cell(uv.x(), uv.y()))];
    points.emplace_back(static_cast<float>(uv.x()), static_cast<float>(uv.y()));
  }

  std::vector<Corner> candidates;
  for (int cell = 0; cell < grid.columns * grid.rows; ++cell) {
    int rank = held[static_cast<std::size_t>(cell)];
    const cv::Rect area = grid.area(cell) & inner;
    if (rank >= kMostPerCell || area.width < 3 || area.height < 3) continue;
    std::vector<cv::Point2f> nearby = points;
    for (Corner& corner : corners_in(image, area, options.min_strength)) {
      if (rank >= kMostPerCell) break;
      if (!is_free(corner.at, nearby, options.min_distance)) continue;
      corner.rank = rank++;
      nearby.push_back(corner.at);
      candidates.push_back(corner);
    }
  }
  // The emptiest cells first, the strongest corners first within them.
  std::stable_sort(candidates.begin(), candidates.end(), [](const Corner& x, const Corner& y) {
    return std::tie(x.rank, y.strength) < std::tie(y.rank, x.strength);
  });
  std::vector<cv::Point2f> fresh;
  for (const Corner& corner : candidates) {
    if (static_cast<int>(fresh.size()) >= missing) break;
    if (!is_free(corner.at, points, options.min_distance)) continue;
    points.push_back(corner.at);
    fresh.push_back(corner.at);
  }
  if (fresh.empty()) return {};
  cv::cornerSubPix(image, fresh, {3, 3}, {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 10, 0.02});
  std::vector<Eigen::Vector2d> result;
  for (const cv::Point2f& p : fresh) result.emplace_back(p.x, p.y);
  return result;
}

}  // namespace limber::frontend
