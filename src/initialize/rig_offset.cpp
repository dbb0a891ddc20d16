// SPDX-License-Identifier: MIT
#include "rig_offset.hpp"

#include <algorithm>
#include <vector>

#include "limber/core/chi_square.hpp"
#include "limber/core/factors.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Lenses that are a little wrong look like a rig that is: of sound ones with realistic pixels a quarter is
/// below. Rigs that are off by 0.05 deg are far below (docs/evidence/start.md).
constexpr double kLeastChance = 1e-3;
constexpr double kMostScatter = 1.25;  // of a rig that stays as it is: 1, within 0.1

struct FramesTheta {
  VectorXd theta;
  MatrixXd covariance;
  MatrixXd constant;  // from a theta that all frames share
};

FramesTheta theta_of_frames(const WindowModel& model, const WindowState& solution,
                            const MatrixXd& covariance) {
  const auto frames = static_cast<Index>(solution.frames.size());
  const Index b = model.directions.cols();
  FramesTheta out{VectorXd(frames * b), {}, MatrixXd(frames * b, b)};
  std::vector<Index> at;
  for (Index k = 0; k < frames; ++k) {
    out.theta.segment(k * b, b) = solution.frames[static_cast<std::size_t>(k)].theta;
    out.constant.middleRows(k * b, b).setIdentity();
    for (Index i = 0; i < b; ++i) {
      at.push_back(k * model.frame_size() + model.body_size() + i);
    }
  }
  out.covariance = covariance(at, at);
  return out;
}

}  // namespace

RigOffset rig_offset(const WindowModel& model, const WindowState& solution, const MatrixXd& covariance,
                     double noise) {
  const FramesTheta of = theta_of_frames(model, solution, covariance);
  const Cholesky C(noise * of.covariance);
  if (!C.succeeded()) {
    return {};
  }
  const MatrixXd by_constant = C.solve(of.constant);
  const VectorXd score = by_constant.transpose() * of.theta;
  const double of_constant = score.dot(solve_symmetric(of.constant.transpose() * by_constant, score));
  const double of_all = of.theta.dot(C.solve(of.theta));
  const Index b = of.constant.cols(), rest = of.theta.size() - b;
  return {chi_square_survival(of_constant, static_cast<double>(b)),
          (of_all - of_constant) / static_cast<double>(std::max<Index>(rest, 1))};
}

bool looks_sound(const RigOffset& offset) {
  return offset.p_value > kLeastChance && offset.scatter < kMostScatter;
}

}  // namespace limber::detail
