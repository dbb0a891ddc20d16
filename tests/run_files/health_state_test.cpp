// SPDX-License-Identifier: MIT
#include "limber/run_files/health_state.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "datasets/files.hpp"
#include "random_geometry.hpp"

namespace limber {
namespace {

using ::testing::HasSubstr;

HealthState some_state() {
  testing::Generator generator(3);
  HealthState out;
  out.recording = "monday";
  out.cameras = {camera_in_words({458.654, 457.296, 367.215, 248.375, 752, 480, NoDistortion{}}),
                 camera_in_words({1.0, 2.0, 3.0, 4.0, 5, 6, RadialTangential{0.1, -0.2, 1e-5, 2e-5}})};
  out.rig.theta << testing::random_vector(generator, 0.1), testing::random_vector(generator, 0.2);
  out.rig.from_ns = 1'403'636'579'763'555'584;
  out.rig.to_ns = out.rig.from_ns + 1;
  out.rig.windows = 7;
  out.rig.tracks = 70;
  out.rig.points = 700;
  out.rig.deep = 500;
  out.rig.deep_tracks = 50;
  out.rig.estimate.beta.setLinSpaced(-1.0 / 3.0, 2.0 / 3.0);
  out.rig.estimate.covariance = 0.1 * NormalEquations::Matrix::Identity();
  out.rig.estimate.covariance(0, 1) = out.rig.estimate.covariance(1, 0) = 0.01;
  out.rig.estimate.epipolar = 3.0 * NormalEquations::Matrix::Identity();
  return out;
}

class HealthStateFile : public ::testing::Test {
 protected:
  HealthStateFile() { write_health_state(path(), some_state()); }
  [[nodiscard]] std::filesystem::path path() const { return folder_.path() / kHealthStateName; }
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_.path(); }

  /// What is said of the file with a value replaced.
  [[nodiscard]] std::string refusal_of(const std::string& key, const nlohmann::json& value) const {
    auto json = nlohmann::json::parse(testing::read_text(path()));
    json[key] = value;
    testing::write_text(folder() / "bad.json", json.dump());
    return testing::data_error_of([&] { (void)read_health_state(folder() / "bad.json"); }).what();
  }

 private:
  testing::TemporaryFolder folder_;
};

TEST_F(HealthStateFile, ComesBackAsItWasWritten) {
  const HealthState wanted = some_state();
  for (const auto& where : {path(), folder()}) {
    const HealthState read = read_health_state(where);
    EXPECT_EQ(read.recording, wanted.recording);
    EXPECT_EQ(read.cameras, wanted.cameras);
    EXPECT_EQ(read.rig.theta, wanted.rig.theta);
    EXPECT_EQ(read.rig.metric, wanted.rig.metric);
    EXPECT_EQ(read.rig.from_ns, wanted.rig.from_ns);
    EXPECT_EQ(read.rig.to_ns, wanted.rig.to_ns);
    EXPECT_EQ(read.rig.windows, wanted.rig.windows);
    EXPECT_EQ(read.rig.tracks, wanted.rig.tracks);
    EXPECT_EQ(read.rig.points, wanted.rig.points);
    EXPECT_EQ(read.rig.deep, wanted.rig.deep);
    EXPECT_EQ(read.rig.deep_tracks, wanted.rig.deep_tracks);
    EXPECT_EQ(read.rig.estimate.beta, wanted.rig.estimate.beta);
    EXPECT_EQ(read.rig.estimate.covariance, wanted.rig.estimate.covariance);
    EXPECT_EQ(read.rig.estimate.epipolar, wanted.rig.estimate.epipolar);
  }
}

/// Files of older versions do not say how many tracks had a depth.
TEST_F(HealthStateFile, OfAnOlderVersionIsRead) {
  nlohmann::json json = nlohmann::json::parse(to_json(some_state()));
  json.erase("tracks_with_depth");
  EXPECT_EQ(parse_health_state(json.dump(), "old").rig.deep_tracks, some_state().rig.tracks);
}

TEST_F(HealthStateFile, IsRefusedWithWhatWasExpected) {
  EXPECT_THAT(refusal_of("theta", {1.0, 2.0}), HasSubstr("6 numbers at 'theta', found 2"));
  EXPECT_THAT(refusal_of("beta", "all"), HasSubstr("7 numbers at 'beta'"));
  EXPECT_THAT(refusal_of("windows", -1), HasSubstr("a whole number from 0 at 'windows', found -1"));
  EXPECT_THAT(refusal_of("metric", 1), HasSubstr("true or false at 'metric'"));
  EXPECT_THAT(refusal_of("cameras", {"one"}), HasSubstr("text at 'cameras'"));
  EXPECT_THAT(refusal_of("limber_health_state", 2), HasSubstr("expected limber_health_state 1"));
  auto negative = nlohmann::json::array();
  for (int k = 0; k < 49; ++k) {
    negative.push_back(k == 0 ? -1.0 : 0.0);
  }
  EXPECT_THAT(refusal_of("covariance", negative), HasSubstr("no negative diagonal at 'covariance'"));
  testing::write_text(folder() / "other.json", "{}");
  EXPECT_THAT(testing::data_error_of([&] { (void)read_health_state(folder() / "other.json"); }).what(),
              HasSubstr("a health_state.json that limber health wrote"));
  testing::write_text(folder() / "no.json", "{");
  EXPECT_THROW((void)read_health_state(folder() / "no.json"), DataError);
  EXPECT_THROW((void)read_health_state(folder() / "none.json"), DataError);
}

TEST(CameraInWords, TellsCamerasApart) {
  const Camera camera{458.654, 457.296, 367.215, 248.375, 752, 480, Equidistant{0.1, 0.0, 0.0, 0.0}};
  Camera other = camera;
  EXPECT_EQ(camera_in_words(camera), camera_in_words(other));
  other.distortion = RadialTangential{0.1, 0.0, 0.0, 0.0};
  EXPECT_NE(camera_in_words(camera), camera_in_words(other));
  other = camera;
  other.fu += 1e-9;
  EXPECT_NE(camera_in_words(camera), camera_in_words(other));
}

}  // namespace
}  // namespace limber
