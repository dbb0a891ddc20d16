// SPDX-License-Identifier: MIT
// The same pixels as OpenCV's, over the whole image.
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "rig_files/opencv_lens.hpp"
#include "sensors/cameras.hpp"

namespace limber {
namespace {

std::vector<cv::Point3d> rays_of(const Camera& camera) {
  std::vector<cv::Point3d> out;
  for (double u = 0.5; u < camera.width; u += 37.0) {
    for (double v = 0.5; v < camera.height; v += 23.0) {
      const auto ray = unproject(camera, {u, v});
      EXPECT_TRUE(ray) << u << " " << v;
      out.emplace_back(3.0 * ray->x(), 3.0 * ray->y(), 3.0 * ray->z());
    }
  }
  return out;
}

/// Largest distance between OpenCV's pixels and limber's [px].
double worst_of(const Camera& camera, const std::vector<cv::Point3d>& rays,
                const std::vector<cv::Point2d>& by_opencv) {
  double worst = 0.0;
  for (std::size_t k = 0; k < rays.size(); ++k) {
    const auto own = project(camera, {rays[k].x, rays[k].y, rays[k].z});
    worst = std::max(worst, own ? (own->uv - Eigen::Vector2d(by_opencv[k].x, by_opencv[k].y)).norm() : 1e9);
  }
  return worst;
}

cv::Mat matrix_of(const Camera& camera) {
  return (cv::Mat_<double>(3, 3) << camera.fu, 0, camera.cu, 0, camera.fv, camera.cv, 0, 0, 1);
}

TEST(OpenCvProjects, LensesOfFourFiveAndEightCoefficientsWhereLimberDoes) {
  for (const Camera& camera :
       {testing::euroc_camera(), testing::kitti_raw_camera(), testing::rational_camera()}) {
    const auto k = detail::opencv_coefficients(camera.distortion);
    ASSERT_TRUE(k);
    const auto rays = rays_of(camera);
    ASSERT_GT(rays.size(), 400u);
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(rays, cv::Vec3d(), cv::Vec3d(), matrix_of(camera), *k, pixels);
    EXPECT_LT(worst_of(camera, rays, pixels), 1e-9) << k->size() << " coefficients";
  }
  EXPECT_EQ(detail::opencv_coefficients(testing::kitti_raw_camera().distortion)->size(), 5u);
  EXPECT_EQ(detail::opencv_coefficients(testing::rational_camera().distortion)->size(), 8u);
}

TEST(OpenCvProjects, AFisheyeWhereLimberDoes) {
  Camera camera = testing::tum_vi_camera();
  camera.width = camera.height = 300;  // cv::fisheye ends at 90 degrees
  camera.cu = camera.cv = 150.0;
  const auto rays = rays_of(camera);
  std::vector<cv::Point2d> pixels;
  cv::fisheye::projectPoints(rays, pixels, cv::Vec3d(), cv::Vec3d(), matrix_of(camera),
                             coefficients(camera.distortion));
  EXPECT_LT(worst_of(camera, rays, pixels), 1e-9);
}

}  // namespace
}  // namespace limber
