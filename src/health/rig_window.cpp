// SPDX-License-Identifier: MIT
#include "limber/health/rig_window.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "left_track.hpp"
#include "limber/core/factors.hpp"
#include "limber/core/median.hpp"
#include "limber/measure/epipolar.hpp"
#include "limber/sensors/image_cell.hpp"

namespace limber {

using Eigen::Vector3d;
using Matrix = NormalEquations::Matrix;
using Vector = NormalEquations::Vector;

namespace {

constexpr double kPrior = NormalEquations::kPrior;
constexpr std::size_t kFewestPoints = 100;
constexpr std::size_t kMostPoints = 12000;  // of a window
constexpr double kStep = 1e-6;              // of numerical derivatives [rad, m]
constexpr double kMostDepthNoise = 2;       // px that the depth from motion adds, for 1 px of the left pixels
constexpr double kHuberLimit = 1.345, kTukeyLimit = 4.685;
constexpr double kLeastNoise_px = 0.02;
constexpr Eigen::Index kVergence = NormalEquations::kVergence, kLens = NormalEquations::kLens;
constexpr std::size_t kBlocks = 5;  // of a window
constexpr int kFewestOfAHalf = 8;   // rows
constexpr int kHuberSteps = 6, kTukeySteps = 4;
constexpr int kMostLinearisations = 4;
constexpr double kAsGood = 1.0;  // plausible errors from where the rows were made: linear enough

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
std::map<RigWindow::TrackKey, detail::LeftPoint> RigWindow::points() const {
  std::map<TrackKey, std::vector<detail::LeftView>> tracks;
  for (const Frame& frame : frames_) {
    for (const Seen& seen : frame.points) {
      tracks[seen.track].push_back({frame.T_world_cam0, seen.d0});
    }
  }
  std::map<TrackKey, detail::LeftPoint> out;
  for (const auto& [key, views] : tracks) {
    if (const auto point = detail::triangulate(views, focal_px_)) {
      out.emplace(key, *point);
    }
  }
  return out;
}

/// Where rows are linear, and the rigs beside it for their derivatives.
struct RigWindow::Linearisation {
  Vector beta;  // in plausible errors; of the lens what vergence does
  Pose rig;
  std::array<std::pair<Pose, Pose>, 6> moved;

  Linearisation(const Vector& at, const RigParameters& assumed, const RigParameters& scale) : beta(at) {
    beta(kLens) = beta(kVergence);
    const RigParameters theta = assumed + at.head<6>().cwiseProduct(scale);
    rig = pose_from_rig(theta);
    for (Eigen::Index k = 0; k < 6; ++k) {
      const RigParameters step = kStep * RigParameters::Unit(k);
      moved[static_cast<std::size_t>(k)] = {pose_from_rig(theta + step), pose_from_rig(theta - step)};
    }
  }

  /// Of f(rig) by beta.
  template <class F>
  Vector derivative(const F& f, const RigParameters& scale) const {
    Vector J = Vector::Zero();
    for (Eigen::Index k = 0; k < 6; ++k) {
      const auto& [above, below] = moved[static_cast<std::size_t>(k)];
      J(k) = scale(k) * (f(above) - f(below)) / (2.0 * kStep);
    }
    return J;
  }
};

void RigWindow::add_across(const Linearisation& at, const Seen& seen, std::size_t frame,
                           std::vector<Row>& rows) const {
  const auto across = [&](const Pose& rig) {
    return focal_px_ * detail::epipolar_line(seen.d0, rig).dot(seen.d1);
  };
  Vector J = -at.derivative(across, scale_);
  std::swap(J(kVergence), J(kLens));
  rows.push_back({J, across(at.rig) + J.dot(at.beta), 1.0, 1.0, seen.track.first, seen.cell, false, frame});
}

void RigWindow::add_along(const Linearisation& at, const Seen& seen, std::size_t frame,
                          const detail::LeftPoint& point, std::vector<Row>& rows) const {
  const Pose& T_world_cam0 = frames_[frame].T_world_cam0;
  const Vector3d axis = T_world_cam0.R.col(2);
  const double z = axis.dot(point.in_world - T_world_cam0.p);
  const double rho_sigma = std::sqrt(std::max(axis.dot(point.covariance * axis), 0.0)) / (z * z);
  const double noise = at.rig.p.norm() * rho_sigma;  // of the disparity, in those of the left pixel
  if (!(z > 0.0) || !(noise < kMostDepthNoise)) {
    return;
  }
  const Vector3d normal = detail::epipolar_line(seen.d0, at.rig);
  const Vector3d along(normal.y(), -normal.x(), 0.0);
  const auto predicted = [&](const Pose& rig) {
    const Vector3d p = rig.R * seen.d0 + rig.p / z;
    return focal_px_ * along.dot(p) / p.z();
  };
  const Vector J = at.derivative(predicted, scale_);
  rows.push_back({J, focal_px_ * along.dot(seen.d1) - predicted(at.rig) + J.head<6>().dot(at.beta.head<6>()),
                  std::hypot(1.0, noise), 1.0, seen.track.first, seen.cell, true, frame});
}

std::vector<RigWindow::Row> RigWindow::rows_at(const Vector& beta,
                                               const std::map<TrackKey, detail::LeftPoint>& points) const {
  const Linearisation at(beta, calibration_.theta, scale_);
  std::vector<Row> rows;
  rows.reserve(2 * seen_);
  for (std::size_t n = 0; n < frames_.size(); ++n) {
    for (const Seen& seen : frames_[n].points) {
      add_across(at, seen, n, rows);
      if (const auto point = points.find(seen.track); point != points.end()) {
        add_along(at, seen, n, point->second, rows);
      }
    }
  }
  return rows;
}

std::optional<RigEvidence> RigWindow::close() {
  std::optional<RigEvidence> out = evidence();
  frames_.clear();
  return out;
}

NormalEquations RigWindow::normal_equations(const std::vector<Row>& rows) {
  NormalEquations out;
  out.information.diagonal().setConstant(kPrior);
  for (const Row& row : rows) {
    out.information.noalias() += row.weight * row.J * row.J.transpose();
    out.vector += row.weight * row.y * row.J;
  }
  return out;
}

/// Huber's weights, then Tukey's; scales from the median absolute residual of either kind.
Vector RigWindow::weigh(std::vector<Row>& rows) {
  Vector beta = Vector::Zero();
  for (int step = 0; step < kHuberSteps + kTukeySteps; ++step) {
    std::array<std::vector<double>, 2> off;
    for (const Row& row : rows) {
      off[row.along].push_back(std::abs(row.y - row.J.dot(beta)) / row.noise);
    }
    std::array<double, 2> noise{};
    for (std::size_t k = 0; k < 2; ++k) {
      noise[k] = off[k].empty() ? 1.0 : std::max(1.4826 * upper_median(off[k]), kLeastNoise_px);
    }
    for (Row& row : rows) {
      const double sigma = noise[row.along] * row.noise;
      const double u = std::abs(row.y - row.J.dot(beta)) / sigma;
      const double share = u / kTukeyLimit;
      const double weight = step < kHuberSteps ? (u > kHuberLimit ? kHuberLimit / u : 1.0)
                            : share < 1.0      ? (1.0 - share * share) * (1.0 - share * share)
                                               : 0.0;
      row.weight = weight / (sigma * sigma);
    }
    solve(normal_equations(rows), beta);
  }
  return beta;
}

/// The robust fit, linear about a rig that is near the one it finds. What is hardly seen stays as assumed.
std::vector<RigWindow::Row> RigWindow::fit(Vector& beta) const {
  const std::map<TrackKey, detail::LeftPoint> seen_from_the_left = points();
  Vector at = Vector::Zero();
  for (int turn = 1;; ++turn) {
    std::vector<Row> rows = rows_at(at, seen_from_the_left);
    beta = weigh(rows);
    const Matrix information = normal_equations(rows).information;
    const Vector next = Cholesky(information + Matrix::Identity()).solve(information * beta);
    if (turn == kMostLinearisations || (next - at).head<6>().cwiseAbs().maxCoeff() < kAsGood) {
      return rows;
    }
    at = next;
  }
}

std::optional<RigEvidence> RigWindow::evidence() const {
  if (seen_ < kFewestPoints) {
    return std::nullopt;
  }
  Vector delta;
  const std::vector<Row> rows = fit(delta);
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
