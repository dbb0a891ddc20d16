// SPDX-License-Identifier: MIT
// Whole runs against real time: the paper's scenario, simulated, and a recorded flight.
#include <benchmark/benchmark.h>

#include <filesystem>
#include <numeric>
#include <optional>
#include <string>

#include "data_folder.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/simulator.hpp"

namespace {

namespace fs = std::filesystem;

/// Runs the method over the whole recording in each iteration and reports how much faster than the recording
/// that was, and how many states the filter carried.
void run_over(benchmark::State& state, const limber::Recording& recording,
              const limber::RunOptions& options) {
  double filter_s = 0.0, points = 0.0;
  std::size_t frames = 0;
  for (auto _ : state) {
    const limber::RunRecord record =
        limber::run_recording(recording, options, limber::matched_frames(recording));
    filter_s += 1e-3 * std::accumulate(record.frame_ms.begin(), record.frame_ms.end(), 0.0);
    frames = record.frames.size();
    points = std::accumulate(
        record.frames.begin(), record.frames.end(), 0.0,
        [](double sum, const limber::FrameReport& f) { return sum + static_cast<double>(f.used); });
  }
  const double duration_s =
      1e-9 * static_cast<double>(recording.frames.back().t_ns - recording.frames.front().t_ns);
  const double runs = static_cast<double>(state.iterations());
  state.counters["frames"] = static_cast<double>(frames);
  state.counters["points_per_frame"] = points / static_cast<double>(frames);
  state.counters["filter_ms_per_frame"] = 1e3 * filter_s / runs / static_cast<double>(frames);
  state.counters["realtime_factor"] =
      benchmark::Counter(runs * duration_s, benchmark::Counter::kIsRate);  // over processor time
}

void paper_ii(benchmark::State& state, limber::Method method) {
  static const limber::Recording recording =
      limber::simulate(limber::read_scenario(fs::path(LIMBER_SOURCE_DIR) / "scenarios" / "paper_ii.yaml"), 1);
  limber::RunOptions options;
  options.method = method;
  options.start = limber::StartMode::kGroundTruth;
  options.gate = false;
  options.max_landmarks = 300;
  run_over(state, recording, options);
}

void euroc_imu_april(benchmark::State& state, limber::Method method) {
  const fs::path folder = data_folder() / "track_logs" / "euroc_imu_april";
  if (!fs::exists(folder)) {
    state.SkipWithError(("no recording at " + folder.string() + ": set LIMBER_DATA").c_str());
    return;
  }
  static const limber::Recording recording = limber::read_recording(folder);
  limber::RunOptions options;
  options.method = method;
  run_over(state, recording, options);
}

#define LIMBER_RUN_BENCHMARK(function, name, method) \
  BENCHMARK_CAPTURE(function, name, limber::Method::method)->Iterations(1)->Unit(benchmark::kSecond)

LIMBER_RUN_BENCHMARK(paper_ii, ekf, kEkf);
LIMBER_RUN_BENCHMARK(paper_ii, ekf_full, kEkfFull);
LIMBER_RUN_BENCHMARK(paper_ii, lcekf, kLcekf);
LIMBER_RUN_BENCHMARK(paper_ii, mono_left, kMonoLeft);
LIMBER_RUN_BENCHMARK(paper_ii, adaptive, kAdaptive);
LIMBER_RUN_BENCHMARK(euroc_imu_april, ekf, kEkf);
LIMBER_RUN_BENCHMARK(euroc_imu_april, ekf_full, kEkfFull);
LIMBER_RUN_BENCHMARK(euroc_imu_april, lcekf, kLcekf);
LIMBER_RUN_BENCHMARK(euroc_imu_april, adaptive, kAdaptive);

}  // namespace

BENCHMARK_MAIN();
