// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "limber/render/scene.hpp"

namespace limber::detail {

/// What is under the names of both cameras in one frame.
struct FramePictures {
  bool has[2] = {true, true};  ///< left, right
  bool swapped = false;        ///< each shows what the other camera saw

  [[nodiscard]] bool sound() const { return has[0] && has[1] && !swapped; }
};

/// The world as tables (data.csv; moving_boxes.csv and moving_box_poses.csv if any box moves): with poses and
/// theta they say where any pixel is seen by any other camera.
/// @throws DataError if a file cannot be written
void write_scene(const Scene& scene, const std::vector<std::int64_t>& times_ns,
                 const std::filesystem::path& folder);

/// The frames that are not sound, one a row.
/// @throws DataError if the file cannot be written
void write_faulty_frames(const std::vector<std::int64_t>& times_ns, const std::vector<FramePictures>& frames,
                         const std::filesystem::path& file);

}  // namespace limber::detail
