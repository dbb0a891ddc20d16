// SPDX-License-Identifier: MIT
// What the core says of inputs that no node should get: core_test. Exit code 1, and the line, if it is wrong.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "node_core.hpp"

namespace {

constexpr std::int64_t kFrame = 50'000'000, kStart = 1'600'000'000'000'000'000;

void expect(bool holds, const char* what) {
  if (!holds) {
    std::fprintf(stderr, "core_test: wrong: %s\n", what);
    std::exit(1);
  }
}

struct Heard final : limber_node::Output {
  void odometry(const limber_node::Odometry& odometry) override {
    ++poses;
    last = odometry;
  }
  void status(const limber_node::Status& status) override { states.push_back(status); }
  void note(const std::string&) override {}
  void warning(const std::string& text) override { warnings.push_back(text); }
  bool warned(const std::string& of) const {
    return !warnings.empty() && warnings.back().find(of) != std::string::npos;
  }
  std::size_t poses = 0;
  limber_node::Odometry last;
  std::vector<limber_node::Status> states;
  std::vector<std::string> warnings;
};

/// A Kalibr camchain that places its cameras on an IMU.
std::string write_camchain() {
  const auto path = std::filesystem::temp_directory_path() / "limber_core_test_camchain.yaml";
  std::ofstream file(path);
  for (const int camera : {0, 1}) {
    const char* x = camera == 0 ? "0" : "-0.1";
    file << "cam" << camera << ":\n  camera_model: pinhole\n  intrinsics: [100, 100, 80, 60]\n"
         << "  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [160, 120]\n"
         << "  T_cam_imu:\n  - [1, 0, 0, " << x
         << "]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n";
    if (camera == 1) {
      file << "  T_cn_cnm1:\n  - [1, 0, 0, -0.1]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n";
    }
  }
  return path.string();
}

limber_node::Image image(int width = 160) {
  return {"mono8", width,
          120,     static_cast<std::size_t>(width),
          false,   std::vector<std::uint8_t>(static_cast<std::size_t>(width) * 120, 100)};
}

std::string refused(const limber_node::Parameters& parameters) {
  Heard heard;
  try {
    const limber_node::Core core(parameters, heard);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

void test_parameters(const std::string& camchain) {
  limber_node::Parameters parameters;
  expect(refused(parameters).find("calib is missing") != std::string::npos, "no calibration is said so");
  parameters.calib = "/nowhere/camchain.yaml";
  expect(refused(parameters).find("/nowhere/camchain.yaml") != std::string::npos,
         "the missing file is named");
  parameters.calib = camchain;
  expect(refused(parameters).empty(), "a camchain is enough");
  parameters.method = "oracle";
  expect(!refused(parameters).empty(), "the oracle is refused");
  parameters.method = "lcekf";
  parameters.inputs = "wheels";
  expect(refused(parameters).find("imu, odometry, twist or twist_with_covariance") != std::string::npos,
         "inputs are of four kinds");
  for (const char* const inputs : {"odometry", "twist", "twist_with_covariance"}) {
    parameters.inputs = inputs;
    expect(refused(parameters).empty(), inputs);
  }
  parameters.images = "blue";
  expect(!refused(parameters).empty(), "images are raw or rectified");
}

void test_inputs(const std::string& camchain) {
  Heard heard;
  limber_node::Parameters parameters;
  parameters.calib = camchain;
  limber_node::Core core(parameters, heard);
  const auto imu_until = [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t t = from; t <= to; t += 5'000'000) {
      core.add_imu(t, {0, 0, 0}, {0, 0, 9.81});
    }
  };
  imu_until(kStart - 10'000'000, kStart + kFrame);
  core.add_imu(kStart, {0, 0, 0}, {0, 0, 9.81});
  expect(heard.warned("not later than the one before"), "a late sample is said");
  core.add_imu(kStart + 2 * kFrame, {std::nan(""), 0, 0}, {0, 0, 9.81});
  expect(heard.warned("not finite"), "a sample that is none is said");

  core.add_image(0, kStart, image());
  core.add_image(1, kStart + 1'000'000, image());
  expect(heard.states.size() == 1 && heard.states[0].level == 3,
         "the first frame starts, and says what is missing");
  core.add_image(0, kStart + kFrame, image());
  core.add_image(1, kStart + 2 * kFrame, image());
  expect(heard.warned("left image without a right one"), "a single image is said");
  core.add_image(0, kStart + 2 * kFrame, image());
  expect(heard.states.size() == 1, "the frame waits for the IMU");
  imu_until(kStart + kFrame + 5'000'000, kStart + 3 * kFrame);
  expect(heard.states.size() == 2, "and is processed when it has come");
  core.add_image(0, kStart + 3 * kFrame, image(80));
  core.add_image(1, kStart + 3 * kFrame, image());
  expect(heard.warned("left image: expected an image of"), "an image of another size is said");

  core.add_image(0, kStart - 100 * kFrame, image());
  expect(heard.warned("jumped back"), "a clock that jumps back is said");
  core.add_image(1, kStart - 100 * kFrame, image());
  imu_until(kStart - 101 * kFrame, kStart - 99 * kFrame);
  const std::size_t before = heard.states.size();
  core.add_image(0, kStart - 99 * kFrame, image());
  core.add_image(1, kStart - 99 * kFrame, image());
  expect(heard.states.size() == before + 1, "it starts anew");
  expect(heard.poses == 0, "and tells no pose of a grey wall");
}

void test_odometry(const std::string& camchain) {
  Heard heard;
  limber_node::Parameters parameters;
  parameters.calib = camchain;
  parameters.inputs = "odometry";
  limber_node::Core core(parameters, heard);
  core.add_imu(kStart, {std::nan(""), 0, 0}, {0, 0, 9.81});
  expect(heard.warnings.empty(), "an IMU that nobody asked for is not looked at");
  core.add_odometry(kStart, {0, std::nan(""), 0}, {0, 0, 0});
  expect(heard.warned("odometry sample that is not finite"), "a sample that is none is said");
  for (const std::int64_t t : {kStart - kFrame, kStart, kStart + kFrame}) {
    core.add_odometry(t, {1, 0, 0}, {0, 0, 0});
  }
  core.add_odometry(kStart, {1, 0, 0}, {0, 0, 0});
  expect(heard.warned("not later than the one before"), "a late sample is said");
  for (const std::int64_t t : {kStart, kStart + kFrame, kStart + 2 * kFrame}) {
    core.add_image(0, t, image());
    core.add_image(1, t, image());
  }
  expect(heard.poses == 2, "odometry starts with the first frame, and the last one waits for it");
  expect(std::abs(heard.last.position[0] - 1e-9 * kFrame) < 1e-3, "and moves the body");
}

}  // namespace

int main() {
  const std::string camchain = write_camchain();
  test_parameters(camchain);
  test_inputs(camchain);
  test_odometry(camchain);
  std::filesystem::remove(camchain);
  std::puts("core_test: passed");
  return 0;
}
