// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

/// Which samples of a long series are worth drawing: a screen has a thousand columns.
namespace limber {

/// @brief For a curve over time: of each of equally long stretches the lowest and the highest sample, beside
/// the first and the last of all, so that no peak is lost. Gaps (NaN) stay: a stretch keeps its first one.
/// @param limit largest number of indices, at least 8
/// @return increasing indices into y; all of them if there are no more than `limit`
/// @throws std::invalid_argument if limit < 8
[[nodiscard]] std::vector<std::size_t> thin_to_extremes(std::span<const double> y, std::size_t limit);

/// @brief For a path or a cloud: evenly, the first and the last included.
/// @param limit largest number of indices, at least 2
/// @return increasing indices below `count`; all of them if there are no more than `limit`
/// @throws std::invalid_argument if limit < 2
[[nodiscard]] std::vector<std::size_t> thin_evenly(std::size_t count, std::size_t limit);

}  // namespace limber
