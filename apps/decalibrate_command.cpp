// SPDX-License-Identifier: MIT
// limber decalibrate: a recording as a rig that bends would have made it.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "commands.hpp"
#include "interrupt.hpp"
#include "limber/bags/bag_file.hpp"
#include "limber/core/errors.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/datasets/recording_place.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/decalibrate/bend_images.hpp"
#include "limber/decalibrate/bend_tracks.hpp"
#include "limber/io/atomic_file.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/scenario_presets.hpp"
#include "messages.hpp"
#include "output_folder.hpp"
#include "progress.hpp"
#include "replaceable.hpp"
#include "uninterrupted.hpp"
#include "validators.hpp"

namespace limber::app {
namespace {

namespace fs = std::filesystem;

struct DecalibrateArguments {
  fs::path dataset, out;
  std::string as;
  std::uint64_t seed = 0;
  bool force = false;
};

bool lies_in(const fs::path& inner, const fs::path& outer) {
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

void require_outside(const fs::path& out, const fs::path& recording) {
  const fs::path to = (fs::weakly_canonical(fs::absolute(out)) / "").parent_path(),
                 from = fs::canonical(recording);
  if (lies_in(to, from) || lies_in(from, to)) {
    throw DataError(out.string(), 0, "a folder outside the recording, and not around it", "the same files");
  }
}

/// @throws std::invalid_argument, DataError
std::vector<DecalibrationSignal> signals_of(const std::string& as, const Recording& recording) {
  if (as.find('=') != std::string::npos && !fs::exists(as)) {
    try {
      return {decalibration_from_string(as, recording.calibration.baseline())};
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(std::string("--as: ") + error.what());
    }
  }
  std::vector<DecalibrationSignal> signals = limber::read_scenario(as).decalibration;
  if (signals.empty()) throw DataError(as, 0, "a scenario with a decalibration", "none");
  return signals;
}

bool moves_the_centre(const std::vector<DecalibrationSignal>& signals) {
  return std::any_of(signals.begin(), signals.end(), [](const DecalibrationSignal& signal) {
    return !signal.amplitude.tail<3>().isZero(0.0);
  });
}

bool turns(const std::vector<DecalibrationSignal>& signals) {
  return std::any_of(signals.begin(), signals.end(), [](const DecalibrationSignal& signal) {
    return !signal.amplitude.head<3>().isZero(0.0);
  });
}

void bend_pictures(const DecalibrateArguments& arguments, const Recording& recording,
                   const std::vector<DecalibrationSignal>& signals) {
  if (!turns(signals)) {
    throw DataError(arguments.as, 0,
                    "an ax, ay or az that is not zero, since images can be turned, not moved", "none");
  }
  if (moves_the_centre(signals)) {
    print_warning("images can be turned, not moved: tx, ty, tz of the profile are left out");
  }
  const BentRig rig(recording, signals, arguments.seed, BentRig::Parts::kRotation);
  const FolderUnlessEmpty parent(fs::absolute(arguments.out).lexically_normal().parent_path());
  StagedFolder staged(arguments.out);
  ImageBending bending;
  {
    const Interrupt interrupt;
    Progress progress("decalibrate", recording.images.size());
    bending = bend_images(
        recording, rig, staged.path(), [&](std::size_t n) { progress.done(n); }, Interrupt::asked);
  }
  {
    const Uninterrupted until_written;
    staged.replace();
  }
  fmt::print(
      "{}: {} right images turned, written to {}\n"
      "same size, Lanczos interpolation; black where the real camera saw nothing: {:.1f} % of an image, "
      "{:.1f} % at "
      "most\n",
      recording.name, bending.images, arguments.out.string(), 100.0 * bending.black_mean,
      100.0 * bending.black_largest);
}

void bend_points(const DecalibrateArguments& arguments, const Recording& recording,
                 const std::vector<DecalibrationSignal>& signals) {
  const TrackBending bent =
      bend_tracks(recording, BentRig(recording, signals, arguments.seed, BentRig::Parts::kAll));
  {
    const Uninterrupted until_written;
    write_track_log(bent.recording, arguments.out, arguments.force);
  }
  fmt::print("{}: {} right pixels moved, {} of them out of the image, written to {}\n", recording.name,
             bent.points + bent.left_image, bent.left_image, arguments.out.string());
  if (bent.without_depth > 0) {
    print_note(fmt::format("{} right pixels without a left one have no depth to be moved by: left out",
                           bent.without_depth));
  }
}

void decalibrate(const DecalibrateArguments& arguments) {
  if (is_bag(arguments.dataset)) {
    throw DataError(arguments.dataset.string(), 0, "the folder of a recording",
                    "a bag: limber convert makes a folder of it");
  }
  require_place_for_recording(arguments.out, arguments.force);
  const ClaimedFolder claimed(arguments.out);
  const Recording recording = limber::read_recording(arguments.dataset);
  const std::vector<DecalibrationSignal> signals = signals_of(arguments.as, recording);
  require_outside(arguments.out, arguments.dataset);
  recording.images.empty() ? bend_points(arguments, recording, signals)
                           : bend_pictures(arguments, recording, signals);
}

}  // namespace

void add_decalibrate_command(CLI::App& app) {
  auto arguments = std::make_shared<DecalibrateArguments>();
  CLI::App* command = app.add_subcommand("decalibrate", "Bend the rig of a real recording");
  command->add_option("DATASET", arguments->dataset, "Folder of an EuRoC, KITTI or track-log recording")
      ->required()
      ->check(not_empty());
  command
      ->add_option("--as", arguments->as,
                   "What to bend like: a scenario file, whose decalibration is taken, or a profile such as "
                   "ay=0.5,shape=vibration,frequency=1 (degrees; m or % of the baseline for tx, ty, tz)")
      ->required()
      ->check(not_empty());
  command->add_option("--out", arguments->out, "New folder for the bent recording")
      ->required()
      ->check(not_empty());
  command->add_option("--seed", arguments->seed, "Of random profiles")
      ->check(whole_number())
      ->capture_default_str();
  add_force_option(*command, arguments->force, kEarlierRecording);
  command->footer(
      "\nRight images are turned by the exact homography of the rotation, through the lens; the right pixels "
      "of\n"
      "track logs move with rotation and translation. Calibration, stamps and left images stay as they are; "
      "the\n"
      "true rig is written beside them.\n"
      "Example:\n  limber decalibrate data/v101 --as ay=2,shape=ramp,end=8 --out data/v101_ramp");
  command->callback([arguments] { decalibrate(*arguments); });
}

}  // namespace limber::app
