// SPDX-License-Identifier: MIT
#include "frontend/patch.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

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

/// Grey values of an upright grid of points a pixel apart, the first at uv: columns u, rows v. The pixels of
/// one column and one row more are read.
template <int Columns, int Rows>
bool sample_grid(const GreyImage& image, const Eigen::Vector2d& uv,
                 Eigen::Array<float, Columns, Rows>& values) {
  if (!uv.allFinite()) return false;
  const double left = std::floor(uv.x()), top = std::floor(uv.y());
  if (left < 0 || top < 0 || left + Columns >= image.width || top + Rows >= image.height) return false;
  const auto fu = static_cast<float>(uv.x() - left), fv = static_cast<float>(uv.y() - top);
  const std::uint8_t* row =
      image.data + static_cast<std::ptrdiff_t>(top) * image.stride + static_cast<std::ptrdiff_t>(left);
  using Row = std::array<float, Columns>;
  const auto between_columns = [fu](const std::uint8_t* pixels, Row& out) {
    for (std::size_t u = 0; u < Columns; ++u) {
      const auto left_pixel = static_cast<float>(static_cast<int>(pixels[u]));
      out[u] = left_pixel + fu * (static_cast<float>(static_cast<int>(pixels[u + 1])) - left_pixel);
    }
  };
  Row above{}, below{};
  between_columns(row, above);
  for (int v = 0; v < Rows; ++v) {
    row += image.stride;
    between_columns(row, below);
    float* out = &values(0, v);
    for (std::size_t u = 0; u < Columns; ++u) out[u] = above[u] + fv * (below[u] - above[u]);
    above = below;
  }
  return true;
}

/// Sum over all points of the product. Always in the same order: the same image gives the same bits.
template <int Columns, int Rows>
float dot(const Eigen::Array<float, Columns, Rows>& x, const Eigen::Array<float, Columns, Rows>& y) {
  Eigen::Array<float, Columns, 1> sum = x.col(0) * y.col(0);
  for (int v = 1; v < Rows; ++v) sum += x.col(v) * y.col(v);
  return sum.sum();
}

}  // namespace

/// Takes the mean away from the points, and leaves zeros at the ends of the rows.
template <int Columns>
void BasicPatch<Columns>::remove_mean(Values& values) {
  static const Values kInside = [] {
    Values inside = Values::Ones();
    inside.row(kWidth).setZero();
    return inside;
  }();
  const float mean = dot(values, kInside) / kArea;
  values = (values - mean) * kInside;
}

template <int Columns>
bool BasicPatch<Columns>::sample_upright(const GreyImage& image, const Eigen::Vector2d& uv, Values& values) {
  if (!sample_grid(image, uv.array() - kRadius, values)) return false;
  values.row(kWidth).setZero();
  return true;
}

/// Grey values at uv + A x, for the points x of the square.
template <int Columns>
bool BasicPatch<Columns>::sample(const GreyImage& image, const Eigen::Vector2d& uv, const Eigen::Matrix2d& A,
                                 Values& values) {
  if (!uv.allFinite()) return false;
  const Eigen::Vector2d reach = kRadius * A.cwiseAbs().rowwise().sum();
  const Eigen::Vector2d low = uv - reach, high = uv + reach;
  // Half a pixel is left for the rounding of single precision.
  if (low.minCoeff() < 0.5 || high.x() > image.width - 1.5 || high.y() > image.height - 1.5) return false;
  constexpr std::size_t kLanes = kWidth + 1;
  const Eigen::Matrix2f Af = A.cast<float>();
  const auto stride = static_cast<int>(image.stride);
  for (int y = -kRadius; y <= kRadius; ++y) {
    const float u0 = static_cast<float>(uv.x()) + Af(0, 1) * static_cast<float>(y);
    const float v0 = static_cast<float>(uv.y()) + Af(1, 1) * static_cast<float>(y);
    // In three loops, of which the first and the last become vector instructions.
    alignas(64) std::array<int, kLanes> offset{};
    alignas(64) std::array<float, kLanes> fu{}, fv{};
    alignas(64) std::array<std::uint32_t, kLanes> four{};  // pixels: above left, right, below left, right
    for (std::size_t k = 0; k < kLanes; ++k) {
      const float x = static_cast<float>(static_cast<int>(k)) - kRadius;
      const float u = u0 + Af(0, 0) * x, v = v0 + Af(1, 0) * x;
      const int iu = static_cast<int>(u), iv = static_cast<int>(v);
      offset[k] = iv * stride + iu;
      fu[k] = u - static_cast<float>(iu);
      fv[k] = v - static_cast<float>(iv);
    }
    for (std::size_t k = 0; k < kWidth; ++k) {
      const std::uint8_t* pixel = image.data + offset[k];
      std::uint16_t above = 0, below = 0;
      std::memcpy(&above, pixel, 2);
      std::memcpy(&below, pixel + image.stride, 2);
      four[k] = above | static_cast<std::uint32_t>(below) << 16;
    }
    float* out = &values(0, y + kRadius);
    for (std::size_t k = 0; k < kLanes; ++k) {
      const auto a00 = static_cast<float>(static_cast<int>(four[k] & 255));
      const auto a10 = static_cast<float>(static_cast<int>(four[k] >> 8 & 255));
      const auto a01 = static_cast<float>(static_cast<int>(four[k] >> 16 & 255));
      const auto a11 = static_cast<float>(static_cast<int>(four[k] >> 24));
      const float top = a00 + fu[k] * (a10 - a00), bottom = a01 + fu[k] * (a11 - a01);
      out[k] = top + fv[k] * (bottom - top);
    }
    out[kWidth] = 0.0f;
  }
  return true;
}

/// For each point of the square its u (or v), from -1 at one edge to 1 at the other.
template <int Columns>
typename BasicPatch<Columns>::Values BasicPatch<Columns>::unit_grid(bool along_u) {
  Values values;
  for (int v = 0; v < kWidth; ++v) {
    for (int u = 0; u <= kWidth; ++u)
      values(u, v) = static_cast<float>((along_u ? u : v) - kRadius) / kRadius;
  }
  return values;
}

template <int Columns>
std::optional<BasicPatch<Columns>> BasicPatch<Columns>::cut(const GreyImage& image,
                                                            const Eigen::Vector2d& uv) {
  // With a margin of a pixel, for the gradients.
  Eigen::Array<float, kWidth + 2, kWidth + 2> wide;
  if (!sample_grid(image, uv.array() - (kRadius + 1), wide)) return std::nullopt;
  std::optional<BasicPatch> result(std::in_place);
  BasicPatch& patch = *result;
  Values& value = patch.value_;
  auto& descent = patch.descent_;
  constexpr int kLanes = kWidth + 1;
  value = wide.template block<kLanes, kWidth>(1, 1);
  remove_mean(value);
  const float contrast = std::sqrt(dot(value, value));
  if (contrast * contrast < kMinTexture * kArea) return std::nullopt;
  value /= contrast;

  descent[0].template topRows<kWidth>() =
      0.5f * (wide.template block<kWidth, kWidth>(2, 1) - wide.template block<kWidth, kWidth>(0, 1));
  descent[0].row(kWidth).setZero();
  descent[1] = 0.5f * (wide.template block<kLanes, kWidth>(1, 2) - wide.template block<kLanes, kWidth>(1, 0));
  if constexpr (Columns == 6) {
    static const Values kX = unit_grid(true), kY = unit_grid(false);
    for (const std::size_t k : {0u, 1u}) {
      descent[2 + k] = descent[k] * kX;
      descent[4 + k] = descent[k] * kY;
    }
  }
  Eigen::Matrix<float, Columns, Columns> H;
  for (std::size_t i = 0; i < Columns; ++i) {
    remove_mean(descent[i]);
    descent[i] -= dot(descent[i], value) * value;
    for (std::size_t k = 0; k <= i; ++k) {
      const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(k);
      H(row, column) = H(column, row) = dot(descent[i], descent[k]);
    }
  }
  if (smaller_eigenvalue(H.template topLeftCorner<2, 2>()) < kMinTexture * kArea) return std::nullopt;
  H.diagonal().template tail<Columns - 2>().array() += kSigmaGrey * kSigmaGrey / (kSigmaEdge * kSigmaEdge);
  for (Values& step : descent) step /= contrast;
  H /= contrast * contrast;
  patch.H_shift_inverse_ = H.template topLeftCorner<2, 2>().inverse();
  patch.H_inverse_ = H.llt().solve(Eigen::Matrix<float, Columns, Columns>::Identity());
  return result;
}

/// In one pass. The mean of what is seen need not be taken away first: value_ and descent_ have none.
template <int Columns>
template <int Steps>
typename BasicPatch<Columns>::template Sums<Steps> BasicPatch<Columns>::sums(const Values& seen) const {
  using Row = Eigen::Array<float, kWidth + 1, 1>;
  Row all = Row::Zero(), square = Row::Zero(), gain = Row::Zero();
  std::array<Row, Steps> descent;
  descent.fill(Row::Zero());
  for (int v = 0; v < kWidth; ++v) {
    const Row row = seen.col(v);
    all += row;
    square += row * row;
    gain += row * value_.col(v);
    for (std::size_t k = 0; k < Steps; ++k) descent[k] += row * descent_[k].col(v);
  }
  Sums<Steps> result;
  const double sum = all.template cast<double>().sum();
  result.contrast_squared = static_cast<float>(square.template cast<double>().sum() - sum * sum / kArea);
  result.gain = gain.sum();
  for (std::size_t k = 0; k < Steps; ++k) result.descent[static_cast<Eigen::Index>(k)] = descent[k].sum();
  return result;
}

template <int Columns>
std::optional<PatchFit> BasicPatch<Columns>::find(const GreyImage& image, const PatchFit& start,
                                                  PatchMotion motion, double max_shift_px) const {
  PatchFit fit = start;
  Values seen;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const bool upright = fit.A.isIdentity(0.0);
    if (!(upright ? sample_upright(image, fit.uv, seen) : sample(image, fit.uv, fit.A, seen))) {
      return std::nullopt;
    }
    // seen(x) = gain * value(x + shift + B x) + offset; the warp is composed with the inverse of that.
    const auto is_alike = [&fit](float gain, float contrast_squared) {
      if (gain <= 0.0f || contrast_squared < kMinTexture * kArea) return false;
      fit.ncc = gain / std::sqrt(contrast_squared);
      fit.rest = std::sqrt(std::max(0.0f, contrast_squared - gain * gain) / kArea);
      return true;
    };
    double largest_step = 0.0;
    if (Columns == 2 || motion == PatchMotion::kShift) {
      const Sums<2> sum = sums<2>(seen);
      if (!is_alike(sum.gain, sum.contrast_squared)) return std::nullopt;
      const Eigen::Vector2f shift = H_shift_inverse_ * sum.descent / sum.gain;
      fit.uv -= fit.A * shift.cast<double>();
      largest_step = shift.norm();
    } else if constexpr (Columns == 6) {
      const Sums<6> sum = sums<6>(seen);
      if (!is_alike(sum.gain, sum.contrast_squared)) return std::nullopt;
      const Eigen::Matrix<double, 6, 1> d = (H_inverse_ * sum.descent / sum.gain).template cast<double>();
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
