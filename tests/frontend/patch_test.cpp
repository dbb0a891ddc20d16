// SPDX-License-Identifier: MIT
#include "frontend/patch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>

#include "frontend/painted_room.hpp"

namespace limber::frontend {
namespace {

using limber::testing::Image;
using limber::testing::plain_image;

/// Smooth blobs, seen at A^-1 (x - shift), with a gain and an offset of the brightness.
Image blobs(const Eigen::Vector2d& shift, const Eigen::Matrix2d& A = Eigen::Matrix2d::Identity(),
            double gain = 1.0, double offset = 0.0) {
  Image image = plain_image(96, 96, 0);
  const Eigen::Vector2d centre(48.0, 48.0);
  const Eigen::Matrix2d A_inverse = A.inverse();
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      const Eigen::Vector2d x = A_inverse * (Eigen::Vector2d(u, v) - centre - shift);
      const double grey = 120.0 + 40.0 * std::sin(0.45 * x.x() + 0.3) * std::cos(0.38 * x.y()) +
                          30.0 * std::sin(0.21 * x.x() - 0.33 * x.y());
      image.pixels[static_cast<std::size_t>(v * image.width + u)] =
          static_cast<std::uint8_t>(std::lround(gain * grey + offset));
    }
  }
  return image;
}

const Eigen::Vector2d kCentre(48.0, 48.0);

TEST(Patch, IsFoundToAFewHundredthsOfAPixel) {
  const auto patch = Patch::cut(blobs({0, 0}).view(), kCentre);
  ASSERT_TRUE(patch);
  for (const double du : {-1.8, -0.5, 0.0, 0.25, 1.3}) {
    for (const double dv : {-1.6, 0.0, 0.4, 1.5}) {
      const Eigen::Vector2d shift(du, dv);
      for (const PatchMotion motion : {PatchMotion::kShift, PatchMotion::kAffine}) {
        const auto fit = patch->find(blobs(shift).view(), {kCentre}, motion, 4.0);
        ASSERT_TRUE(fit) << shift.transpose();
        EXPECT_LT((fit->uv - kCentre - shift).norm(), 0.04) << shift.transpose();
        EXPECT_GT(fit->ncc, 0.99);
      }
    }
  }
}

/// Cuts and finds with `bytes` more on the stack: locals have other addresses.
[[gnu::noinline]] PatchFit found_deep(const Image& from, const Image& to, std::size_t bytes) {
  volatile char* const room = static_cast<volatile char*>(__builtin_alloca(bytes));
  room[0] = 1;
  return Patch::cut(from.view(), kCentre)->find(to.view(), {kCentre}, PatchMotion::kAffine, 4.0).value();
}

TEST(Patch, GivesTheSameBitsWhereverItLiesInMemory) {
  const Image from = blobs({0, 0}), to = blobs({0.7, -0.4});
  const PatchFit once = found_deep(from, to, 16);
  for (std::size_t bytes = 32; bytes <= 256; bytes += 16) {
    const PatchFit again = found_deep(from, to, bytes);
    EXPECT_EQ(again.uv, once.uv) << bytes;
    EXPECT_EQ(again.A, once.A) << bytes;
    EXPECT_EQ(again.ncc, once.ncc) << bytes;
  }
}

TEST(Patch, IsBlindToGainAndOffsetOfTheBrightness) {
  const Eigen::Vector2d shift(1.3, -0.8);
  const auto patch = Patch::cut(blobs({0, 0}).view(), kCentre);
  const auto fit = patch->find(blobs(shift, Eigen::Matrix2d::Identity(), 0.5, 60.0).view(), {kCentre},
                               PatchMotion::kShift, 4.0);
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->uv - kCentre - shift).norm(), 0.04);
  EXPECT_GT(fit->ncc, 0.99);
}

TEST(Patch, FindsItsShapeWhenItMayBeDeformed) {
  Eigen::Matrix2d A;
  A << 1.15, 0.12, -0.08, 0.92;
  const Eigen::Vector2d shift(0.6, -0.7);
  const auto patch = Patch::cut(blobs({0, 0}).view(), kCentre);
  const auto fit = patch->find(blobs(shift, A).view(), {kCentre}, PatchMotion::kAffine, 4.0);
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->uv - kCentre - shift).norm(), 0.05);
  EXPECT_LT((fit->A - A).cwiseAbs().maxCoeff(), 0.02);
  EXPECT_GT(fit->ncc, 0.99);
}

TEST(Patch, KeepsTheShapeItIsGivenWhenItMayOnlyShift) {
  Eigen::Matrix2d A;
  A << 1.15, 0.12, -0.08, 0.92;
  const auto patch = Patch::cut(blobs({0, 0}).view(), kCentre);
  const auto fit = patch->find(blobs({0.5, 0.25}, A).view(), {kCentre, A}, PatchMotion::kShift, 4.0);
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->A, A);
  EXPECT_LT((fit->uv - kCentre - Eigen::Vector2d(0.5, 0.25)).norm(), 0.04);
}

TEST(Patch, HasALowCorrelationWhereSomethingElseIs) {
  const auto patch = Patch::cut(blobs({0, 0}).view(), kCentre);
  Eigen::Matrix2d quarter_turn;
  quarter_turn << 0.0, -1.0, 1.0, 0.0;
  const Image other = blobs({3.0, 5.0}, quarter_turn);
  int settled = 0;
  for (double v = 30.0; v < 70.0; v += 8.0) {
    for (double u = 30.0; u < 70.0; u += 8.0) {
      const auto fit = patch->find(other.view(), {Eigen::Vector2d(u, v)}, PatchMotion::kShift, 8.0);
      if (!fit) continue;
      ++settled;
      EXPECT_LT(fit->ncc, 0.8) << u << " " << v;
    }
  }
  EXPECT_GT(settled, 0);
}

TEST(Patch, IsNotCutWithoutTextureOrAtTheEdge) {
  EXPECT_FALSE(Patch::cut(plain_image(96, 96, 77).view(), kCentre));
  const Image image = blobs({0, 0});
  EXPECT_FALSE(Patch::cut(image.view(), {7.5, 48.0}));
  EXPECT_FALSE(Patch::cut(image.view(), {48.0, 88.0}));
  EXPECT_FALSE(Patch::cut(image.view(), {std::nan(""), 48.0}));
  EXPECT_TRUE(Patch::cut(image.view(), {8.0, 8.0}));
  // An edge fixes one coordinate, not two.
  Image edge = plain_image(96, 96, 20);
  for (int i = 0; i < 96 * 96; ++i) edge.pixels[static_cast<std::size_t>(i)] = i % 96 < 48 ? 20 : 220;
  EXPECT_FALSE(Patch::cut(edge.view(), kCentre));
}

TEST(Patch, IsNotFoundWhereThereIsNoneOrWhenItRunsAway) {
  const auto patch = Patch::cut(blobs({0, 0}).view(), kCentre);
  EXPECT_FALSE(patch->find(plain_image(96, 96, 0).view(), {kCentre}, PatchMotion::kAffine, 4.0));
  EXPECT_FALSE(patch->find(blobs({3.0, 0.0}).view(), {kCentre}, PatchMotion::kShift, 1.0));
  EXPECT_FALSE(patch->find(blobs({0, 0}).view(), {Eigen::Vector2d(3.0, 48.0)}, PatchMotion::kShift, 4.0));
}

}  // namespace
}  // namespace limber::frontend
