// SPDX-License-Identifier: MIT
#include "frontend/patch.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

namespace limber::frontend {
namespace {

constexpr int kMaxIterations = 20;
constexpr double kSettledPx = 0.01;
/// Least variance [grey level^2], and least smaller eigenvalue of the mean structure tensor
/// [(grey level / px)^2]: what is below is taken for noise.
constexpr float kMinTexture = 1.0f;
/// Damping of the shape: standard deviations of a grey level, and of a step of the square's edge [px].
constexpr float kSigmaGrey = 3.0f, kSigmaEdge = 0.5f;
constexpr double kMaxStretch = 2.0;  ///< of a side of the square, and by the inverse at least

float smaller_eigenvalue(const Eigen::Matrix2f& A) {
  const float half_trace = 0.5f * A.trace();
  return half_trace - std::sqrt(std::max(0.0f, half_trace * half_trace - A.determinant()));
}

bool in_shape(const Eigen::Matrix2d& A) {
  const double det = A.determinant();
  return A.allFinite() && A.norm() < kMaxStretch * std::sqrt(2.0) && det > 1.0 / (kMaxStretch * kMaxStretch);
}

}  // namespace

/// Grey values of the upright square around uv: every pixel is weighed alike.
bool Patch::sample(const GreyImage& image, const Eigen::Vector2d& uv, Values& values) {
  if (!uv.allFinite()) return false;
  const double left = std::floor(uv.x()) - kRadius, top = std::floor(uv.y()) - kRadius;
  if (left < 0 || top < 0 || left + kWidth >= image.width || top + kWidth >= image.height) return false;
  const auto fu = static_cast<float>(uv.x() - std::floor(uv.x()));
  const auto fv = static_cast<float>(uv.y() - std::floor(uv.y()));
  const float w00 = (1 - fu) * (1 - fv), w10 = fu * (1 - fv), w01 = (1 - fu) * fv, w11 = fu * fv;
  const std::uint8_t* row =
      image.data + static_cast<std::ptrdiff_t>(top) * image.stride + static_cast<std::ptrdiff_t>(left);
  for (int v = 0; v < kWidth; ++v, row += image.stride) {
    const std::uint8_t* below = row + image.stride;
    for (int u = 0; u < kWidth; ++u) {
      values[v * kWidth + u] = w00 * row[u] + w10 * row[u + 1] + w01 * below[u] + w11 * below[u + 1];
    }
  }
  return true;
}

/// Grey values at uv + A x, for the points x of the square.
bool Patch::sample(const GreyImage& image, const Eigen::Vector2d& uv, const Eigen::Matrix2d& A,
                   Values& values) {
  if (!uv.allFinite()) return false;
  const Eigen::Vector2d reach = kRadius * A.cwiseAbs().rowwise().sum();
  const Eigen::Vector2d low = uv - reach, high = uv + reach;
  // Half a pixel is left for the rounding of single precision.
  if (low.minCoeff() < 0.5 || high.x() > image.width - 1.5 || high.y() > image.height - 1.5) return false;
  const Eigen::Matrix2f Af = A.cast<float>();
  for (int y = -kRadius, i = 0; y <= kRadius; ++y) {
    const float u0 = static_cast<float>(uv.x()) + Af(0, 1) * static_cast<float>(y);
    const float v0 = static_cast<float>(uv.y()) + Af(1, 1) * static_cast<float>(y);
    for (int x = -kRadius; x <= kRadius; ++x, ++i) {
      const float u = u0 + Af(0, 0) * static_cast<float>(x), v = v0 + Af(1, 0) * static_cast<float>(x);
      const int iu = static_cast<int>(u), iv = static_cast<int>(v);
      const float fu = u - static_cast<float>(iu), fv = v - static_cast<float>(iv);
      const std::uint8_t* above = image.data + iv * image.stride + iu;
      const std::uint8_t* below = above + image.stride;
      const auto top = static_cast<float>(above[0]) + fu * static_cast<float>(above[1] - above[0]);
      const auto bottom = static_cast<float>(below[0]) + fu * static_cast<float>(below[1] - below[0]);
      values[i] = top + fv * (bottom - top);
    }
  }
  return true;
}

std::optional<Patch> Patch::cut(const GreyImage& image, const Eigen::Vector2d& uv) {
  Patch patch;
  Values left, right, above, below;
  const Eigen::Vector2d du(1, 0), dv(0, 1);
  if (!sample(image, uv, patch.value_) || !sample(image, uv - du, left) || !sample(image, uv + du, right) ||
      !sample(image, uv - dv, above) || !sample(image, uv + dv, below)) {
    return std::nullopt;
  }
  patch.value_.array() -= patch.value_.mean();
  const float contrast = patch.value_.norm();
  if (contrast * contrast < kMinTexture * kArea) return std::nullopt;
  patch.value_ /= contrast;

  const Values gradient_u = 0.5f * (right - left), gradient_v = 0.5f * (below - above);
  for (int i = 0; i < kArea; ++i) {
    const float x = static_cast<float>(i % kWidth - kRadius) / kRadius;
    const float y = static_cast<float>(i / kWidth - kRadius) / kRadius;
    const float gu = gradient_u[i], gv = gradient_v[i];
    patch.descent_.row(i) << gu, gv, gu * x, gv * x, gu * y, gv * y;
  }
  for (auto descent : patch.descent_.colwise()) {
    descent.array() -= descent.mean();
    descent -= descent.dot(patch.value_) * patch.value_;
  }
  Eigen::Matrix<float, 6, 6> H = patch.descent_.transpose().lazyProduct(patch.descent_);
  if (smaller_eigenvalue(H.topLeftCorner<2, 2>()) < kMinTexture * kArea) return std::nullopt;
  H.diagonal().tail<4>().array() += kSigmaGrey * kSigmaGrey / (kSigmaEdge * kSigmaEdge);
  patch.descent_ /= contrast;
  H /= contrast * contrast;
  patch.H_shift_inverse_ = H.topLeftCorner<2, 2>().inverse();
  patch.H_affine_inverse_ = H.llt().solve(Eigen::Matrix<float, 6, 6>::Identity());
  return patch;
}

std::optional<PatchFit> Patch::find(const GreyImage& image, const PatchFit& start, PatchMotion motion,
                                    double max_shift_px) const {
  PatchFit fit = start;
  Values seen;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const bool inside =
        fit.A.isIdentity(0.0) ? sample(image, fit.uv, seen) : sample(image, fit.uv, fit.A, seen);
    if (!inside) return std::nullopt;
    seen.array() -= seen.mean();
    const float contrast = seen.norm();
    const float gain = seen.dot(value_);
    if (gain <= 0.0f || contrast * contrast < kMinTexture * kArea) return std::nullopt;
    fit.ncc = gain / contrast;
    // seen(x) = gain * value(x + shift + B x) + offset; the warp is composed with the inverse of that.
    double largest_step = 0.0;
    if (motion == PatchMotion::kShift) {
      const Eigen::Vector2f shift = H_shift_inverse_ * (descent_.leftCols<2>().transpose() * seen) / gain;
      fit.uv -= fit.A * shift.cast<double>();
      largest_step = shift.norm();
    } else {
      const Eigen::Matrix<float, 6, 1> step = H_affine_inverse_ * (descent_.transpose() * seen) / gain;
      const Eigen::Matrix<double, 6, 1> d = step.cast<double>();
      Eigen::Matrix2d B;
      B << d[2], d[4], d[3], d[5];
      fit.A = fit.A * (Eigen::Matrix2d::Identity() + B / kRadius).inverse();
      fit.uv -= fit.A * d.head<2>();
      largest_step = std::max(d.head<2>().norm(), 0.2 * B.norm());
    }
    if (!in_shape(fit.A) || (fit.uv - start.uv).norm() > max_shift_px) return std::nullopt;
    if (largest_step < kSettledPx) return fit;
  }
  return std::nullopt;
}

}  // namespace limber::frontend
