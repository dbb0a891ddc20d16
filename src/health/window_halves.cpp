// SPDX-License-Identifier: MIT
#include <array>
#include <cstddef>
#include <vector>

#include "limber/health/rig_movement.hpp"
#include "limber/health/window_fit.hpp"

/// @file
/// Of WindowFit: what the frames of a window say, one by one.
namespace limber {

namespace {

constexpr int kFewestOfAHalf = 8, kFewestDepthsOfAHalf = 4;  // rows

}  // namespace

std::vector<FrameHalves> WindowFit::frame_halves() const {
  struct Half {
    NormalEquations normal{NormalEquations::kPrior * Matrix::Identity(), Vector::Zero()};
    int rows = 0;
  };
  // Weights that fall with the distance from the mean would make every movement look smaller: all or nothing.
  std::vector<std::array<Half, 2>> halves(window_.frames.size());
  for (const Row& row : rows_) {
    if (!row.along && row.weight > 0.0) {
      Half& half = halves[row.frame][static_cast<std::size_t>(row.track & 1)];
      half.normal += {row.J * row.J.transpose(), row.y * row.J};
      ++half.rows;
    }
  }
  std::vector<FrameHalves> out(kBlocks);
  for (std::size_t n = 0; n < halves.size(); ++n) {
    const auto& [a, b] = halves[n];
    if (std::min(a.rows, b.rows) >= kFewestOfAHalf) {
      const Matrix of_points =
          (a.normal.information + b.normal.information - 2.0 * NormalEquations::kPrior * Matrix::Identity()) /
          (a.rows + b.rows);
      out[n * kBlocks / halves.size()].add(of_points, a.normal.solution(), b.normal.solution());
    }
  }
  return out;
}

std::vector<DepthHalves> WindowFit::depth_halves() const {
  using Pair = DepthHalves::Pair;
  struct Half {
    Pair information = Pair::Zero(), vector = Pair::Zero();
    int rows = 0;
  };
  const auto ways = depth_ways(window_.calibration.theta);
  const std::size_t frames = window_.frames.size();
  std::vector<std::array<Half, 2>> halves(frames);
  std::vector<DepthHalves> out(kBlocks);
  for (const Row& row : rows_) {
    if (row.along && row.weight > 0.0) {
      const Pair J(row.J.head<6>().dot(ways[0]), row.J.head<6>().dot(ways[1]));
      const double weight = 1.0 / (row.sigma * row.sigma);
      Half& half = halves[row.frame][static_cast<std::size_t>(row.track & 1)];
      half.information += weight * J.square();
      half.vector += weight * (row.y - row.J.dot(beta_)) * J;
      ++half.rows;
      DepthHalves& block = out[row.frame * kBlocks / frames];
      block.px_squared += J.square();
      block.points += 1.0;
    }
  }
  std::array<std::array<std::vector<Pair>, 2>, kBlocks> said;
  for (std::size_t n = 0; n < frames; ++n) {
    const auto& [a, b] = halves[n];
    if (std::min(a.rows, b.rows) >= kFewestDepthsOfAHalf) {
      auto& [first, second] = said[n * kBlocks / frames];
      first.emplace_back(a.vector / a.information);
      second.emplace_back(b.vector / b.information);
    }
  }
  for (std::size_t k = 0; k < kBlocks; ++k) {
    out[k].add_stretch(said[k][0], said[k][1]);
  }
  return out;
}

}  // namespace limber
