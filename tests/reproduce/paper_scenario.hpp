// SPDX-License-Identifier: MIT
#pragma once

#include "reproduce/paper_claims.hpp"

namespace limber::testing {

inline Scenario paper_scenario(const PaperCase& paper_case) {
  Scenario scenario;
  scenario.name = to_string(paper_case);
  scenario.use_imu = paper_case.with_imu;
  RigParameters delta = paper_decalibration();
  switch (paper_case.noise) {
    case PaperNoise::kNone:
      break;
    case PaperNoise::kConstant:
      scenario.decalibration = {{delta, ConstantShape{}}};
      break;
    case PaperNoise::kSinus:
      scenario.decalibration = {{delta, SinusShape{}}};
      break;
    case PaperNoise::kSteps:
      scenario.decalibration = {{delta, StepsShape{}}};
      break;
    case PaperNoise::kSquareStrong:
      delta(3) = 0.5;
      [[fallthrough]];
    case PaperNoise::kSquare:
      scenario.decalibration = {{delta, SquareWaveShape{}}};
      break;
  }
  return scenario;
}

}  // namespace limber::testing
