// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <unordered_map>

#include "formats.hpp"
#include "io/text_file.hpp"
#include "io/times_of.hpp"
#include "limber/core/errors.hpp"
#include "rig_files/sensor_yaml.hpp"

namespace limber::detail {
namespace {

namespace fs = std::filesystem;

constexpr double kLargestInImages = 10.0;  // a pixel this many images away is none
constexpr double kEdge = 2.0;              // [px]: trackers follow points beyond the last pixel

/// Collects the rows of tracks0/data.csv into frames.
class FrameCollector {
 public:
  FrameCollector(TableReader& table, const StereoCalibration& calibration)
      : table_(table), calibration_(calibration) {}

  void add_row() {
    const std::int64_t t_ns = table_.integer(0);
    const bool no_points = is_empty(1) && is_empty(2) && is_empty(3) && is_empty(4) && is_empty(5);
    if (frames_.empty() || t_ns != frames_.back().t_ns || no_points || last_had_no_points_) {
      table_.require_later(t_ns);
      frames_.push_back({t_ns, {}});
    }
    last_had_no_points_ = no_points;
    if (!no_points) {
      add_point(frames_.back());
    }
  }

  [[nodiscard]] std::vector<StereoFrame> frames() && { return std::move(frames_); }

  /// Where more than a hundredth of a camera's pixels lie outside of its images.
  void note_outside(std::vector<std::string>& notes) const {
    for (std::size_t cam = 0; cam < 2; ++cam) {
      const Count& count = counts_[cam];
      if (100 * count.outside > count.all) {
        const Camera& camera = cam == 0 ? calibration_.cam0 : calibration_.cam1;
        notes.push_back(
            fmt::format("tracks0/data.csv: {} of {} pixels of cam{} lie outside of its {} x {} images, the "
                        "first in line {}: is the resolution right?",
                        count.outside, count.all, cam, camera.width, camera.height, count.first_line));
      }
    }
  }

 private:
  [[nodiscard]] bool is_empty(std::size_t column) const { return table_.field(column).empty(); }

  Eigen::Vector2d pixel(std::size_t cam) {
    const Camera& camera = cam == 0 ? calibration_.cam0 : calibration_.cam1;
    const std::size_t column = 2 + 2 * cam;
    const Eigen::Vector2d uv(table_.number(column, kLargestInImages * camera.width),
                             table_.number(column + 1, kLargestInImages * camera.height));
    Count& count = counts_[cam];
    ++count.all;
    if (uv.minCoeff() < -kEdge || uv.x() > camera.width - 1 + kEdge || uv.y() > camera.height - 1 + kEdge) {
      count.first_line = count.outside == 0 ? table_.line() : count.first_line;
      ++count.outside;
    }
    return uv;
  }

  void add_point(StereoFrame& frame) {
    StereoObservation point;
    point.track_id = table_.integer(1);
    point.in_cam0 = !is_empty(2) || !is_empty(3);
    point.in_cam1 = !is_empty(4) || !is_empty(5);
    if (!point.in_cam0 && !point.in_cam1) {
      table_.fail("pixels in at least one camera", "none");
    }
    if (point.in_cam0) {
      point.uv_cam0 = pixel(0);
    }
    if (point.in_cam1) {
      point.uv_cam1 = pixel(1);
    }
    const auto [last_seen, is_new] = last_frame_.try_emplace(point.track_id, frame.t_ns);
    if (!is_new && std::exchange(last_seen->second, frame.t_ns) == frame.t_ns) {
      table_.fail("every track_id once in a frame", fmt::format("{} again", point.track_id));
    }
    frame.observations.push_back(point);
  }

  struct Count {
    std::size_t all = 0, outside = 0, first_line = 0;
  };

  TableReader& table_;
  const StereoCalibration& calibration_;
  std::array<Count, 2> counts_;  // of pixels
  std::vector<StereoFrame> frames_;
  std::unordered_map<std::int64_t, std::int64_t> last_frame_;  // track_id -> time of its last frame [ns]
  bool last_had_no_points_ = false;
};

void read_pixel_noise(const fs::path& path, Recording& recording) {
  if (fs::exists(path)) {
    const SensorYaml yaml(path);
    if (yaml.has("sigma_px")) {
      const auto sigma = yaml.numbers("sigma_px", 4);
      if (*std::min_element(sigma.begin(), sigma.end()) <= 0.0) {
        yaml.fail("sigma_px", "sigma_px above zero", fmt::format("[{}]", fmt::join(sigma, ", ")));
      }
      recording.pixel_noise = PixelNoise(sigma[0], sigma[1], sigma[2], sigma[3]);
      return;
    }
  }
  recording.notes.emplace_back("tracks0/sensor.yaml does not give sigma_px");
}

}  // namespace

Recording read_track_log(const fs::path& mav0) {
  Recording recording = read_euroc_common(mav0);
  StereoCalibration& calibration = recording.calibration;
  if (recording.imu.empty() && recording.odometry.empty() && calibration.T_body_cam0.R.isIdentity(0.0) &&
      calibration.T_body_cam0.p.isZero(0.0)) {
    calibration.body = BodyFrame::kCam0;
  }
  const fs::path path = mav0 / "tracks0" / "data.csv";
  TableReader table(
      path,
      {.names = {"timestamp [ns]", "track_id", "u0 [px]", "v0 [px]", "u1 [px]", "v1 [px]"}, .counts = {6}});
  FrameCollector collector(table, calibration);
  while (table.next()) {
    collector.add_row();
  }
  table.require_a_row("frame");
  collector.note_outside(recording.notes);
  recording.frames = std::move(collector).frames();
  require_nanoseconds(times_of(recording.frames), kShortestFrame_ns, path);
  note_if_cut_off(path, recording.notes);
  read_pixel_noise(mav0 / "tracks0" / "sensor.yaml", recording);
  if (fs::exists(mav0 / "cam0" / "data.csv")) {
    recording.notes.emplace_back("the images are not used: tracks0 holds matched points");
  }
  return recording;
}

}  // namespace limber::detail
