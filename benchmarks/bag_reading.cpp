// SPDX-License-Identifier: MIT
// How fast a bag is read: a scan (stamps, IMU, poses), then every image of the proposed stereo pair.
//   bag_reading FILE
#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <exception>
#include <filesystem>
#include <functional>

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

/// Runs `work` and prints what it read, in how much time.
void measure(const char* name, const std::function<double()>& work) {
  const auto start = std::chrono::steady_clock::now();
  const double cpu = cpu_s();
  const double megabytes = work();
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double used = cpu_s() - cpu;
  fmt::print("{:<8} {:8.1f} MB  {:6.2f} s wall  {:6.2f} s CPU  {:7.0f} MB/s of CPU time\n", name, megabytes,
             wall, used, megabytes / used);
}

void read(const std::filesystem::path& path) {
  limber::RecordingInfo info;
  measure("scan", [&] {
    info = limber::inspect(path);
    return static_cast<double>(std::filesystem::file_size(path)) * 1e-6;
  });
  measure("images", [&] {
    double bytes = 0.0;
    for (std::size_t pair = 0; info.images && pair < info.stereo->pairs; ++pair) {
      for (const std::size_t camera : {0U, 1U}) {
        bytes += static_cast<double>(info.images->load(camera, pair).data.size());
      }
    }
    return bytes * 1e-6;
  });
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  fmt::print("peak memory {:.0f} MB\n", static_cast<double>(usage.ru_maxrss) / 1024.0);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "bag_reading FILE\n");
    return 2;
  }
  try {
    read(argv[1]);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
