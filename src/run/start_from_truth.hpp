// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "limber/run/run_options.hpp"

namespace limber::detail {

/// The truth at a frame plus an error drawn from the initial sigmas. What the truth does not give (velocity,
/// biases) is little known.
[[nodiscard]] InitialState start_from_truth(const Recording& recording, const RunOptions& options,
                                            const RunSetup& setup, std::int64_t t_ns);

}  // namespace limber::detail
