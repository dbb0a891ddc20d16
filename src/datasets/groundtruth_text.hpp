// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "limber/datasets/trajectory_files.hpp"

namespace limber::detail {

/// What write_euroc_groundtruth writes. @throws std::invalid_argument as it does
[[nodiscard]] std::string groundtruth_text(const GroundTruth& truth);

}  // namespace limber::detail
