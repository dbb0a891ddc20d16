// SPDX-License-Identifier: MIT
// One update beside another: constrained and plain EKF, with and without the health monitor; and the gate
// beside the update it precedes. Same covariance, same stereo frame.
#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

#include "limber/core/covariance.hpp"
#include "limber/core/linear_measurement.hpp"
#include "limber/measure/point_rows.hpp"
#include "limber/measure/rig.hpp"
#include "limber/measure/stereo_model.hpp"
#include "limber/navigate/method.hpp"
#include "limber/update/frame_innovation.hpp"
#include "limber/update/gate.hpp"
#include "limber/update/innovation.hpp"
#include "limber/update/update.hpp"

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Clock = std::chrono::steady_clock;

constexpr Index kRowsPerPoint = 4;
constexpr double kGate = 0.999;  // as the filter has it
constexpr Index kBody = 15;      // with IMU; a witness or the map follows

class Draws {
 public:
  double uniform() { return uniform_(generator_); }

  MatrixXd matrix(Index rows, Index cols, double sigma) {
    return MatrixXd::NullaryExpr(rows, cols, [&] { return sigma * normal_(generator_); });
  }

 private:
  std::mt19937_64 generator_{7};
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_;
};

/// A map of n states whose errors share those of the body, as in SLAM: rank-12 common part and own noise.
limber::Covariance make_covariance(Index n, Draws& draws) {
  const MatrixXd common = draws.matrix(n, 12, 0.05);
  MatrixXd dense = common * common.transpose();
  dense.diagonal().array() += 0.01;
  limber::Covariance P;
  P.append(n);
  P.set_diagonal_block(0, dense);
  return P;
}

/// The paper's rig, without distortion.
limber::MountedRig make_rig() {
  limber::StereoCalibration calibration;
  calibration.cam0 = calibration.cam1 = {300.0, 300.0, 240.0, 320.0, 480, 640, limber::NoDistortion{}};
  calibration.theta << 0.01, -0.02, 0.005, -2.0, 0.02, -0.04;
  return limber::mount(calibration);
}

/// `points` Cartesian points that both cameras see, 3 to 60 m away. Landmarks are spread over the whole map;
/// a map smaller than the frame is seen more than once.
limber::LinearMeasurement make_frame(Index n, Index points, Draws& draws, Index map_begin = kBody) {
  const limber::MountedRig rig = make_rig();
  const limber::StateLayout layout{limber::MotionModel::kImu, false};
  const Index landmarks = (n - map_begin) / limber::kTriplet;
  limber::LinearMeasurement z = limber::empty_measurement(kRowsPerPoint * points);
  for (Index point = 0; point < points; ++point) {
    limber::Landmark landmark;
    landmark.kind = limber::LandmarkKind::kCartesian;
    landmark.at =
        map_begin + limber::kTriplet * (landmarks >= points ? point * landmarks / points : point % landmarks);
    const double depth = 3.0 * std::pow(20.0, draws.uniform());
    landmark.value = depth * Eigen::Vector3d(draws.uniform() - 0.5, draws.uniform() - 0.5, 1.0);
    const limber::BodyPoint body = limber::body_point(limber::Pose{}, landmark, nullptr);
    for (const Index camera : {0, 1}) {
      const auto projection = limber::project_point(rig[static_cast<std::size_t>(camera)], body).value();
      limber::write_point_rows(z, kRowsPerPoint * point + 2 * camera, projection.uv + draws.matrix(2, 1, 0.5),
                               {0.5, 0.5}, projection, landmark, nullptr, layout);
    }
    z.groups.push_back({kRowsPerPoint * point, kRowsPerPoint, landmark.at});
  }
  return z;
}

/// All six parameters, scaled to one plausible error each.
MatrixXd scaled_axes() { return limber::plausible_error(2.0).asDiagonal(); }

/// One way to update, with the covariance that it needs.
struct Contestant {
  limber::Covariance prior;
  limber::LinearMeasurement frame;
  limber::ParameterErrorModel treatment;
};

double time_update(const Contestant& of) {
  limber::Covariance P = of.prior;
  const Clock::time_point begin = Clock::now();
  const limber::UpdateReport report = limber::update(P, of.frame, of.treatment);
  const Clock::time_point end = Clock::now();
  benchmark::DoNotOptimize(report.dx.data());
  return std::chrono::duration<double>(end - begin).count();
}

double time_gate(const Contestant& of) {
  const Clock::time_point begin = Clock::now();
  const limber::FrameInnovation seen = limber::form_frame_innovation(of.prior, of.frame);
  const limber::GateReport report =
      limber::gate(seen.innovation, seen.groups, of.treatment, limber::GateThresholds(kGate));
  const Clock::time_point end = Clock::now();
  benchmark::DoNotOptimize(report.distance.data());
  return std::chrono::duration<double>(end - begin).count();
}

Contestant contestant(const benchmark::State& state, Index witness = 0) {
  Draws draws;
  const Index n = state.range(0) + witness;
  return {make_covariance(n, draws), make_frame(n, state.range(1), draws, kBody + witness), {}};
}

/// Times of both, taken in turn so that a busy machine slows both alike; each is judged by its fastest run,
/// which is the one that nobody disturbed.
void race(benchmark::State& state, const Contestant& base, const Contestant& rival,
          double (*time_of_rival)(const Contestant&) = time_update) {
  double best_base = 1e9, best_rival = 1e9;
  bool base_first = true;
  for (auto _ : state) {
    double base_s = 0.0, rival_s = 0.0;
    const auto time_base = [&] { base_s = time_update(base); };
    const auto time_rival = [&] { rival_s = time_of_rival(rival); };
    base_first ? (time_base(), time_rival()) : (time_rival(), time_base());
    base_first = !base_first;
    best_base = std::min(best_base, base_s);
    best_rival = std::min(best_rival, rival_s);
    state.SetIterationTime(rival_s);
  }
  state.counters["base_ms"] = 1e3 * best_base;
  state.counters["ms"] = 1e3 * best_rival;
  state.counters["ratio"] = best_rival / best_base;
}

void lcekf_beside_ekf(benchmark::State& state) {
  const Contestant ekf = contestant(state);
  Contestant lcekf = ekf;
  lcekf.treatment.constrained = scaled_axes();
  race(state, ekf, lcekf);
}

/// What the health monitor adds to an update of lcekf: evidence and a witness, six states more.
void watched_beside_lcekf(benchmark::State& state) {
  Contestant lcekf = contestant(state), watched = contestant(state, limber::kWitnessSize);
  lcekf.treatment.constrained = watched.treatment.constrained = watched.treatment.watched = scaled_axes();
  watched.treatment.witness = limber::Witness{kBody, Eigen::VectorXd::Zero(limber::kWitnessSize)};
  race(state, lcekf, watched);
}

/// The same for ekf, which needs no witness.
void watched_beside_ekf(benchmark::State& state) {
  const Contestant ekf = contestant(state);
  Contestant watched = ekf;
  watched.treatment.watched = scaled_axes();
  race(state, ekf, watched);
}

/// The gate beside the update of a frame without mismatches, where a share of the points is one.
void gate_beside_update(benchmark::State& state) {
  Contestant sound = contestant(state);
  sound.treatment.constrained = scaled_axes();
  Draws draws;
  sound.frame.residual = draws.matrix(sound.frame.rows(), 1, 0.5);  // as innovations are: small beside S
  Contestant mismatched = sound;
  const Index points = state.range(1), wrong = points * state.range(2) / 100;
  for (Index k = 0; k < wrong; ++k) {
    mismatched.frame.residual.segment<kRowsPerPoint>(kRowsPerPoint * (k * points / wrong)) +=
        draws.matrix(kRowsPerPoint, 1, static_cast<double>(state.range(3)));
  }
  race(state, sound, mismatched, time_gate);
  const limber::FrameInnovation seen = limber::form_frame_innovation(mismatched.prior, mismatched.frame);
  const auto accepted =
      limber::gate(seen.innovation, seen.groups, mismatched.treatment, limber::GateThresholds(kGate))
          .accepted;
  state.counters["refused"] = static_cast<double>(std::count(accepted.begin(), accepted.end(), false));
}

void sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgNames({"states", "points"})
      ->ArgsProduct({{99, 249, 501, 750, 999}, {20, 40, 60, 100}})
      ->UseManualTime()
      ->MinTime(0.3)
      ->Unit(benchmark::kMillisecond);
}

BENCHMARK(lcekf_beside_ekf)->Apply(sizes);
BENCHMARK(watched_beside_lcekf)->Apply(sizes);
BENCHMARK(watched_beside_ekf)->Apply(sizes);
BENCHMARK(gate_beside_update)
    ->ArgNames({"states", "points", "percent", "px"})
    ->ArgsProduct({{249, 501}, {60, 120}, {0, 5, 20}, {30, 300}})
    ->UseManualTime()
    ->MinTime(0.3)
    ->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
