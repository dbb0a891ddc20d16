// SPDX-License-Identifier: MIT
#include "limber/sensors/camera.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "cameras.hpp"
#include "check_jacobian.hpp"
#include "random_geometry.hpp"

namespace limber {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::Generator;

/// Pixels at the centre, next to it, at the border and anywhere in the image.
std::vector<Vector2d> pixels_of(const Camera& camera) {
  const double right = camera.width - 1.0;
  const double bottom = camera.height - 1.0;
  std::vector<Vector2d> pixels = {{camera.cu, camera.cv},
                                  {camera.cu + 1e-8, camera.cv},
                                  {camera.cu, camera.cv - 1e-6},
                                  {0.0, camera.cv},
                                  {right, camera.cv},
                                  {camera.cu, 0.0},
                                  {camera.cu, bottom},
                                  {0.0, 0.0},
                                  {right, 0.0},
                                  {0.0, bottom},
                                  {right, bottom}};
  Generator generator(1);
  for (int k = 0; k < 200; ++k) {
    const double u = testing::random_scalar(generator, 0.0, right);
    pixels.emplace_back(u, testing::random_scalar(generator, 0.0, bottom));
  }
  return pixels;
}

/// Angle between two unit vectors [rad], exact for small angles.
double angle_between(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

TEST(Camera, PinholeProjectsAsThePaperWritesIt) {
  // Eq. (23)-(24): u = fu X/Z + cu, v = fv Y/Z + cv.
  const auto projection = project(testing::paper_camera(), {1.0, -2.0, 10.0});
  ASSERT_TRUE(projection);
  EXPECT_NEAR(projection->uv.x(), 270.0, 1e-12);
  EXPECT_NEAR(projection->uv.y(), 260.0, 1e-12);
}

TEST(Camera, RadialTangentialProjectsAsOpenCvWritesIt) {
  // x = 0.1, y = -0.2, r2 = 0.05, radial = 1 + 0.1 * 0.05 - 0.2 * 0.0025 = 1.0045;
  // x' = 0.1 * 1.0045 + 2 * 0.01 * (-0.02) + 0.02 * (0.05 + 2 * 0.01) = 0.10145,
  // y' = -0.2 * 1.0045 + 0.01 * (0.05 + 2 * 0.04) + 2 * 0.02 * (-0.02) = -0.2004.
  const Camera camera{100.0, 200.0, 50.0, 60.0, 100, 120, RadialTangential{0.1, -0.2, 0.01, 0.02}};
  const auto projection = project(camera, {0.3, -0.6, 3.0});
  ASSERT_TRUE(projection);
  EXPECT_NEAR(projection->uv.x(), 50.0 + 100.0 * 0.10145, 1e-12);
  EXPECT_NEAR(projection->uv.y(), 60.0 - 200.0 * 0.2004, 1e-12);
}

TEST(Camera, EquidistantWithoutCoefficientsIsLinearInTheAngle) {
  const Camera camera{100.0, 100.0, 50.0, 50.0, 100, 100, Equidistant{}};
  const double theta = 1.2;
  const auto projection = project(camera, {std::sin(theta), 0.0, std::cos(theta)});
  ASSERT_TRUE(projection);
  EXPECT_NEAR(projection->uv.x(), 50.0 + 100.0 * theta, 1e-12);
  EXPECT_NEAR(projection->uv.y(), 50.0, 1e-12);
}

TEST(Camera, EquidistantCoefficientsMultiplyOddPowersOfTheAngle) {
  const Camera camera{100.0, 100.0, 0.0, 0.0, 100, 100, Equidistant{0.1, -0.02, 0.003, -0.0004}};
  const double t = 0.5;
  const auto projection = project(camera, {0.0, 2.0 * std::sin(t), 2.0 * std::cos(t)});
  ASSERT_TRUE(projection);
  const double theta_d =
      t + 0.1 * std::pow(t, 3) - 0.02 * std::pow(t, 5) + 0.003 * std::pow(t, 7) - 0.0004 * std::pow(t, 9);
  EXPECT_NEAR(projection->uv.y(), 100.0 * theta_d, 1e-12);
}

TEST(Camera, OnlyTheBearingMattersNotTheRange) {
  for (const auto& [name, camera] : testing::all_cameras()) {
    const Vector3d X(0.3, -0.2, 1.0);
    const auto near = project(camera, X);
    const auto far = project(camera, 1e4 * X);
    ASSERT_TRUE(near && far) << name;
    EXPECT_LE((near->uv - far->uv).norm(), 1e-10) << name;
  }
}

TEST(Camera, ProjectUndoesUnprojectOverTheWholeImage) {
  for (const auto& [name, camera] : testing::all_cameras()) {
    for (const Vector2d& uv : pixels_of(camera)) {
      const auto bearing = unproject(camera, uv);
      ASSERT_TRUE(bearing) << name << " " << uv.transpose();
      EXPECT_NEAR(bearing->norm(), 1.0, 1e-14);
      const auto projection = project(camera, *bearing);
      ASSERT_TRUE(projection) << name << " " << uv.transpose();
      EXPECT_LE((projection->uv - uv).norm(), 1e-9) << name << " " << uv.transpose();
    }
  }
}

TEST(Camera, UnprojectUndoesProjectToANanoradian) {
  Generator generator(2);
  for (const auto& [name, camera] : testing::all_cameras()) {
    int seen = 0;
    for (int k = 0; k < 500; ++k) {
      const Vector3d bearing = testing::random_direction(generator);
      const auto projection = project(camera, bearing);
      if (!projection || !in_image(camera, projection->uv)) {
        continue;
      }
      ++seen;
      const auto back = unproject(camera, projection->uv);
      ASSERT_TRUE(back) << name << " " << bearing.transpose();
      EXPECT_LE(angle_between(*back, bearing), 1e-9) << name << " " << bearing.transpose();
    }
    EXPECT_GE(seen, 20) << name;
  }
}

TEST(Camera, JacobianMatchesCentralDifferences) {
  Generator generator(3);
  for (const auto& [name, camera] : testing::all_cameras()) {
    SCOPED_TRACE(name);
    for (const Vector2d& uv : pixels_of(camera)) {
      const auto bearing = unproject(camera, uv);
      ASSERT_TRUE(bearing);
      const Vector3d X = testing::random_scalar(generator, 1.0, 20.0) * *bearing;
      const auto projection = project(camera, X);
      ASSERT_TRUE(projection);
      testing::check_jacobian(
          projection->J_uv_X,
          [&, &camera = camera](const Eigen::VectorXd& d) {
            return Eigen::VectorXd(project(camera, X + Vector3d(d))->uv);
          },
          1e-7);
    }
  }
}

TEST(Camera, JacobianDoesNotMoveThePixelAlongTheRay) {
  for (const auto& [name, camera] : testing::all_cameras()) {
    for (const Vector2d& uv : pixels_of(camera)) {
      const auto bearing = unproject(camera, uv);
      ASSERT_TRUE(bearing);
      EXPECT_LE((project(camera, *bearing)->J_uv_X * *bearing).norm(), 1e-7) << name;
    }
  }
}

TEST(Camera, PointsBehindOrInThePinholeHaveNoPixel) {
  for (const Camera& camera :
       {testing::paper_camera(), testing::euroc_camera(), testing::rational_camera()}) {
    EXPECT_FALSE(project(camera, {0.1, 0.1, -1.0}));
    EXPECT_FALSE(project(camera, {0.1, 0.1, 0.0}));
    EXPECT_FALSE(project(camera, {0.0, 0.0, 0.0}));
  }
  for (const Camera& camera :
       {testing::tum_vi_camera(), testing::kalibr_omni_camera(), testing::kitti_360_camera()}) {
    EXPECT_FALSE(project(camera, {0.0, 0.0, 0.0}));
    EXPECT_FALSE(project(camera, {0.0, 0.0, -1.0}));
  }
}

TEST(Camera, NotANumberHasNoPixelAndNoBearing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const auto& [name, camera] : testing::all_cameras()) {
    EXPECT_FALSE(project(camera, {nan, 0.0, 1.0})) << name;
    EXPECT_FALSE(project(camera, {0.0, 0.0, nan})) << name;
    EXPECT_FALSE(unproject(camera, {nan, 0.0})) << name;
  }
}

TEST(Camera, FisheyeSeesBeyondNinetyDegrees) {
  const Camera camera = testing::tum_vi_camera();
  const Vector3d X(1.0, 0.0, -0.05);
  const auto projection = project(camera, X);
  ASSERT_TRUE(projection);
  const auto bearing = unproject(camera, projection->uv);
  ASSERT_TRUE(bearing);
  EXPECT_LE(angle_between(*bearing, X.normalized()), 1e-9);
}

TEST(Camera, RadialDistortionEndsWhereItFoldsBack) {
  // r (1 - 0.3 r^2) grows until r = 1 / sqrt(0.9) = 1.054, where it is 0.703.
  const Camera camera{100.0, 100.0, 0.0, 0.0, 200, 200, RadialTangential{-0.3, 0.0, 0.0, 0.0}};
  EXPECT_TRUE(project(camera, {1.05, 0.0, 1.0}));
  EXPECT_FALSE(project(camera, {1.06, 0.0, 1.0}));
  EXPECT_FALSE(project(camera, {0.8, 0.8, 1.0}));
  EXPECT_FALSE(project(camera, {3.0, 0.0, 1.0}));
  EXPECT_TRUE(unproject(camera, {70.0, 0.0}));
  EXPECT_FALSE(unproject(camera, {71.0, 0.0}));
}

TEST(Camera, RadialDistortionThatGrowsAgainStaysEndedWhereItFirstFolded) {
  // 1 + 3 k1 s + 5 k2 s^2 with s = r^2 is negative from s = 0.5 to s = 2 only.
  const Camera camera{100.0, 100.0, 0.0, 0.0, 200, 200, RadialTangential{-2.5 / 3.0, 0.2, 0.0, 0.0}};
  EXPECT_TRUE(project(camera, {0.7, 0.0, 1.0}));
  EXPECT_FALSE(project(camera, {1.0, 0.0, 1.0}));
  EXPECT_FALSE(project(camera, {1.5, 0.0, 1.0}));
}

TEST(Camera, FisheyeDistortionEndsWhereItFoldsBack) {
  // theta (1 - 0.2 theta^2) grows until theta = 1.291, where it is 0.861.
  const Camera camera{100.0, 100.0, 0.0, 0.0, 200, 200, Equidistant{-0.2, 0.0, 0.0, 0.0}};
  EXPECT_TRUE(project(camera, {std::sin(1.28), 0.0, std::cos(1.28)}));
  EXPECT_FALSE(project(camera, {std::sin(1.30), 0.0, std::cos(1.30)}));
  EXPECT_TRUE(unproject(camera, {86.0, 0.0}));
  EXPECT_FALSE(unproject(camera, {87.0, 0.0}));
}

TEST(Camera, FisheyeDistortionThatGrowsAgainStaysEndedWhereItFirstFolded) {
  // 1 + 3 k1 s + 5 k2 s^2 with s = theta^2 is negative from s = 1 to s = 2 only.
  const Camera camera{100.0, 100.0, 0.0, 0.0, 200, 200, Equidistant{-0.5, 0.1, 0.0, 0.0}};
  EXPECT_TRUE(project(camera, {std::sin(0.99), 0.0, std::cos(0.99)}));
  EXPECT_FALSE(project(camera, {std::sin(1.2), 0.0, std::cos(1.2)}));
  EXPECT_FALSE(project(camera, {std::sin(1.6), 0.0, std::cos(1.6)}));
}

TEST(Camera, EveryPixelWithABearingComesBackEvenFarOutsideTheImage) {
  Generator generator(4);
  std::vector<testing::NamedCamera> cameras = testing::all_cameras();
  cameras.push_back({"folding", {100.0, 100.0, 0.0, 0.0, 200, 200, RadialTangential{-0.3, 0.0, 0.0, 0.0}}});
  cameras.push_back(
      {"folding fisheye", {100.0, 100.0, 0.0, 0.0, 200, 200, Equidistant{-0.5, 0.1, 0.0, 0.0}}});
  cameras.push_back({"folding rational", {100.0, 100.0, 0.0, 0.0, 200, 200, Rational{.k3 = -0.2}}});
  for (const auto& [name, camera] : cameras) {
    for (int k = 0; k < 500; ++k) {
      const double u = testing::random_scalar(generator, -2000.0, 2000.0);
      const Vector2d uv(u, testing::random_scalar(generator, -2000.0, 2000.0));
      const auto bearing = unproject(camera, uv);
      if (!bearing) {
        continue;
      }
      const auto projection = project(camera, *bearing);
      ASSERT_TRUE(projection) << name << " " << uv.transpose();
      EXPECT_LE((projection->uv - uv).norm(), 1e-6) << name << " " << uv.transpose();
    }
  }
}

TEST(Camera, RationalDistortionEndsWhereItFoldsBack) {
  // r (1 - 0.2 r^6) grows until r^6 = 1 / 1.4, r = 0.9455, where it is 0.8104.
  const Camera camera{100.0, 100.0, 0.0, 0.0, 200, 200, Rational{.k3 = -0.2}};
  EXPECT_TRUE(project(camera, {0.94, 0.0, 1.0}));
  EXPECT_FALSE(project(camera, {0.95, 0.0, 1.0}));
  EXPECT_FALSE(project(camera, {5.0, 0.0, 1.0}));
  EXPECT_TRUE(unproject(camera, {81.0, 0.0}));
  EXPECT_FALSE(unproject(camera, {81.1, 0.0}));
}

TEST(Camera, RationalDistortionEndsAtThePoleOfItsDenominator) {
  // r / (1 - r^2) grows without end towards r = 1.
  const Camera camera{100.0, 100.0, 0.0, 0.0, 200, 200, Rational{.k4 = -1.0}};
  EXPECT_TRUE(project(camera, {0.99, 0.0, 1.0}));
  EXPECT_FALSE(project(camera, {1.0, 0.0, 1.0}));
  EXPECT_FALSE(project(camera, {1.5, 0.0, 1.0}));
  EXPECT_TRUE(unproject(camera, {1000.0, 0.0}));
}

TEST(Camera, RationalWithoutItsOwnCoefficientsIsRadialTangential) {
  Camera camera = testing::euroc_camera();
  const auto d = std::get<RadialTangential>(camera.distortion);
  const Vector3d X(0.4, -0.3, 1.1);
  const auto plain = project(camera, X);
  camera.distortion = Rational{.k1 = d.k1, .k2 = d.k2, .p1 = d.p1, .p2 = d.p2};
  const auto rational = project(camera, X);
  ASSERT_TRUE(plain && rational);
  EXPECT_LE((plain->uv - rational->uv).norm(), 1e-12);
  EXPECT_LE((plain->J_uv_X - rational->J_uv_X).norm(), 1e-10);
}

/// Mei's model with Kalibr's numbers: the unit sphere from xi behind it, then radtan, then Kalibr's focal
/// lengths.
Vector2d by_kalibrs_formula(const Camera& camera, const Vector3d& X) {
  const auto d = std::get<Omni>(camera.distortion);
  const Vector3d on_sphere = X / X.norm();
  const double x = on_sphere.x() / (on_sphere.z() + d.xi), y = on_sphere.y() / (on_sphere.z() + d.xi);
  const double s = x * x + y * y, radial = 1.0 + d.k1 * s + d.k2 * s * s;
  const double gamma_u = camera.fu * (1.0 + d.xi), gamma_v = camera.fv * (1.0 + d.xi);
  return {gamma_u * (x * radial + 2.0 * d.p1 * x * y + d.p2 * (s + 2.0 * x * x)) + camera.cu,
          gamma_v * (y * radial + d.p1 * (s + 2.0 * y * y) + 2.0 * d.p2 * x * y) + camera.cv};
}

TEST(Camera, OmniIsKalibrsFormulaWithTheFocalLengthsOfTheAxis) {
  Generator generator(5);
  for (const Camera& camera : {testing::kalibr_omni_camera(), testing::kitti_360_camera()}) {
    int seen = 0;
    for (int k = 0; k < 300; ++k) {
      const Vector3d X = 7.0 * testing::random_direction(generator);
      const auto projection = project(camera, X);
      if (projection && in_image(camera, projection->uv)) {
        EXPECT_LE((projection->uv - by_kalibrs_formula(camera, X)).norm(), 1e-9);
        ++seen;
      }
    }
    EXPECT_GE(seen, 20);
    const auto near_axis = project(camera, {1e-4, 0.0, 1.0});
    ASSERT_TRUE(near_axis);
    EXPECT_NEAR((near_axis->uv.x() - camera.cu) / 1e-4, camera.fu, 1e-3 * camera.fu);
  }
}

TEST(Camera, OmniEndsWhereTheSphereHidesItself) {
  // xi = 2 sees until cos(theta) = -1/2, 120 degrees; xi = 0.5 until cos(theta) = -0.5 too, at infinity.
  const auto at = [](double degrees) {
    const double theta = degrees * std::numbers::pi / 180.0;
    return Vector3d(std::sin(theta), 0.0, std::cos(theta));
  };
  for (const double xi : {2.0, 0.5}) {
    const Camera camera{100.0, 100.0, 0.0, 0.0, 200, 200, Omni{.xi = xi}};
    EXPECT_TRUE(project(camera, at(119.9))) << xi;
    EXPECT_FALSE(project(camera, at(120.1))) << xi;
    EXPECT_FALSE(project(camera, at(180.0))) << xi;
  }
  // sin / (cos + 2) = 0.57735 at the end, times 1 + xi and f.
  const Camera camera{100.0, 100.0, 0.0, 0.0, 200, 200, Omni{.xi = 2.0}};
  EXPECT_TRUE(unproject(camera, {173.2, 0.0}));
  EXPECT_FALSE(unproject(camera, {173.3, 0.0}));
}

TEST(Camera, InImageKeepsTheBorderFree) {
  const Camera camera = testing::paper_camera();
  EXPECT_TRUE(in_image(camera, {0.0, 0.0}));
  EXPECT_TRUE(in_image(camera, {479.9, 639.9}));
  EXPECT_FALSE(in_image(camera, {480.0, 100.0}));
  EXPECT_FALSE(in_image(camera, {100.0, 640.0}));
  EXPECT_FALSE(in_image(camera, {-0.1, 100.0}));
  EXPECT_FALSE(in_image(camera, {9.9, 100.0}, 10.0));
  EXPECT_TRUE(in_image(camera, {10.0, 100.0}, 10.0));
  EXPECT_FALSE(in_image(camera, {std::numeric_limits<double>::quiet_NaN(), 100.0}));
}

}  // namespace
}  // namespace limber
