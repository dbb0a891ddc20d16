// SPDX-License-Identifier: MIT
#include "limber/run/draw_initial_state.hpp"

#include "limber/core/random.hpp"
#include "limber/core/so3.hpp"

namespace limber {

GroundTruthState draw_initial_state(const GroundTruthState& truth, const InitialSigma& sigmas,
                                    std::uint64_t seed, std::uint64_t run) {
  const RandomStream error(seed, run, "initial_error");
  GroundTruthState state = truth;
  state.p_world_body += sigmas.position * error.normal3(0);
  state.R_world_body = truth.R_world_body * so3_exp(sigmas.attitude * error.normal3(1));
  state.v_world_body += sigmas.velocity * error.normal3(2);
  state.bias_accel += sigmas.bias_accel * error.normal3(3);
  state.bias_gyro += sigmas.bias_gyro * error.normal3(4);
  return state;
}

}  // namespace limber
