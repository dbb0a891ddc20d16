// SPDX-License-Identifier: MIT
// How many points of the left image the front end finds in the right one, on rendered pictures of a rig that
// is not the one it was told.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <numbers>
#include <string>
#include <vector>

#include "limber/frontend/stereo_tracker.hpp"
#include "limber/measure/rig.hpp"
#include "limber/render/picture_truth.hpp"
#include "limber/simulate/scenario_file.hpp"

namespace {

using limber::PictureTruth;
using limber::RigParameters;

constexpr double kWrong = 1.0;  ///< [px] from the truth

struct Counts {
  double points = 0.0, matches = 0.0;
  double wrong = 0.0;  ///< matches
  double wrong_off_edges =
      0.0;  ///< those of points that do not stand on the edge of a thing in front of another

  [[nodiscard]] double share() const { return matches / points; }
};

/// The same left pictures before rigs that bend in different ways.
class Experiment {
 public:
  Experiment(const limber::Scenario& scenario, limber::SceneKind kind, std::uint64_t seed, double noise)
      : truth_(scenario, {.scene = kind}, seed, 0),
        times_(limber::sample_times(scenario.stereo_rate, scenario.duration)),
        right_(truth_.nominal().cam1) {
    effects_.noise = noise;
    const limber::PictureCamera left(truth_.nominal().cam0);
    for (const std::int64_t t_ns : times_) {
      lefts_.push_back(limber::develop(left.light(truth_.scene(), truth_.view(0, seconds(t_ns))),
                                       truth_.nominal().cam0, effects_, 2 * lefts_.size()));
    }
  }

  /// The tracker is told the nominal rig; the rig that takes the pictures differs by delta.
  [[nodiscard]] Counts track(const RigParameters& delta) const {
    const limber::Camera &cam0 = truth_.nominal().cam0, &cam1 = truth_.nominal().cam1;
    limber::StereoTracker tracker(truth_.nominal());
    Counts counts;
    for (std::size_t n = 0; n < times_.size(); ++n) {
      const double t = seconds(times_[n]);
      const limber::Pose T_world_cam0 = truth_.view(0, t).T_world_cam;
      const limber::Pose T_world_cam1 =
          T_world_cam0 * limber::pose_from_rig(truth_.nominal().theta + delta).inverse();
      const auto right =
          limber::develop(right_.light(truth_.scene(), {t, T_world_cam1}), cam1, effects_, 2 * n + 1);
      const auto frame = tracker.process(times_[n], view(cam0, lefts_[n]), view(cam1, right));
      for (const limber::StereoObservation& point : frame.observations) {
        counts.points += 1.0;
        if (!point.in_cam1) continue;
        counts.matches += 1.0;
        const auto place = truth_.place(0, times_[n], point.uv_cam0);
        const auto expected = place ? limber::project(cam1, T_world_cam1.inverse() * place->p) : std::nullopt;
        if (expected && (expected->uv - point.uv_cam1).norm() <= kWrong) continue;
        counts.wrong += 1.0;
        if (!truth_.on_an_edge(0, times_[n], point.uv_cam0)) counts.wrong_off_edges += 1.0;
      }
    }
    return counts;
  }

  [[nodiscard]] double baseline() const { return truth_.nominal().baseline(); }

 private:
  static double seconds(std::int64_t t_ns) { return 1e-9 * static_cast<double>(t_ns); }
  static limber::GreyImage view(const limber::Camera& camera, const std::vector<std::uint8_t>& pixels) {
    return {camera.width, camera.height, camera.width, pixels.data()};
  }

  PictureTruth truth_;
  std::vector<std::int64_t> times_;
  limber::PictureCamera right_;
  limber::SensorEffects effects_;
  std::vector<std::vector<std::uint8_t>> lefts_;
};

/// One way to bend a rig, more and more.
struct Bend {
  const char* name;
  Eigen::Index parameter;
  bool is_angle;  ///< amounts in degrees, else in percent of the baseline
  std::vector<double> amounts;
};

const std::vector<Bend>& bends() {
  static const std::vector<double> kDegrees = {0.3, 1, 2, 3, 5}, kPercents = {10, 20, 30};
  static const std::vector<Bend> kAll = {{"nod", 0, true, kDegrees},
                                         {"vergence", 1, true, kDegrees},
                                         {"roll", 2, true, kDegrees},
                                         {"baseline, tx", 3, false, kPercents},
                                         {"baseline, ty", 4, false, kPercents},
                                         {"baseline, tz", 5, false, kPercents}};
  return kAll;
}

/// Shares in percent: matches of points, that beside the undisturbed rig, wrong ones of matches; of the two
/// signs the one with fewer matches.
void print_row(const Experiment& experiment, const Counts& undisturbed, const Bend& bend, double amount) {
  const double size =
      bend.is_angle ? amount * std::numbers::pi / 180.0 : amount / 100.0 * experiment.baseline();
  std::array<Counts, 2> signs;
  for (const std::size_t k : {0u, 1u}) {
    RigParameters delta = RigParameters::Zero();
    delta[bend.parameter] = k == 0 ? size : -size;
    signs[k] = experiment.track(delta);
  }
  const Counts& worse = signs[0].share() < signs[1].share() ? signs[0] : signs[1];
  fmt::print("| {} {} {} | {:.1f} | {:.1f} | {:.2f} | {:.2f} |\n", bend.name, amount,
             bend.is_angle ? "°" : "%", 100.0 * worse.share(), 100.0 * worse.share() / undisturbed.share(),
             100.0 * worse.wrong / worse.matches, 100.0 * worse.wrong_off_edges / worse.matches);
}

}  // namespace

int main(int argc, char** argv) {
  std::string file, scene = "room";
  std::uint64_t seed = 1;
  double duration = 1.5, noise = 2.0;
  CLI::App app{"Right matches on rendered pictures of a bent rig"};
  app.add_option("SCENARIO", file, "Scenario file (YAML); its decalibration is left out")->required();
  app.add_option("--scene", scene, "room, hall or street")->capture_default_str();
  app.add_option("--seed", seed)->capture_default_str();
  app.add_option("--duration", duration, "[s]")->capture_default_str();
  app.add_option("--image-noise", noise, "[grey levels]")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    limber::Scenario scenario = limber::read_scenario(file);
    scenario.duration = duration;
    scenario.decalibration.clear();
    const Experiment experiment(scenario, limber::scene_from_string(scene), seed, noise);
    const Counts undisturbed = experiment.track(RigParameters::Zero());
    fmt::print(
        "| {} | matches of points, % | beside the undisturbed rig, % | wrong of matches, % | off edges |\n",
        scene);
    fmt::print("| --- | --- | --- | --- | --- |\n| undisturbed | {:.1f} | 100 | {:.2f} | {:.2f} |\n",
               100.0 * undisturbed.share(), 100.0 * undisturbed.wrong / undisturbed.matches,
               100.0 * undisturbed.wrong_off_edges / undisturbed.matches);
    for (const Bend& bend : bends()) {
      for (const double amount : bend.amounts) print_row(experiment, undisturbed, bend, amount);
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "right_matches: error: {}\n", error.what());
    return 1;
  }
  return 0;
}
