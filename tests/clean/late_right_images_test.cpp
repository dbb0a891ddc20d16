// SPDX-License-Identifier: MIT
// Right pixels of an earlier frame are not used; what a rig does is left alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "clean/cleaned_frames.hpp"
#include "limber/core/so3.hpp"
#include "limber/measure/rig.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;
using ::testing::AllOf;
using testing::cleaned;
using ::testing::Each;
using ::testing::ElementsAre;
using testing::Frames;
using ::testing::Ge;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using testing::kStepNs;
using ::testing::Le;
using testing::matched_in;
using testing::rig_of;

constexpr std::size_t kCount = 40;

struct Flight {
  /// Frames whose right image is late, and by how many.
  std::function<std::size_t(std::size_t)> lag = [](std::size_t) { return std::size_t{0}; };
  /// What the rig is turned by about y [rad].
  std::function<double(std::size_t)> vergence = [](std::size_t) { return 0.0; };
  /// How fast the camera turns and goes: 1 as usual, 0 not at all.
  std::function<double(std::size_t)> pace = [](std::size_t) { return 1.0; };
};

/// A camera that goes sideways and turns to and fro before thirty points at 3 to 30 m.
Frames seen_on(const Flight& flight) {
  const StereoCalibration rig = rig_of(0.1);
  const Pose T_cam1_cam0 = pose_from_rig(rig.theta);
  std::vector<Pose> from_world;
  double t = 0.0;
  for (std::size_t k = 0; k < kCount; ++k) {
    t += 0.05 * flight.pace(k);
    from_world.push_back(Pose{
        so3_exp(Vector3d(0.02 * std::cos(2.0 * t), 0.1 * std::sin(3.0 * t), 0.0)),
        {0.5 * t, 0.0, 0.0}}.inverse());
  }
  Frames frames;
  for (std::size_t k = 0; k < kCount; ++k) {
    StereoFrame frame{static_cast<std::int64_t>(k) * kStepNs, {}};
    const Pose bent{so3_exp(Vector3d(0.0, flight.vergence(k), 0.0)), Vector3d::Zero()};
    for (std::int64_t id = 0; id < 30; ++id) {
      const double depth = 3.0 + 27.0 * static_cast<double>(id * 7 % 30) / 30.0;
      const Vector3d place = depth * Vector3d(0.1 * static_cast<double>(id % 6 - 2),
                                              0.08 * static_cast<double>(id / 6 - 2), 1.0);
      const auto left = project(rig.cam0, from_world[k] * place);
      const auto right = project(rig.cam1, bent * T_cam1_cam0 * from_world[k - flight.lag(k)] * place);
      frame.observations.push_back({id, left.value().uv, right.value().uv, true, true});
    }
    frames.push_back(frame);
  }
  return frames;
}

std::vector<std::size_t> without_right(const Frames& frames) {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    EXPECT_EQ(frames[k].observations.size(), 30u) << "left pixels stay: " << k;
    if (matched_in(frames[k]).empty()) {
      out.push_back(k);
    }
  }
  return out;
}

std::vector<std::size_t> from_to(std::size_t first, std::size_t last) {
  std::vector<std::size_t> out;
  for (std::size_t k = first; k <= last; ++k) {
    out.push_back(k);
  }
  return out;
}

TEST(LateRightImages, AreNotUsedUntilTheyFitAgain) {
  for (const std::size_t lag : {1u, 2u, 3u}) {
    Flight late;
    late.lag = [lag](std::size_t k) { return k >= 12 && k < 24 ? lag : 0; };
    const auto [frames, report] = cleaned(seen_on(late), rig_of(0.1));
    EXPECT_EQ(without_right(frames), from_to(12, 23)) << lag;
    EXPECT_EQ(report.late_frames, 12u);
    EXPECT_THAT(in_words(report), ElementsAre(HasSubstr("in 12 of 40 frames the right image is that of an")));
  }
}

TEST(LateRightImages, OfARigThatJumpsMeanwhileAreNotUsedEither) {
  Flight late;
  late.lag = [](std::size_t k) { return std::size_t{k >= 12 && k < 24}; };
  late.vergence = [](std::size_t k) { return k / 8 % 2 == 0 ? 0.0 : 0.01; };  // at 8, 16, 24, 32
  EXPECT_EQ(without_right(cleaned(seen_on(late), rig_of(0.1)).frames), from_to(12, 23));
}

/// In the midst the camera rests for a while: then a late image is as good as any.
TEST(LateRightImages, AreKnownAgainAfterARest) {
  Flight late;
  late.lag = [](std::size_t k) { return std::size_t{k >= 12 && k < 34}; };
  late.pace = [](std::size_t k) { return k >= 18 && k < 26 ? 0.01 : 1.0; };
  const auto without = without_right(cleaned(seen_on(late), rig_of(0.1)).frames);
  EXPECT_THAT(without, IsSupersetOf({12, 17, 28, 33}));
  EXPECT_THAT(without, Each(AllOf(Ge(12u), Le(33u))));
}

TEST(LateRightImages, WhatTheRigDoesIsLeftAlone) {
  const std::vector<std::function<double(std::size_t)>> bends = {
      [](std::size_t) { return 0.0; }, [](std::size_t k) { return k < 15 ? 0.0 : 0.02; },
      [](std::size_t k) { return k < 15 ? 0.0 : -0.02; },
      [](std::size_t k) { return 0.002 * std::sin(3.8 * static_cast<double>(k)); },
      [](std::size_t k) { return 0.001 * static_cast<double>(k); }};
  for (std::size_t i = 0; i < bends.size(); ++i) {
    Flight bent;
    bent.vergence = bends[i];
    const auto [frames, report] = cleaned(seen_on(bent), rig_of(0.1));
    EXPECT_EQ(report.late_frames, 0u) << i;
    EXPECT_THAT(without_right(frames), IsEmpty()) << i;
  }
}

/// Of the jumps to and fro one has the right pixels stand where a late picture would, by chance: it is used
/// with the next frame, in which that is over.
TEST(LateRightImages, AJumpThatLooksLikeOneWaitsUntilItDoesNot) {
  Flight bent;
  bent.vergence = [](std::size_t k) { return k / 5 % 2 == 0 ? 0.0 : 0.01; };
  EXPECT_THAT(without_right(cleaned(seen_on(bent), rig_of(0.1)).frames), ElementsAre(35));
}

/// The camera turns, as fast all the time, and the rig once by as much as within a frame, the other way: that
/// cannot be told from a late picture.
TEST(LateRightImages, WhatCannotBeToldIsTakenForAJumpAfterFiveSeconds) {
  const StereoFrame first = seen_on({}).front();
  Frames frames;
  for (std::size_t k = 0; k < 130; ++k) {
    const double turn = 2.0 * static_cast<double>(k);  // [px]
    frames.push_back(first);
    frames.back().t_ns = static_cast<std::int64_t>(k) * kStepNs;
    for (StereoObservation& point : frames.back().observations) {
      point.uv_cam0.x() += turn;
      point.uv_cam1.x() += turn - (k < 20 ? 0.0 : 2.0);
    }
  }
  EXPECT_EQ(without_right(cleaned(frames, rig_of(0.1)).frames), from_to(20, 120));
}

}  // namespace
}  // namespace limber
