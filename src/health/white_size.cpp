// SPDX-License-Identifier: MIT
#include "limber/health/white_size.hpp"

#include <cmath>

#include "limber/core/factors.hpp"
#include "limber/sensors/calibration.hpp"

namespace limber {

using Eigen::MatrixXd;

namespace {

constexpr double kWhiteMemory = 10.0;  // [s]
constexpr double kFirstFrames = 4.0;   // what the start is worth
constexpr double kConfidence = 4.0;    // standard deviations of the size squared

}  // namespace

void WhiteSize::begin(const Vector6& sigma) {
  const Vector6 variance = sigma.cwiseAbs2().cwiseMax(this->variance());
  weight_ = kFirstFrames * variance.cwiseAbs2().cwiseInverse();
  sum_ = weight_.cwiseProduct(variance);
}

void WhiteSize::learn(const ParameterEvidence& evidence, double dt) {
  MatrixXd A = evidence.information;
  A.diagonal().array() += 1.0 / (kWidestErrors * kWidestErrors);
  const MatrixXd C = Cholesky(A).inverse();
  const Vector6 beta = C * evidence.vector;
  const Vector6 c = C.diagonal();
  const Vector6 weight = (c + sum_.cwiseQuotient(weight_).cwiseMax(0.0)).cwiseAbs2().cwiseInverse();
  const double keep = std::exp(-dt / kWhiteMemory);
  weight_ = keep * weight_ + weight;
  sum_ = keep * sum_ + weight.cwiseProduct(beta.cwiseAbs2() - c);
}

WhiteSize::Vector6 WhiteSize::variance() const {
  if (is_zero()) {
    return Vector6::Zero();
  }
  const Vector6 deviation = (2.0 * weight_.cwiseInverse()).cwiseSqrt();
  return sum_.cwiseQuotient(weight_).cwiseMax(0.0) + kConfidence * deviation;
}

}  // namespace limber
