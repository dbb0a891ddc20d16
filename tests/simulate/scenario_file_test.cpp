// SPDX-License-Identifier: MIT
#include "limber/simulate/scenario_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "limber/core/errors.hpp"
#include "message_of.hpp"
#include "source_folder.hpp"

namespace limber {
namespace {

using detail::kDegree;
using Eigen::Vector3d;

Scenario parse(const std::string& text) { return parse_scenario(text, "folder/case.yaml"); }

std::filesystem::path scenario_folder() { return testing::source_folder() / "scenarios"; }

std::vector<std::filesystem::path> shipped_scenarios() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(scenario_folder())) {
    if (entry.path().extension() == ".yaml") {
      files.push_back(entry.path());
    }
  }
  return files;
}

TEST(ParseScenario, HasThePapersNumbersAsDefaults) {
  const Scenario s = parse("decalibration: []");
  EXPECT_EQ(s.name, "case");
  EXPECT_EQ(s.duration, 35.0);
  EXPECT_EQ(s.imu_rate, 100.0);
  EXPECT_EQ(s.stereo_rate, 20.0);
  EXPECT_TRUE(s.use_imu);
  EXPECT_EQ(s.gravity, 9.81);
  EXPECT_EQ(s.world.max_range, 100.0);
  EXPECT_EQ(s.rig.theta, (RigParameters() << 0, 0, 0, -2, 0, 0).finished());
  for (const Camera& camera : {s.rig.cam0, s.rig.cam1}) {
    EXPECT_EQ(camera.fu, 300.0);
    EXPECT_EQ(camera.fv, 300.0);
    EXPECT_EQ(camera.cu, 240.0);
    EXPECT_EQ(camera.cv, 320.0);
    EXPECT_EQ(camera.width, 480);
    EXPECT_EQ(camera.height, 640);
  }
  EXPECT_EQ(s.noise.pixel, 0.5);
  EXPECT_EQ(s.noise.accel, 0.1);
  EXPECT_EQ(s.noise.gyro, 0.5 * kDegree);
  EXPECT_EQ(s.initial.position, 1e-3);
  EXPECT_EQ(s.initial.attitude, 1e-4);
  EXPECT_EQ(s.initial.velocity, 0.01);
  EXPECT_EQ(s.initial.bias_accel, 0.01);
  EXPECT_EQ(s.initial.bias_gyro, 1e-3);
  EXPECT_NEAR(s.filter.theta_sigma[0], 0.1 * kDegree, 1e-18);
  EXPECT_NEAR(s.filter.theta_sigma[3], 0.1, 1e-16);
  EXPECT_TRUE(s.filter.theta_walk.isApprox(RigParameters::Constant(1e-4),
                                           1e-15));  // 100 times a second 1e-6 rad^2 and 1 mm^2
  EXPECT_EQ(s.filter.acceleration_noise, 0.5);
  EXPECT_EQ(s.filter.angular_noise, 0.2);
  EXPECT_FALSE(s.filter.gate);
  EXPECT_EQ(s.filter.max_landmarks, 400);
  EXPECT_FALSE(s.odometry.has_value());
  EXPECT_TRUE(s.decalibration.empty());
}

TEST(ParseScenario, ConvertsDegreesAndPercentagesOfTheBaseline) {
  const Scenario s = parse(
      "rig: {theta: [0, 1, 0, -0.12, 0, 0]}\n"
      "noise: {gyro: 0.1}\n"
      "decalibration:\n"
      "  - {shape: constant, amplitude: [0.01, -0.05, 0.1, 5%, -0.5%, 0.0003]}\n");
  EXPECT_EQ(s.rig.theta[1], kDegree);
  EXPECT_EQ(s.noise.gyro, 0.1 * kDegree);
  const RigParameters& amplitude = s.decalibration.at(0).amplitude;
  EXPECT_EQ(amplitude[0], 0.01 * kDegree);
  EXPECT_NEAR(amplitude[3], 0.006, 1e-17);
  EXPECT_NEAR(amplitude[4], -0.0006, 1e-18);
  EXPECT_EQ(amplitude[5], 0.0003);
  EXPECT_NEAR(s.filter.theta_sigma[3], 0.006, 1e-17);
}

TEST(ParseScenario, LetsCam1AndTheFilterFollowWhatTheFileSays) {
  const Scenario s = parse(
      "rig: {cam0: {resolution: [752, 480], intrinsics: [455, 456, 376, 240]}}\n"
      "initial: {velocity: 0.3}\n");
  EXPECT_EQ(s.rig.cam1.fv, 456.0);
  EXPECT_EQ(s.rig.cam1.width, 752);
  EXPECT_EQ(s.filter.initial.velocity, 0.3);
  EXPECT_EQ(parse("{initial: {velocity: 0.3}, filter: {initial: {velocity: 0.4}}}").filter.initial.velocity,
            0.4);
}

TEST(ParseScenario, KnowsEveryShape) {
  const Scenario s = parse(
      "decalibration:\n"
      "  - {shape: constant, amplitude: [0, 0, 0, 1, 0, 0]}\n"
      "  - {shape: sinus, angular_frequency: 2, phase: 0.5, amplitude: [0, 0, 0, 1, 0, 0]}\n"
      "  - {shape: steps, steps: [{at: 5, value: 2}], amplitude: [0, 0, 0, 1, 0, 0]}\n"
      "  - {shape: square_wave, period: 3, amplitude: [0, 0, 0, 1, 0, 0]}\n"
      "  - {shape: ramp, start: 1, end: 2, amplitude: [0, 0, 0, 1, 0, 0]}\n"
      "  - {shape: random_walk, sigma: 3, amplitude: [0, 0, 0, 1, 0, 0]}\n"
      "  - {shape: white_noise, amplitude: [0, 0, 0, 1, 0, 0]}\n"
      "  - {shape: vibration, frequency: 10, amplitude: [0, 0, 0, 1, 0, 0]}\n");
  ASSERT_EQ(s.decalibration.size(), 8u);
  EXPECT_TRUE(std::holds_alternative<ConstantShape>(s.decalibration[0].shape));
  EXPECT_EQ(std::get<SinusShape>(s.decalibration[1].shape).phase, 0.5);
  EXPECT_EQ(std::get<StepsShape>(s.decalibration[2].shape).steps.at(0).value, 2.0);
  EXPECT_EQ(std::get<SquareWaveShape>(s.decalibration[3].shape).period, 3.0);
  EXPECT_EQ(std::get<RampShape>(s.decalibration[4].shape).end, 2.0);
  EXPECT_EQ(std::get<RandomWalkShape>(s.decalibration[5].shape).sigma, 3.0);
  EXPECT_TRUE(std::holds_alternative<WhiteNoiseShape>(s.decalibration[6].shape));
  EXPECT_NEAR(std::get<SinusShape>(s.decalibration[7].shape).angular_frequency, 20.0 * M_PI, 1e-12);
}

TEST(ParseScenario, TakesRealisticPixelsByOneWordOrEachOnItsOwn) {
  const Scenario by_word = parse("pixels: realistic");
  EXPECT_EQ(by_word.pixels.per_track, 0.3);
  EXPECT_EQ(by_word.noise.pixel, 0.1);
  EXPECT_FALSE(by_word.noise.stated);
  EXPECT_TRUE(by_word.filter.gate);
  EXPECT_EQ(parse("{pixels: realistic, noise: {pixel: 0.5}}").noise.pixel, 0.5);

  const Scenario each = parse("pixels: {mismatches: 0.02}");
  EXPECT_EQ(each.pixels.mismatches, 0.02);
  EXPECT_EQ(each.pixels.per_track, 0.0);
  EXPECT_EQ(each.noise.pixel, 0.5);
  EXPECT_TRUE(each.filter.gate);
  EXPECT_FALSE(parse("{pixels: {mismatches: 0.02}, filter: {gate: false}}").filter.gate);
  EXPECT_TRUE(parse("world: {moving_body: {}}").filter.gate);
  EXPECT_FALSE(parse("pixels: white").filter.gate);
  for (const Scenario& s : {by_word, each, parse("world: {moving_body: {share: 0.3}}")}) {
    EXPECT_EQ(format_scenario(parse(format_scenario(s))), format_scenario(s));
  }
}

// What studies made before are known by stays as it was.
TEST(FormatScenario, LeavesOutWhatIsNotThere) {
  const std::string text = format_scenario(Scenario{});
  for (const char* key : {"pixels:", "faults:", "moving_body:", "stated:"}) {
    EXPECT_EQ(text.find(key), std::string::npos) << key;
  }
}

TEST(ParseScenario, SeeksTrajectoriesBesideTheScenarioFile) {
  const Scenario s = parse_scenario("trajectory: {kind: file, path: ../a.tum}", "/data/scenarios/case.yaml");
  EXPECT_EQ(std::get<FileTrajectory>(s.trajectory).path, "/data/a.tum");
  const Scenario absolute =
      parse_scenario("trajectory: {kind: file, path: /b.tum}", "/data/scenarios/case.yaml");
  EXPECT_EQ(std::get<FileTrajectory>(absolute.trajectory).path, "/b.tum");
}

TEST(ShippedScenarios, HoldThePapersFiveCasesAndTheStrongOne) {
  const auto delta = [](const char* file) {
    const Scenario s = read_scenario(scenario_folder() / file);
    return Decalibration(s.decalibration, s.duration, 1, 0);
  };
  const std::int64_t t_ns = 12'300'000'000;
  const RigParameters paper = paper_decalibration();
  EXPECT_TRUE(delta("paper_i.yaml").at(t_ns).isZero(0.0));
  EXPECT_TRUE(delta("paper_ii.yaml").at(t_ns).isApprox(paper, 1e-15));
  EXPECT_TRUE(delta("paper_iii.yaml").at(t_ns).isApprox(paper * std::sin(12.3), 1e-12));
  EXPECT_TRUE(delta("paper_iv.yaml").at(t_ns).isApprox(paper, 1e-15));
  EXPECT_TRUE(delta("paper_iv.yaml").at(30'000'000'000).isApprox(-paper, 1e-15));
  EXPECT_TRUE(delta("paper_v.yaml").at(t_ns).isApprox(paper, 1e-15));
  EXPECT_TRUE(delta("paper_v.yaml").at(12'600'000'000).isApprox(-paper, 1e-15));
  RigParameters strong = paper;
  strong[3] = 0.5;
  EXPECT_TRUE(delta("paper_v_strong.yaml").at(t_ns).isApprox(strong, 1e-15));
}

TEST(ShippedScenarios, GiveTheDroneThePapersDeltaInProportionToItsBaseline) {
  RigParameters expected = paper_decalibration();
  expected.tail<3>() *= 0.12 / 2.0;
  for (const char* file : {"drone_constant.yaml", "drone_step.yaml", "drone_square.yaml"}) {
    const Scenario s = read_scenario(scenario_folder() / file);
    EXPECT_TRUE(s.decalibration.at(0).amplitude.isApprox(expected, 1e-14)) << file;
    EXPECT_EQ(s.duration, 30.0);
  }
  const Scenario step = read_scenario(scenario_folder() / "drone_step.yaml");
  const Decalibration signal(step.decalibration, step.duration, 1, 0);
  EXPECT_TRUE(signal.at(4'999'999'999).isZero(0.0));
  EXPECT_TRUE(signal.at(5'000'000'000).isApprox(expected, 1e-14));
}

TEST(FormatScenario, WritesWhatParsesBackToTheSameBits) {
  ASSERT_GE(shipped_scenarios().size(), 11u);
  for (const auto& file : shipped_scenarios()) {
    const Scenario first = read_scenario(file);
    const std::string text = format_scenario(first);
    const Scenario second = parse_scenario(text, "elsewhere/other.yaml");
    EXPECT_EQ(format_scenario(second), text) << file;
    EXPECT_EQ(second.name, file.stem().string());
    EXPECT_EQ(second.rig.theta, first.rig.theta);
    EXPECT_EQ(second.rig.T_imu_cam0.R, first.rig.T_imu_cam0.R);
    EXPECT_EQ(second.noise.gyro, first.noise.gyro);
    EXPECT_EQ(second.filter.theta_sigma, first.filter.theta_sigma);
    EXPECT_EQ(second.filter.theta_walk, first.filter.theta_walk);
    EXPECT_EQ(second.filter.gate, first.filter.gate);
    EXPECT_EQ(second.filter.max_landmarks, first.filter.max_landmarks);
    EXPECT_EQ(second.trajectory.index(), first.trajectory.index());
    EXPECT_EQ(second.odometry.has_value(), first.odometry.has_value());
    ASSERT_EQ(second.decalibration.size(), first.decalibration.size());
    for (std::size_t i = 0; i < first.decalibration.size(); ++i) {
      EXPECT_EQ(second.decalibration[i].amplitude, first.decalibration[i].amplitude) << file;
    }
  }
}

TEST(FormatScenario, ShowsEveryKeyWithItsUnit) {
  const std::string text = format_scenario(Scenario{});
  for (const char* line : {"duration: 35  # s\n", "max_angles: [10, 10, 180]  # deg: roll, pitch, yaw\n",
                           "gyro: 0.5  # deg/s per sample\n", "pixel: 0.5  # px\n",
                           "intrinsics: [300, 300, 240, 320]  # px: fu, fv, cu, cv\n",
                           "theta_walk_translation: [1, 1, 1]  # mm^2 per 10 ms\n"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << "\n" << text;
  }
}

TEST(CheckScenario, RefusesWhatNoFileMaySay) {
  const auto broken = [](auto change) {
    Scenario s;
    change(s);
    return s;
  };
  EXPECT_NO_THROW(check_scenario(Scenario{}));
  EXPECT_THROW(check_scenario(broken([](Scenario& s) { s.noise.pixel = -0.5; })), std::invalid_argument);
  EXPECT_THROW(check_scenario(broken([](Scenario& s) { s.duration = std::nan(""); })), std::invalid_argument);
  EXPECT_THROW(check_scenario(broken([](Scenario& s) { s.imu_rate = 0.0; })), std::invalid_argument);
  EXPECT_THROW(check_scenario(broken([](Scenario& s) { s.rig.theta[3] = 2.0; })), std::invalid_argument);
  EXPECT_THROW(check_scenario(broken([](Scenario& s) { s.rig.T_imu_cam0.R *= 2.0; })), std::invalid_argument);
  EXPECT_THROW(check_scenario(broken([](Scenario& s) { s.world.max_range = 0.1; })), std::invalid_argument);
  EXPECT_EQ(testing::message_of([&] { check_scenario(broken([](Scenario& s) { s.noise.pixel = -0.5; })); }),
            "scenario: expected noise.pixel as a number in [0, 1000] px, got -0.5");
}

/// A text that no scenario may be, the line that the message must name and what it must say.
struct BadScenario {
  const char* name;
  const char* text;
  std::size_t line;
  const char* says;
};

void PrintTo(const BadScenario& bad, std::ostream* out) { *out << bad.name; }

class BadScenarios : public ::testing::TestWithParam<BadScenario> {};

TEST_P(BadScenarios, AreRefusedWithLineKeyAndWhatIsAllowed) {
  const BadScenario& bad = GetParam();
  try {
    (void)parse(bad.text);
    FAIL() << "accepted: " << bad.text;
  } catch (const DataError& e) {
    EXPECT_EQ(e.file(), "folder/case.yaml");
    EXPECT_EQ(e.line(), bad.line) << e.what();
    EXPECT_NE(std::string(e.what()).find(bad.says), std::string::npos) << e.what();
  }
}

INSTANTIATE_TEST_SUITE_P(
    Texts, BadScenarios,
    ::testing::Values(
        BadScenario{"UnknownKey", "duration: 10\ndurration: 35\n", 2, "the unknown key 'durration'"},
        BadScenario{"UnknownKeyListsThoseThatExist", "noise:\n  pixels: 1\n", 2,
                    "one of the keys pixel, accel, gyro, accel_walk, gyro_walk, stated in noise"},
        BadScenario{"RepeatedKey", "duration: 10\nnoise: {}\nduration: 35\n", 3,
                    "each key once, found 'duration', which stands in line 1, too"},
        BadScenario{"RepeatedKeyWithin", "noise:\n  pixel: 1\n  gyro: 0.1\n  pixel: 2\n", 4, "'pixel'"},
        BadScenario{"UnknownPixels", "duration: 10\npixels: pink\n", 2,
                    "pixels as one of white, realistic, found 'pink'"},
        BadScenario{
            "UnknownKeyOfPixels", "pixels:\n  per_track: 0.3\n  lens: 0.2\n", 3,
            "one of the keys per_track, correlated, correlated_coefficient, field, mismatches in pixels"},
        BadScenario{"CorrelationOfOne", "pixels: {correlated_coefficient: 1}\n", 1,
                    "pixels.correlated_coefficient as a number in [0, 0.9999]"},
        BadScenario{"MoreMismatchesThanPoints", "pixels:\n  mismatches: 2\n", 2,
                    "pixels.mismatches as a number in [0, 1]"},
        BadScenario{"UnknownKeyOfAMovingBody", "world:\n  moving_body: {sharing: 0.4}\n", 2,
                    "one of the keys share, speed, radius, start in world.moving_body"},
        BadScenario{"UnknownFault", "faults:\n  - {kind: imu_hole, at: 5}\n", 2,
                    "faults[0].kind as one of gyro_bias_step, accel_bias_step, imu_spike"},
        BadScenario{"FaultWithoutDuration", "faults:\n  - {kind: imu_gap, at: 5}\n", 2,
                    "the key faults[0].duration"},
        BadScenario{"KeyOfAnotherFault",
                    "faults:\n  - kind: imu_spike\n    at: 5\n    size: 10\n    duration: 1\n", 5,
                    "the unknown key 'duration'"},
        BadScenario{"FaultBeforeTheStart", "faults:\n  - {kind: imu_gap, at: -1, duration: 2}\n", 2,
                    "faults[0].at as a number in [0, 1000000] s"},
        BadScenario{"TextForANumber", "duration: long\n", 1,
                    "expected duration as a number in (0, 10000] s, found 'long'"},
        BadScenario{"ListForANumber", "duration: [1, 2]\n", 1, "found a list of 2"},
        BadScenario{"NumberForAMapping", "\nnoise: 0.5\n", 2, "noise as a mapping"},
        BadScenario{"NothingForAMapping", "noise:\n", 1, "noise as a mapping (key: value), found nothing"},
        BadScenario{"NumberForABoolean", "use_imu: 1\n", 1, "use_imu as true or false"},
        BadScenario{"NegativeNoise", "noise:\n  pixel: -0.5\n", 2, "noise.pixel as a number in [0, 1000] px"},
        BadScenario{"NotANumber", "noise: {accel: .nan}\n", 1, "noise.accel"},
        BadScenario{"Infinite", "gravity: 1e999\n", 1, "gravity"},
        BadScenario{"NothingInAMapping", "noise:\n  pixel:\n", 2, "noise.pixel"},
        BadScenario{"NoDuration", "duration: 0\n", 1, "(0, "},
        BadScenario{"TooManySamples", "gravity: 9\nduration: 5000\nrates: {imu: 5000}\n", 2,
                    "duration with at most 1e+07 samples of each sensor, found 5000 s at 5000 Hz"},
        BadScenario{"ProbabilityAboveOne", "dropout: {frames: 1.5}\n", 1,
                    "dropout.frames as a number in [0, 1]"},
        BadScenario{"HalfAPoint", "world: {points: 10.5}\n", 1, "world.points as a whole number"},
        BadScenario{"RangeUpsideDown", "world:\n  min_range: 10\n  max_range: 5\n", 3, "not below min_range"},
        BadScenario{"DistanceUpsideDown", "world: {min_distance: 90}\n", 1, "not below min_distance"},
        BadScenario{"SpeedUpsideDown", "trajectory: {kind: figure_eight, min_speed: 5}\n", 1,
                    "not below min_speed"},
        BadScenario{"UnknownTrajectory", "trajectory: {kind: circle}\n", 1,
                    "trajectory.kind as one of random_spline, figure_eight, file"},
        BadScenario{"KeyOfAnotherTrajectory", "trajectory:\n  kind: figure_eight\n  max_angles: [1, 1, 1]\n",
                    3, "unknown key 'max_angles'"},
        BadScenario{"FileWithoutPath", "trajectory: {kind: file}\n", 1, "the key trajectory.path"},
        BadScenario{"ZeroBaseline", "rig: {theta: [0, 0, 0, 0, 0, 0]}\n", 1, "cam1 to the right of cam0"},
        BadScenario{"Cam1ToTheLeft", "rig: {theta: [0, 0, 0, 2, 0, 0]}\n", 1, "cam1 to the right of cam0"},
        BadScenario{"FiveRigParameters", "rig: {theta: [0, 0, 0, -2, 0]}\n", 1,
                    "rig.theta as a list of 6 numbers"},
        BadScenario{"NoRotation", "rig:\n  T_imu_cam0: [2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n", 2,
                    "rig.T_imu_cam0 with a rotation matrix"},
        BadScenario{"Reflection", "rig:\n  T_imu_cam0: [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n",
                    2, "rig.T_imu_cam0 with a rotation matrix"},
        BadScenario{"LastRow", "rig:\n  T_imu_cam0: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 1]\n", 2,
                    "with 0, 0, 0, 1 as last row"},
        BadScenario{"BodyIsCam0ButAside",
                    "rig:\n  body: cam0\n  T_imu_cam0: [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n", 3,
                    "unless body is imu"},
        BadScenario{"NegativeFocalLength", "rig:\n  cam0:\n    intrinsics: [-300, 300, 240, 320]\n", 3,
                    "rig.cam0.intrinsics with positive focal lengths"},
        BadScenario{"UnknownDistortion", "rig: {cam1: {distortion_model: fov}}\n", 1,
                    "rig.cam1.distortion_model as one of none, radial-tangential, equidistant, "
                    "rational-polynomial, omni"},
        BadScenario{"DistortionWithoutCoefficients", "rig: {cam0: {distortion_model: equidistant}}\n", 1,
                    "the key rig.cam0.distortion_coefficients"},
        BadScenario{"SignalWithoutShape", "decalibration:\n  - {amplitude: [0, 0, 0, 0, 0, 0]}\n", 2,
                    "the key decalibration[0].shape"},
        BadScenario{"SignalWithoutAmplitude", "decalibration:\n  - shape: constant\n", 2,
                    "the key decalibration[0].amplitude"},
        BadScenario{"UnknownShape", "decalibration:\n  - {shape: triangle, amplitude: [0, 0, 0, 0, 0, 0]}\n",
                    2, "decalibration[0].shape as one of constant, sinus, steps"},
        BadScenario{"SignalsAsMapping", "decalibration: {shape: constant}\n", 1,
                    "decalibration as a list of mappings"},
        BadScenario{"PercentageOfAnAngle",
                    "decalibration:\n  - {shape: constant, amplitude: [5%, 0, 0, 0, 0, 0]}\n", 2,
                    "decalibration[0].amplitude"},
        BadScenario{"BrokenPercentage",
                    "decalibration:\n  - {shape: constant, amplitude: [0, 0, 0, x%, 0, 0]}\n", 2,
                    "a percentage of the baseline such as 5%, found 'x%'"},
        BadScenario{"StepsOutOfOrder",
                    "decalibration:\n  - shape: steps\n    amplitude: [0, 0, 0, 0, 0, 0]\n    steps:\n"
                    "      - {at: 5, value: 1}\n      - {at: 4, value: 0}\n",
                    6, "decalibration[0].steps[1].at later than the step before it"},
        BadScenario{"StepWithoutValue",
                    "decalibration:\n  - {shape: steps, amplitude: [0, 0, 0, 0, 0, 0], steps: [{at: 5}]}\n",
                    2, "the key decalibration[0].steps[0].value"},
        BadScenario{"RampBackwards",
                    "decalibration:\n  - {shape: ramp, start: 5, end: 4, amplitude: [0, 0, 0, 0, 0, 0]}\n", 2,
                    "decalibration[0].end later than start"},
        BadScenario{"ZeroPeriod",
                    "decalibration:\n  - {shape: square_wave, period: 0, amplitude: [0, 0, 0, 0, 0, 0]}\n", 2,
                    "decalibration[0].period as a number in [0.001, 1000000] s"},
        BadScenario{"VibrationWithoutFrequency",
                    "decalibration:\n  - {shape: vibration, amplitude: [0, 0, 0, 0, 0, 0]}\n", 2,
                    "the key decalibration[0].frequency"},
        BadScenario{"BrokenYaml", "duration: 10\nnoise: {pixel: 1\n", 3, "valid YAML"},
        BadScenario{"NoMapping", "just text\n", 1, "a YAML mapping (key: value)"},
        BadScenario{"Empty", "# nothing\n", 0, "a YAML mapping (key: value), found an empty file"},
        BadScenario{"TwoDocuments", "duration: 1\n---\nduration: 2\n", 0,
                    "one YAML document, found more than one"},
        BadScenario{"ListAsKey", "[1, 2]: 3\n", 1, "a name as key"}),
    [](const auto& bad) { return bad.param.name; });

TEST(ReadScenario, NamesAFileThatIsNotThere) {
  try {
    (void)read_scenario("no/such/file.yaml");
    FAIL();
  } catch (const DataError& e) {
    EXPECT_EQ(e.file(), "no/such/file.yaml");
  }
}

}  // namespace
}  // namespace limber
