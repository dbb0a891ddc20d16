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

/// Eigen's own mean() adds up in an order that goes with the address of x, so that the same image would give
/// other bits in another place of the memory. A product is summed from its first element on.
template <typename Derived>
float mean_of(const Eigen::MatrixBase<Derived>& x) {
  return x.dot(Derived::PlainObject::Ones()) / static_cast<float>(x.size());
}

bool in_shape(const Eigen::Matrix2d& A) {
  const double det = A.determinant();
  return A.allFinite() && A.norm() < kMaxStretch * std::sqrt(2.0) && det > 1.0 / (kMaxStretch * kMaxStretch);
}

/// Grey values of the upright square of this width (odd) around uv: every pixel is weighed alike.
template <int Width>
bool sample_upright(const GreyImage& image, const Eigen::Vector2d& uv,
                    Eigen::Matrix<float, Width, Width, Eigen::RowMajor>& values) {
  if (!uv.allFinite()) return false;
  const double left = std::floor(uv.x()) - Width / 2, top = std::floor(uv.y()) - Width / 2;
  if (left < 0 || top < 0 || left + Width >= image.width || top + Width >= image.height) return false;
  const auto fu = static_cast<float>(uv.x() - std::floor(uv.x()));
  const auto fv = static_cast<float>(uv.y() - std::floor(uv.y()));
  const float w00 = (1 - fu) * (1 - fv), w10 = fu * (1 - fv), w01 = (1 - fu) * fv, w11 = fu * fv;
  const std::uint8_t* row =
      image.data + static_cast<std::ptrdiff_t>(top) * image.stride + static_cast<std::ptrdiff_t>(left);
  for (int v = 0; v < Width; ++v, row += image.stride) {
    const std::uint8_t* below = row + image.stride;
    for (int u = 0; u < Width; ++u) {
      values(v, u) = w00 * row[u] + w10 * row[u + 1] + w01 * below[u] + w11 * below[u + 1];
    }
  }
  return true;
}

}  // namespace

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

/// For each point of the square its u (or v), from -1 at one edge to 1 at the other.
Patch::Values Patch::unit_grid(bool along_u) {
  Values values;
  for (int i = 0; i < kArea; ++i) {
    values[i] = static_cast<float>((along_u ? i % kWidth : i / kWidth) - kRadius) / kRadius;
  }
  return values;
}

std::optional<Patch> Patch::cut(const GreyImage& image, const Eigen::Vector2d& uv) {
  // With a margin of a pixel, for the gradients.
  Eigen::Matrix<float, kWidth + 2, kWidth + 2, Eigen::RowMajor> wide;
  if (!sample_upright(image, uv, wide)) return std::nullopt;
  Patch patch;
  const auto square = [](Values& values) { return Eigen::Map<Square>(values.data()); };
  square(patch.value_) = wide.block<kWidth, kWidth>(1, 1);
  patch.value_.array() -= mean_of(patch.value_);
  const float contrast = patch.value_.norm();
  if (contrast * contrast < kMinTexture * kArea) return std::nullopt;
  patch.value_ /= contrast;

  Values gradient_u, gradient_v;
  square(gradient_u) = 0.5f * (wide.block<kWidth, kWidth>(1, 2) - wide.block<kWidth, kWidth>(1, 0));
  square(gradient_v) = 0.5f * (wide.block<kWidth, kWidth>(2, 1) - wide.block<kWidth, kWidth>(0, 1));
  static const Values kX = unit_grid(true), kY = unit_grid(false);
  patch.descent_ << gradient_u, gradient_v, gradient_u.cwiseProduct(kX), gradient_v.cwiseProduct(kX),
      gradient_u.cwiseProduct(kY), gradient_v.cwiseProduct(kY);
  for (auto descent : patch.descent_.colwise()) {
    descent.array() -= mean_of(descent);
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
  Square upright;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    if (fit.A.isIdentity(0.0)) {
      if (!sample_upright(image, fit.uv, upright)) return std::nullopt;
      seen = Eigen::Map<const Values>(upright.data());
    } else if (!sample(image, fit.uv, fit.A, seen)) {
      return std::nullopt;
    }
    seen.array() -= mean_of(seen);
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
