// SPDX-License-Identifier: MIT
#include "rig_files/camera_fit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "limber/core/factors.hpp"

namespace limber::detail {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Unknowns = Eigen::Matrix<double, 8, 1>;  // fu, fv, cu, cv and four coefficients

constexpr int kDirections = 48;
constexpr double kAngleStep = 0.5 * M_PI / 180.0, kLargestAngle = 100.0 * M_PI / 180.0;
constexpr std::size_t kEnoughRays = 200;
constexpr int kIterations = 50;
constexpr double kDerivativeStep = 1e-6, kConverged = 1e-10;

struct Sample {
  Vector3d ray;
  Vector2d uv;
};

/// Rays of a polar grid that fall into the image; none if the model folds back or ends within it.
std::vector<Sample> rays_in_image(const ForeignProjection& projection, const Camera& size) {
  std::vector<Sample> out;
  for (int k = 0; k < kDirections; ++k) {
    const double phi = 2.0 * M_PI * k / kDirections;
    double before = -1.0;
    for (double angle = 0.0; angle < kLargestAngle; angle += kAngleStep) {
      const Vector3d ray(std::sin(angle) * std::cos(phi), std::sin(angle) * std::sin(phi), std::cos(angle));
      const auto uv = projection(ray);
      if (uv && uv->allFinite() && !in_image(size, *uv)) {
        break;
      }
      const double radius = uv ? (*uv - Vector2d(size.cu, size.cv)).norm() : 0.0;
      if (!(radius > before)) {
        return {};
      }
      before = radius;
      out.push_back({ray, *uv});
    }
  }
  return out;
}

Camera camera_from(const Unknowns& x, Camera like, bool equidistant) {
  like.fu = x(0);
  like.fv = x(1);
  like.cu = x(2);
  like.cv = x(3);
  if (equidistant) {
    like.distortion = Equidistant{x(4), x(5), x(6), x(7)};
  } else {
    like.distortion = RadialTangential{x(4), x(5), x(6), x(7)};
  }
  return like;
}

/// Residuals of all rays; nothing if one is beyond the model.
std::optional<Eigen::VectorXd> residuals(const std::vector<Sample>& samples, const Camera& camera) {
  Eigen::VectorXd out(2 * static_cast<Eigen::Index>(samples.size()));
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const auto projected = project(camera, samples[k].ray);
    if (!projected) {
      return std::nullopt;
    }
    out.segment<2>(2 * static_cast<Eigen::Index>(k)) = projected->uv - samples[k].uv;
  }
  return out;
}

/// Levenberg-Marquardt with numerical derivatives: eight unknowns, once per file.
std::optional<CameraFit> fit(const std::vector<Sample>& samples, const Camera& start, bool equidistant) {
  Unknowns x;
  x << start.fu, start.fv, start.cu, start.cv, Eigen::Vector4d::Zero();
  auto r = residuals(samples, camera_from(x, start, equidistant));
  double damping = 1e-4;
  for (int iteration = 0; r && iteration < kIterations; ++iteration) {
    Eigen::MatrixXd J(r->size(), x.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const double step = kDerivativeStep * std::max(1.0, std::abs(x(k)));
      const auto moved = residuals(samples, camera_from(x + step * Unknowns::Unit(k), start, equidistant));
      if (!moved) {
        return std::nullopt;
      }
      J.col(k) = (*moved - *r) / step;
    }
    const Eigen::MatrixXd information = multiply(transposed(J), J);
    Eigen::MatrixXd damped = information;
    damped.diagonal() *= 1.0 + damping;
    const Unknowns step = -solve_symmetric(damped, J.transpose() * *r);
    auto next = residuals(samples, camera_from(x + step, start, equidistant));
    if (next && next->squaredNorm() <= r->squaredNorm()) {
      const bool converged = r->squaredNorm() - next->squaredNorm() <= kConverged * (1.0 + r->squaredNorm());
      x += step;
      r = std::move(next);
      damping *= 0.1;
      if (converged) {
        break;
      }
    } else {
      damping *= 10.0;
    }
  }
  if (!r) {
    return std::nullopt;
  }
  double worst = 0.0;
  for (Eigen::Index k = 0; k < r->size(); k += 2) {
    worst = std::max(worst, r->segment<2>(k).norm());
  }
  return CameraFit{camera_from(x, start, equidistant), worst};
}

}  // namespace

std::optional<CameraFit> fit_camera(const ForeignProjection& projection, const Camera& start) {
  const std::vector<Sample> samples = rays_in_image(projection, start);
  if (samples.size() < kEnoughRays) {
    return std::nullopt;
  }
  auto best = fit(samples, start, false);
  auto other = fit(samples, start, true);
  if (other && (!best || other->worst_px < best->worst_px)) {
    best = std::move(other);
  }
  return best;
}

}  // namespace limber::detail
