// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "limber/health/frame_halves.hpp"

namespace limber {

/// A stretch of frames, summed up.
struct RigEvidence {
  /// over beta
  using Matrix = NormalEquations::Matrix;
  /// first and last frame [ns]
  std::int64_t from_ns = 0, to_ns = 0;
  /// of all rows
  NormalEquations all;
  std::map<int, NormalEquations> cells;  ///< by where in the right image
  Matrix tracks = Matrix::Zero();        ///< sum over tracks of score scoreᵀ
  Matrix both = Matrix::Zero();          ///< the same over tracks within cells
  Matrix epipolar = Matrix::Zero();      ///< sum of J Jᵀ, J the px that a point leaves its epipolar line by
  /// stereo points, one a frame and track; tracks
  std::size_t points = 0, track_count = 0;
  std::size_t deep = 0;                   ///< points whose depth is known from motion
  std::size_t deep_tracks = 0;            ///< tracks that have such points
  double scale_sigma = 0.0;               ///< relative standard deviation of the trajectory's scale
  std::vector<FrameHalves> blocks;        ///< fifths of it
  std::vector<DepthHalves> depth_blocks;  ///< the same fifths
};

}  // namespace limber
