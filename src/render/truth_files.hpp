// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "limber/render/scene.hpp"

namespace limber::detail {

/// What is under the names of both cameras in one frame.
struct FramePictures {
  bool has[2] = {true, true};  ///< left, right
  bool swapped = false;        ///< each shows what the other camera saw

  [[nodiscard]] bool sound() const { return has[0] && has[1] && !swapped; }
};

/// @throws DataError if the file cannot be written
void write_text(const std::filesystem::path& file, std::string_view text);

/// The world as tables (data.csv; moving_boxes.csv and moving_box_poses.csv if any box moves): with poses and
/// theta they say where any pixel is seen by any other camera. Throws as write_text.
void write_scene(const Scene& scene, const std::vector<std::int64_t>& times_ns,
                 const std::filesystem::path& folder);

/// The frames that are not sound, one a row. Throws as write_text.
void write_faulty_frames(const std::vector<std::int64_t>& times_ns, const std::vector<FramePictures>& frames,
                         const std::filesystem::path& file);

}  // namespace limber::detail
