// SPDX-License-Identifier: MIT
// One update beside another: constrained and plain EKF, with and without the health monitor. Same
// covariance, same stereo frame.
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

/// One way to update, with the covariance that it needs.
struct Contestant {
  limber::Covariance prior;
  limber::ParameterTreatment treatment;
};

/// Times of both, taken in turn so that a busy machine slows both alike; each is judged by its fastest run,
/// which is the one that nobody disturbed.
void race(benchmark::State& state, const limber::LinearMeasurement& frame, const Contestant& base,
          const Contestant& rival) {
  double best_base = 1e9, best_rival = 1e9;
  bool base_first = true;
  for (auto _ : state) {
    double base_s = 0.0, rival_s = 0.0;
    const auto time_base = [&] { base_s = time_update(base.prior, frame, base.treatment); };
    const auto time_rival = [&] { rival_s = time_update(rival.prior, frame, rival.treatment); };
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
  Draws draws;
  const Contestant ekf{make_covariance(state.range(0), draws), {}};
  Contestant lcekf = ekf;
  lcekf.treatment.constrained = MatrixXd::Identity(kParameters, kParameters);
  race(state, make_frame(state.range(0), state.range(1), draws), ekf, lcekf);
}

/// What the health monitor adds to an update of lcekf: evidence and witness, six states more.
void watched_beside_lcekf(benchmark::State& state) {
  Draws draws;
  Contestant lcekf{make_covariance(state.range(0), draws), {}};
  lcekf.treatment.constrained = MatrixXd::Identity(kParameters, kParameters);
  Contestant watched = lcekf;
  watched.prior.append(limber::kWitnessSize);
  watched.prior.set_diagonal_block(state.range(0),
                                   MatrixXd::Identity(limber::kWitnessSize, limber::kWitnessSize));
  watched.treatment.watched = lcekf.treatment.constrained;
  watched.treatment.witness = limber::Witness{state.range(0), Eigen::VectorXd::Zero(limber::kWitnessSize)};
  race(state, make_frame(state.range(0), state.range(1), draws), lcekf, watched);
}

/// The same for ekf, which needs no witness.
void watched_beside_ekf(benchmark::State& state) {
  Draws draws;
  const Contestant ekf{make_covariance(state.range(0), draws), {}};
  Contestant watched = ekf;
  watched.treatment.watched = MatrixXd::Identity(kParameters, kParameters);
  race(state, make_frame(state.range(0), state.range(1), draws), ekf, watched);
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

}  // namespace

BENCHMARK_MAIN();
