// SPDX-License-Identifier: MIT
#include "limber/health/window_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "limber/core/factors.hpp"
#include "limber/core/median.hpp"
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
constexpr std::size_t kBlocks = 5;                           // of a window
constexpr int kFewestOfAHalf = 8, kFewestDepthsOfAHalf = 4;  // rows
constexpr int kHuberSteps = 6, kTukeySteps = 4;
constexpr int kStepsPerSlice = 4;
constexpr int kMostLinearisations = 4;
constexpr double kMost = 0.95;  // of the rows of a kind: larger derivatives than theirs count as much
constexpr std::size_t kFewestLevers = 20;
constexpr double kMostMismatched = 0.15;  // of the points of the usual fifth of a window
constexpr double kAsGood = 1.0;           // plausible errors from where the rows were made: linear enough

Vector solve(const NormalEquations& normal) { return Cholesky(normal.information).inverse() * normal.vector; }

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
  rows_.push_back({J, across + J.dot(at.beta), 1.0, 1.0, seen.track.first, seen.cell, false, frame});
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
  detail::PoseSlope slope;
  slope << turned.cross(by_p).transpose(), by_p.transpose() / z;
  const Vector J = focal_px_ * at.derivative(slope);
  rows_.push_back({J, focal_px_ * (along.dot(seen.d1) - predicted) + J.head<6>().dot(at.beta.head<6>()),
                   std::hypot(1.0, noise), 1.0, seen.track.first, seen.cell, true, frame});
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
}

/// What moves a point across its line grows with its disparity, and that of a wrong match is anything: its
/// derivatives are, and a few such rows fit themselves, whatever their residuals were. So a row has no more
/// influence than the largest of most (bounded influence, Mallows' weights [Maronna2006]).
void WindowFit::bound_levers() {
  for (const bool along : {false, true}) {
    for (Eigen::Index k = 0; k < NormalEquations::kSize; ++k) {
      std::vector<double> sizes;
      for (const Row& row : rows_) {
        if (row.along == along) {
          sizes.push_back(std::abs(row.J(k)));
        }
      }
      if (sizes.size() < kFewestLevers) {
        continue;
      }
      const auto most = static_cast<std::size_t>(kMost * static_cast<double>(sizes.size()));
      const double limit = order_statistic(std::move(sizes), most);
      for (Row& row : rows_) {
        const double size = std::abs(row.J(k));
        if (row.along == along && size > limit) {
          row.lever = std::min(row.lever, (limit / size) * (limit / size));
        }
      }
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

/// Some steps of the reweighting: Huber's weights, then Tukey's; scales from the median absolute residual of
/// either kind.
void WindowFit::weigh() {
  const int last = std::min(weighted_ + kStepsPerSlice, kHuberSteps + kTukeySteps);
  for (; weighted_ < last; ++weighted_) {
    std::array<std::vector<double>, 2> off;
    for (const Row& row : rows_) {
      off[row.along].push_back(std::abs(row.y - row.J.dot(beta_)) / row.noise);
    }
    std::array<double, 2> noise{};
    for (std::size_t k = 0; k < 2; ++k) {
      noise[k] = off[k].empty() ? 1.0 : std::max(sigma_of_magnitudes(off[k]), kLeastNoise_px);
    }
    for (Row& row : rows_) {
      const double sigma = noise[row.along] * row.noise;
      const double u = std::abs(row.y - row.J.dot(beta_)) / sigma;
      const double share = u / kTukeyLimit;
      const double weight = weighted_ < kHuberSteps ? (u > kHuberLimit ? kHuberLimit / u : 1.0)
                            : share < 1.0           ? (1.0 - share * share) * (1.0 - share * share)
                                                    : 0.0;
      row.weight = row.lever * weight / (sigma * sigma);
    }
    beta_ = solve(normal_equations());
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

std::vector<FrameHalves> WindowFit::frame_halves() const {
  struct Half {
    NormalEquations normal{kPrior * Matrix::Identity(), Vector::Zero()};
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
          (a.normal.information + b.normal.information - 2.0 * kPrior * Matrix::Identity()) /
          (a.rows + b.rows);
      out[n * kBlocks / halves.size()].add(of_points, solve(a.normal), solve(b.normal));
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
      const double weight = 1.0 / (row.noise * row.noise);
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
