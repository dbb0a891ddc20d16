// SPDX-License-Identifier: MIT
#include "limber/health/rig_window.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "limber/core/factors.hpp"
#include "limber/core/median.hpp"
#include "limber/measure/epipolar.hpp"
#include "limber/sensors/image_cell.hpp"

namespace limber {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix = NormalEquations::Matrix;
using Vector = NormalEquations::Vector;

namespace {

constexpr double kPrior = NormalEquations::kPrior;
constexpr std::size_t kFewestPoints = 100;
constexpr std::size_t kMostPoints = 12000;  // of a window
constexpr double kStep = 1e-6;              // of numerical derivatives [rad, m]
constexpr double kMostDepthNoise = 2;       // px that the depth from motion adds, for 1 px of the left pixels
constexpr double kMoving_px = 3.0;  // rms of a track's left pixels about one point: it moved, or is none
constexpr std::size_t kShortestTrack = 4;  // frames
constexpr int kPixelSteps = 4;             // of Gauss-Newton on a point
constexpr double kHuberLimit = 1.345, kTukeyLimit = 4.685;
constexpr double kLeastNoise_px = 0.02;
constexpr Eigen::Index kVergence = NormalEquations::kVergence, kLens = NormalEquations::kLens;
constexpr std::size_t kBlocks = 5;  // of a window
constexpr int kFewestOfAHalf = 8;   // rows
constexpr int kHuberSteps = 6, kTukeySteps = 4;

/// One camera's sight of a point.
struct View {
  Pose T_world_cam0;
  Vector3d d0;  // z = 1
};

/// The point nearest to all rays, by distance over range. Noise of the bearings draws it nearer.
Vector3d midpoint(const std::vector<View>& views) {
  const Vector3d& origin = views.front().T_world_cam0.p;
  Vector3d point = origin;
  for (int step = 0; step < 3; ++step) {
    Matrix3d N = Matrix3d::Zero();
    Vector3d n = Vector3d::Zero();
    for (const View& view : views) {
      const Vector3d bearing = (view.T_world_cam0.R * view.d0).normalized();
      const double range2 = step == 0 ? 1.0 : std::max((point - view.T_world_cam0.p).squaredNorm(), 1e-6);
      const Matrix3d across = (Matrix3d::Identity() - bearing * bearing.transpose()) / range2;
      N += across;
      n += across * (view.T_world_cam0.p - origin);
    }
    point = origin + N.ldlt().solve(n);
  }
  return point;
}

/// Normal equations of the point's pixels (z = 1), which noise does not draw nearer.
struct PixelEquations {
  Matrix3d information = Matrix3d::Zero();
  Vector3d vector = Vector3d::Zero();
  double squares = 0.0;
  bool in_front = true;
};

PixelEquations pixel_equations(const std::vector<View>& views, const Vector3d& point) {
  PixelEquations out;
  for (const View& view : views) {
    const Matrix3d& R = view.T_world_cam0.R;
    const Vector3d p = R.transpose() * (point - view.T_world_cam0.p);
    if (!(p.z() > 0.0)) {
      out.in_front = false;
      return out;
    }
    const Eigen::Vector2d r = view.d0.head<2>() - p.head<2>() / p.z();
    Eigen::Matrix<double, 2, 3> J;
    J << 1.0, 0.0, -p.x() / p.z(), 0.0, 1.0, -p.y() / p.z();
    J = (J / p.z() * R.transpose()).eval();
    out.information.noalias() += J.transpose() * J;
    out.vector.noalias() += J.transpose() * r;
    out.squares += r.squaredNorm();
  }
  return out;
}

Matrix solve(const NormalEquations& normal, Vector& beta) {
  const Matrix inverse = Cholesky(normal.information).inverse();
  beta = inverse * normal.vector;
  return inverse;
}

}  // namespace

NormalEquations::Vector NormalEquations::score(const Vector& beta) const {
  return vector - information * beta;
}

NormalEquations& NormalEquations::operator+=(const NormalEquations& other) {
  information += other.information;
  vector += other.vector;
  return *this;
}

RigWindow::RigWindow(const StereoCalibration& calibration)
    : calibration_(calibration),
      scale_(plausible_error(calibration.baseline())),
      focal_px_(calibration.cam1.fu) {}

void RigWindow::add(const StereoFrame& frame, const Pose& T_world_cam0, bool follows) {
  if (frames_.empty()) {
    from_ns_ = frame.t_ns;
    stretch_ = 0;
    seen_ = 0;
  }
  last_ns_ = frame.t_ns;
  stretch_ += follows ? 0 : 1;
  Frame& kept = frames_.emplace_back(Frame{T_world_cam0, {}});
  for (const StereoObservation& o : frame.observations) {
    if (!o.in_cam0 || !o.in_cam1 || seen_ >= kMostPoints) {
      continue;
    }
    const auto d0 = unproject(calibration_.cam0, o.uv_cam0), d1 = unproject(calibration_.cam1, o.uv_cam1);
    if (d0 && d1 && d0->z() > 0.0 && d1->z() > 0.0) {
      kept.points.push_back({{o.track_id, stretch_}, *d0 / d0->z(), *d1 / d1->z(), image_cell(o.uv_cam1)});
      ++seen_;
    }
  }
}

/// Where the left camera alone, as it moved, sees each track; only where it moved enough.
void RigWindow::triangulate() {
  points_.clear();
  std::map<TrackKey, std::vector<View>> tracks;
  for (const Frame& frame : frames_) {
    for (const Seen& seen : frame.points) {
      tracks[seen.track].push_back({frame.T_world_cam0, seen.d0});
    }
  }
  for (const auto& [key, views] : tracks) {
    if (views.size() < kShortestTrack) {
      continue;
    }
    Vector3d point = midpoint(views);
    PixelEquations pixels;
    for (int step = 0; step < kPixelSteps && pixels.in_front; ++step) {
      pixels = pixel_equations(views, point);
      point += pixels.information.ldlt().solve(pixels.vector);
    }
    pixels = pixel_equations(views, point);
    const double rms = std::sqrt(pixels.squares / static_cast<double>(views.size()));
    if (pixels.in_front && rms * focal_px_ <= kMoving_px) {
      points_[key] = {point, pixels.information.ldlt().solve(Matrix3d::Identity())};
    }
  }
}

void RigWindow::add_rows(std::size_t index, const Seen& seen, std::vector<Row>& rows) const {
  const Frame& frame = frames_[index];
  const Pose assumed = pose_from_rig(calibration_.theta);
  std::array<std::pair<Pose, Pose>, 6> moved;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const RigParameters step = kStep * RigParameters::Unit(k);
    moved[static_cast<std::size_t>(k)] = {pose_from_rig(calibration_.theta + step),
                                          pose_from_rig(calibration_.theta - step)};
  }
  const auto derivative = [&](const auto& f) {
    Vector J = Vector::Zero();
    for (Eigen::Index k = 0; k < 6; ++k) {
      const auto& [above, below] = moved[static_cast<std::size_t>(k)];
      J(k) = focal_px_ * scale_(k) * (f(above) - f(below)) / (2.0 * kStep);
    }
    return J;
  };
  const auto across = [&](const Pose& rig) { return detail::epipolar_line(seen.d0, rig).dot(seen.d1); };
  Vector J_across = -derivative(across);
  std::swap(J_across(kVergence), J_across(kLens));
  rows.push_back(
      {J_across, focal_px_ * across(assumed), 1.0, 1.0, seen.track.first, seen.cell, false, index});
  const auto point = points_.find(seen.track);
  if (point == points_.end()) {
    return;
  }
  const Vector3d in_cam0 = frame.T_world_cam0.R.transpose() * (point->second.in_world - frame.T_world_cam0.p);
  const Vector3d axis = frame.T_world_cam0.R.col(2);
  const double z = in_cam0.z();
  const double rho_sigma = std::sqrt(std::max(axis.dot(point->second.covariance * axis), 0.0)) / (z * z);
  const double noise = assumed.p.norm() * rho_sigma;  // of the disparity, in those of the left pixel
  if (!(z > 0.0) || !(noise < kMostDepthNoise)) {
    return;
  }
  const auto predicted = [&](const Pose& rig) -> Vector3d {
    const Vector3d p = rig.R * seen.d0 + rig.p / z;
    return p / p.z();
  };
  const Vector3d normal = detail::epipolar_line(seen.d0, assumed);
  const Vector3d along(normal.y(), -normal.x(), 0.0);
  rows.push_back({derivative([&](const Pose& rig) { return along.dot(predicted(rig)); }),
                  focal_px_ * along.dot(seen.d1 - predicted(assumed)), std::hypot(1.0, noise), 1.0,
                  seen.track.first, seen.cell, true, index});
}

std::optional<RigEvidence> RigWindow::close() {
  std::optional<RigEvidence> out = evidence();
  frames_.clear();
  return out;
}

std::optional<RigEvidence> RigWindow::evidence() {
  if (seen_ < kFewestPoints) {
    return std::nullopt;
  }
  triangulate();
  std::vector<Row> rows;
  rows.reserve(2 * seen_);
  for (std::size_t n = 0; n < frames_.size(); ++n) {
    for (const Seen& seen : frames_[n].points) {
      add_rows(n, seen, rows);
    }
  }
  Vector delta = Vector::Zero();
  const auto normal_of = [&] {
    NormalEquations out;
    out.information.diagonal().setConstant(kPrior);
    for (const Row& row : rows) {
      out.information.noalias() += row.weight * row.J * row.J.transpose();
      out.vector += row.weight * row.y * row.J;
    }
    return out;
  };
  for (int step = 0; step < kHuberSteps + kTukeySteps; ++step) {
    std::array<std::vector<double>, 2> off;
    for (const Row& row : rows) {
      off[row.along].push_back(std::abs(row.y - row.J.dot(delta)) / row.noise);
    }
    std::array<double, 2> noise{};
    for (std::size_t k = 0; k < 2; ++k) {
      noise[k] = off[k].empty() ? 1.0 : std::max(1.4826 * upper_median(off[k]), kLeastNoise_px);
    }
    for (Row& row : rows) {
      const double sigma = noise[row.along] * row.noise;
      const double u = std::abs(row.y - row.J.dot(delta)) / sigma;
      const double share = u / kTukeyLimit;
      const double weight = step < kHuberSteps ? (u > kHuberLimit ? kHuberLimit / u : 1.0)
                            : share < 1.0      ? (1.0 - share * share) * (1.0 - share * share)
                                               : 0.0;
      row.weight = weight / (sigma * sigma);
    }
    solve(normal_of(), delta);
  }
  RigEvidence out;
  out.from_ns = from_ns_;
  out.to_ns = last_ns_;
  std::unordered_map<std::int64_t, Vector> tracks;
  std::map<std::pair<std::int64_t, int>, Vector> both;
  for (const Row& row : rows) {
    const NormalEquations one{row.weight * row.J * row.J.transpose(), row.weight * row.y * row.J};
    out.all += one;
    out.cells[row.cell] += one;
    const Vector score = one.score(delta);
    tracks.try_emplace(row.track, Vector::Zero()).first->second += score;
    both.try_emplace({row.track, row.cell}, Vector::Zero()).first->second += score;
    if (row.along) {
      ++out.deep;
    } else if (row.weight > 0.0) {
      Vector of_the_rig = row.J;  // what the lens does is not the rig's error
      std::swap(of_the_rig(kVergence), of_the_rig(kLens));
      out.epipolar.noalias() += of_the_rig * of_the_rig.transpose();
      ++out.points;
    }
  }
  for (const auto& [id, score] : tracks) {
    out.tracks.noalias() += score * score.transpose();
  }
  for (const auto& [id, score] : both) {
    out.both.noalias() += score * score.transpose();
  }
  out.track_count = tracks.size();
  out.blocks = blocks(rows);
  return out;
}

std::vector<FrameHalves> RigWindow::blocks(const std::vector<Row>& rows) const {
  struct Half {
    NormalEquations normal{kPrior * Matrix::Identity(), Vector::Zero()};
    int rows = 0;
  };
  // Weights that fall with the distance from the mean would make every movement look smaller: all or nothing.
  std::vector<std::array<Half, 2>> halves(frames_.size());
  for (const Row& row : rows) {
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
      Vector first, second;
      solve(a.normal, first);
      solve(b.normal, second);
      out[n * kBlocks / halves.size()].add(first, second);
    }
  }
  return out;
}

}  // namespace limber
