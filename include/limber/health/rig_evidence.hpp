// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "limber/health/frame_halves.hpp"

namespace limber {

/// Rows of a kind: across the epipolar lines, along them.
inline constexpr std::size_t kKinds = 2;

/// What a track adds to a window's score.
struct TrackScores {
  /// in a fit without the track, by where in the right image
  std::map<int, NormalEquations::Vector> cells;
  /// if all its rows of a kind were off by 1 px
  std::array<NormalEquations::Vector, kKinds> of_a_pixel = {NormalEquations::Vector::Zero(),
                                                            NormalEquations::Vector::Zero()};
};

/// Sums over tracks of a score times a score, transposed: of one window, or of two that see the same tracks.
struct ScoreProducts {
  /// over beta
  using Matrix = NormalEquations::Matrix;
  Matrix tracks = Matrix::Zero();  ///< of scores
  Matrix both = Matrix::Zero();    ///< the same of tracks within cells
  /// of `of_a_pixel`
  std::array<Matrix, kKinds> of_a_pixel = {Matrix::Zero(), Matrix::Zero()};

  /// Of both together.
  ScoreProducts& operator+=(const ScoreProducts& other);
  /// The windows the other way round.
  [[nodiscard]] ScoreProducts transposed() const;
};

/// Errors that tracks have in common over a window, by kind.
struct TrackErrors {
  std::array<double, kKinds> squares{};  ///< sum over tracks of their weight times the mean error, squared
  std::array<double, kKinds> weights{};  ///< sum of weights [1/px^2]

  /// Of both together.
  TrackErrors& operator+=(const TrackErrors& other);
  /// Mean square of a track's error [px^2].
  [[nodiscard]] double variance(std::size_t kind) const;
};

/// A stretch of frames, summed up.
struct RigEvidence {
  /// over beta
  using Matrix = NormalEquations::Matrix;
  /// first and last frame [ns]
  std::int64_t from_ns = 0, to_ns = 0;
  /// of all rows
  NormalEquations all;
  std::map<int, NormalEquations> cells;  ///< by where in the right image
  /// by track; only while windows to come may see the same ones
  std::map<std::int64_t, TrackScores> tracks;
  TrackErrors errors;      ///< of these
  ScoreProducts products;  ///< of the tracks
  std::vector<ScoreProducts>
      with_earlier;  ///< of its tracks and those of the window before, of the one before that, ...
  Matrix epipolar = Matrix::Zero();  ///< sum of J Jᵀ, J the px that a point leaves its epipolar line by
  /// stereo points, one a frame and track; tracks
  std::size_t points = 0, track_count = 0;
  std::size_t deep = 0;             ///< points whose depth is known from motion
  std::size_t deep_tracks = 0;      ///< tracks that have such points
  double scale_sigma = 0.0;         ///< relative standard deviation of the trajectory's scale
  double length_weight = 0.0;       ///< how much is known of the baseline's length: next to nothing at rest
  std::vector<FrameHalves> blocks;  ///< fifths of it
  std::vector<DepthHalves> depth_blocks;  ///< the same fifths
};

/// @brief Variance of the scale of windows together, each counted by what it tells of the baseline's length:
/// how far a camera went that stood still does not matter.
/// @return of none that tell anything, the largest
[[nodiscard]] double mean_scale_variance(std::span<const RigEvidence* const> windows);

/// So many windows before it a window is taken to share tracks with.
inline constexpr std::size_t kSharedWindows = 4;

/// @brief Sums over tracks that both windows see.
[[nodiscard]] ScoreProducts products_of(const std::map<std::int64_t, TrackScores>& window,
                                        const std::map<std::int64_t, TrackScores>& other);

/// @brief Adds a window, and what it shares with those before.
void append(const RigEvidence& window, std::vector<RigEvidence>& windows);

/// @brief Makes one window of each two.
void halve(std::vector<RigEvidence>& windows);

}  // namespace limber
