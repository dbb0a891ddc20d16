// SPDX-License-Identifier: MIT
#include "recalibration.hpp"

#include <algorithm>
#include <string_view>

#include "frame_source.hpp"
#include "limber/core/errors.hpp"
#include "limber/diagnose/run_summary.hpp"
#include "limber/io/atomic_file.hpp"
#include "limber/rig_files/write_rig_files.hpp"
#include "recalibration_text.hpp"
#include "replaceable.hpp"

namespace limber::app {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kRecalibrationMark = "\"recalibration\"";

std::optional<BeforeAfter> ate_of(const Recording& recording, const RunOptions& run,
                                  const Recalibration& found, const FramesOf& frames,
                                  std::vector<std::string>& notes) {
  if (recording.truth.motion.states.empty()) {
    return std::nullopt;
  }
  RunOptions options = run;
  options.method = Method::kEkf;
  options.assume_error.setZero();
  std::vector<double> ates;
  for (const StereoCalibration* calibration : {&found.given, &found.fitted}) {
    Recording with = recording;
    with.calibration = *calibration;
    try {
      const RunRecord record = run_recording(with, options, frames(with).frames);
      const auto ate = summarize(with, options, record).ate_se3_m;
      if (!ate) {
        return std::nullopt;
      }
      ates.push_back(*ate);
    } catch (const std::runtime_error& error) {
      notes.push_back("ekf with the " + std::string(ates.empty() ? "given" : "corrected") +
                      " calibration fails: " + error.what());
      return std::nullopt;
    }
  }
  return BeforeAfter{ates[0], ates[1]};
}

/// What an earlier recalibration wrote in formats that cannot say this one: it would pass for its own.
void remove_older(const fs::path& folder, const std::vector<std::string>& written) {
  for (const std::string& name : rig_file_names()) {
    if (std::find(written.begin(), written.end(), name) == written.end()) {
      fs::remove(folder / name);
    }
  }
}

}  // namespace

RecalibrationOutcome recalibrate(const Recording& recording, const RecalibrateOptions& options,
                                 const FramesOf& frames, const std::function<void(std::size_t)>& progress) {
  RecalibrationOutcome out;
  const ImageFrames images = frames(recording);
  out.found = recalibrate_recording(recording, options, images.frames, progress);
  out.notes = out.found.notes;
  (void)note_damaged(images, out.notes);
  out.ate = ate_of(recording, options.run, out.found, frames, out.notes);
  return out;
}

void require_replaceable_recalibration(const fs::path& folder, bool force,
                                       const std::vector<fs::path>& inputs) {
  require_no_recording(folder);
  const fs::path report = folder / kRecalibrationFile;
  require_replaceable(report, kRecalibrationMark, force, inputs);
  const std::string_view mark = fs::exists(report) ? "" : kRecalibrationMark;
  for (const std::string& name : rig_file_names()) {
    require_replaceable(folder / name, mark, force, inputs);
  }
}

void write_recalibration(const fs::path& folder, const RecalibrationOutcome& outcome,
                         const Recording& recording, bool rig) {
  try {
    const FolderUnlessEmpty outer(folder);
    StagedFolder staged(folder / "calibration");
    std::vector<std::string> files;
    if (rig) {
      files = write_rig_files(staged.path(), outcome.found.fitted, recording.imu_noise);
    }
    write_file_atomically(staged.path() / kRecalibrationFile,
                          to_json(outcome.found, recording.name, outcome.ate, files));
    if (rig) {
      remove_older(folder, files);
    }
    for (const std::string& name : files) {
      fs::create_directories((folder / name).parent_path());
    }
    files.emplace_back(kRecalibrationFile);
    staged.move_files(files, folder);
  } catch (const fs::filesystem_error& error) {
    throw DataError(folder.string(), 0, "a folder that can be made and written", error.code().message());
  }
}

}  // namespace limber::app
