// SPDX-License-Identifier: MIT
#include "frontend/corners.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace limber::frontend {
namespace {

constexpr int kBlock = 5;        ///< [px] window of the structure tensor
constexpr int kRefine = 5;       ///< [px] half the window of the sub-pixel refinement
constexpr int kPerCell = 3;      ///< points that a cell holds when the texture is even
constexpr int kMostPerCell = 6;  ///< and where it must stand in for empty ones

struct Corner {
  cv::Point2f at;
  float strength = 0.0f;
};

bool stronger(const Corner& x, const Corner& y) { return x.strength > y.strength; }

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

using Row = Eigen::ArrayXf;

/// Smaller eigenvalue of the mean structure tensor [(grey level / px)^2] of each pixel of `area`, which
/// must be kBlock / 2 + 1 away from the edges of the image.
cv::Mat1f corner_strength(const cv::Mat& image, const cv::Rect& area) {
  constexpr int kAround = kBlock / 2;
  const int width = area.width, wide = area.width + 2 * kAround;
  const auto row_of = [width](cv::Mat1f& sums, int v) { return Eigen::Map<Row>(sums[v], width); };
  Row slope_u(wide), slope_v(wide), product(wide);
  cv::Mat1f uu(area.height + 2 * kAround, width), uv(uu.size()), vv(uu.size());  // sums over kBlock columns
  for (int v = 0; v < uu.rows; ++v) {
    const int first = area.x - kAround;
    const auto* above = image.ptr<std::uint8_t>(area.y - kAround + v - 1) + first;
    const auto* here = above + image.step[0];
    const auto* below = here + image.step[0];
    for (int u = 0; u < wide; ++u) {  // the Sobel operator, times 8
      slope_u[u] = static_cast<float>(above[u + 1] - above[u - 1] + 2 * (here[u + 1] - here[u - 1]) +
                                      below[u + 1] - below[u - 1]);
      slope_v[u] = static_cast<float>(below[u - 1] - above[u - 1] + 2 * (below[u] - above[u]) + below[u + 1] -
                                      above[u + 1]);
    }
    const auto add_up = [&](cv::Mat1f& sums) {
      auto row = row_of(sums, v);
      row = product.head(width);
      for (int k = 1; k < kBlock; ++k) row += product.segment(k, width);
    };
    product = slope_u * slope_u;
    add_up(uu);
    product = slope_u * slope_v;
    add_up(uv);
    product = slope_v * slope_v;
    add_up(vv);
  }
  constexpr float kScale = 1.0f / (64.0f * kBlock * kBlock);
  cv::Mat1f strength(area.size());
  Row a(width), b(width), c(width);
  for (int v = 0; v < area.height; ++v) {
    const auto over_rows = [&](cv::Mat1f& sums, Row& sum) {
      sum = row_of(sums, v);
      for (int k = 1; k < kBlock; ++k) sum += row_of(sums, v + k);
    };
    over_rows(uu, a);
    over_rows(uv, b);
    over_rows(vv, c);
    row_of(strength, v) = kScale * (0.5f * (a + c) - (0.25f * (a - c).square() + b.square()).sqrt());
  }
  return strength;
}

/// The largest of each value and its two neighbours; of the ends nothing.
void largest_of_three(const cv::Mat1f& values, int v, Row& out) {
  const Eigen::Index inner = values.cols - 2;
  const Eigen::Map<const Row> row(values[v], values.cols);
  out = row.head(inner).max(row.segment(1, inner)).max(row.tail(inner));
}

/// Local maxima of the corner strength in `area`, strongest first.
std::vector<Corner> corners_in(const cv::Mat& image, const cv::Rect& area, float min_strength) {
  if (area.width < 3 || area.height < 3) return {};
  const cv::Mat1f strength = corner_strength(image, area);
  std::vector<Corner> corners;
  Row above, here, below, largest;
  largest_of_three(strength, 0, above);
  largest_of_three(strength, 1, here);
  for (int v = 1; v + 1 < area.height; ++v) {
    largest_of_three(strength, v + 1, below);
    largest = above.max(here).max(below).max(min_strength);
    const float* row = strength[v] + 1;
    for (int u = 0; u + 2 < area.width; ++u) {
      if (row[u] >= largest[u] && row[u] > min_strength) {
        corners.push_back(
            {cv::Point2f(static_cast<float>(area.x + 1 + u), static_cast<float>(area.y + v)), row[u]});
      }
    }
    above.swap(here);
    here.swap(below);
  }
  std::stable_sort(corners.begin(), corners.end(), stronger);
  return corners;
}

bool is_free(const cv::Point2f& at, const std::vector<cv::Point2f>& points, float min_distance) {
  return std::none_of(points.begin(), points.end(), [&](const cv::Point2f& p) {
    const float du = p.x - at.x, dv = p.y - at.y;
    return du * du + dv * dv < min_distance * min_distance;
  });
}

/// How many points a cell holds already, and its corners, strongest first, once somebody asks.
class Cell {
 public:
  explicit Cell(const cv::Rect& area) : area_(area) {}

  int held = 0;

  /// The strongest corner that is away from the points; none if there is no such corner left.
  std::optional<Corner> next_free(const cv::Mat& image, const std::vector<cv::Point2f>& points,
                                  const CornerOptions& options) {
    if (!corners_) corners_ = corners_in(image, area_, static_cast<float>(options.min_strength));
    while (next_ < corners_->size()) {
      const Corner& corner = (*corners_)[next_++];
      if (is_free(corner.at, points, static_cast<float>(options.min_distance))) return corner;
    }
    return std::nullopt;
  }

 private:
  cv::Rect area_;
  std::optional<std::vector<Corner>> corners_;
  std::size_t next_ = 0;  ///< the first corner that was not looked at yet
};

struct Offer {
  Cell* cell;
  Corner corner;
};

/// The best corner of each cell that holds the fewest points of those that have a corner left. Empty if there
/// is none.
std::vector<Offer> emptiest_offer(std::vector<Cell>& cells, const cv::Mat& image,
                                  const std::vector<cv::Point2f>& points, const CornerOptions& options) {
  std::vector<Offer> offers;
  for (int held = 0; held < kMostPerCell && offers.empty(); ++held) {
    for (Cell& cell : cells) {
      if (cell.held != held) continue;
      if (const auto corner = cell.next_free(image, points, options)) offers.push_back({&cell, *corner});
    }
  }
  return offers;
}

}  // namespace

std::vector<Eigen::Vector2d> new_corners(const cv::Mat& image, const std::vector<Eigen::Vector2d>& taken,
                                         const CornerOptions& options) {
  const auto wanted = static_cast<std::size_t>(options.max_points);
  if (taken.size() >= wanted) return {};
  const Grid grid(image.size(), options.max_points / kPerCell);
  const int border = options.border + kRefine;
  const cv::Rect inner(border, border, image.cols - 2 * border, image.rows - 2 * border);
  std::vector<Cell> cells;
  for (int i = 0; i < grid.columns * grid.rows; ++i) cells.emplace_back(grid.area(i) & inner);
  std::vector<cv::Point2f> points;
  for (const Eigen::Vector2d& uv : taken) {
    ++cells[static_cast<std::size_t>(grid.cell(uv.x(), uv.y()))].held;
    points.emplace_back(static_cast<float>(uv.x()), static_cast<float>(uv.y()));
  }
  while (points.size() < wanted) {
    std::vector<Offer> offers = emptiest_offer(cells, image, points, options);
    if (offers.empty()) break;
    std::stable_sort(offers.begin(), offers.end(),
                     [](const Offer& x, const Offer& y) { return stronger(x.corner, y.corner); });
    for (const Offer& offer : offers) {
      if (points.size() == wanted ||
          !is_free(offer.corner.at, points, static_cast<float>(options.min_distance)))
        continue;
      points.push_back(offer.corner.at);
      ++offer.cell->held;
    }
  }
  std::vector<cv::Point2f> fresh(points.begin() + static_cast<std::ptrdiff_t>(taken.size()), points.end());
  if (fresh.empty()) return {};
  cv::cornerSubPix(image, fresh, {kRefine, kRefine}, {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 10, 0.02});
  std::vector<Eigen::Vector2d> result;
  for (const cv::Point2f& p : fresh) result.emplace_back(p.x, p.y);
  return result;
}

}  // namespace limber::frontend
