// SPDX-License-Identifier: MIT
#include "health_since.hpp"

#include <fmt/format.h>

#include "limber/core/errors.hpp"

namespace limber::app {

void require_same_cameras(const HealthState& state, const StereoCalibration& assumed,
                          const std::string& file) {
  for (std::size_t k = 0; k < 2; ++k) {
    const std::string camera = camera_in_words(k == 0 ? assumed.cam0 : assumed.cam1);
    if (state.cameras[k] != camera) {
      throw DataError(file, 0, fmt::format("the cameras of this recording, cam{}: {}", k, camera),
                      state.cameras[k]);
    }
  }
}

HealthState earlier_state(const std::filesystem::path& since, const StereoCalibration& assumed) {
  HealthState state = read_health_state(since);
  require_same_cameras(state, assumed, health_state_file(since).string());
  return state;
}

std::optional<SinceThen> since_then(const std::optional<HealthState>& before, const Diagnosis& now) {
  if (!before || !now.state) {
    return std::nullopt;
  }
  return SinceThen{before->recording, change_between(before->rig, now.state->rig, now.judged_by.tolerance)};
}

}  // namespace limber::app
