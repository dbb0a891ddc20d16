// SPDX-License-Identifier: MIT
#include "limber/landmarks/landmark_initialization.hpp"
#include "limber/core/factors.hpp"

#include <gtest/gtest.h>

#include "check_covariance.hpp"
#include "landmarks/pinhole_at_the_body.hpp"
#include "limber/core/so3.hpp"
#include "state/small_map.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::Generator;
using testing::Snapshot;
using testing::snapshot;

constexpr std::int64_t kNow = 123;

StereoCalibration calibration(BodyFrame body = BodyFrame::kImu) {
  StereoCalibration out;
  out.cam0 = {455.0, 450.0, 376.0, 240.0, 752, 480, RadialTangential{-0.28, 0.0, 2e-4, 2e-5}};
  out.cam1 = {460.0, 458.0, 370.0, 250.0, 752, 480, NoDistortion{}};
  out.theta << 0.01, -0.02, 0.005, -0.3, 0.003, -0.006;
  out.body = body;
  out.T_body_cam0 = {so3_exp(Vector3d(-1.2, 1.2, -1.2)), Vector3d(0.05, 0.02, -0.03)};
  return out;
}

/// What the rig sees of a point of the left camera.
StereoObservation seen(const StereoCalibration& rig, const Vector3d& X_cam0) {
  StereoObservation out;
  out.track_id = 7;
  out.uv_cam0 = project(rig.cam0, X_cam0)->uv;
  const auto right = project(rig.cam1, pose_from_rig(rig.theta) * X_cam0);
  out.in_cam1 = right.has_value();
  out.uv_cam1 = right ? right->uv : Vector2d::Zero();
  return out;
}

Vector3d in_cam0(const Estimate& estimate, const StereoCalibration& rig, const Landmark& landmark) {
  return (estimate.nav().T_world_body * body_from_cam0(rig)).inverse() * estimate.landmark_position(landmark);
}

/// A new landmark of a small map, on a new anchor if the kind needs one.
std::optional<RemainingRows> initialize(Estimate& estimate, const StereoObservation& observation,
                                        const StereoCalibration& rig, const LandmarkInitOptions& options) {
  const MountedRig mounted = mount(rig);
  const int anchor =
      options.kind == LandmarkKind::kInverseDepth ? estimate.add_anchor(mounted[0].T_cam_body.inverse()) : -1;
  const auto rows =
      initialize_landmark(estimate, observation, mounted, PixelNoise::Constant(0.5), kNow, anchor, options);
  estimate.drop_unused_anchor(anchor);
  return rows;
}

LandmarkInitOptions options_for(LandmarkInitMode mode, LandmarkKind kind) {
  LandmarkInitOptions options;
  options.mode = mode;
  options.kind = kind;
  return options;
}

std::vector<LandmarkInitOptions> all_options() {
  return {options_for(LandmarkInitMode::kClassical, LandmarkKind::kInverseDepth),
          options_for(LandmarkInitMode::kClassical, LandmarkKind::kCartesian),
          options_for(LandmarkInitMode::kDiffuse, LandmarkKind::kInverseDepth),
          options_for(LandmarkInitMode::kDiffuse, LandmarkKind::kCartesian)};
}

constexpr BodyFrame kBodies[] = {BodyFrame::kImu, BodyFrame::kCam0, BodyFrame::kMiddleOfBaseline};

TEST(InitializeLandmark, PutsAPerfectlySeenPointWhereItIs) {
  Generator generator(1);
  for (const BodyFrame body : kBodies) {
    const StereoCalibration rig = calibration(body);
    for (const LandmarkInitOptions& options : all_options()) {
      for (const Vector3d& X :
           {Vector3d(0.3, -0.2, 1.5), Vector3d(-1.0, 0.8, 6.0), Vector3d(5.0, 3.0, 40.0)}) {
        Estimate estimate = testing::random_map(generator, 5);
        ASSERT_TRUE(initialize(estimate, seen(rig, X), rig, options));
        const Landmark& landmark = *estimate.find(7);
        EXPECT_EQ(landmark.kind, options.kind);
        EXPECT_EQ(landmark.last_seen_ns, kNow);
        EXPECT_LE((in_cam0(estimate, rig, landmark) - X).norm(), 1e-6 * X.squaredNorm());
      }
    }
  }
}

TEST(InitializeLandmark, ChangesNothingElseAndKeepsTheCovariancePositiveDefinite) {
  Generator generator(2);
  for (const StateLayout layout :
       {StateLayout{MotionModel::kImu, false}, StateLayout{MotionModel::kImu, true}}) {
    for (const LandmarkInitOptions& options : all_options()) {
      Estimate estimate = testing::random_map(generator, 5, layout);
      const Snapshot before = snapshot(estimate);
      const StereoCalibration rig = calibration();
      ASSERT_TRUE(initialize(estimate, seen(rig, {0.5, 0.2, 4.0}), rig, options));
      EXPECT_EQ(snapshot(estimate, {7}), before);
      EXPECT_TRUE(Cholesky(estimate.P().dense()).succeeded());
    }
  }
}

TEST(InitializeLandmark, SaysWhichRowsAreStillToBeUsed) {
  Generator generator(3);
  const auto rows = [&](BodyFrame body, const LandmarkInitOptions& options, bool right) {
    Estimate estimate = testing::random_estimate(generator);
    const StereoCalibration rig = calibration(body);
    StereoObservation observation = seen(rig, {0.5, 0.2, 4.0});
    observation.in_cam1 = right;
    return initialize(estimate, observation, rig, options);
  };
  const auto classical = options_for(LandmarkInitMode::kClassical, LandmarkKind::kInverseDepth);
  const auto diffuse = options_for(LandmarkInitMode::kDiffuse, LandmarkKind::kInverseDepth);
  EXPECT_EQ(rows(BodyFrame::kImu, classical, true), RemainingRows::kNone);
  EXPECT_EQ(rows(BodyFrame::kImu, diffuse, true), RemainingRows::kRight);
  EXPECT_EQ(rows(BodyFrame::kCam0, diffuse, true), RemainingRows::kRight);
  EXPECT_EQ(rows(BodyFrame::kMiddleOfBaseline, diffuse, true), RemainingRows::kAll);
  EXPECT_EQ(rows(BodyFrame::kImu, diffuse, false), RemainingRows::kNone);
  EXPECT_EQ(rows(BodyFrame::kImu, options_for(LandmarkInitMode::kDiffuse, LandmarkKind::kCartesian), true),
            RemainingRows::kAll);
  EXPECT_EQ(rows(BodyFrame::kImu, options_for(LandmarkInitMode::kClassical, LandmarkKind::kCartesian), true),
            RemainingRows::kNone);
}

/// The initialisation must refuse, and leave no trace.
void expect_refusal(Generator& generator, const StereoObservation& observation,
                    const LandmarkInitOptions& options, const char* why) {
  Estimate estimate = testing::random_map(generator, 5);
  const Snapshot before = snapshot(estimate);
  const Index size = estimate.size();
  EXPECT_FALSE(initialize(estimate, observation, calibration(), options)) << why;
  EXPECT_EQ(snapshot(estimate), before) << why;
  EXPECT_EQ(estimate.size(), size) << why;
  EXPECT_EQ(estimate.find(observation.track_id), nullptr) << why;
}

TEST(InitializeLandmark, RefusesWhatItCannotPlaceAndLeavesTheEstimateAsItWas) {
  Generator generator(4);
  for (const LandmarkInitOptions& options : all_options()) {
    StereoObservation right_only = seen(calibration(), {0.5, 0.2, 4.0});
    right_only.in_cam0 = false;
    expect_refusal(generator, right_only, options, "no left pixel");
    StereoObservation outside = seen(calibration(), {0.5, 0.2, 4.0});
    outside.uv_cam0 << 1e5, 1e5;
    expect_refusal(generator, outside, options, "outside the model");
    if (options.kind == LandmarkKind::kCartesian) {
      StereoObservation left_only = seen(calibration(), {0.5, 0.2, 4.0});
      left_only.in_cam1 = false;
      expect_refusal(generator, left_only, options, "no depth");
    }
  }
}

TEST(InitializeLandmark, PointsAtAndBeyondInfinityBeginFarAway) {
  Generator generator(5);
  for (const LandmarkInitMode mode : {LandmarkInitMode::kClassical, LandmarkInitMode::kDiffuse}) {
    for (const double disparity_error : {0.0, 3.0}) {
      Estimate estimate = testing::random_map(generator, 5);
      const StereoCalibration rig = calibration();
      StereoObservation observation = seen(rig, {1e4, -2e3, 1e5});
      observation.uv_cam1.x() += disparity_error;  // the rays part behind the rig
      ASSERT_TRUE(initialize(estimate, observation, rig, options_for(mode, LandmarkKind::kInverseDepth)));
      const Landmark& landmark = *estimate.find(7);
      EXPECT_TRUE(landmark.value.allFinite());
      EXPECT_LE(landmark.value.z(), 1.0 / 100.0);
      const double sigma_rho = std::sqrt(estimate.P().diagonal_block<3>(landmark.at)(2, 2));
      EXPECT_GE(sigma_rho, 0.003) << "one pixel is 1 / (f b) = 0.007 in inverse depth";
      EXPECT_TRUE(Cholesky(estimate.P().dense()).succeeded());
    }
  }
}

TEST(InitializeLandmark, SeenByTheLeftCameraAloneItsDepthIsThePrior) {
  Generator generator(6);
  for (const LandmarkInitMode mode : {LandmarkInitMode::kClassical, LandmarkInitMode::kDiffuse}) {
    Estimate estimate = testing::random_map(generator, 5);
    LandmarkInitOptions options = options_for(mode, LandmarkKind::kInverseDepth);
    options.mono_inverse_depth = 0.2;
    options.mono_inverse_depth_sigma = 0.3;
    const StereoCalibration rig = calibration();
    StereoObservation observation = seen(rig, {0.5, 0.2, 4.0});
    observation.in_cam1 = false;
    ASSERT_TRUE(initialize(estimate, observation, rig, options));
    const Landmark& landmark = *estimate.find(7);
    EXPECT_TRUE(landmark.depth_guessed);
    EXPECT_EQ(landmark.value, Vector3d(0.0, 0.0, 0.2));
    const Matrix3d P = estimate.P().diagonal_block<3>(landmark.at);
    EXPECT_NEAR(P(2, 2), 0.09, 1e-12);
    EXPECT_NEAR(P(2, 0), 0.0, 1e-15);
    // Half a pixel, near the axis of a camera with f = 455.
    EXPECT_NEAR(std::sqrt(P(0, 0)), 0.5 / 455.0, 0.1 * 0.5 / 455.0);
    const Vector3d ray = in_cam0(estimate, rig, landmark).normalized();
    EXPECT_LE((ray - Vector3d(0.5, 0.2, 4.0).normalized()).norm(), 1e-9);
  }
}

TEST(GuessDepthAsInMap, IsTheMedianOfWhatIsKnownAndWasSeenAndWide) {
  Estimate estimate = testing::empty_map();
  const MountedCamera cam0 = testing::pinhole_at_the_body();
  const LandmarkInitOptions before = options_for(LandmarkInitMode::kClassical, LandmarkKind::kInverseDepth);
  std::int64_t id = 0;
  const auto add = [&](double depth, double share, std::int64_t seen_ns) {
    testing::add_landmark_ahead(estimate, id++, depth, share / depth, seen_ns);
  };
  for (const double depth : {10.0, 20.0, 25.0, 40.0}) {
    add(depth, 0.01, 100);
  }
  add(2.0, 0.5, 100);  // not known
  add(3.0, 0.01, 99);  // not seen
  LandmarkInitOptions options = before;
  guess_depth_as_in_map(estimate, cam0, 100, options);
  EXPECT_EQ(options.mono_inverse_depth, before.mono_inverse_depth) << "four tell nothing";
  add(50.0, 0.01, 100);
  guess_depth_as_in_map(estimate, cam0, 100, options);
  EXPECT_NEAR(options.mono_inverse_depth, 1.0 / 25.0, 1e-12);
  EXPECT_NEAR(options.mono_inverse_depth_sigma, 4.0 / 25.0, 1e-12);
  // From where it is now, not from where they began.
  testing::move_body(estimate, [](NavigationState& nav) { nav.T_world_body.p.z() = 5.0; });
  guess_depth_as_in_map(estimate, cam0, 100, options);
  EXPECT_NEAR(options.mono_inverse_depth, 1.0 / 20.0, 1e-12);
}

TEST(InitializeLandmark, DiffuselyInitializedPointsKnowNothingOfTheOthersButTheirAnchor) {
  Generator generator(7);
  for (const LandmarkKind kind : {LandmarkKind::kInverseDepth, LandmarkKind::kCartesian}) {
    Estimate estimate = testing::random_map(generator, 5);
    const StereoCalibration rig = calibration();
    LandmarkInitOptions options = options_for(LandmarkInitMode::kDiffuse, kind);
    options.inverse_depth_sigma_baselines = 0.7;
    options.cartesian_sigma = 500.0;
    ASSERT_TRUE(initialize(estimate, seen(rig, {0.5, 0.2, 4.0}), rig, options));
    const Landmark& landmark = *estimate.find(7);
    MatrixXd column;
    estimate.P().gather(std::vector<Index>{landmark.at}, column);
    column.middleRows<3>(landmark.at).setZero();
    EXPECT_TRUE(column.isZero(0.0));
    const Matrix3d P = estimate.P().diagonal_block<3>(landmark.at);
    if (kind == LandmarkKind::kCartesian) {
      EXPECT_LE((P - 500.0 * 500.0 * Matrix3d::Identity()).norm(), 1e-9);
    } else {
      EXPECT_NEAR(std::sqrt(P(2, 2)), 0.7 / rig.baseline(), 1e-12);
    }
  }
}

/// The joint error of pose, theta and landmark over many initialisations from disturbed poses, rigs and
/// pixels.
struct Disturbed {
  Estimate estimate;
  VectorXd error;  // pose, theta, landmark position
};

Disturbed initialize_disturbed(Generator& generator, const StateLayout& layout,
                               const StereoCalibration& truth, const NavigationState& nav,
                               const MatrixXd& P_body, const MatrixXd& P_theta, const Vector3d& X_cam0,
                               const PixelNoise& sigma_px, LandmarkKind kind) {
  VectorXd error = VectorXd::Zero(15);
  const VectorXd e_body = Cholesky(P_body).L() * testing::random_normal(generator, P_body.rows());
  const VectorXd e_theta = Cholesky(P_theta).L() * testing::random_normal(generator, 6);
  error.head<6>() = e_body.head<6>();
  NavigationState assumed_nav = nav;  // true = assumed ⊕ error
  assumed_nav.T_world_body.p -= e_body.segment<3>(0);
  assumed_nav.T_world_body.R = nav.T_world_body.R * so3_exp(-e_body.segment<3>(3));
  StereoCalibration assumed = truth;
  if (layout.has_theta) {
    error.segment<6>(6) = e_theta;
    assumed.theta -= e_theta;
  }
  Estimate estimate(layout, assumed_nav, P_body, assumed.theta, P_theta);
  const MountedRig rig = mount(assumed);
  const int anchor =
      kind == LandmarkKind::kInverseDepth ? estimate.add_anchor(rig[0].T_cam_body.inverse()) : -1;
  StereoObservation observation = seen(truth, X_cam0);
  observation.uv_cam0 += sigma_px.head<2>().cwiseProduct(testing::random_normal(generator, 2));
  observation.uv_cam1 += sigma_px.tail<2>().cwiseProduct(testing::random_normal(generator, 2));
  EXPECT_TRUE(initialize_landmark(estimate, observation, rig, sigma_px, kNow, anchor,
                                  options_for(LandmarkInitMode::kClassical, kind)));
  const Vector3d p_true = nav.T_world_body * (body_from_cam0(truth) * X_cam0);
  if (kind == LandmarkKind::kInverseDepth) {
    estimate.convert_to_cartesian(*estimate.find(7));
  }
  error.tail<3>() = p_true - estimate.find(7)->value;
  return {std::move(estimate), error};
}

TEST(InitializeLandmark, ClassicallyHasTheCovarianceOfManyDisturbedOnes) {
  Generator generator(8);
  const PixelNoise sigma_px(0.05, 0.08, 0.06, 0.04);
  const Vector3d X_cam0(0.4, -0.3, 2.5);
  for (const BodyFrame body : {BodyFrame::kImu, BodyFrame::kMiddleOfBaseline}) {
    for (const LandmarkKind kind : {LandmarkKind::kInverseDepth, LandmarkKind::kCartesian}) {
      for (const bool has_theta : {false, true}) {
        if (body == BodyFrame::kMiddleOfBaseline && !has_theta) {
          continue;  // with theta exact this is the case of the IMU body
        }
        const StateLayout layout{MotionModel::kOdometry, has_theta};
        const StereoCalibration truth = calibration(body);
        NavigationState nav;
        nav.T_world_body = testing::random_pose(generator, 3.0);
        const MatrixXd P_body = testing::random_positive_definite(generator, 6, 1e-3);
        const MatrixXd P_theta = testing::random_positive_definite(generator, 6, 3e-4);
        testing::SampleCovariance errors(has_theta ? 15 : 9);
        MatrixXd P;
        for (int run = 0; run < 4000; ++run) {
          const Disturbed d =
              initialize_disturbed(generator, layout, truth, nav, P_body, P_theta, X_cam0, sigma_px, kind);
          VectorXd error(has_theta ? 15 : 9);
          error << (has_theta ? VectorXd(d.error.head<12>()) : VectorXd(d.error.head<6>())),
              d.error.tail<3>();
          errors.add(error);
          if (run == 0) {
            P = snapshot(d.estimate).P;
          }
        }
        SCOPED_TRACE(::testing::Message() << "theta " << has_theta);
        errors.expect(P, 0.02);
      }
    }
  }
}

}  // namespace
}  // namespace limber
