// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "start_from_sensors.hpp"

/// The frames of a start in the record of its run.
namespace limber::detail {

/// How an IMU's samples are used where they were not taken when they are stamped: by what the start found.
/// Nothing where they are used as stamped, or nearly.
void say_clock(const RunRecord& record, std::vector<std::string>& notes);

/// The window's states, as far as they are known.
void write_states(const std::vector<SmoothedState>& states, RunRecord& record);

/// Who looks at every frame gets those of the start as they stay: what tells of them is read before.
/// @param next, count  the first frame of the recording that was not read, and how many there are
[[nodiscard]] std::vector<SmoothedState> smoothed_ahead(const FrameSource& source, std::size_t next,
                                                        std::size_t count, SensorWindow& window,
                                                        WindowSmoother& smoother);

/// Writes the window's frames into the record; says how long it took and what was not known by then.
void keep_window(const SensorWindow& window, Navigator& navigator, RunRecord& record);

}  // namespace limber::detail
