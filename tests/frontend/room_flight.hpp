// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "frontend/painted_room.hpp"
#include "limber/frontend/stereo_tracker.hpp"

namespace limber::testing {

inline constexpr std::int64_t kPeriodNs = 50'000'000;

struct ImagePairInMemory {
  Image left, right;
};

/// The rig as it really is: not as small_rig() has it, but turned by a degree and longer by a fifth.
inline RigParameters true_theta() {
  RigParameters theta = small_rig().theta;
  theta << 0.015, -0.012, 0.018, 1.2 * theta[3], 0.008, -0.006;
  return theta;
}

/// What the true rig sees in frame k. The right camera is exposed differently.
inline ImagePairInMemory pair_of_frame(int k, const RigParameters& theta) {
  const StereoCalibration rig = small_rig();
  const Pose T_world_cam0 = flight(k), T_world_cam1 = T_world_cam0 * pose_from_rig(theta).inverse();
  const auto seed = static_cast<std::uint64_t>(k);
  return {photograph(rig.cam0, T_world_cam0, {1.0, 0.0, 1.5, 2 * seed}),
          photograph(rig.cam1, T_world_cam1, {0.8, 15.0, 1.5, 2 * seed + 1})};
}

inline std::vector<ImagePairInMemory> sequence(int frames, const RigParameters& theta = true_theta()) {
  std::vector<ImagePairInMemory> pairs;
  for (int k = 0; k < frames; ++k) pairs.push_back(pair_of_frame(k, theta));
  return pairs;
}

inline StereoFrame process(StereoTracker& tracker, int k, const Image& left, const Image& right) {
  return tracker.process(k * kPeriodNs, left.view(), right.view());
}

inline std::vector<StereoFrame> track(const std::vector<ImagePairInMemory>& pairs,
                                      const StereoCalibration& assumed) {
  StereoTracker tracker(assumed);
  std::vector<StereoFrame> frames;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    frames.push_back(process(tracker, static_cast<int>(k), pairs[k].left, pairs[k].right));
  }
  return frames;
}

}  // namespace limber::testing
