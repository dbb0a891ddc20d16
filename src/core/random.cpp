// SPDX-License-Identifier: MIT
#include "limber/core/random.hpp"

#include <cmath>
#include <numbers>

namespace limber {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::uint32_t low(std::uint64_t x) { return static_cast<std::uint32_t>(x); }
constexpr std::uint32_t high(std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); }

/// 64 random bits to (0, 1): 53 of them, in the middle of their cell, so that neither end can occur.
double to_open_unit(std::uint32_t a, std::uint32_t b) {
  const std::uint64_t bits = (static_cast<std::uint64_t>(a) << 32 | b) >> 12;
  return (static_cast<double>(bits) + 0.5) * 0x1p-52;
}

Vector2d box_muller(const Vector2d& u) {
  const double radius = std::sqrt(-2.0 * std::log(u.x()));
  const double angle = 2.0 * std::numbers::pi * u.y();
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

}  // namespace

std::array<std::uint32_t, 4> philox4x32(const std::array<std::uint32_t, 4>& counter,
                                        const std::array<std::uint32_t, 2>& key) {
  std::array<std::uint32_t, 4> c = counter;
  std::array<std::uint32_t, 2> k = key;
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t product0 = std::uint64_t{0xD2511F53} * c[0];
    const std::uint64_t product1 = std::uint64_t{0xCD9E8D57} * c[2];
    c = {high(product1) ^ c[1] ^ k[0], low(product1), high(product0) ^ c[3] ^ k[1], low(product0)};
    k[0] += 0x9E3779B9;  // golden ratio
    k[1] += 0xBB67AE85;  // sqrt(3) - 1
  }
  return c;
}

std::uint64_t fnv1a(std::string_view text) {
  std::uint64_t h = 0xcbf29ce484222325ULL;
  for (const char c : text) {
    h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  }
  return h;
}

RandomStream::RandomStream(std::uint64_t seed, std::uint64_t run, std::string_view name) {
  const std::uint64_t stream = fnv1a(name);
  const auto bits = philox4x32({low(run), high(run), low(stream), high(stream)}, {low(seed), high(seed)});
  key_ = {bits[0], bits[1]};
}

Vector2d RandomStream::uniform2(std::uint64_t i, std::uint32_t j, std::uint32_t block) const {
  const auto bits = philox4x32({low(i), high(i), j, block}, key_);
  return {to_open_unit(bits[0], bits[1]), to_open_unit(bits[2], bits[3])};
}

double RandomStream::uniform(std::uint64_t i, std::uint32_t j) const { return uniform2(i, j, 0).x(); }

Vector3d RandomStream::uniform3(std::uint64_t i, std::uint32_t j) const {
  const Vector2d first = uniform2(i, j, 0);
  return {first.x(), first.y(), uniform2(i, j, 1).x()};
}

Vector2d RandomStream::normal2(std::uint64_t i, std::uint32_t j) const {
  return box_muller(uniform2(i, j, 0));
}

Vector3d RandomStream::normal3(std::uint64_t i, std::uint32_t j) const {
  const Vector2d first = normal2(i, j);
  return {first.x(), first.y(), box_muller(uniform2(i, j, 1)).x()};
}

}  // namespace limber
