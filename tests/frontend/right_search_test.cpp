// SPDX-License-Identifier: MIT
#include "frontend/right_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "frontend/painted_room.hpp"

namespace limber::frontend {
namespace {

const Eigen::Vector2d kPoint(180.0, 120.0);

/// Blobs; stretched along u by `stretch` about a point `disparity` to the left of kPoint.
Pyramid blobs(const Camera& camera, double stretch, double disparity) {
  cv::Mat1b image(camera.height, camera.width);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const double x = (u - kPoint.x() + disparity) / stretch, y = v - kPoint.y();
      image(v, u) = cv::saturate_cast<std::uint8_t>(
          120.0 + 40.0 * std::sin(0.45 * x + 0.3 + 0.0007 * x * y) * std::cos(0.38 * y) +
          40.0 * std::sin(0.21 * x - 0.33 * y));
    }
  }
  return pyramid_of(image);
}

/// Where the point is found near its place, if it looks stretched there by so much.
std::optional<PatchFit> followed(double stretch) {
  const StereoCalibration rig = testing::small_rig();
  constexpr double kDisparity = 9.25;
  Eigen::Matrix2d A = Eigen::Matrix2d::Identity();
  A(0, 0) = stretch;
  return RightSearch(rig, {}).follow(blobs(rig.cam0, 1.0, 0.0), blobs(rig.cam1, stretch, kDisparity), kPoint,
                                     {kPoint - Eigen::Vector2d(kDisparity - 0.3, 0.2), A});
}

TEST(RightSearch, FollowsASurfaceThatTheOtherCameraSeesAslant) {
  for (const double stretch : {0.7, 0.9, 1.0, 1.1, 1.4}) {
    const auto fit = followed(stretch);
    ASSERT_TRUE(fit) << stretch;
    EXPECT_LT((fit->uv - kPoint + Eigen::Vector2d(9.25, 0.0)).norm(), 0.1) << stretch;
  }
}

/// Two cameras side by side do not see a surface like that: it is another one, torn until it resembles it.
TEST(RightSearch, DoesNotFollowWhatIsTornToBeAlike) {
  EXPECT_FALSE(followed(1.8));
  EXPECT_FALSE(followed(0.55));
}

/// What lies 2 px to the right of the point is 6 px off in the right image: no patch of one surface fits
/// both. A shift alone finds the other side, alike by 0.93.
TEST(RightSearch, DoesNotFollowAShiftThatNoShapeConfirms) {
  const StereoCalibration rig = testing::small_rig();
  constexpr double kDisparity = 9.25;
  cv::Mat image = blobs(rig.cam1, 1.0, kDisparity)[0];
  const cv::Mat other = blobs(rig.cam1, 1.0, kDisparity - 6.0)[0];
  const int edge = static_cast<int>(kPoint.x() - kDisparity + 2.0);
  other.colRange(edge, image.cols).copyTo(image.colRange(edge, image.cols));
  const PatchFit guess{kPoint - Eigen::Vector2d(kDisparity - 0.25, 0.2)};
  EXPECT_FALSE(RightSearch(rig, {}).follow(blobs(rig.cam0, 1.0, 0.0), pyramid_of(image), kPoint, guess));
}

}  // namespace
}  // namespace limber::frontend
