// SPDX-License-Identifier: MIT
// How fast a bag is read: a scan (stamps, IMU, poses), then every image of the proposed stereo pair.
//   bag_reading FILE [TURNS]     more than one: medians
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <vector>

#include "limber/bags/inspect.hpp"

namespace {

double cpu_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

struct Reading {
  double megabytes, wall_s, cpu_s;
};

/// Runs `work`, which says how many MB it has read, and takes its time.
Reading timed(const std::function<double()>& work) {
  const auto start = std::chrono::steady_clock::now();
  const double cpu = cpu_s();
  const double megabytes = work();
  return {megabytes, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
          cpu_s() - cpu};
}

/// The median by CPU time, and the slowest and the fastest.
void print(const char* name, std::vector<Reading> turns) {
  std::sort(turns.begin(), turns.end(), [](const auto& a, const auto& b) { return a.cpu_s < b.cpu_s; });
  const auto speed = [](const Reading& r) { return r.megabytes / r.cpu_s; };
  const Reading& median = turns[turns.size() / 2];
  fmt::print("{:<8} {:8.1f} MB  {:6.2f} s wall  {:6.2f} s CPU  {:7.0f} MB/s of CPU time ({:.0f} to {:.0f})\n",
             name, median.megabytes, median.wall_s, median.cpu_s, speed(median), speed(turns.back()),
             speed(turns.front()));
}

double images_in_mb(const limber::RecordingInfo& info) {
  double bytes = 0.0;
  for (std::size_t pair = 0; info.images && pair < info.stereo->pairs; ++pair) {
    for (const std::size_t camera : {0U, 1U}) {
      bytes += static_cast<double>(info.images->load(camera, pair).data.size());
    }
  }
  return bytes * 1e-6;
}

void read(const std::filesystem::path& path, int turns) {
  std::vector<Reading> scans, images;
  for (int turn = 0; turn < turns; ++turn) {
    limber::RecordingInfo info;
    scans.push_back(timed([&] {
      info = limber::inspect(path);
      return static_cast<double>(std::filesystem::file_size(path)) * 1e-6;
    }));
    images.push_back(timed([&] { return images_in_mb(info); }));
  }
  print("scan", scans);
  print("images", images);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  fmt::print("peak memory {:.0f} MB\n", static_cast<double>(usage.ru_maxrss) / 1024.0);
}

}  // namespace

int main(int argc, char** argv) {
  const int turns = argc == 3 ? std::atoi(argv[2]) : 1;
  if (argc < 2 || argc > 3 || turns < 1) {
    fmt::print(stderr, "bag_reading FILE [TURNS]\n");
    return 2;
  }
  try {
    read(argv[1], turns);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
