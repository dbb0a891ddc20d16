// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstdint>
#include <numbers>
#include <vector>

#include "limber/frontend/stereo_tracker.hpp"
#include "limber/measure/rig.hpp"
#include "limber/render/picture_truth.hpp"
#include "render/small_drone.hpp"

namespace limber {
namespace {

class Pictures {
 public:
  Pictures(const Scenario& scenario, SceneKind kind)
      : truth(scenario, {.scene = kind}, 11, 0), rig(truth.nominal()), left(rig.cam0), right(rig.cam1) {}

  /// Right matches within 1 px of the truth, of all points: the rig differs from what the tracker is told by
  /// an angle about an axis of the right camera.
  [[nodiscard]] double share(Eigen::Index axis, double degrees, const TrackerOptions& options = {}) const {
    StereoCalibration bent = rig;
    bent.theta[axis] += degrees * std::numbers::pi / 180.0;
    StereoTracker tracker(rig, options);
    int points = 0, matches = 0;
    for (const std::int64_t t_ns : sample_times(20.0, 0.15)) {
      const View eye = truth.view(0, 1e-9 * static_cast<double>(t_ns));
      const View other{eye.t, eye.T_world_cam * pose_from_rig(bent.theta).inverse()};
      const auto image0 = develop(left.light(truth.scene(), eye), rig.cam0, {}, 0);
      const auto image1 = develop(right.light(truth.scene(), other), rig.cam1, {}, 1);
      const StereoFrame frame = tracker.process(t_ns, grey(rig.cam0, image0), grey(rig.cam1, image1));
      for (const StereoObservation& point : frame.observations) {
        ++points;
        const auto place = truth.place(0, t_ns, point.uv_cam0);
        const auto expected =
            place ? project(rig.cam1, other.T_world_cam.inverse() * place->p) : std::nullopt;
        matches += point.in_cam1 && expected && (expected->uv - point.uv_cam1).norm() < 1.0;
      }
    }
    EXPECT_GT(points, 200);
    return static_cast<double>(matches) / points;
  }

  PictureTruth truth;
  StereoCalibration rig;
  PictureCamera left, right;

 private:
  static GreyImage grey(const Camera& camera, const std::vector<std::uint8_t>& pixels) {
    return {camera.width, camera.height, camera.width, pixels.data()};
  }
};

class RightMatches : public ::testing::TestWithParam<SceneKind> {};

TEST_P(RightMatches, OutliveARigThatIsFiveDegreesOff) {
  const Pictures pictures(testing::small_drone(0.2), GetParam());
  const double undisturbed = pictures.share(0, 0.0);
  EXPECT_GT(undisturbed, 0.7);
  for (const Eigen::Index axis : {0, 1, 2}) {  // nod, vergence, roll
    for (const double sign : {-1.0, 1.0}) {
      EXPECT_GE(pictures.share(axis, 3.0 * sign), 0.9 * undisturbed) << axis << sign;
      EXPECT_GE(pictures.share(axis, 5.0 * sign), 0.6 * undisturbed) << axis << sign;
    }
  }
  const TrackerOptions trusting{.search_margin_degrees = 0.3};
  EXPECT_LT(pictures.share(0, 5.0, trusting), 0.6 * undisturbed);
}
INSTANTIATE_TEST_SUITE_P(Scenes, RightMatches, ::testing::Values(SceneKind::kRoom, SceneKind::kStreet));

/// How far five degrees move a pixel depends on the focal length and on where it is, not on the image's
/// height.
TEST(RightMatchesOfALongLens, OutliveFiveDegreesOfVergence) {
  Scenario scenario = testing::small_drone(0.2);
  scenario.rig.cam0 = scenario.rig.cam1 = {460.0, 460.0, 376.0, 120.0, 752, 240, NoDistortion{}};
  const Pictures pictures(scenario, SceneKind::kStreet);
  const double undisturbed = pictures.share(1, 0.0);
  for (const double degrees : {-5.0, 5.0}) {
    EXPECT_GE(pictures.share(1, degrees), 0.6 * undisturbed) << degrees;
  }
}

}  // namespace
}  // namespace limber
