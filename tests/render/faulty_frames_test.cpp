// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>
#include <sstream>

#include "datasets/files.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/render/render_recording.hpp"
#include "render/small_drone.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

/// Pictures the size of a stamp: of frames there are many.
Scenario stamps() {
  Scenario scenario = testing::small_drone(10.0);
  scenario.rig.cam0 = {24.0, 24.0, 20.0, 15.0, 40, 30, NoDistortion{}};
  scenario.rig.cam1 = {24.0, 24.0, 20.0, 15.0, 40, 30, NoDistortion{}};
  return scenario;
}

std::string picture(const fs::path& recording, const std::string& camera, const std::string& t_ns) {
  const std::string name = std::string(19 - t_ns.size(), '0') + t_ns + ".png";
  std::ifstream stream(recording / "mav0" / camera / "data" / name, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// What the truth says that both cameras show, by time; frames that are sound are not in it.
std::map<std::string, std::array<std::string, 2>> faults_of(const fs::path& recording) {
  std::map<std::string, std::array<std::string, 2>> faults;
  std::ifstream table(recording / "mav0" / "scene0" / "faulty_frames.csv");
  std::string line, t_ns, left, right;
  std::getline(table, line);
  while (std::getline(table, t_ns, ',') && std::getline(table, left, ',') && std::getline(table, right)) {
    faults[t_ns] = {left, right};
  }
  return faults;
}

TEST(FaultyFrames, AreThoseOfTheTruthAndAsManyAsAsked) {
  const testing::TemporaryFolder scratch;
  const fs::path sound = scratch.path() / "sound", faulty = scratch.path() / "faulty";
  ASSERT_EQ(render_recording(stamps(), 7, 0, {}, sound), 201u);
  ASSERT_EQ(render_recording(stamps(), 7, 0, {.dropped = 0.3, .swapped = 0.2}, faulty), 201u);
  const auto faults = faults_of(faulty);
  int dropped = 0, swapped = 0;
  for (const ImagePair& pair : read_recording(sound).images) {
    const std::string t_ns = std::to_string(pair.t_ns);
    const auto fault = faults.find(t_ns);
    const std::map<std::string, std::string> pictures = {
        {"nothing", ""}, {"left", picture(sound, "cam0", t_ns)}, {"right", picture(sound, "cam1", t_ns)}};
    const auto [left, right] =
        fault == faults.end() ? std::array<std::string, 2>{"left", "right"} : fault->second;
    EXPECT_TRUE(picture(faulty, "cam0", t_ns) == pictures.at(left)) << t_ns;
    EXPECT_TRUE(picture(faulty, "cam1", t_ns) == pictures.at(right)) << t_ns;
    EXPECT_FALSE(left == "nothing" && right == "nothing") << t_ns;
    dropped += left == "nothing" || right == "nothing";
    swapped += left == "right" || right == "left";
  }
  EXPECT_NEAR(dropped, 60, 20);  // three sigma
  EXPECT_NEAR(swapped, 40, 17);
  const Recording read = read_recording(faulty);
  EXPECT_EQ(read.images.size(), 201u - static_cast<std::size_t>(dropped));
  ASSERT_FALSE(read.notes.empty());
  EXPECT_NE(read.notes.back().find("no partner"), std::string::npos) << read.notes.back();
}

TEST(FaultyFrames, LeaveTheFirstPairWhole) {
  const testing::TemporaryFolder scratch;
  Scenario scenario = stamps();
  scenario.duration = 0.2;
  render_recording(scenario, 7, 0, {.dropped = 1.0}, scratch.path());
  EXPECT_EQ(read_recording(scratch.path()).images.size(), 1u);
}

}  // namespace
}  // namespace limber
