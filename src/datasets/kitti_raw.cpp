// SPDX-License-Identifier: MIT
// KITTI raw drives: image_00, image_01 (or image_02, image_03) and oxts, each with data and timestamps.txt;
// the calibration of the day in the drive's folder or in the one above it.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "formats.hpp"
#include "image_checks.hpp"
#include "io/numbers.hpp"
#include "io/text_file.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/so3.hpp"
#include "limber/core/time.hpp"
#include "rig_files/rig_formats.hpp"

namespace limber::detail {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCameras = "calib_cam_to_cam.txt";
constexpr std::int64_t kSlowestImu = 20'000'000;  // [ns] between samples: slower ones are no IMU
constexpr double kFarthest = 0.5;                 // of an interval, between left and right image

std::optional<std::int64_t> parse_date(std::string_view text) {  // 2011-09-26
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') {
    return std::nullopt;
  }
  const auto year = parse_integer(text.substr(0, 4)), month = parse_integer(text.substr(5, 2)),
             day = parse_integer(text.substr(8, 2));
  if (!year || !month || !day || *month < 0 || *day < 0) {
    return std::nullopt;
  }
  const std::chrono::year_month_day date{std::chrono::year(static_cast<int>(*year)),
                                         std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  constexpr std::int64_t kDayNs = 86'400'000'000'000;
  return date.ok() ? std::optional(std::chrono::sys_days(date).time_since_epoch().count() * kDayNs)
                   : std::nullopt;
}

std::optional<std::int64_t> parse_clock(std::string_view text) {  // 13:02:25.964389445
  if (text.size() < 8 || text[2] != ':' || text[5] != ':') {
    return std::nullopt;
  }
  const auto hours = parse_integer(text.substr(0, 2)), minutes = parse_integer(text.substr(3, 2));
  const auto seconds = parse_seconds_as_ns(text.substr(6));
  if (!hours || !minutes || !seconds || *hours < 0 || *hours > 23 || *minutes < 0 || *minutes > 59 ||
      *seconds < 0 || *seconds >= 61'000'000'000) {
    return std::nullopt;
  }
  return (*hours * 60 + *minutes) * 60'000'000'000 + *seconds;
}

/// A sensor's timestamps.txt: "2011-09-26 13:02:25.964389445", taken for UTC.
std::vector<std::int64_t> read_timestamps(const fs::path& sensor) {
  TableReader table(sensor / "timestamps.txt", {.separator = ' ', .names = {"date", "time"}, .counts = {2}});
  std::vector<std::int64_t> times;
  while (table.next()) {
    const auto date = parse_date(table.field(0));
    const auto clock = parse_clock(table.field(1));
    if (!date || !clock) {
      table.fail("a time like 2011-09-26 13:02:25.964389445",
                 excerpt(fmt::format("{} {}", table.field(0), table.field(1))));
    }
    times.push_back(*date + *clock);
  }
  table.require_a_row("time");
  return times;
}

fs::path data_file(const fs::path& sensor, std::size_t index, const char* ending) {
  return sensor / "data" / fmt::format("{:010}{}", index, ending);
}

fs::path image_file(const fs::path& sensor, std::size_t index) {
  const fs::path jpg = data_file(sensor, index, ".jpg");
  return fs::exists(jpg) ? jpg : data_file(sensor, index, ".png");
}

struct RawDrive {
  fs::path folder, calibration;  ///< of calib_cam_to_cam.txt and the others
  bool colour;
  ImageKind images;

  [[nodiscard]] fs::path cameras() const { return calibration / kCameras; }
  [[nodiscard]] fs::path camera(int side) const {
    return folder / fmt::format("image_{:02}", (colour ? 2 : 0) + side);
  }
};

fs::path calibration_folder(const fs::path& folder) {
  const fs::path above = fs::canonical(folder).parent_path();
  for (const fs::path& place : {folder, above}) {
    if (fs::exists(place / kCameras)) {
      return place;
    }
  }
  throw DataError(
      (above / kCameras).string(), 0,
      "the calibration of the day, in the drive's folder or above it (KITTI's archive DATE_calib.zip)",
      "no such file");
}

void read_pairs(const RawDrive& drive, Recording& recording) {
  const auto left = read_timestamps(drive.camera(0)), right = read_timestamps(drive.camera(1));
  const std::string place = (drive.camera(1) / "timestamps.txt").string();
  std::vector<DataError> missing;
  if (left.size() != right.size()) {
    throw DataError(place, 0, fmt::format("{} times, as on the left", left.size()),
                    fmt::format("{}", right.size()));
  }
  for (std::size_t k = 0; k < left.size(); ++k) {
    const std::int64_t interval = k > 0 ? left[k] - left[k - 1] : left.size() > 1 ? left[1] - left[0] : 1;
    if (interval <= 0) {
      throw DataError((drive.camera(0) / "timestamps.txt").string(), k + 1, "a later time than before it",
                      "an earlier one, or the same");
    }
    if (static_cast<double>(std::abs(right[k] - left[k])) > kFarthest * static_cast<double>(interval)) {
      throw DataError(place, k + 1, "a time near that of the left image",
                      fmt::format("one {:.3f} s away", seconds_between(left[k], right[k])));
    }
    const ImagePair pair{left[k], image_file(drive.camera(0), k), image_file(drive.camera(1), k)};
    if (const bool has_left = is_image_file(pair.cam0); !has_left || !is_image_file(pair.cam1)) {
      missing.emplace_back((has_left ? pair.cam1 : pair.cam0).string(), 0,
                           "an image for each time in timestamps.txt", "no such file");
    }
    recording.images.push_back(pair);
  }
  require_most_images(recording, missing);
}

/// Rectified images have another size than raw ones, and the calibration has both.
ImageKind image_kind_of(const RawDrive& drive, const UsualImage& image) {
  const ImageSize& size = image.size;
  std::string known;
  for (const ImageKind kind : {ImageKind::kRectified, ImageKind::kRaw}) {
    const auto [width, height] = kitti_raw_size(drive.cameras(), kind, drive.colour);
    if (width == size.width && height == size.height) {
      return kind;
    }
    known += fmt::format("{}{} x {} ({})", known.empty() ? "" : " or ", width, height, to_string(kind));
  }
  throw DataError(image.file.string(), 0, "an image of " + known + " pixels",
                  fmt::format("{} x {}", size.width, size.height));
}

void read_cameras(RawDrive& drive, Recording& recording) {
  drive.images = image_kind_of(drive, usual_image(recording, 0));
  const RigFile rig = read_kitti_raw_rig(drive.cameras(), drive.images, drive.colour);
  recording.calibration = rig.calibration;
  recording.notes = rig.notes;
  recording.notes.push_back(fmt::format("the images are {}, by their size of {} x {} pixels",
                                        to_string(drive.images), rig.calibration.cam0.width,
                                        rig.calibration.cam0.height));
}

/// What OXTS's inertial navigation system says: place by its Kalman filter with GPS, and inertial samples.
struct Oxts {
  std::vector<GroundTruthState> poses;  ///< of the IMU; x east, y north, z up from the first one
  std::vector<ImuSample> samples;
};

/// Mercator's projection, as KITTI's own tools take it.
Eigen::Vector3d mercator(double latitude, double longitude, double altitude, double scale) {
  constexpr double kEarth = 6'378'137.0;  // radius [m]
  constexpr double kDegree = std::numbers::pi / 180.0;
  return {scale * kEarth * longitude * kDegree,
          scale * kEarth * std::log(std::tan(0.5 * (90.0 + latitude) * kDegree)), altitude};
}

Oxts read_oxts(const fs::path& sensor, std::vector<std::string>& notes) {
  constexpr std::size_t kColumns = 30;
  constexpr double kLargestForceAndRate = 1e5;
  Oxts out;
  const auto times = read_timestamps(sensor);
  std::optional<double> scale;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  std::size_t disordered = 0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    TableReader table(data_file(sensor, k, ".txt"),
                      {.separator = ' ', .names = {"latitude, ..., orimode"}, .counts = {kColumns}});
    if (!table.next()) {
      table.require_a_row("sample");
    }
    if (!out.samples.empty() && times[k] <= out.samples.back().t_ns) {
      ++disordered;
      continue;
    }
    const double latitude = table.number(0, 89.0), longitude = table.number(1, 360.0);
    if (!scale) {
      scale = std::cos(latitude * std::numbers::pi / 180.0);
      origin = mercator(latitude, longitude, table.number(2, 1e5), *scale);
    }
    GroundTruthState& state = out.poses.emplace_back();
    state.t_ns = times[k];
    state.p_world_body = mercator(latitude, longitude, table.number(2, 1e5), *scale) - origin;
    state.R_world_body = rotation_from_euler_zyx(table.vector3(3, 10.0));  // roll, pitch, yaw [rad]
    out.samples.push_back(
        {times[k], table.vector3(17, kLargestForceAndRate), table.vector3(11, kLargestForceAndRate)});
  }
  if (disordered > 0) {
    notes.push_back(fmt::format("oxts: {} of {} samples are not later than those before and left out",
                                disordered, times.size()));
  }
  return out;
}

bool is_fast(const std::vector<ImuSample>& samples) {
  return samples.size() > 1 && samples.back().t_ns - samples.front().t_ns <=
                                   kSlowestImu * static_cast<std::int64_t>(samples.size() - 1);
}

void read_oxts_into(const RawDrive& drive, Recording& recording) {
  for (const char* name : {"calib_imu_to_velo.txt", "calib_velo_to_cam.txt"}) {
    if (!fs::exists(drive.calibration / name)) {
      recording.notes.push_back(fmt::format("oxts is not used: without {} nothing says where it sits", name));
      return;
    }
  }
  Oxts oxts = read_oxts(drive.folder / "oxts", recording.notes);
  const Pose T_imu_cam0 = kitti_camera_on_imu(drive.calibration, drive.images, drive.colour);
  if (is_fast(oxts.samples)) {
    recording.calibration.body = BodyFrame::kImu;
    recording.calibration.T_body_cam0 = T_imu_cam0;
    recording.imu = std::move(oxts.samples);
    recording.truth.motion.states = std::move(oxts.poses);
  } else {
    recording.notes.emplace_back(
        "oxts: its inertial samples come at less than 50 Hz, which is too slow for an IMU: they are not used "
        "(the oxts folder of DATE_drive_NUMBER_extract has 100 Hz, and may stand in the place of this one)");
    for (GroundTruthState& state : oxts.poses) {
      state.p_world_body += state.R_world_body * T_imu_cam0.p;
      state.R_world_body = so3_normalized(state.R_world_body * T_imu_cam0.R);
      recording.truth.motion.states.push_back(state);
    }
  }
  recording.notes.emplace_back(
      "the truth is that of oxts (GPS and inertial), good to some centimetres at best");
}

}  // namespace

Recording read_kitti_raw(const fs::path& folder) {
  Recording recording;
  RawDrive drive{folder, calibration_folder(folder), !fs::exists(folder / "image_00"), ImageKind::kRectified};
  read_pairs(drive, recording);
  read_cameras(drive, recording);
  if (fs::exists(folder / "oxts" / "timestamps.txt")) {
    read_oxts_into(drive, recording);
  }
  return recording;
}

}  // namespace limber::detail
