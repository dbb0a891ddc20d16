// SPDX-License-Identifier: MIT
#include "limber/decalibrate/bent_rig.hpp"

#include <algorithm>
#include <stdexcept>

#include "limber/core/time.hpp"
#include "limber/datasets/interpolate.hpp"

namespace limber {
namespace {

std::vector<std::int64_t> require_frames(std::vector<std::int64_t> times) {
  if (times.empty()) throw std::invalid_argument("BentRig: the recording has no frames");
  return times;
}

}  // namespace

std::vector<std::int64_t> frame_times(const Recording& recording) {
  std::vector<std::int64_t> times;
  for (const ImagePair& pair : recording.images) times.push_back(pair.t_ns);
  for (const StereoFrame& frame : recording.frames) times.push_back(frame.t_ns);
  return times;
}

BentRig::BentRig(const Recording& recording, std::vector<DecalibrationSignal> signals, std::uint64_t seed,
                 Parts parts)
    : recording_(recording),
      parts_(parts),
      times_(require_frames(frame_times(recording))),
      decalibration_(std::move(signals), seconds_between(times_.front(), times_.back()), seed, 0) {}

RigParameters BentRig::delta(std::int64_t t_ns) const {
  return decalibration_.at(std::max<std::int64_t>(t_ns - times_.front(), 0));
}

RigParameters BentRig::before(std::int64_t t_ns) const {
  return recording_.truth.rig.empty() ? recording_.calibration.theta
                                      : true_rig_at(recording_.truth.rig, t_ns).theta;
}

RigParameters BentRig::after(std::int64_t t_ns) const {
  const RigParameters theta = before(t_ns);
  RigParameters bent = theta + delta(t_ns);
  if (parts_ == Parts::kRotation) {
    const Eigen::Vector3d centre = pose_from_rig(theta).inverse().p;
    bent.tail<3>() = -(pose_from_rig(bent).R * centre);
  }
  return bent;
}

Eigen::Matrix3d BentRig::turn_of_cam1(std::int64_t t_ns) const {
  return pose_from_rig(after(t_ns)).R * pose_from_rig(before(t_ns)).R.transpose();
}

std::vector<TrueRig> BentRig::truth() const {
  std::vector<std::int64_t> times = times_;
  for (const std::int64_t jump : decalibration_.jumps(times_.back() - times_.front())) {
    times.push_back(times_.front() + jump);
  }
  for (const TrueRig& known : recording_.truth.rig) times.push_back(known.t_ns);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  std::vector<TrueRig> truth;
  for (const std::int64_t t_ns : times) truth.push_back({t_ns, after(t_ns)});
  return truth;
}

}  // namespace limber
