// SPDX-License-Identifier: MIT
#include "limber/health/tolerance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "limber/core/factors.hpp"

namespace limber {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

namespace {

constexpr double k95 = 1.96;

void check_band(const Band& band, const std::string& name) {
  if (!(band.ok > 0.0) || !(band.wrong >= band.ok) || !std::isfinite(band.wrong)) {
    throw std::invalid_argument("tolerance: " + name + " is " + std::to_string(band.ok) + " and " +
                                std::to_string(band.wrong) + ", expected 0 < ok <= wrong");
  }
}

SizeInterval about(double value, double sigma) {
  const double size = std::abs(value);
  return {size, std::max(size - k95 * sigma, 0.0), size + k95 * sigma};
}

constexpr double kNoEffect = 1e-3;  // [px, shares of a depth by rad, m]: others have hundreds

/// Infinite where nothing of it shows.
double error_with_effect(double slope, double effect) {
  return std::abs(slope) > kNoEffect ? effect / std::abs(slope) : std::numeric_limits<double>::infinity();
}

}  // namespace

std::string to_string(HealthVerdict verdict) {
  switch (verdict) {
    case HealthVerdict::kOk:
      return "ok";
    case HealthVerdict::kSuspect:
      return "suspect";
    case HealthVerdict::kDegraded:
      return "degraded";
    case HealthVerdict::kDecalibrated:
      return "decalibrated";
    case HealthVerdict::kCannotTell:
      break;
  }
  return "cannot tell";
}

bool is_wrong(HealthVerdict verdict) {
  return verdict == HealthVerdict::kDegraded || verdict == HealthVerdict::kDecalibrated;
}

void Tolerance::check() const {
  check_band(epipolar_px, "the epipolar error");
  check_band(depth, "the depth");
  for (const auto& band : axes) {
    if (band) {
      check_band(*band, "an axis");
    }
  }
  if (!(baselines > 0.0) || !std::isfinite(baselines)) {
    throw std::invalid_argument("tolerance: " + std::to_string(baselines) +
                                " baselines, expected a positive number");
  }
}

HealthVerdict judge(const SizeInterval& interval, const Band& band) {
  if (interval.low > band.wrong) {
    return HealthVerdict::kDecalibrated;
  }
  if (interval.low > band.ok) {
    return HealthVerdict::kDegraded;
  }
  return interval.high <= band.ok ? HealthVerdict::kOk : HealthVerdict::kCannotTell;
}

RigParameters depth_slope(const RigParameters& theta, double baselines) {
  constexpr double kDifference = 1e-7;
  const Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ();
  const double depth = baselines * theta.tail<3>().norm();
  const Pose assumed = pose_from_rig(theta);
  // Where the right camera sees the point, along the line that the depth moves it on.
  const auto image = [&](const Pose& rig, double z) -> Eigen::Vector2d {
    return (rig * Eigen::Vector3d(z * ahead)).hnormalized();
  };
  const double dz = 1e-4 * depth;
  const Eigen::Vector2d by_depth = (image(assumed, depth + dz) - image(assumed, depth - dz)) / (2.0 * dz);
  RigParameters slope;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const RigParameters step = kDifference * RigParameters::Unit(k);
    const Eigen::Vector2d by_theta =
        (image(pose_from_rig(theta + step), depth) - image(pose_from_rig(theta - step), depth)) /
        (2.0 * kDifference);
    slope(k) = by_theta.dot(by_depth) / by_depth.squaredNorm() / depth;
  }
  return slope;
}

RigParameters visible_slope(const RigParameters& theta, bool metric, const Tolerance& tolerance) {
  RigParameters slope = depth_slope(theta, tolerance.baselines);
  if (!metric) {
    const Eigen::Vector3d along = theta.tail<3>().normalized();
    slope.tail<3>() -= along * along.dot(slope.tail<3>());
  }
  return slope;
}

SizeInterval root_of_form(const Eigen::VectorXd& x, const Eigen::MatrixXd& covariance,
                          const Eigen::MatrixXd& M) {
  const Eigen::MatrixXd MV = M * covariance;
  const double mean = std::max(x.dot(M * x) - MV.trace(), 0.0);
  const double variance = 2.0 * (MV * MV).trace() + 4.0 * x.dot(MV * M * x);
  const double sigma = std::sqrt(std::max(variance, 0.0));
  return {std::sqrt(mean), std::sqrt(std::max(mean - k95 * sigma, 0.0)), std::sqrt(mean + k95 * sigma)};
}

CalibrationEffect effect_of(const BetaEstimate& estimate, const RigParameters& theta,
                            const RigParameters& slope) {
  const RigEstimate rig = estimate.rig(theta);
  CalibrationEffect out;
  out.epipolar_px = root_of_form(estimate.beta, estimate.covariance, estimate.epipolar);
  out.depth_signed = slope.dot(rig.delta);
  out.depth = about(out.depth_signed, std::sqrt(std::max(slope.dot(rig.covariance * slope), 0.0)));
  return out;
}

std::array<Band, 6> axis_bands(const Tolerance& tolerance, const RigParameters& px,
                               const RigParameters& slope) {
  std::array<Band, 6> out;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const auto reached = [&](double epipolar_px, double depth) {
      return std::min(error_with_effect(px(k), epipolar_px), error_with_effect(slope(k), depth));
    };
    out[i] = tolerance.axes[i].value_or(Band{reached(tolerance.epipolar_px.ok, tolerance.depth.ok),
                                             reached(tolerance.epipolar_px.wrong, tolerance.depth.wrong)});
  }
  return out;
}

SizeInterval axis_size(const RigEstimate& estimate, Eigen::Index axis) {
  return about(estimate.delta(axis), std::sqrt(estimate.covariance(axis, axis)));
}

Eigen::Index most_likely_axis(const RigEstimate& estimate, const std::array<Band, 6>& bands) {
  const RigParameters sigma = estimate.sigma(), unit = sigma.cwiseInverse();
  Matrix6 correlation = unit.asDiagonal() * estimate.covariance * unit.asDiagonal();
  correlation.diagonal().array() += 1e-9;
  const Matrix6 inverse = Cholesky(correlation).inverse();
  const RigParameters evidence = inverse * unit.cwiseProduct(estimate.delta);
  RigParameters explained = evidence.cwiseAbs2().cwiseQuotient(inverse.diagonal());
  const RigParameters alone = sigma.cwiseProduct(evidence.cwiseQuotient(inverse.diagonal()));
  Eigen::Index best = 0;
  explained.maxCoeff(&best);
  for (Eigen::Index k = 0; k < 6; ++k) {
    if (std::abs(alone(k)) <= bands[static_cast<std::size_t>(k)].ok) {
      explained(k) = 0.0;
    }
  }
  if (explained.maxCoeff() > 0.0) {
    explained.maxCoeff(&best);
  }
  return best;
}

HealthVerdict worst(HealthVerdict a, HealthVerdict b) {
  const auto rank = [](HealthVerdict verdict) {
    switch (verdict) {
      case HealthVerdict::kOk:
        return 0;
      case HealthVerdict::kCannotTell:
        return 1;
      case HealthVerdict::kSuspect:
      case HealthVerdict::kDegraded:
        return 2;
      case HealthVerdict::kDecalibrated:
        break;
    }
    return 3;
  };
  return rank(a) >= rank(b) ? a : b;
}

}  // namespace limber
