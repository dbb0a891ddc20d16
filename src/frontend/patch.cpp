// SPDX-License-Identifier: MIT
#include "frontend/patch.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
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
  const std::uint8_t* row =
      image.data + static_cast<std::ptrdiff_t>(top) * image.stride + static_cast<std::ptrdiff_t>(left);
  std::array<float, Width> above{}, below{};
  const auto between_columns = [fu](const std::uint8_t* pixels, std::array<float, Width>& out) {
    for (std::size_t u = 0; u < Width; ++u) {
      const auto left_pixel = static_cast<float>(pixels[u]);
      out[u] = left_pixel + fu * (static_cast<float>(pixels[u + 1]) - left_pixel);
    }
  };
  between_columns(row, above);
  for (int v = 0; v < Width; ++v) {
    row += image.stride;
    between_columns(row, below);
    float* out = &values(v, 0);
    for (std::size_t u = 0; u < Width; ++u) out[u] = above[u] + fv * (below[u] - above[u]);
    above = below;
  }
  return true;
}

}  // namespace

/// Grey values at uv + A x, for the points x of the square.
template <int Columns>
bool BasicPatch<Columns>::sample(const GreyImage& image, const Eigen::Vector2d& uv, const Eigen::Matrix2d& A,
                                 Values& values) {
  if (!uv.allFinite()) return false;
  const Eigen::Vector2d reach = kRadius * A.cwiseAbs().rowwise().sum();
  const Eigen::Vector2d low = uv - reach, high = uv + reach;
  // Half a pixel is left for the rounding of single precision.
  if (low.minCoeff() < 0.5 || high.x() > image.width - 1.5 || high.y() > image.height - 1.5) return false;
  const Eigen::Matrix2f Af = A.cast<float>();
  for (int y = -kRadius; y <= kRadius; ++y) {
    const float u0 = static_cast<float>(uv.x()) + Af(0, 1) * static_cast<float>(y);
    const float v0 = static_cast<float>(uv.y()) + Af(1, 1) * static_cast<float>(y);
    // In three loops, of which the first and the last become vector instructions.
    std::array<int, kWidth> iu{}, iv{};
    std::array<float, kWidth> fu{}, fv{}, a00{}, a10{}, a01{}, a11{};
    for (std::size_t k = 0; k < kWidth; ++k) {
      const float x = static_cast<float>(k) - kRadius;
      const float u = u0 + Af(0, 0) * x, v = v0 + Af(1, 0) * x;
      iu[k] = static_cast<int>(u);
      iv[k] = static_cast<int>(v);
      fu[k] = u - static_cast<float>(iu[k]);
      fv[k] = v - static_cast<float>(iv[k]);
    }
    for (std::size_t k = 0; k < kWidth; ++k) {
      const std::uint8_t* above = image.data + iv[k] * image.stride + iu[k];
      const std::uint8_t* below = above + image.stride;
      a00[k] = above[0];
      a10[k] = above[1];
      a01[k] = below[0];
      a11[k] = below[1];
    }
    float* out = values.data() + (y + kRadius) * kWidth;
    for (std::size_t k = 0; k < kWidth; ++k) {
      const float top = a00[k] + fu[k] * (a10[k] - a00[k]), bottom = a01[k] + fu[k] * (a11[k] - a01[k]);
      out[k] = top + fv[k] * (bottom - top);
    }
  }
  return true;
}

/// For each point of the square its u (or v), from -1 at one edge to 1 at the other.
template <int Columns>
typename BasicPatch<Columns>::Values BasicPatch<Columns>::unit_grid(bool along_u) {
  Values values;
  for (int i = 0; i < kArea; ++i) {
    values[i] = static_cast<float>((along_u ? i % kWidth : i / kWidth) - kRadius) / kRadius;
  }
  return values;
}

template <int Columns>
std::optional<BasicPatch<Columns>> BasicPatch<Columns>::cut(const GreyImage& image,
                                                            const Eigen::Vector2d& uv) {
  // With a margin of a pixel, for the gradients.
  Eigen::Matrix<float, kWidth + 2, kWidth + 2, Eigen::RowMajor> wide;
  if (!sample_upright(image, uv, wide)) return std::nullopt;
  BasicPatch patch;
  const auto square = [](Values& values) { return Eigen::Map<Square>(values.data()); };
  square(patch.value_) = wide.template block<kWidth, kWidth>(1, 1);
  patch.value_.array() -= mean_of(patch.value_);
  const float contrast = patch.value_.norm();
  if (contrast * contrast < kMinTexture * kArea) return std::nullopt;
  patch.value_ /= contrast;

  Values gradient_u, gradient_v;
  square(gradient_u) =
      0.5f * (wide.template block<kWidth, kWidth>(1, 2) - wide.template block<kWidth, kWidth>(1, 0));
  square(gradient_v) =
      0.5f * (wide.template block<kWidth, kWidth>(2, 1) - wide.template block<kWidth, kWidth>(0, 1));
  if constexpr (Columns == 2) {
    patch.descent_ << gradient_u, gradient_v;
  } else {
    static const Values kX = unit_grid(true), kY = unit_grid(false);
    patch.descent_ << gradient_u, gradient_v, gradient_u.cwiseProduct(kX), gradient_v.cwiseProduct(kX),
        gradient_u.cwiseProduct(kY), gradient_v.cwiseProduct(kY);
  }
  for (auto descent : patch.descent_.colwise()) {
    descent.array() -= mean_of(descent);
    descent -= descent.dot(patch.value_) * patch.value_;
  }
  Eigen::Matrix<float, Columns, Columns> H = patch.descent_.transpose().lazyProduct(patch.descent_);
  if (smaller_eigenvalue(H.template topLeftCorner<2, 2>()) < kMinTexture * kArea) return std::nullopt;
  H.diagonal().template tail<Columns - 2>().array() += kSigmaGrey * kSigmaGrey / (kSigmaEdge * kSigmaEdge);
  patch.descent_ /= contrast;
  H /= contrast * contrast;
  patch.H_shift_inverse_ = H.template topLeftCorner<2, 2>().inverse();
  patch.H_inverse_ = H.llt().solve(Eigen::Matrix<float, Columns, Columns>::Identity());
  return patch;
}

template <int Columns>
std::optional<PatchFit> BasicPatch<Columns>::find(const GreyImage& image, const PatchFit& start,
                                                  PatchMotion motion, double max_shift_px) const {
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
    if (Columns == 2 || motion == PatchMotion::kShift) {
      const Eigen::Vector2f shift =
          H_shift_inverse_ * (descent_.template leftCols<2>().transpose() * seen) / gain;
      fit.uv -= fit.A * shift.cast<double>();
      largest_step = shift.norm();
    } else if constexpr (Columns == 6) {
      const Eigen::Matrix<double, 6, 1> d =
          (H_inverse_ * (descent_.transpose() * seen) / gain).template cast<double>();
      Eigen::Matrix2d B;
      B << d[2], d[4], d[3], d[5];
      fit.A = fit.A * (Eigen::Matrix2d::Identity() + B / kRadius).inverse();
      fit.uv -= fit.A * d.template head<2>();
      largest_step = std::max(d.template head<2>().norm(), 0.2 * B.norm());
    }
    if (!in_shape(fit.A) || (fit.uv - start.uv).norm() > max_shift_px) return std::nullopt;
    if (largest_step < kSettledPx) return fit;
  }
  return std::nullopt;
}

template class BasicPatch<6>;
template class BasicPatch<2>;

}  // namespace limber::frontend
