// SPDX-License-Identifier: MIT
// One update of the plain EKF beside one of the constrained EKF: same covariance, same stereo frame.
#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <chrono>
#include <random>

#include "limber/core/covariance.hpp"
#include "limber/core/linear_measurement.hpp"
#include "limber/update/update.hpp"

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Clock = std::chrono::steady_clock;

constexpr Index kParameters = 6;
constexpr Index kRowsPerPoint = 4;
constexpr Index kMapBegin = 15;  // body with IMU; the map follows

class Draws {
 public:
  MatrixXd matrix(Index rows, Index cols, double sigma) {
    return MatrixXd::NullaryExpr(rows, cols, [&] { return sigma * normal_(generator_); });
  }

 private:
  std::mt19937_64 generator_{7};
  std::normal_distribution<double> normal_;
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

/// `points` stereo points: 4 rows each, H with blocks for position, attitude and the landmark, D on the right
/// rows. Landmarks are spread over the whole map; a map smaller than the frame is seen more than once.
limber::LinearMeasurement make_frame(Index n, Index points, Draws& draws) {
  const Index m = kRowsPerPoint * points;
  limber::LinearMeasurement z;
  z.residual = draws.matrix(m, 1, 1.0);
  z.sigma = Eigen::VectorXd::Constant(m, 0.5);
  z.D = MatrixXd::Zero(m, kParameters);
  const Index landmarks = (n - kMapBegin) / limber::kTriplet;
  for (Index point = 0; point < points; ++point) {
    const Index landmark =
        kMapBegin + limber::kTriplet * (landmarks >= points ? point * landmarks / points : point % landmarks);
    for (Index camera = 0; camera < 2; ++camera) {
      const Index row = kRowsPerPoint * point + 2 * camera;
      for (const Index col : {Index{0}, Index{3}, landmark}) {
        z.H.blocks.push_back({row, col, draws.matrix(2, limber::kTriplet, 30.0)});
      }
    }
    z.D.middleRows<2>(kRowsPerPoint * point + 2) = draws.matrix(2, kParameters, 10.0);
    z.groups.push_back({kRowsPerPoint * point, kRowsPerPoint});
  }
  return z;
}

double time_update(const limber::Covariance& prior, const limber::LinearMeasurement& frame,
                   const limber::ParameterTreatment& treatment) {
  limber::Covariance P = prior;
  const Clock::time_point begin = Clock::now();
  const limber::UpdateReport report = limber::update(P, frame, treatment);
  const Clock::time_point end = Clock::now();
  benchmark::DoNotOptimize(report.dx.data());
  return std::chrono::duration<double>(end - begin).count();
}

/// Times of both, taken in turn so that a busy machine slows both alike; each is judged by its fastest run,
/// which is the one that nobody disturbed.
void ekf_beside_lcekf(benchmark::State& state) {
  Draws draws;
  const Index n = state.range(0);
  const limber::Covariance prior = make_covariance(n, draws);
  const limber::LinearMeasurement frame = make_frame(n, state.range(1), draws);
  const limber::ParameterTreatment free;
  limber::ParameterTreatment full;
  full.constrained = MatrixXd::Identity(kParameters, kParameters);

  double best_ekf = 1e9, best_lcekf = 1e9;
  bool ekf_first = true;
  for (auto _ : state) {
    double ekf = 0.0, lcekf = 0.0;
    if (ekf_first) {
      ekf = time_update(prior, frame, free);
      lcekf = time_update(prior, frame, full);
    } else {
      lcekf = time_update(prior, frame, full);
      ekf = time_update(prior, frame, free);
    }
    ekf_first = !ekf_first;
    best_ekf = std::min(best_ekf, ekf);
    best_lcekf = std::min(best_lcekf, lcekf);
    state.SetIterationTime(lcekf);
  }
  state.counters["ekf_ms"] = 1e3 * best_ekf;
  state.counters["lcekf_ms"] = 1e3 * best_lcekf;
  state.counters["ratio"] = best_lcekf / best_ekf;
}

BENCHMARK(ekf_beside_lcekf)
    ->ArgNames({"states", "points"})
    ->ArgsProduct({{99, 249, 501, 750, 999}, {20, 40, 60, 100}})
    ->UseManualTime()
    ->MinTime(0.3)
    ->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
