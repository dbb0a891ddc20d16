// SPDX-License-Identifier: MIT
#include "limber/render/render_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <future>
#include <stdexcept>

#include "io/times_of.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/random.hpp"
#include "limber/core/so3.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/images/picture.hpp"
#include "limber/io/atomic_file.hpp"
#include "render/truth_files.hpp"
#include "simulate/faults.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using detail::FramePictures, detail::times_of;

constexpr int kFewestInstants = 8, kMostInstants = 64;  ///< of an exposure
constexpr double kInstantPx = 0.7;    ///< that things in the picture go by between two instants in a turn
constexpr double kSwingPeriod = 7.0;  ///< [s] of the exposure of both cameras

/// A scenario in front of the lens.
class Studio {
 public:
  Studio(const Scenario& scenario, std::uint64_t seed, std::uint64_t run, const PictureOptions& options)
      : options_(options),
        truth_(scenario, options, seed, run),
        cameras_{PictureCamera(truth_.nominal().cam0), PictureCamera(truth_.nominal().cam1)} {}

  [[nodiscard]] const Scene& scene() const { return truth_.scene(); }
  [[nodiscard]] const Camera& lens(std::size_t camera) const {
    return camera == 0 ? truth_.nominal().cam0 : truth_.nominal().cam1;
  }

  /// Grey values of one camera in frame n.
  [[nodiscard]] std::vector<std::uint8_t> picture(std::size_t camera, std::int64_t t_ns,
                                                  std::size_t n) const {
    std::vector<float> light;
    const int steps = instants(camera, t_ns);
    for (int k = 0; k < steps; ++k) {
      const auto part = instant(camera, t_ns, options_.exposure * ((k + 0.5) / steps - 0.5));
      light.resize(part.size());
      for (std::size_t i = 0; i < part.size(); ++i) light[i] += part[i] / static_cast<float>(steps);
    }
    const double swing = std::sin(2.0 * M_PI * 1e-9 * static_cast<double>(t_ns) / kSwingPeriod);
    const double darker = camera == 1 ? options_.gain_difference : 0.0;
    const SensorEffects effects{options_.noise, 1.0 - darker + 0.5 * options_.gain_difference * swing,
                                options_.vignetting};
    return develop(light, lens(camera), effects, 2 * n + camera);
  }

 private:
  /// Enough that blur is none of copies side by side, to which patches would lock.
  [[nodiscard]] int instants(std::size_t camera, std::int64_t t_ns) const {
    if (!(options_.exposure > 0.0)) return 1;
    const double middle = truth_.time_of_row(camera, t_ns, 0.5 * lens(camera).height);
    const Pose from = truth_.view(camera, middle - 0.5 * options_.exposure).T_world_cam,
               to = truth_.view(camera, middle + 0.5 * options_.exposure).T_world_cam;
    const double px = lens(camera).fu * so3_log(from.R.transpose() * to.R).norm();
    return std::clamp(static_cast<int>(std::ceil(px / kInstantPx)), kFewestInstants, kMostInstants);
  }

  /// The light at one instant of every row's exposure.
  [[nodiscard]] std::vector<float> instant(std::size_t camera, std::int64_t t_ns, double shift) const {
    const auto view_of = [&](std::size_t row) {
      return truth_.view(camera, truth_.time_of_row(camera, t_ns, static_cast<double>(row)) + shift);
    };
    return options_.rolling_shutter > 0.0 ? cameras_[camera].light(scene(), view_of)
                                          : cameras_[camera].light(scene(), view_of(0));
  }

  const PictureOptions& options_;
  PictureTruth truth_;
  std::array<PictureCamera, 2> cameras_;
};

void write_png(const fs::path& file, const Camera& camera, const std::vector<std::uint8_t>& pixels) {
  const auto width = static_cast<std::size_t>(camera.width);
  const auto bytes = encode_png({camera.width, camera.height, 1, 8, width, pixels.data()});
  write_staged_file(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

std::vector<FramePictures> draw_faults(std::size_t frames, const PictureOptions& options, std::uint64_t seed,
                                       std::uint64_t run) {
  const RandomStream dropped(seed, run, "dropped pictures"), swapped(seed, run, "swapped pictures");
  std::vector<FramePictures> drawn(frames);
  for (std::size_t n = 0; n < frames; ++n) {
    drawn[n].swapped = swapped.uniform(n) < options.swapped;
    if (n == 0 || dropped.uniform(n) >= options.dropped) continue;
    drawn[n].has[dropped.uniform(n, 1) < 0.5 ? 0 : 1] = false;
  }
  return drawn;
}

/// The exposure that a frame shows: its own, but where faults repeat frames or delay the right camera.
struct Exposure {
  std::array<std::int64_t, 2> t_ns = {};  ///< of the left camera, of the right one
  std::size_t number = 0;                 ///< of the frame that it was taken for; its noise goes with it
};

/// Of each frame of the recording.
std::vector<Exposure> exposures_of(const Scenario& scenario, std::uint64_t seed, std::uint64_t run) {
  Scenario sound = scenario;
  sound.faults.clear();
  std::vector<StereoFrame> frames = simulate(sound, seed, run).frames;
  for (StereoFrame& frame : frames) {
    frame.observations = {{.track_id = frame.t_ns}};  // goes where the frame's pixels would
  }
  detail::spoil_frames(scenario.faults, frames);
  std::vector<Exposure> out;
  for (const StereoFrame& frame : frames) {
    const std::int64_t t_ns = frame.observations.front().track_id;
    const bool repeated = !out.empty() && out.back().t_ns[0] == t_ns;
    out.push_back({{t_ns, t_ns - detail::right_delay(scenario.faults, t_ns)},
                   repeated ? out.back().number : out.size()});
  }
  return out;
}

/// Writes pictures of both cameras at once.
class PictureWriter {
 public:
  PictureWriter(const Studio& studio, const fs::path& mav0) : studio_(studio), mav0_(mav0) {
    for (const char* camera : kNames) fs::create_directories(mav0 / camera / "data");
  }

  void write(std::int64_t t_ns, const Exposure& exposure, const FramePictures& pictures) {
    auto right = std::async(std::launch::async, [&] { write(1, t_ns, exposure, pictures); });
    write(0, t_ns, exposure, pictures);
    right.get();
  }

  void write_lists() const {
    for (std::size_t camera : {0, 1}) {
      write_staged_file(mav0_ / kNames[camera] / "data.csv", "#timestamp [ns],filename\n" + lists_[camera]);
    }
  }

 private:
  static constexpr std::array<const char*, 2> kNames = {"cam0", "cam1"};

  void write(std::size_t camera, std::int64_t t_ns, const Exposure& exposure, const FramePictures& pictures) {
    if (!pictures.has[camera]) return;
    const std::size_t shown = pictures.swapped ? 1 - camera : camera;
    const std::string name = fmt::format("{:019}.png", t_ns);
    write_png(mav0_ / kNames[camera] / "data" / name, studio_.lens(shown),
              studio_.picture(shown, exposure.t_ns[shown], exposure.number));
    lists_[camera] += fmt::format("{},{}\n", t_ns, name);
  }

  const Studio& studio_;
  fs::path mav0_;
  std::array<std::string, 2> lists_;
};

}  // namespace

std::size_t render_recording(const Scenario& scenario, std::uint64_t seed, std::uint64_t run,
                             const PictureOptions& options, const fs::path& folder,
                             const std::function<void(std::size_t)>& progress,
                             const std::function<bool()>& stop) {
  const Studio studio(scenario, seed, run, options);
  Recording recording = simulate(scenario, seed, run);
  recording.pixel_noise.reset();
  recording.truth.landmarks.clear();
  if (options.tell_readout) recording.calibration.readout_time_s.fill(options.rolling_shutter);
  write_track_log(recording, folder);
  const fs::path mav0 = folder / "mav0";
  fs::remove_all(mav0 / "tracks0");
  detail::write_scene(studio.scene(), times_of(recording.truth.motion.states), mav0 / "scene0");
  const std::vector<std::int64_t> times = times_of(recording.frames);
  const std::vector<FramePictures> pictures = draw_faults(times.size(), options, seed, run);
  const std::vector<Exposure> exposures = exposures_of(scenario, seed, run);
  if (options.dropped > 0.0 || options.swapped > 0.0) {
    detail::write_faulty_frames(times, pictures, mav0 / "scene0" / "faulty_frames.csv");
  }
  PictureWriter writer(studio, mav0);
  for (std::size_t n = 0; n < times.size(); ++n) {
    if (stop && stop()) throw std::runtime_error("stopped: nothing is written");
    writer.write(times[n], exposures[n], pictures[n]);
    if (progress) progress(n + 1);
  }
  writer.write_lists();
  return times.size();
}

}  // namespace limber
