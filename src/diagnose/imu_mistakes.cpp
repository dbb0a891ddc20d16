// SPDX-License-Identifier: MIT
#include "limber/diagnose/imu_mistakes.hpp"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "diagnose/accelerometer_mistake.hpp"
#include "diagnose/directions.hpp"
#include "diagnose/gyro_attitude.hpp"
#include "diagnose/left_turn.hpp"
#include "limber/core/angle.hpp"
#include "limber/core/median.hpp"
#include "limber/core/so3.hpp"

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kUnitRange = 0.3;       // of an accelerometer's length about what is expected
constexpr double kWithoutGravity = 0.4;  // of its length
constexpr std::size_t kFewestTurns = 50;
constexpr double kLeastTurning = 0.01;  // median of the camera's rate, less its mean [rad/s]
constexpr double kLittle = 0.5, kMost = 0.8, kAsGood = 0.03;  // shares of the camera's turning

/// Rates of the left camera (cam0 frame) and of the gyro (IMU frame) at the same times, without their means.
struct Rates {
  std::vector<Vector3d> camera, gyro;
};

void centre(std::vector<Vector3d>& rates) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& rate : rates) {
    mean += rate / static_cast<double>(rates.size());
  }
  for (Vector3d& rate : rates) {
    rate -= mean;
  }
}

Rates rates_of(const StereoCalibration& calibration, std::span<const StereoFrame> frames,
               std::span<const ImuSample> imu) {
  Rates out;
  const detail::GyroAttitude gyro(imu);
  const Matrix3d R_cam0_body = calibration.T_body_cam0.R.transpose();
  for (const detail::Turn& turn : detail::left_turns(calibration, frames, imu.front().t_ns)) {
    if (const auto mean = gyro.mean_samples(turn.begin_s, turn.end_s)) {
      out.camera.emplace_back(R_cam0_body * turn.rate);
      out.gyro.push_back(*mean);
    }
  }
  centre(out.camera);
  centre(out.gyro);
  return out;
}

double usual_rate(const std::vector<Vector3d>& rates) {
  std::vector<double> lengths;
  for (const Vector3d& rate : rates) {
    lengths.push_back(rate.norm());
  }
  return upper_median(std::move(lengths));
}

/// Share of the camera's turning that M times the gyro explains, by medians: 1 is all of it; below 0 it is
/// worse than nothing.
double explained(const Rates& rates, const Matrix3d& M) {
  std::vector<Vector3d> left;
  for (std::size_t k = 0; k < rates.camera.size(); ++k) {
    left.emplace_back(rates.camera[k] - M * rates.gyro[k]);
  }
  return 1.0 - usual_rate(left) / usual_rate(rates.camera);
}

/// The orthogonal matrix (a rotation if it is proper) times the factor that explains most.
struct BestMount {
  Matrix3d proper, improper;
};

BestMount best_mount(const Rates& rates) {
  Matrix3d H = Matrix3d::Zero();
  for (std::size_t k = 0; k < rates.camera.size(); ++k) {
    H += rates.camera[k].normalized() * rates.gyro[k].transpose();  // one that is far off must not decide
  }
  const Eigen::JacobiSVD<Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  const auto with = [&](double last) {
    return Matrix3d(svd.matrixU() * Vector3d(1.0, 1.0, last).asDiagonal() * svd.matrixV().transpose());
  };
  return {with(sign), with(-sign)};
}

std::string shares(double given, double without) {
  return fmt::format("the gyro explains {:.0f} % of how the left camera turned, {:.0f} % without the mistake",
                     100.0 * std::max(0.0, given), 100.0 * without);
}

struct Candidate {
  Matrix3d M;
  std::string words;
};

std::vector<Candidate> candidates(const Matrix3d& R_cam0_imu, const BestMount& best) {
  const double unit = 1.0 / kToDegrees;
  const Vector3d off = so3_log(Matrix3d(R_cam0_imu * best.proper.transpose()));
  const Vector3d axis = off.stableNormalized();
  return {
      {unit * R_cam0_imu, "the gyro's rates are in deg/s instead of rad/s"},
      {R_cam0_imu.transpose(), "T_BS of cam0 is inverted" + std::string(kDirections)},
      {best.proper, fmt::format("T_BS of cam0 does not fit the IMU's axes: it is turned by {:.0f} deg about "
                                "({:.2f}, {:.2f}, {:.2f}) of cam0",
                                off.norm() * kToDegrees, axis.x(), axis.y(), axis.z())},
      {best.improper, "an axis of the gyro has the wrong sign, or two of them are swapped"}};
}

/// Share that the gyro explains as it is; nothing where the body hardly turns.
std::optional<double> explained_as_given(const StereoCalibration& calibration, const Rates& rates) {
  if (rates.camera.size() < kFewestTurns || usual_rate(rates.camera) < kLeastTurning) {
    return std::nullopt;
  }
  return explained(rates, calibration.T_body_cam0.R.transpose());
}

std::optional<std::string> turning_mistake(const StereoCalibration& calibration, const Rates& rates,
                                           double given) {
  const Matrix3d R_cam0_imu = calibration.T_body_cam0.R.transpose();
  const std::vector<Candidate> all = candidates(R_cam0_imu, best_mount(rates));
  std::vector<double> of_each;
  for (const Candidate& candidate : all) {
    of_each.push_back(explained(rates, candidate.M));
  }
  const double best = *std::ranges::max_element(of_each);
  if (best < kMost) {
    return std::nullopt;
  }
  // Of those that explain as much, what is most common comes first: turns about one axis fit many mounts.
  const auto first = std::ranges::find_if(of_each, [&](double share) { return share > best - kAsGood; });
  return all[static_cast<std::size_t>(first - of_each.begin())].words + ": " + shares(given, *first);
}

std::optional<std::string> unit_mistake(std::span<const ImuSample> imu, double gravity) {
  std::vector<double> lengths;
  lengths.reserve(imu.size());
  for (const ImuSample& sample : imu) {
    lengths.push_back(sample.accel_imu.norm());
  }
  const double usual = upper_median(lengths);
  const auto is_near = [](double length, double expected) {
    return std::abs(length - expected) <= kUnitRange * expected;
  };
  if (is_near(usual, gravity)) {
    return std::nullopt;
  }
  const std::string length = fmt::format(": its length is {:.2f}, expected about {:.2f}", usual, gravity);
  for (double& one : lengths) {
    one = std::abs(one - usual);
  }
  const bool holds_gravity = upper_median(std::move(lengths)) < kUnitRange * usual;
  if (is_near(usual, 1.0) && holds_gravity) {
    return "the accelerometer is in g instead of m/s^2" + length;
  }
  if (usual < kWithoutGravity * gravity) {
    return "the accelerometer's samples are without gravity (\"linear acceleration\"), which belongs to "
           "them" +
           length;
  }
  return std::nullopt;
}

}  // namespace

std::vector<std::string> imu_mistakes(const StereoCalibration& calibration,
                                      std::span<const StereoFrame> frames, std::span<const ImuSample> imu,
                                      double gravity) {
  std::vector<std::string> out;
  if (calibration.body != BodyFrame::kImu || imu.size() < 2) {
    return out;
  }
  const auto add = [&out](std::optional<std::string> words) {
    if (words) {
      out.push_back(*std::move(words));
    }
  };
  add(unit_mistake(imu, gravity));
  const Rates rates = rates_of(calibration, frames, imu);
  const auto given = explained_as_given(calibration, rates);
  if (given && *given < kLittle) {
    add(turning_mistake(calibration, rates, *given));
  } else if (out.empty()) {  // what turns by a wrong gyro says nothing
    add(detail::accelerometer_mistake(calibration, frames, imu));
  }
  return out;
}

}  // namespace limber
