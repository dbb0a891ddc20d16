// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "limber/sensors/calibration.hpp"

namespace limber::detail {

/// Throws DataError, which names `place` and `line`, if the baseline is zero or cam1 stands to the left of
/// cam0.
/// @param hint what may be the cause, for the message
/// @return a note if the baseline is not mainly along x, else an empty text
[[nodiscard]] std::string check_baseline(const RigParameters& theta, const std::filesystem::path& place,
                                         std::size_t line, const std::string& hint);

}  // namespace limber::detail
