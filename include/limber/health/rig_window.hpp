// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/health/frame_halves.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

/// @file
/// What the right pixels of a stretch of frames say of the rig, with errors that are not white.
namespace limber {

namespace detail {
struct LeftPoint;
}

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
  std::size_t deep = 0;             ///< points whose depth is known from motion
  double scale_sigma = 0.0;         ///< relative standard deviation of the trajectory's scale
  std::vector<FrameHalves> blocks;  ///< fifths of it
};

/// @brief Frames of one window, and their robust regression on the rig's error.
///
/// Two rows a stereo point: its distance from the epipolar line, which needs nothing else; and along the line
/// its distance from where the depth puts it that the left camera alone has found from the motion. Linear
/// about the rig that is found, not the assumed one: a baseline that is turned by 15 deg is no small error.
/// Tukey's weights. Errors are alike along a track and at one place of the image: scores are kept by track
/// and cell.
/// @note docs/derivations/health.md
class RigWindow {
 public:
  /// @param calibration  as it is believed to be
  explicit RigWindow(const StereoCalibration& calibration);

  /// @param follows  the pose can be trusted to have followed the motion since the frame before
  void add(const StereoFrame& frame, const Pose& T_world_cam0, bool follows);

  /// No frame since the window began.
  [[nodiscard]] bool empty() const { return frames_.empty(); }
  /// Time of its first frame [ns]; only if there is one.
  [[nodiscard]] std::int64_t from_ns() const { return from_ns_; }

  /// Of the frames so far; nothing with fewer than 100 points.
  [[nodiscard]] std::optional<RigEvidence> evidence() const;
  /// The same, and begins the next window.
  [[nodiscard]] std::optional<RigEvidence> close();

 private:
  /// A track, as far as the poses follow each other.
  using TrackKey = std::pair<std::int64_t, int>;
  struct Seen {
    TrackKey track;
    Eigen::Vector3d d0, d1;  // z = 1
    int cell;
  };
  struct Frame {
    Pose T_world_cam0;
    std::vector<Seen> points;
  };
  struct Row {
    NormalEquations::Vector J;
    double y, noise, weight;  // noise: in units of the common one
    std::int64_t track;
    int cell;
    bool along;
    std::size_t frame;
  };

  struct Linearisation;

  [[nodiscard]] std::map<TrackKey, detail::LeftPoint> points() const;
  void add_across(const Linearisation& at, const Seen& seen, std::size_t frame, std::vector<Row>& rows) const;
  void add_along(const Linearisation& at, const Seen& seen, std::size_t frame, const detail::LeftPoint& point,
                 std::vector<Row>& rows) const;
  [[nodiscard]] std::vector<Row> rows_at(const NormalEquations::Vector& beta,
                                         const std::map<TrackKey, detail::LeftPoint>& points) const;
  [[nodiscard]] static NormalEquations normal_equations(const std::vector<Row>& rows);
  [[nodiscard]] static NormalEquations::Vector weigh(std::vector<Row>& rows);
  [[nodiscard]] std::vector<Row> fit(NormalEquations::Vector& beta) const;
  /// What the frames alone say, without the outliers of the whole window.
  [[nodiscard]] std::vector<FrameHalves> blocks(const std::vector<Row>& rows) const;

  StereoCalibration calibration_;
  RigParameters scale_;  // one plausible error
  double focal_px_;
  std::int64_t from_ns_ = 0, last_ns_ = 0;
  int stretch_ = 0;  // of poses that follow each other
  std::size_t seen_ = 0;
  std::vector<Frame> frames_;
};

}  // namespace limber
