// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include "run_and_summarize.hpp"

namespace limber::testing {

/// Expects of a disturbed recording so many times the error of the sound one at most, and that it is not
/// lost.
/// @return what the disturbed one comes to
inline RunSummary expect_beside_the_sound(const Recording& sound, const Recording& disturbed, Method method,
                                          double times) {
  RunOptions options;
  options.method = method;
  const RunSummary with = run_and_summarize(disturbed, options);
  EXPECT_LT(with.ate_se3_m.value(), times * run_and_summarize(sound, options).ate_se3_m.value());
  EXPECT_FALSE(with.inputs.lost_since_ns);
  return with;
}

}  // namespace limber::testing
