// SPDX-License-Identifier: MIT
// Frames whose left and right pictures are exchanged are not used; what only looks alike is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "clean/cleaned_frames.hpp"
#include "limber/measure/rig.hpp"

namespace limber {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::cleaned;
using ::testing::ElementsAre;
using testing::Frames;
using ::testing::HasSubstr;
using testing::kStepNs;
using testing::rig_of;

/// Points at 2 to 30 m before a camera that moves sideways by so much of the baseline a frame; in the frames
/// `exchanged` the pictures are.
Frames with_exchanged(const std::vector<std::size_t>& exchanged, double baselines, std::size_t count) {
  const StereoCalibration rig = rig_of(0.1);
  const Pose T_cam1_cam0 = pose_from_rig(rig.theta);
  Frames frames;
  for (std::size_t k = 0; k < count; ++k) {
    StereoFrame frame{static_cast<std::int64_t>(k) * kStepNs, {}};
    for (std::int64_t id = 0; id < 20; ++id) {
      const Vector3d place(static_cast<double>(id % 5) - 2.0, 0.2 * static_cast<double>(id / 5),
                           2.0 + 28.0 * static_cast<double>(id * 7 % 20) / 20.0);
      const Vector3d p = place - 0.1 * baselines * static_cast<double>(k) * Vector3d::UnitX();
      Vector2d left = project(rig.cam0, p).value().uv, right = project(rig.cam1, T_cam1_cam0 * p).value().uv;
      if (std::count(exchanged.begin(), exchanged.end(), k) > 0) {
        std::swap(left, right);
      }
      frame.observations.push_back({id, left, right, true, true});
    }
    frames.push_back(frame);
  }
  return frames;
}

TEST(ExchangedPictures, AreNotUsed) {
  for (const double baselines : {-3.0, -0.3, 0.0, 0.3, 3.0}) {
    const auto [frames, report] = cleaned(with_exchanged({2, 3, 6}, baselines, 8), rig_of(0.1));
    for (std::size_t k = 0; k < frames.size(); ++k) {
      EXPECT_EQ(frames[k].observations.empty(), k == 2 || k == 3 || k == 6) << k;
      EXPECT_EQ(frames[k].t_ns, static_cast<std::int64_t>(k) * kStepNs);
    }
    EXPECT_EQ(report.exchanged_frames, 3u);
    EXPECT_EQ(report.leapt_matches, 0u);
    EXPECT_THAT(in_words(report), ElementsAre(HasSubstr("in 3 of 8 frames the left and the right image")));
  }
}

TEST(ExchangedPictures, ThatTheFrontEndPutBackAreCounted) {
  Frames put_back = with_exchanged({}, 0.3, 8);
  put_back[5].put_back = true;
  const auto [frames, report] = cleaned(put_back, rig_of(0.1));
  EXPECT_EQ(frames[5].observations.size(), put_back[5].observations.size());
  EXPECT_EQ(report.put_back_frames, 1u);
  EXPECT_THAT(in_words(report), ElementsAre(HasSubstr("in 1 of 8 frames the left and the right image were")));
}

TEST(ExchangedPictures, AreNotSeenInMotion) {
  for (const double baselines : {-2.0, -1.0, 1.0, 2.0}) {  // with 1, left pixels stand where right ones did
    EXPECT_EQ(cleaned(with_exchanged({}, baselines, 8), rig_of(0.1)).report.exchanged_frames, 0u)
        << baselines;
  }
}

/// The body turns and the right camera turns the other way, within a frame: all left pixels go to one side,
/// all right ones to the other, as if they came to where the others had been.
TEST(ExchangedPictures, AreNotSeenInBending) {
  for (const double shift : {-12.0, -6.0, 6.0, 12.0}) {
    Frames bent = with_exchanged({}, 0.05, 8);
    for (StereoObservation& point : bent[4].observations) {
      point.uv_cam0.x() -= shift;
      point.uv_cam1.x() += shift;
    }
    EXPECT_EQ(cleaned(bent, rig_of(0.1)).report.exchanged_frames, 0u) << shift;
  }
}

TEST(ExchangedPictures, ThatStaySoAreTakenAsTheyAre) {
  std::vector<std::size_t> from_three_on;
  for (std::size_t k = 3; k < 40; ++k) {
    from_three_on.push_back(k);
  }
  const auto [frames, report] = cleaned(with_exchanged(from_three_on, 0.02, 40), rig_of(0.1));
  EXPECT_EQ(report.exchanged_frames, 20u);  // a second
  EXPECT_FALSE(frames.back().observations.empty());
}

}  // namespace
}  // namespace limber
