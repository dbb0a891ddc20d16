// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>

#include "limber/render/picture.hpp"
#include "limber/simulate/simulator.hpp"

namespace limber {

/// What pictures of a scenario are like. By default nothing disturbs them.
struct PictureOptions {
  SceneKind scene = SceneKind::kRoom;
  double noise = 0.0;  ///< sigma [grey levels]
  double gain_difference =
      0.0;                  ///< the right camera is darker by this share; both swing by half of it within 7 s
  double vignetting = 0.0;  ///< light lost in the corners, 0 to 1
  double exposure = 0.0;    ///< [s], around the stamp: motion blur
};

/// The world that pictures of a scenario show: around its trajectory. Throws as `simulate`.
[[nodiscard]] Scene make_scene(const Scenario& scenario, SceneKind kind, std::uint64_t seed,
                               std::uint64_t run);

/// @brief Writes what `simulate` makes as an EuRoC folder with pictures in place of matched points. The rig
/// bends between the pictures; where they are blurred, during the exposure too.
/// @param folder    is filled with mav0; should be a StagedFolder
/// @param progress  told the number of pairs done; may be empty
/// @param stop      asked before every pair: true ends the work by std::runtime_error; may be empty
/// @return number of pairs
/// @throws as simulate and write_track_log; std::invalid_argument if an option makes no sense
std::size_t render_recording(const Scenario& scenario, std::uint64_t seed, std::uint64_t run,
                             const PictureOptions& options, const std::filesystem::path& folder,
                             const std::function<void(std::size_t)>& progress = {},
                             const std::function<bool()>& stop = {});

}  // namespace limber
