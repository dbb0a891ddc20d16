// SPDX-License-Identifier: MIT
// The image front end on real stereo pairs: time on one core beside what it found.
#include <benchmark/benchmark.h>

#include <filesystem>
#include <map>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <vector>

#include "data_folder.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/frontend/stereo_tracker.hpp"

namespace {

struct LoadedPair {
  std::int64_t t_ns;
  cv::Mat left, right;
};

/// A recording with its images in memory.
struct LoadedRecording {
  limber::StereoCalibration calibration;
  std::vector<LoadedPair> pairs;
};

std::optional<LoadedRecording> load(const std::string& name) {
  const std::filesystem::path folder = data_folder() / name;
  if (!std::filesystem::exists(folder)) return std::nullopt;
  const limber::Recording recording = limber::read_recording(folder);
  LoadedRecording loaded{recording.calibration, {}};
  for (const limber::ImagePair& pair : recording.images) {
    loaded.pairs.push_back({pair.t_ns, cv::imread(pair.cam0.string(), cv::IMREAD_GRAYSCALE),
                            cv::imread(pair.cam1.string(), cv::IMREAD_GRAYSCALE)});
  }
  return loaded;
}

limber::GreyImage view(const cv::Mat& image) {
  return {image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step[0]), image.data};
}

/// Tracks the whole recording in each iteration, from images in memory.
void track(benchmark::State& state, const std::string& name) {
  const auto recording = load(name);
  if (!recording) {
    state.SkipWithError(("no " + name + " in " + data_folder().string()).c_str());
    return;
  }
  cv::setNumThreads(1);
  double points = 0.0, matches = 0.0;
  std::map<std::int64_t, int> tracks;
  for (auto _ : state) {
    points = matches = 0.0;
    tracks.clear();
    limber::StereoTracker tracker(recording->calibration);
    for (const LoadedPair& pair : recording->pairs) {
      for (const limber::StereoObservation& point :
           tracker.process(pair.t_ns, view(pair.left), view(pair.right)).observations) {
        ++points;
        matches += point.in_cam1 ? 1.0 : 0.0;
        ++tracks[point.track_id];
      }
    }
  }
  const auto pairs = static_cast<double>(recording->pairs.size());
  state.counters["pairs"] = pairs;
  state.counters["s_per_pair"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * pairs,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);  // of processor time
  state.counters["points"] = points / pairs;
  state.counters["right_matches"] = matches / pairs;
  state.counters["frames_per_track"] = points / static_cast<double>(tracks.size());
}

BENCHMARK_CAPTURE(track, euroc_mh01_a, "euroc_mh01_a")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(track, kitti_06_first51, "kitti_06_first51")->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
