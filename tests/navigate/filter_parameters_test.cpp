// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <string>

#include "check_covariance.hpp"
#include "limber/core/chi_square.hpp"
#include "limber/core/factors.hpp"
#include "limber/navigate/stereo_filter.hpp"
#include "scene.hpp"

/// Parameters beyond theta, estimated, constrained or softened: seeded runs of three seconds each.
namespace limber {
namespace {

using Eigen::VectorXd;
using testing::Generator;
using testing::make_scene;
using testing::pose_error;
using testing::run;
using testing::Scene;
using testing::SceneOptions;
using testing::with_method;

Scene exact_scene(std::uint64_t seed) {
  SceneOptions options;
  options.seed = seed;
  return make_scene(options);
}

/// Three tenths of a plausible error of each that is named.
ParameterVector small_sigma(const std::vector<std::string>& names, const StereoCalibration& calibration) {
  ParameterVector out = ParameterVector::Zero();
  for (const std::string& name : names) {
    const ParameterSet set = parameters_named(name).value();
    for (std::size_t k = 0; k < set.size(); ++k) {
      if (set[k]) {
        out(static_cast<Eigen::Index>(k)) = 0.3 * plausible_errors(calibration)(static_cast<Eigen::Index>(k));
      }
    }
  }
  return out;
}

double nees(const VectorXd& error, const Eigen::MatrixXd& covariance) {
  return error.dot(Cholesky(covariance).solve(error));
}

struct Outcome {
  double pose = 0.0;        ///< NEES at the end
  double parameters = 0.0;  ///< NEES at the end, of all that are estimated
  VectorXd sigma;           ///< of those, at the end
};

/// Runs with a calibration that is off by a draw from what the filter expects.
Outcome estimate_parameters(const Scene& exact, Method method, const ParameterVector& sigma,
                            std::uint64_t seed) {
  Generator generator(1000 + seed);
  const ParameterVector error =
      sigma.cwiseProduct(ParameterVector(testing::random_normal(generator, kParameters)));
  Scene scene = exact;
  scene.calibration = corrected(scene.calibration, error);
  NavigatorOptions options = with_method(scene, method);
  options.estimated = sigma;
  Outcome out;
  run(scene, options, [&](StereoFilter& navigator, std::size_t k, const FrameReport&) {
    if (k + 1 < scene.frames.size()) {
      return;
    }
    const Estimate& estimate = navigator.estimate();
    const CalibrationEstimate found = navigator.calibration_estimate();
    EXPECT_EQ(found.parameters, parameters_of(sigma));
    std::vector<Eigen::Index> members, places;
    for (Eigen::Index p = kBlockSize; p < kParameters; ++p) {
      if (found.parameters[static_cast<std::size_t>(p)]) {
        members.push_back(p);
        places.push_back(estimate.layout().more(static_cast<std::size_t>(p / kBlockSize) - 1) +
                         p % kBlockSize);
      }
    }
    out.pose = nees(pose_error(navigator, scene.truth[k]), estimate.P().diagonal_block<6>(0));
    out.parameters = nees((found.error + error)(members), estimate.P().dense()(places, places));
    out.sigma = found.sigma(members).cwiseQuotient(sigma(members));
  });
  return out;
}

struct Estimated {
  std::vector<std::string> names;
  double least_gain;  ///< the best known of them is at least that much better known at the end
};

void expect_found(std::uint64_t runs) {
  const std::vector<Estimated> all = {{{"dt0", "dt1"}, 1.5},
                                      {{"intrinsics1"}, 5.0},
                                      {{"intrinsics0", "intrinsics1"}, 5.0},
                                      {{"imu"}, 1.2},
                                      {{"imu", "dt0", "dt1", "cu1"}, 2.0}};
  for (const Method method : {Method::kEkf, Method::kLcekf}) {
    for (const auto& [names, least_gain] : all) {
      SCOPED_TRACE(to_string(method) + ", " + names.front() + " and so on");
      double pose = 0.0, parameters = 0.0, gain = 0.0;
      Eigen::Index count = 0;
      for (std::uint64_t seed = 1; seed <= runs; ++seed) {
        const Scene scene = exact_scene(seed);
        const Outcome one = estimate_parameters(scene, method, small_sigma(names, scene.calibration), seed);
        pose += one.pose;
        parameters += one.parameters;
        gain = std::max(gain, 1.0 / one.sigma.minCoeff());
        count = one.sigma.size();
      }
      const double n = static_cast<double>(runs), dof = n * static_cast<double>(count);
      EXPECT_GE(pose, chi_square_quantile(1e-6, 6.0 * n));
      EXPECT_LE(pose, chi_square_quantile(1.0 - 1e-6, 6.0 * n));
      EXPECT_GE(parameters, chi_square_quantile(1e-6, dof));
      EXPECT_LE(parameters, chi_square_quantile(1.0 - 1e-6, dof));
      if (method == Method::kEkf) {
        EXPECT_GE(gain, least_gain);
      }
    }
  }
}

TEST(NavigatorParameters, WhatIsEstimatedIsFoundAndKnowsHowWell) { expect_found(3); }

TEST(FullNavigatorParameters, WhatIsEstimatedIsFoundAndKnowsHowWell) { expect_found(12); }

/// The principal point of the right camera jumps in every frame by `sigma` [px].
Scene wavering_scene(std::uint64_t seed, double sigma) {
  Scene scene = exact_scene(seed);
  Generator generator(2000 + seed);
  for (StereoFrame& frame : scene.frames) {
    const double jump = sigma * testing::random_normal(generator, 1)(0);
    for (StereoObservation& point : frame.observations) {
      point.uv_cam1.x() += jump;
    }
  }
  return scene;
}

constexpr double kJumpPx = 10.0;

double sum_of_end_nees(std::uint64_t runs, Method method, const std::string& constraints,
                       double softened_px) {
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const Scene scene = wavering_scene(seed, kJumpPx);
    NavigatorOptions options = with_method(scene, method);
    options.constraints = constraint_set_from_string(constraints);
    options.softened(first_of(ParameterBlock::kCam1) + 2) = softened_px;
    run(scene, options, [&](StereoFilter& navigator, std::size_t k, const FrameReport&) {
      if (k + 1 == scene.frames.size()) {
        sum += nees(pose_error(navigator, scene.truth[k]), navigator.estimate().P().diagonal_block<6>(0));
      }
    });
  }
  return sum;
}

void expect_harmless(std::uint64_t runs) {
  const double dof = 6.0 * static_cast<double>(runs);
  const double high = chi_square_quantile(1.0 - 1e-6, dof), low = chi_square_quantile(1e-6, dof);
  const double constrained = sum_of_end_nees(runs, Method::kLcekf, "cu1", 0.0);
  EXPECT_GE(constrained, low);
  EXPECT_LE(constrained, high);
  const double both = sum_of_end_nees(runs, Method::kLcekf, "full,cu1", 0.0);
  EXPECT_GE(both, low);
  EXPECT_LE(both, high);
  const double softened = sum_of_end_nees(runs, Method::kEkf, "full", kJumpPx);
  EXPECT_GE(softened, low);
  EXPECT_LE(softened, high);
  EXPECT_GE(sum_of_end_nees(runs, Method::kEkf, "full", 0.0), 3.0 * high);
}

TEST(NavigatorParameters, WhatWaversIsHarmlessWhereItIsConstrainedOrSoftened) { expect_harmless(4); }

TEST(FullNavigatorParameters, WhatWaversIsHarmlessWhereItIsConstrainedOrSoftened) { expect_harmless(12); }

TEST(NavigatorParameters, TheMonitorJudgesThetaWhateverElseIsConstrained) {
  const Scene scene = wavering_scene(1, 3.0);
  const auto alarms = [&](const std::string& constraints) {
    NavigatorOptions options = with_method(scene, Method::kLcekf);
    options.constraints = constraint_set_from_string(constraints);
    options.health.emplace();
    int count = 0, watched = 0;
    run(scene, options, [&](StereoFilter&, std::size_t, const FrameReport& report) {
      count += report.health && report.health->alarm ? 1 : 0;
      watched += report.health ? 1 : 0;
    });
    EXPECT_GE(watched, 50);
    return count;
  };
  EXPECT_GT(alarms("full"), 0);
  EXPECT_EQ(alarms("full,cu1"), 0);
  EXPECT_EQ(alarms("cu1"), 0);
}

}  // namespace
}  // namespace limber
