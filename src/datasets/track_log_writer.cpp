// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <stdexcept>

#include "euroc_folder.hpp"
#include "io/table_text.hpp"
#include "limber/core/errors.hpp"
#include "limber/datasets/recording_place.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/io/atomic_file.hpp"
#include "rig_files/euroc_text.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using detail::EurocFolder;
using detail::TableText;

constexpr std::array<const char*, 8> kFolders = {
    "imu0",       "odometry0",         "cam0", "cam1", "tracks0", "state_groundtruth_estimate0",
    "landmarks0", "calibration_truth0"};

// Nothing but what this writer makes; so that images, other people's files or logs are never removed.
void require_only_track_log(const fs::path& mav0) {
  if (!fs::exists(mav0)) {
    return;
  }
  const auto refuse = [&mav0](const fs::path& found) {
    throw DataError(mav0.string(), 0, "no folder mav0, or an older track log to replace",
                    "one that holds " + found.string());
  };
  std::set<fs::path> known;
  for (const char* const folder : kFolders) {
    known.insert({mav0 / folder, mav0 / folder / "data.csv", mav0 / folder / "sensor.yaml"});
  }
  known.erase(mav0 / "cam0" / "data.csv");  // lists images
  known.erase(mav0 / "cam1" / "data.csv");
  for (const fs::path& entry : fs::recursive_directory_iterator(mav0)) {
    if (!known.contains(entry)) {
      refuse(entry);
    }
  }
}

void add_pixel(TableText& table, bool is_seen, const Eigen::Vector2d& uv) {
  is_seen ? table.cells(uv) : table.empty_cells(2);
}

void write_tracks(const Recording& recording, const EurocFolder& mav0) {
  TableText table("write_track_log, tracks", ',');
  table.header("#timestamp [ns],track_id,u0 [px],v0 [px],u1 [px],v1 [px]");
  for (const StereoFrame& frame : recording.frames) {
    table.require_later(frame.t_ns);
    if (frame.observations.empty()) {
      table.cell(frame.t_ns);
      table.empty_cells(5);
      table.end_row();
    }
    for (const StereoObservation& point : frame.observations) {
      table.cell(frame.t_ns);
      table.cell(point.track_id);
      add_pixel(table, point.in_cam0, point.uv_cam0);
      add_pixel(table, point.in_cam1, point.uv_cam1);
      table.end_row();
    }
  }
  mav0.write("tracks0", "data.csv", table.text());
  if (const auto& sigma = recording.pixel_noise) {
    mav0.write("tracks0", "sensor.yaml",
               fmt::format("sigma_px: {}  # u0, v0, u1, v1\n", detail::list_of(sigma->data(), 4)));
  }
}

void write_landmarks(const Recording& recording, const EurocFolder& mav0) {
  if (recording.truth.landmarks.empty()) {
    return;
  }
  TableText table("write_track_log, landmarks", ',');
  table.header("#track_id,x [m],y [m],z [m]");
  for (const auto& [id, p_world_landmark] : recording.truth.landmarks) {
    table.cell(id);
    table.cells(p_world_landmark);
    table.end_row();
  }
  mav0.write("landmarks0", "data.csv", table.text());
}

void write_calibration_truth(const Recording& recording, const EurocFolder& mav0) {
  if (recording.truth.rig.empty()) {
    return;
  }
  mav0.write("calibration_truth0", "data.csv", calibration_truth_text(recording.truth.rig));
}

void require(bool condition, const std::string& rule) {
  if (!condition) {
    throw std::invalid_argument("write_track_log: " + rule);
  }
}

void require_plausible_noise(const Recording& recording) {
  if (const auto& noise = recording.imu_noise) {
    const Eigen::Array4d values(noise->gyro_density, noise->gyro_walk, noise->accel_density,
                                noise->accel_walk);
    require(values.isFinite().all() && (values >= 0.0).all(), "IMU noise must be finite and not negative");
  }
  if (const auto& noise = recording.odometry_noise) {
    require((noise->sigma_v.array() >= 0.0).all() && (noise->sigma_omega.array() >= 0.0).all(),
            "odometry noise must not be negative");
  }
  if (const auto& sigma = recording.pixel_noise) {
    require((sigma->array() > 0.0).all(), "pixel noise must be above zero");
  }
}

void require_plausible_frame(const StereoFrame& frame) {
  std::set<std::int64_t> ids;
  for (const StereoObservation& point : frame.observations) {
    require(point.in_cam0 || point.in_cam1, "a point must be seen by at least one camera");
    require(ids.insert(point.track_id).second, "a track_id must not be twice in a frame");
  }
}

void require_writable_content(const Recording& recording) {
  require(!recording.frames.empty(), "the recording has no frames");
  require(recording.calibration.body != BodyFrame::kMiddleOfBaseline,
          "T_BS cannot express the body kMiddleOfBaseline, which moves with theta");
  require_plausible_noise(recording);
  std::for_each(recording.frames.begin(), recording.frames.end(), require_plausible_frame);
}

}  // namespace

std::string calibration_truth_text(const std::vector<TrueRig>& truth) {
  TableText table("true calibration", ',');
  table.header("#timestamp [ns],ax [rad],ay [rad],az [rad],tx [m],ty [m],tz [m]");
  for (const TrueRig& row : truth) {
    table.time(row.t_ns);
    table.cells(row.theta);
    table.end_row();
  }
  return std::string(table.text());
}

void write_track_log(const Recording& recording, const fs::path& folder, bool replace) {
  require_writable_content(recording);
  try {
    const FolderUnlessEmpty outer(folder);
    require_place_for_mav0(folder, replace);
    require_only_track_log(folder / "mav0");
    EurocFolder mav0(folder / "mav0");
    mav0.write_cameras(recording.calibration);
    mav0.write_imu(recording);
    mav0.write_odometry(recording);
    write_tracks(recording, mav0);
    mav0.write_groundtruth(recording);
    write_landmarks(recording, mav0);
    write_calibration_truth(recording, mav0);
    mav0.commit();
  } catch (const fs::filesystem_error& e) {
    throw DataError((folder / "mav0").string(), 0, "a place where folders and files can be written",
                    e.code().message());
  }
}

}  // namespace limber
