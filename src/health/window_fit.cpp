// SPDX-License-Identifier: MIT
#include "limber/health/window_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "limber/core/factors.hpp"
#include "limber/core/median.hpp"
#include "limber/health/bounded_influence.hpp"
#include "limber/health/rig_movement.hpp"
#include "limber/measure/epipolar.hpp"

namespace limber {

using Eigen::Vector3d;

namespace {

using Matrix = NormalEquations::Matrix;
using Vector = NormalEquations::Vector;

constexpr double kPrior = NormalEquations::kPrior;
constexpr std::size_t kFewestPoints = 100;
constexpr double kMostDepthNoise = 2;  // px that the depth from motion adds, for 1 px of the left pixels
constexpr double kHuberLimit = 1.345, kTukeyLimit = 4.685;
constexpr double kLeastNoise_px = 0.02;
constexpr Eigen::Index kLens = NormalEquations::kLens;
constexpr int kHuberSteps = 6, kTukeySteps = 4;
constexpr int kStepsPerSlice = 4;
constexpr int kMostLinearisations = 4;
constexpr std::size_t kThirds = 3;
constexpr double kNearEpipole = 1e-3;     // [rad], where no depth shows
constexpr double kApart = 1.5;            // variances of depths that tell what they do
constexpr double kMostMismatched = 0.15;  // of the points of the usual fifth of a window
constexpr double kAsGood = 1.0;           // plausible errors from where the rows were made: linear enough

/// Of the rows of one track.
struct TrackSums {
  Matrix information = Matrix::Zero();
  TrackScores scores;
  std::array<double, kKinds> weight{}, off{};  // sums of weights, and of weighted residuals
};

/// A fit follows each of its tracks, which leaves them too small a score. Taken is what a track has in a fit
/// without it (a jackknife): of a hundred tracks little more, of ten several times as much.
void sum_up_tracks(std::map<std::int64_t, TrackSums>& tracks, const Matrix& information, RigEvidence& out) {
  for (auto& [id, track] : tracks) {
    const Cholesky others(information - track.information);
    Vector moved = Vector::Zero();  // the estimate, by the track
    for (auto& [cell, score] : track.scores.cells) {
      const Vector by_cell = others.solve(score);
      moved += by_cell;
      score = information * by_cell;
    }
    for (std::size_t kind = 0; kind < kKinds; ++kind) {
      const double without = track.off[kind] + track.scores.of_a_pixel[kind].dot(moved);
      out.errors.squares[kind] += track.off[kind] * without / std::max(track.weight[kind], 1e-30);
      out.errors.weights[kind] += track.weight[kind];
    }
    out.tracks.emplace_hint(out.tracks.end(), id, std::move(track.scores));
  }
  out.products = products_of(out.tracks, out.tracks);
  out.track_count = out.tracks.size();
}

}  // namespace

struct WindowFit::Linearisation {
  Vector beta;  // in plausible errors; of the lens what vergence does
  Pose rig;
  Eigen::Matrix<double, 6, 6> by_beta;  // turn and translation of the rig

  Linearisation(const Vector& at, const RigParameters& assumed, const RigParameters& scale) : beta(at) {
    beta(kLens) = beta(vergence_axis(assumed));
    const RigParameters theta = assumed + at.head<6>().cwiseProduct(scale);
    rig = pose_from_rig(theta);
    by_beta = detail::pose_by_theta(theta) * scale.asDiagonal();
  }

  /// By beta, of what has that derivative by turn and translation.
  [[nodiscard]] Vector derivative(const detail::PoseSlope& slope) const {
    Vector J = Vector::Zero();
    J.head<6>() = (slope * by_beta).transpose();
    return J;
  }
};

WindowFit::WindowFit(detail::WatchedFrames window)
    : window_(std::move(window)),
      scale_(plausible_error(window_.calibration.baseline())),
      focal_px_(window_.calibration.cam1.fu),
      vergence_(vergence_axis(window_.calibration.theta)) {
  if (window_.points < kFewestPoints) {
    stage_ = Stage::kDone;
  }
}

void WindowFit::advance() {
  switch (stage_) {
    case Stage::kTracks:
      find_depths();
      stage_ = Stage::kRows;
      break;
    case Stage::kRows:
      make_rows();
      stage_ = Stage::kLevers;
      break;
    case Stage::kLevers:
      bound_levers();
      stage_ = Stage::kWeights;
      break;
    case Stage::kWeights:
      weigh();
      if (weighted_ == kHuberSteps + kTukeySteps) {
        stage_ = move_linearisation() ? Stage::kRows : is_mismatched() ? Stage::kDone : Stage::kSums;
      }
      break;
    case Stage::kSums:
      sum_up();
      stage_ = Stage::kMovement;
      break;
    case Stage::kMovement:
      evidence_->blocks = frame_halves();
      evidence_->depth_blocks = depth_halves();
      stage_ = Stage::kDone;
      break;
    case Stage::kDone:
      break;
  }
}

/// Where the left camera alone, as it moved, sees each track; only where it moved enough.
void WindowFit::find_depths() {
  std::map<detail::TrackStretch, std::vector<detail::LeftView>> tracks;
  for (const detail::WatchedFrame& frame : window_.frames) {
    for (const detail::WatchedPoint& seen : frame.points) {
      tracks[seen.track].push_back({frame.T_world_cam0, seen.d0});
    }
  }
  for (const auto& [key, views] : tracks) {
    if (const auto point = detail::triangulate(views, focal_px_)) {
      depths_.emplace(key, *point);
    }
  }
}

void WindowFit::add_across(const Linearisation& at, const detail::WatchedPoint& seen, std::size_t frame) {
  const StereoBearings pair{seen.d0, seen.d1};
  Vector J = -focal_px_ * at.derivative(detail::epipolar_slope(pair, at.rig));
  std::swap(J(vergence_), J(kLens));
  const double across = focal_px_ * detail::epipolar_error(pair, at.rig);
  rows_.push_back({J, across + J.dot(at.beta), 1.0, 1.0, 1.0, seen.track.first, seen.cell, false, frame});
}

void WindowFit::add_along(const Linearisation& at, const detail::WatchedPoint& seen, std::size_t frame,
                          const detail::LeftPoint& point) {
  const Pose& T_world_cam0 = window_.frames[frame].T_world_cam0;
  const Vector3d axis = T_world_cam0.R.col(2);
  const double z = axis.dot(point.in_world - T_world_cam0.p);
  const double rho_sigma = std::sqrt(std::max(axis.dot(point.covariance * axis), 0.0)) / (z * z);
  const double noise = at.rig.p.norm() * rho_sigma;  // of the disparity, in those of the left pixel
  if (!(z > 0.0) || !(noise < kMostDepthNoise)) {
    return;
  }
  const Vector3d normal = detail::epipolar_line(seen.d0, at.rig);
  const Vector3d along(normal.y(), -normal.x(), 0.0);
  const Vector3d turned = at.rig.R * seen.d0, p = turned + at.rig.p / z;
  const double predicted = along.dot(p) / p.z();
  const Vector3d by_p = (along - predicted * Vector3d::UnitZ()) / p.z();
  const double by_inverse_depth = by_p.dot(at.rig.p), off = along.dot(seen.d1) - predicted;
  if (!(std::abs(by_inverse_depth) > kNearEpipole * at.rig.p.norm())) {
    return;
  }
  detail::PoseSlope slope, of_right = detail::PoseSlope::Zero();
  slope << turned.cross(by_p).transpose(), by_p.transpose() / z;
  of_right.tail<3>() = by_p.transpose() * (off / by_inverse_depth);  // at the depth that the right pixel says
  const Vector J = focal_px_ * at.derivative(slope);
  rows_.push_back({J, focal_px_ * off + J.head<6>().dot(at.beta.head<6>()), std::hypot(1.0, noise), 1.0, 1.0,
                   seen.track.first, seen.cell, true, frame,
                   focal_px_ * at.derivative(of_right).segment<3>(3)});
  share_depth(rows_.back(), 1.0);
}

/// A depth is known from the motion and from the right pixel. A derivative at a depth that is off goes with
/// its own residual, and the baseline is found too short by the errors of the one or too long by those of the
/// other (errors in variables); at the mean of both by their variances the two effects cancel.
/// @param share  of the right pixel's
void WindowFit::share_depth(Row& row, double share) const {
  const Vector3d by = (share - row.share) * row.of_right;
  row.J.segment<3>(3) += by;
  row.y += by.dot(at_.segment<3>(3));
  row.share = share;
}

void WindowFit::make_rows() {
  const Linearisation at(at_, window_.calibration.theta, scale_);
  ++turns_;
  weighted_ = 0;
  beta_.setZero();
  rows_.clear();
  rows_.reserve(2 * window_.points);
  for (std::size_t n = 0; n < window_.frames.size(); ++n) {
    for (const detail::WatchedPoint& seen : window_.frames[n].points) {
      add_across(at, seen, n);
      if (const auto point = depths_.find(seen.track); point != depths_.end()) {
        add_along(at, seen, n, point->second);
      }
    }
  }
  group_rows();
}

/// By kind; those along in thirds, by how well their depths are known.
void WindowFit::group_rows() {
  std::vector<std::size_t> across, along;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    (rows_[k].along ? along : across).push_back(k);
  }
  groups_ = {std::move(across)};
  auto from = along.begin();
  for (std::size_t left = kThirds; left > 0; --left) {
    const auto to = from + (along.end() - from) / static_cast<std::ptrdiff_t>(left);
    std::nth_element(from, to, along.end(), [&](auto a, auto b) { return rows_[a].noise < rows_[b].noise; });
    groups_.emplace_back(from, to);
    from = to;
  }
  mean_square_noise_.clear();
  for (const std::vector<std::size_t>& alike : groups_) {
    double sum = 0.0;
    for (const std::size_t k : alike) {
      sum += rows_[k].noise * rows_[k].noise;
    }
    mean_square_noise_.push_back(alike.empty() ? 1.0 : sum / static_cast<double>(alike.size()));
  }
}

void WindowFit::bound_levers() {
  for (const std::vector<std::size_t>& alike : groups_) {
    if (alike.empty()) {
      continue;
    }
    Eigen::MatrixXd J(static_cast<Eigen::Index>(alike.size()), NormalEquations::kSize);
    for (Eigen::Index k = 0; k < J.rows(); ++k) {
      J.row(k) = rows_[alike[static_cast<std::size_t>(k)]].J;
    }
    const Eigen::VectorXd levers = detail::lever_weights(J);
    for (Eigen::Index k = 0; k < J.rows(); ++k) {
      rows_[alike[static_cast<std::size_t>(k)]].lever = levers(k);
    }
  }
}

NormalEquations WindowFit::normal_equations() const {
  NormalEquations out;
  out.information.diagonal().setConstant(kPrior);
  for (const Row& row : rows_) {
    out.information.noalias() += row.weight * row.J * row.J.transpose();
    out.vector += row.weight * row.y * row.J;
  }
  return out;
}

/// Size of the residuals of rows that are alike, over their `noise`.
double WindowFit::size_of(const std::vector<std::size_t>& alike) const {
  std::vector<double> off;
  for (const std::size_t k : alike) {
    off.push_back(std::abs(rows_[k].y - rows_[k].J.dot(beta_)) / rows_[k].noise);
  }
  return off.empty() ? 1.0 : std::max(sigma_of_magnitudes(std::move(off)), kLeastNoise_px);
}

/// Variance of the right pixel along its line [px²], which is no less than across it: what the residuals of
/// the best and of the worst known depths leave where depths are exact.
double WindowFit::pixel_variance(const std::vector<double>& sizes) const {
  const double best = mean_square_noise_[1], worst = mean_square_noise_[kThirds];
  const double of_best = sizes[1] * sizes[1] * best, of_worst = sizes[kThirds] * sizes[kThirds] * worst;
  const double across = std::min(sizes[0] * sizes[0], of_best);
  if (!(worst - 1.0 > kApart * (best - 1.0))) {
    return across;
  }
  return std::clamp(of_best - (best - 1.0) * (of_worst - of_best) / (worst - best), across, of_best);
}

/// Some steps of the reweighting: Huber's weights, then Tukey's; scales from the median absolute residual of
/// the rows across, and of those along whose depths are about as well known: what pixels share in a track is
/// no white noise, and depths are worse than it has them.
void WindowFit::weigh() {
  const int last = std::min(weighted_ + kStepsPerSlice, kHuberSteps + kTukeySteps);
  for (; weighted_ < last; ++weighted_) {
    std::vector<double> sizes;
    for (const std::vector<std::size_t>& alike : groups_) {
      sizes.push_back(size_of(alike));
    }
    const double of_pixels = pixel_variance(sizes);
    for (std::size_t group = 0; group < groups_.size(); ++group) {
      for (const std::size_t k : groups_[group]) {
        Row& row = rows_[k];
        row.sigma = sizes[group] * row.noise;
        const double u = std::abs(row.y - row.J.dot(beta_)) / row.sigma, share = u / kTukeyLimit;
        const double weight = weighted_ < kHuberSteps ? (u > kHuberLimit ? kHuberLimit / u : 1.0)
                              : share < 1.0           ? (1.0 - share * share) * (1.0 - share * share)
                                                      : 0.0;
        row.weight = row.lever * weight / (row.sigma * row.sigma);
        if (row.along) {
          share_depth(row, std::max(1.0 - of_pixels / (row.sigma * row.sigma), 0.0));
        }
      }
    }
    beta_ = normal_equations().solution();
  }
}

/// What is hardly seen stays as assumed.
bool WindowFit::move_linearisation() {
  const Matrix information = normal_equations().information;
  const Vector next = Cholesky(information + Matrix::Identity()).solve(information * beta_);
  const bool near_enough =
      turns_ == kMostLinearisations || (next - at_).head<6>().cwiseAbs().maxCoeff() < kAsGood;
  at_ = next;
  return !near_enough;
}

/// The usual fifth has so many points that no rig puts on their lines that a wrong rig may suit some of them:
/// a sum of bounded influences follows what has no mean. A rig that steps leaves most fifths whole.
bool WindowFit::is_mismatched() const {
  std::array<std::array<double, 2>, kBlocks> of_block{};  // points, and those without a weight
  for (const Row& row : rows_) {
    if (!row.along) {
      auto& [points, wrong] = of_block[row.frame * kBlocks / window_.frames.size()];
      points += 1.0;
      wrong += row.weight > 0.0 ? 0.0 : 1.0;
    }
  }
  std::vector<double> shares;
  for (const auto& [points, wrong] : of_block) {
    if (points > 0.0) {
      shares.push_back(wrong / points);
    }
  }
  return !shares.empty() && upper_median(std::move(shares)) > kMostMismatched;
}

void WindowFit::sum_up() {
  RigEvidence& out = evidence_.emplace();
  out.from_ns = window_.from_ns;
  out.to_ns = window_.to_ns;
  std::map<std::int64_t, TrackSums> tracks;
  std::unordered_set<std::int64_t> deep;
  for (const Row& row : rows_) {
    const NormalEquations one{row.weight * row.J * row.J.transpose(), row.weight * row.y * row.J};
    out.all += one;
    out.cells[row.cell] += one;
    TrackSums& track = tracks[row.track];
    track.information += one.information;
    track.scores.cells.try_emplace(row.cell, Vector::Zero()).first->second += one.score(beta_);
    track.scores.of_a_pixel[row.along] += row.weight * row.J;
    track.weight[row.along] += row.weight;
    track.off[row.along] += row.weight * (row.y - row.J.dot(beta_));
    if (row.along) {
      ++out.deep;
      if (row.weight > 0.0) {
        deep.insert(row.track);
      }
    } else if (row.weight > 0.0) {
      Vector of_the_rig = row.J;  // what the lens does is not the rig's error
      std::swap(of_the_rig(vergence_), of_the_rig(kLens));
      out.epipolar.noalias() += of_the_rig * of_the_rig.transpose();
      ++out.points;
    }
  }
  sum_up_tracks(tracks, kPrior * Matrix::Identity() + out.all.information, out);
  out.deep_tracks = deep.size();
}

}  // namespace limber
