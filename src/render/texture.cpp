// SPDX-License-Identifier: MIT
#include "limber/render/texture.hpp"

#include <algorithm>
#include <cmath>

#include "limber/core/random.hpp"

namespace limber {
namespace {

constexpr int kSide = Texture::kSide;
constexpr int kMarks = 1500;  ///< discs and bars

std::size_t index(int x, int y) {
  return static_cast<std::size_t>(y & (kSide - 1)) * kSide + static_cast<std::size_t>(x & (kSide - 1));
}

/// Adds smooth noise in [-1, 1] times `amplitude`, with a lattice of spacing `cell`.
void add_noise(std::vector<float>& grey, int cell, double amplitude, const RandomStream& stream) {
  const int cells = kSide / cell;
  std::vector<double> lattice;
  for (int k = 0; k < cells * cells; ++k) {
    lattice.push_back(2.0 * stream.uniform(static_cast<std::uint64_t>(k), static_cast<std::uint32_t>(cell)) -
                      1.0);
  }
  const auto value = [&](int i, int j) {
    return lattice[static_cast<std::size_t>((j % cells) * cells + i % cells)];
  };
  const auto smooth = [](double t) { return t * t * (3.0 - 2.0 * t); };
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const int i = x / cell, j = y / cell;
      const double fx = smooth(static_cast<double>(x % cell) / cell),
                   fy = smooth(static_cast<double>(y % cell) / cell);
      grey[index(x, y)] +=
          static_cast<float>(amplitude * ((1 - fy) * ((1 - fx) * value(i, j) + fx * value(i + 1, j)) +
                                          fy * ((1 - fx) * value(i, j + 1) + fx * value(i + 1, j + 1))));
    }
  }
}

/// Draws a disc or a bar with soft edges: what corners are made of.
void add_mark(std::vector<float>& grey, std::uint64_t k, const RandomStream& stream) {
  const Eigen::Vector3d where = stream.uniform3(k, 0), what = stream.uniform3(k, 1);
  const double u0 = where.x() * kSide, v0 = where.y() * kSide, size = 3.0 + 22.0 * where.z() * where.z();
  const double turn = 2.0 * M_PI * what.x(), c = std::cos(turn), s = std::sin(turn);
  const float change = static_cast<float>(140.0 * (what.y() - 0.5));
  const bool disc = what.z() < 0.4;
  const int reach = static_cast<int>(1.5 * size) + 2;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const int x = static_cast<int>(u0) + dx, y = static_cast<int>(v0) + dy;
      const double a = x - u0, b = y - v0;
      const double outside =
          disc ? std::hypot(a, b) - size
               : std::max(std::abs(c * a + s * b) - size, std::abs(c * b - s * a) - 0.5 * size);
      const double cover = std::clamp(0.5 - 0.7 * outside, 0.0, 1.0);
      grey[index(x + kSide, y + kSide)] += change * static_cast<float>(cover);
    }
  }
}

std::vector<float> halved(const std::vector<float>& grey, int side) {
  std::vector<float> half;
  const auto at = [&](int x, int y) { return grey[static_cast<std::size_t>(y * side + x)]; };
  for (int y = 0; y < side; y += 2) {
    for (int x = 0; x < side; x += 2) {
      half.push_back(0.25f * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)));
    }
  }
  return half;
}

}  // namespace

Texture::Texture(std::uint64_t seed) {
  const RandomStream stream(seed, 0, "texture");
  std::vector<float> grey(static_cast<std::size_t>(kSide) * kSide, 128.0f);
  for (const int cell : {256, 128, 64, 32, 16, 8}) add_noise(grey, cell, 22.0, stream);
  for (std::uint64_t k = 0; k < kMarks; ++k) add_mark(grey, k, stream);
  for (float& value : grey) value = std::clamp(value, 16.0f, 240.0f);
  levels_.push_back(std::move(grey));
  for (int side = kSide; side > 1; side /= 2) levels_.push_back(halved(levels_.back(), side));
}

Texture Texture::faded(float contrast, float mean) const {
  Texture pale = *this;
  for (std::vector<float>& level : pale.levels_) {
    for (float& value : level) value = mean + contrast * (value - 128.0f);
  }
  return pale;
}

float Texture::bilinear(std::size_t level, float x, float y) const {
  const int mask = (kSide >> level) - 1;
  const float fx0 = std::floor(x), fy0 = std::floor(y);
  const int i = static_cast<int>(fx0), j = static_cast<int>(fy0);
  const float fx = x - fx0, fy = y - fy0;
  const auto width = static_cast<std::size_t>(mask + 1);
  const float* above = levels_[level].data() + static_cast<std::size_t>(j & mask) * width;
  const float* below = levels_[level].data() + static_cast<std::size_t>((j + 1) & mask) * width;
  const auto left = static_cast<std::size_t>(i & mask), right = static_cast<std::size_t>((i + 1) & mask);
  const float top = above[left] + fx * (above[right] - above[left]);
  const float bottom = below[left] + fx * (below[right] - below[left]);
  return top + fy * (bottom - top);
}

float Texture::at(float x, float y, float lod) const {
  const float last = static_cast<float>(levels_.size() - 1);
  const float depth = std::clamp(lod, 0.0f, last);
  const auto level = static_cast<std::size_t>(depth);
  // A texel of level k covers 2^k texels: its centre is half of them further.
  const auto on = [&](std::size_t k) {
    const float scale = 1.0f / static_cast<float>(1 << k);
    return bilinear(k, (x + 0.5f) * scale - 0.5f, (y + 0.5f) * scale - 0.5f);
  };
  const float share = depth - static_cast<float>(level);
  const float fine = on(level);
  return share > 0.0f ? fine + share * (on(level + 1) - fine) : fine;
}

}  // namespace limber
