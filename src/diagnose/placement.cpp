// SPDX-License-Identifier: MIT
#include "diagnose/placement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnose/directions.hpp"
#include "limber/core/angle.hpp"
#include "limber/core/factors.hpp"
#include "limber/core/median.hpp"
#include "limber/core/so3.hpp"
#include "limber/measure/triangulate.hpp"

namespace limber::detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kAgrees_px = 3.0;
constexpr double kTelling = 0.25;                    // share of all points
constexpr double kFewAgree = 0.5, kMostAgree = 0.8;  // of those that tell
constexpr double kTurned = 0.15;    // [rad], of a rig that has turned and of its baseline's direction
constexpr double kTurnPrior = 0.1;  // [rad]
constexpr double kMuchBetter = 0.5;
constexpr int kTurnSteps = 10;
constexpr double kTurnConverged = 1e-5;  // [rad]

struct Mistake {
  Pose T_cam1_cam0;  ///< without it
  std::string words;
  bool exchanged = false;  ///< each image, or its lens, is that of the other camera
};

/// Points as a rig sees them.
struct RigView {
  const std::vector<StereoBearings>& pairs;
  const Pose& T_cam1_cam0;
};

/// What may have been written instead of this rig.
std::vector<Mistake> possible_mistakes(const StereoCalibration& calibration) {
  const Pose given = pose_from_rig(calibration.theta);
  std::vector<Mistake> out = {
      {given.inverse(),
       "the two cameras are swapped (their images, or their calibrations), or T_cam1_cam0 is inverted"},
      {given.inverse(), "the two cameras are swapped (their images, or their calibrations)", true},
      {{given.R, -given.p}, "the baseline has the wrong sign"}};
  if (calibration.body == BodyFrame::kImu) {
    const Pose T_imu_cam0 = calibration.T_body_cam0;
    const Pose T_imu_cam1 = T_imu_cam0 * given.inverse();
    out.push_back({T_imu_cam1 * T_imu_cam0, "T_BS of cam1 is inverted" + std::string(kDirections)});
    out.push_back(
        {T_imu_cam1.inverse() * T_imu_cam0.inverse(), "T_BS of cam0 is inverted" + std::string(kDirections)});
    out.push_back(
        {T_imu_cam1 * T_imu_cam0.inverse(), "T_BS of both cameras is inverted" + std::string(kDirections)});
  }
  return out;
}

bool agrees(const StereoBearings& pair, const Pose& T_cam1_cam0, double focal_px) {
  if (std::abs(epipolar_error(pair, T_cam1_cam0)) * focal_px > kAgrees_px) {
    return false;
  }
  const Vector3d d0 = pair.cam0.normalized(), d1 = pair.cam1.normalized();
  const auto rho = inverse_depth_along(d0, d1, T_cam1_cam0);
  // Far points may lie a few pixels behind infinity.
  const double disparity_px = rho ? *rho * T_cam1_cam0.p.norm() * focal_px : 0.0;
  return disparity_px > -kAgrees_px && (T_cam1_cam0.R * d0).dot(d1) > 0.0;
}

/// What stereo points say of two rigs: those that agree with just one of them, or with neither.
struct Shares {
  double given = 0.0, other = 0.0;  ///< of these
  double telling = 0.0;             ///< they themselves, of all points
};

Shares compare_rigs(const RigView& given, const RigView& other, double focal_px) {
  double of_given = 0.0, of_other = 0.0, of_both = 0.0;
  for (std::size_t k = 0; k < given.pairs.size(); ++k) {
    const bool one = agrees(given.pairs[k], given.T_cam1_cam0, focal_px),
               two = agrees(other.pairs[k], other.T_cam1_cam0, focal_px);
    of_both += one && two ? 1.0 : 0.0;
    of_given += one && !two ? 1.0 : 0.0;
    of_other += two && !one ? 1.0 : 0.0;
  }
  const auto all = static_cast<double>(given.pairs.size());
  const double left = std::max(all - of_both, 1.0);
  return {of_given / left, of_other / left, left / all};
}

double turn_between(const Matrix3d& a, const Matrix3d& b) {
  return so3_log(Matrix3d(a * b.transpose())).norm();
}

/// The rig of the calibration, turned, agrees with as many points as without the mistake.
bool has_only_turned(const Pose& given, const Pose& without, const std::vector<StereoBearings>& pairs,
                     double focal_px) {
  const Pose refined = turned_by_lines(without, pairs, focal_px), turned{refined.R, -refined.p};
  if (turn_between(turned.R, given.R) > kTurned || angle_between(turned.p, given.p) > kTurned) {
    return false;
  }
  const Shares shares = compare_rigs({pairs, turned}, {pairs, refined}, focal_px);
  return shares.given >= shares.other;
}

double median_error(const std::vector<StereoBearings>& pairs, const Pose& T_cam1_cam0) {
  std::vector<double> errors;
  for (const StereoBearings& pair : pairs) {
    errors.push_back(std::abs(epipolar_error(pair, T_cam1_cam0)));
  }
  return upper_median(std::move(errors));
}

/// Points that went through each other's lens fit the lines of the calibration, as it is, much better than
/// the lines of any rig that has turned fit the points as they are.
bool lenses_are_exchanged(const Pose& given, const StereoPairs& pairs, double focal_px) {
  const Pose turned = turned_by_lines(given.inverse(), pairs.as_given, focal_px);
  return median_error(pairs.exchanged, given) < kMuchBetter * median_error(pairs.as_given, turned);
}

}  // namespace

StereoPairs stereo_pairs(const StereoCalibration& calibration, std::span<const StereoFrame> frames) {
  StereoPairs out;
  for (const StereoFrame& frame : frames) {
    for (const StereoObservation& o : frame.observations) {
      StereoObservation exchanged = o;
      std::swap(exchanged.uv_cam0, exchanged.uv_cam1);
      const auto pair = bearings(calibration, o), other = bearings(calibration, exchanged);
      if (pair && other) {
        out.as_given.push_back(*pair);
        out.exchanged.push_back(*other);
      }
    }
  }
  return out;
}

Pose turned_by_lines(Pose T_cam1_cam0, const std::vector<StereoBearings>& pairs, double focal_px) {
  for (int step = 0; step < kTurnSteps; ++step) {
    Matrix3d A = Matrix3d::Identity() / (kTurnPrior * kTurnPrior);
    Vector3d b = Vector3d::Zero();
    for (const StereoBearings& pair : pairs) {
      const double error = focal_px * epipolar_error(pair, T_cam1_cam0);
      const Vector3d slope = focal_px * epipolar_slope(pair, T_cam1_cam0).head<3>().transpose();
      const double weight = 1.0 / (1.0 + error * error);  // Cauchy's, of one pixel
      A += weight * slope * slope.transpose();
      b -= weight * error * slope;
    }
    const Vector3d turn = solve_symmetric(A, b);
    T_cam1_cam0.R = so3_normalized(so3_exp(turn) * T_cam1_cam0.R);
    if (turn.norm() < kTurnConverged) {
      break;
    }
  }
  return T_cam1_cam0;
}

std::optional<std::string> placement_mistake(const StereoCalibration& calibration, const StereoPairs& pairs) {
  if (pairs.as_given.size() < kEnoughStereo) {
    return std::nullopt;
  }
  const double focal_px = calibration.cam1.fu;
  const Pose given = pose_from_rig(calibration.theta);
  double best = kMostAgree;
  std::optional<std::string> words;
  for (const Mistake& mistake : possible_mistakes(calibration)) {
    const RigView without =
        mistake.exchanged ? RigView{pairs.exchanged, given} : RigView{pairs.as_given, mistake.T_cam1_cam0};
    const Shares shares = compare_rigs({pairs.as_given, given}, without, focal_px);
    if (shares.telling >= kTelling && shares.given < kFewAgree && shares.other > best &&
        ((mistake.exchanged && lenses_are_exchanged(given, pairs, focal_px)) ||
         !has_only_turned(given, mistake.T_cam1_cam0, pairs.as_given, focal_px))) {
      best = shares.other;
      words = fmt::format(
          "{}: {:.0f} % of the stereo points that tell agree with the calibration, {:.0f} % would without",
          mistake.words, 100.0 * shares.given, 100.0 * shares.other);
    }
  }
  return words;
}

}  // namespace limber::detail
