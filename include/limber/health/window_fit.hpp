// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/health/frame_halves.hpp"
#include "limber/health/left_track.hpp"
#include "limber/health/rig_evidence.hpp"
#include "limber/sensors/calibration.hpp"

/// @file
/// The robust regression of a window's pixels on the rig's error, in slices.
namespace limber {

namespace detail {

/// A track, as far as the poses follow each other.
using TrackStretch = std::pair<std::int64_t, int>;

/// A stereo point of a frame.
struct WatchedPoint {
  TrackStretch track;      ///< whose sight it is
  Eigen::Vector3d d0, d1;  ///< towards it from the left and the right camera, z = 1
  int cell;                ///< of the right image
};

/// A frame: from where, and what it saw.
struct WatchedFrame {
  Pose T_world_cam0;                 ///< as the filter that watches has it
  std::vector<WatchedPoint> points;  ///< of both cameras
};

/// Frames of one window, and the calibration that is judged.
struct WatchedFrames {
  /// as it is believed to be
  StereoCalibration calibration;
  /// first and last frame [ns]
  std::int64_t from_ns = 0, to_ns = 0;
  std::size_t points = 0;              ///< of all frames
  std::vector<WatchedFrame> frames{};  ///< in time
};

}  // namespace detail

/// @brief The robust regression of a window on the rig's error.
///
/// Two rows a stereo point: its distance from the epipolar line, which needs nothing else; and along the line
/// its distance from where the depth puts it that the left camera alone has found from the motion. Linear
/// about the rig that is found, not the assumed one: a baseline that is turned by 15 deg is no small error.
/// Tukey's weights. Errors are alike along a track and at one place of the image: scores are kept by track
/// and cell.
///
/// It takes several milliseconds, which a filter has not got between two frames: each call of advance()
/// does a slice of about half a millisecond, at most 23 in all.
/// @note docs/derivations/health.md
class WindowFit {
 public:
  /// Not begun yet; done at once where the window has too few points.
  explicit WindowFit(detail::WatchedFrames window);

  /// Does the next slice; nothing once done.
  void advance();
  /// Nothing is left to do.
  [[nodiscard]] bool done() const { return stage_ == Stage::kDone; }
  /// What the window says; nothing with fewer than 100 points, where a seventh of those of the usual fifth
  /// of it are mismatched, or before it is done.
  [[nodiscard]] const std::optional<RigEvidence>& evidence() const { return evidence_; }

 private:
  using Matrix = NormalEquations::Matrix;
  using Vector = NormalEquations::Vector;
  static constexpr std::size_t kBlocks = 5;  // of a window
  enum class Stage { kTracks, kRows, kLevers, kWeights, kSums, kMovement, kDone };
  struct Row {
    Vector J;
    double y, noise;  // noise: in units of that of rows alike
    double sigma, weight;
    std::int64_t track;
    int cell;
    bool along;
    std::size_t frame;
    Eigen::Vector3d of_right =
        Eigen::Vector3d::Zero();  // what J's baseline has more at the right pixel's depth
    double share = 0.0;           // of which it has so much
    double lever = 1.0;           // what is left of its weight because of its derivatives
  };
  struct Linearisation;

  void find_depths();
  void make_rows();
  void share_depth(Row& row, double share) const;
  void group_rows();
  void bound_levers();
  void add_across(const Linearisation& at, const detail::WatchedPoint& seen, std::size_t frame);
  void add_along(const Linearisation& at, const detail::WatchedPoint& seen, std::size_t frame,
                 const detail::LeftPoint& point);
  [[nodiscard]] NormalEquations normal_equations() const;
  [[nodiscard]] double size_of(const std::vector<std::size_t>& alike) const;
  [[nodiscard]] double pixel_variance(const std::vector<double>& sizes) const;
  void weigh();
  /// To where the weighted rows put the rig. @return whether they have to be made anew there
  [[nodiscard]] bool move_linearisation();
  [[nodiscard]] bool is_mismatched() const;
  void sum_up();
  /// What the frames alone say, without the outliers of the whole window.
  [[nodiscard]] std::vector<FrameHalves> frame_halves() const;
  [[nodiscard]] std::vector<DepthHalves> depth_halves() const;

  detail::WatchedFrames window_;
  RigParameters scale_;  // one plausible error
  double focal_px_;
  Eigen::Index vergence_;  // of beta
  Stage stage_ = Stage::kTracks;
  std::map<detail::TrackStretch, detail::LeftPoint> depths_;
  std::vector<Row> rows_;
  std::vector<std::vector<std::size_t>> groups_;  // of rows that are alike
  std::vector<double> mean_square_noise_;         // of each
  Vector at_ = Vector::Zero();                    // where the rows are made, in plausible errors
  Vector beta_ = Vector::Zero();                  // what they say
  int turns_ = 0;                                 // linearisations so far
  int weighted_ = 0;                              // steps so far at this one
  std::optional<RigEvidence> evidence_;
};

}  // namespace limber
