// SPDX-License-Identifier: MIT
#include "rig_files/camera_fit.hpp"

#include <gtest/gtest.h>

namespace limber::detail {
namespace {

TEST(CameraFit, AnEquidistantCameraInPlaceOfADoubleSphereIsTheSameEverywhere) {
  const Pinhole pinhole{349.756, 348.725, 365.894, 249.33};  // Basalt's camera of EuRoC
  const auto projection = double_sphere(pinhole, -0.2409573942, 0.5669968992);
  Camera start{pinhole.fu / 0.759, pinhole.fv / 0.759, pinhole.cu, pinhole.cv, 752, 480, NoDistortion{}};
  const auto fit = fit_camera(projection, start);
  ASSERT_TRUE(fit);
  EXPECT_LT(fit->worst_px, kWorstFit_px);
  double worst = 0.0;
  for (double u = 1.0; u < 752.0; u += 50.0) {
    for (double v = 1.0; v < 480.0; v += 50.0) {
      const auto ray = unproject(fit->camera, {u, v});
      ASSERT_TRUE(ray);
      const auto back = projection(*ray);
      ASSERT_TRUE(back);
      worst = std::max(worst, (*back - Eigen::Vector2d(u, v)).norm());
    }
  }
  EXPECT_LT(worst, 2.0 * kWorstFit_px) << "between the rays of the fit, up to the corners";
}

TEST(CameraFit, FourCoefficientsStandForFiveInANarrowImage) {
  const Pinhole pinhole{1200.0, 1205.0, 610.0, 180.0};
  const auto projection = opencv_pinhole(pinhole, {-0.35, 0.16, 1e-3, -5e-4, -0.01});
  const auto fit = fit_camera(projection, {1200.0, 1205.0, 610.0, 180.0, 1242, 375, NoDistortion{}});
  ASSERT_TRUE(fit);
  EXPECT_LT(fit->worst_px, kWorstFit_px);
}

TEST(CameraFit, FindsItsOwnModelsExactly) {
  const Camera camera{458.0, 457.0, 367.0, 248.0, 752, 480, RadialTangential{-0.28, 0.07, 2e-4, 2e-5}};
  const ForeignProjection itself = [&](const Eigen::Vector3d& X) -> std::optional<Eigen::Vector2d> {
    const auto out = project(camera, X);
    return out ? std::optional(out->uv) : std::nullopt;
  };
  Camera start = camera;
  start.distortion = NoDistortion{};
  const auto fit = fit_camera(itself, start);
  ASSERT_TRUE(fit);
  EXPECT_LT(fit->worst_px, 1e-4);
  EXPECT_NEAR(fit->camera.fu, 458.0, 1e-3);
  ASSERT_TRUE(std::holds_alternative<RadialTangential>(fit->camera.distortion));
}

TEST(CameraFit, ProjectionsAgreeWhereTheModelsMeet) {
  const Pinhole pinhole{300.0, 310.0, 320.0, 240.0};
  const Eigen::Vector3d X(0.3, -0.2, 1.0);
  const auto plain = opencv_pinhole(pinhole, {})(X);
  ASSERT_TRUE(plain);
  for (const auto& same : {double_sphere(pinhole, 0.0, 0.0), extended_unified(pinhole, 0.0, 1.0)}) {
    EXPECT_LT((*same(X) - *plain).norm(), 1e-12);
  }
  // With beta = 1 it is the unified model: alpha = xi / (1 + xi).
  const double xi = 0.8;
  const auto unified = extended_unified(pinhole, xi / (1.0 + xi), 1.0)(X);
  const auto omni = project({300.0, 310.0, 320.0, 240.0, 640, 480, Omni{.xi = xi}}, X);
  ASSERT_TRUE(unified && omni);
  EXPECT_LT((*unified - omni->uv).norm(), 1e-10);
}

}  // namespace
}  // namespace limber::detail
