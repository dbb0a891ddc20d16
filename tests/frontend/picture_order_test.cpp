// SPDX-License-Identifier: MIT
#include "frontend/picture_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "frontend/room_flight.hpp"
#include "same_frames.hpp"

namespace limber {
namespace {

using testing::ImagePairInMemory;
using testing::same;
using testing::sequence;
using testing::small_rig;
using testing::track;

std::vector<ImagePairInMemory> exchanged_in(std::vector<ImagePairInMemory> pairs,
                                            const std::vector<std::size_t>& frames) {
  for (const std::size_t k : frames) std::swap(pairs[k].left, pairs[k].right);
  return pairs;
}

std::vector<std::size_t> put_back(const std::vector<StereoFrame>& frames) {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (frames[k].put_back) out.push_back(k);
  }
  return out;
}

TEST(PictureOrder, PutsExchangedPicturesBackToTheSameBits) {
  const auto pairs = sequence(9);
  const std::vector<std::size_t> exchanged = {3, 5, 6};
  const auto expected = track(pairs, small_rig());
  const auto frames = track(exchanged_in(pairs, exchanged), small_rig());
  EXPECT_EQ(put_back(expected), std::vector<std::size_t>{});
  EXPECT_EQ(put_back(frames), exchanged);
  for (std::size_t k = 0; k < frames.size(); ++k) EXPECT_TRUE(same(frames[k], expected[k])) << k;
}

TEST(PictureOrder, IsNotKnownOfTheFirstPairs) {
  const auto frames = track(exchanged_in(sequence(6), {0}), small_rig());
  EXPECT_EQ(put_back(frames), std::vector<std::size_t>{});
  EXPECT_GE(frames.back().observations.size(), 60u);
}

/// A camera that goes sideways by `baselines` a frame, twenty points.
StereoFrame sideways(std::int64_t k, double baselines, bool exchanged) {
  StereoFrame frame{k * testing::kPeriodNs, {}};
  for (std::int64_t id = 0; id < 20; ++id) {
    const double parallax = 10.0 + static_cast<double>(id);
    const Eigen::Vector2d left(300.0 - baselines * parallax * static_cast<double>(k), 10.0 * id);
    const Eigen::Vector2d right = left - Eigen::Vector2d(parallax, 0.0);
    frame.observations.push_back({id, exchanged ? right : left, exchanged ? left : right, true, true});
  }
  return frame;
}

TEST(PictureOrder, TakesPicturesAsTheyAreThatStayExchanged) {
  frontend::PictureOrder order;
  for (std::int64_t k = 0; k < 3; ++k) order.remember(sideways(k, 0.1, false));
  int turned = 0;
  for (std::int64_t k = 3; k < 40; ++k) {
    const StereoFrame as_given = sideways(k, 0.1, true);
    StereoFrame back = sideways(k, 0.1, false);
    back.put_back = true;
    const bool put_back = order.doubts(as_given) && order.prefers(back, as_given);
    order.remember(put_back ? back : as_given);
    turned += put_back ? 1 : 0;
  }
  EXPECT_EQ(turned, 21);  // a second
}

TEST(PictureOrder, TakesNoMotionForAnExchange) {
  for (const double baselines : {-2.0, -1.0, 1.0, 2.0}) {  // with 1, left pixels stand where right ones did
    frontend::PictureOrder order;
    for (std::int64_t k = 0; k < 8; ++k) {
      const StereoFrame frame = sideways(k, baselines, false);
      EXPECT_FALSE(order.doubts(frame) && order.prefers(sideways(k, baselines, true), frame))
          << baselines << k;
      order.remember(frame);
    }
  }
}

/// All of a frame's pixels moved by a turn that nobody expected.
StereoFrame turned(StereoFrame frame, double px) {
  for (StereoObservation& point : frame.observations) {
    point.uv_cam0.x() += px;
    point.uv_cam1.x() += px;
  }
  return frame;
}

TEST(PictureOrder, TakesNoBlurForAnExchange) {
  frontend::PictureOrder order;
  for (std::int64_t k = 0; k < 4; ++k) order.remember(sideways(k, 0.1, false));
  StereoFrame left_over = turned(sideways(4, 0.1, false), 120.0);  // half of the points are lost
  left_over.observations.resize(9);
  const StereoFrame found_elsewhere = turned(sideways(4, 0.1, true), 60.0);
  EXPECT_TRUE(order.doubts(left_over));
  EXPECT_FALSE(order.prefers(found_elsewhere, left_over));
}

}  // namespace
}  // namespace limber
