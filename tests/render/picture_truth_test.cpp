// SPDX-License-Identifier: MIT
#include "limber/render/picture_truth.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "datasets/files.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/frontend/image_reader.hpp"
#include "limber/render/render_recording.hpp"
#include "render/small_drone.hpp"

namespace limber {
namespace {

using testing::small_drone;

constexpr std::int64_t kStamp = 100'000'000;

TEST(RollingShutter, ExposesEveryRowWhenAPictureTakenAtOnceWould) {
  const testing::TemporaryFolder scratch;
  const Scenario scenario = small_drone(0.2);
  const PictureOptions options{.exposure = 0.02, .rolling_shutter = 0.04, .moving_objects = 2};
  render_recording(scenario, 3, 0, options, scratch.path());
  const Recording recording = read_recording(scratch.path());
  ASSERT_EQ(recording.images[2].t_ns, kStamp);
  const PictureTruth truth(scenario, options, 3, 0);
  for (const std::size_t camera : {0u, 1u}) {
    const Camera& lens = camera == 0 ? scenario.rig.cam0 : scenario.rig.cam1;
    const auto width = static_cast<std::size_t>(lens.width);
    const GreyPixels picture =
        ImageReader(lens).read(camera == 0 ? recording.images[2].cam0 : recording.images[2].cam1);
    const PictureCamera at_once(lens);
    const auto difference = [&](std::size_t row, double middle) {
      std::vector<double> grey(width);
      for (int k = 0; k < 8; ++k) {
        const double t = 0.1 + middle + 0.02 * ((k + 0.5) / 8 - 0.5);
        const std::vector<float> light = at_once.light(truth.scene(), truth.view(camera, t));
        for (std::size_t u = 0; u < width; ++u) grey[u] += light[row * width + u] / 8;
      }
      double largest = 0.0;
      for (std::size_t u = 0; u < width; ++u) {
        largest = std::max(largest, std::abs(grey[u] - picture.data[row * width + u]));
      }
      return largest;
    };
    for (const std::size_t row : {0u, 60u, 120u, 239u}) {
      EXPECT_LT(difference(row, (static_cast<double>(row) / 240 - 0.5) * 0.04), 0.51) << row;  // rounded
    }
    EXPECT_GT(difference(0, 0.0), 10.0);  // the twin is not blind
  }
}

/// Pixels of the left image, and what is there.
std::vector<std::pair<Eigen::Vector2d, Place>> seen_on_a_grid(const PictureTruth& truth) {
  std::vector<std::pair<Eigen::Vector2d, Place>> seen;
  for (int v = 12; v < 230; v += 5) {
    for (int u = 12; u < 366; u += 5) {
      if (const auto place = truth.place(0, kStamp, Eigen::Vector2d(u, v))) {
        seen.emplace_back(Eigen::Vector2d(u, v), *place);
      }
    }
  }
  return seen;
}

TEST(PictureTruth, FindsAPlaceAgainInEveryPicture) {
  const Scenario scenario = small_drone(0.3);
  const PictureTruth truth(scenario, {.rolling_shutter = 0.04, .moving_objects = 3}, 3, 0);
  int moving = 0, shown = 0;
  for (const auto& [uv, place] : seen_on_a_grid(truth)) {
    ASSERT_LT((truth.pixel(0, kStamp, place).value() - uv).norm(), 1e-6);
    const auto elsewhere = truth.pixel(1, kStamp + 50'000'000, place);
    if (!elsewhere) continue;
    const auto there = truth.place(1, kStamp + 50'000'000, *elsewhere);
    const bool hidden = !there || (there->p - truth.scene().moved(place, there->t)).norm() > 1e-6;
    shown += !hidden;
    moving += !hidden && place.box.has_value();
    EXPECT_TRUE(hidden || there->box == place.box);
  }
  EXPECT_GT(shown, 2000);
  EXPECT_GT(moving, 50);
}

TEST(MovingBoxes, CarryTheirPaintAndHideWhatIsBehind) {
  const Scenario scenario = small_drone(0.3);
  const PictureTruth truth(scenario, {.moving_objects = 3}, 3, 0);
  const std::vector<float> before = PictureCamera(scenario.rig.cam0).light(truth.scene(), truth.view(0, 0.1));
  const std::vector<float> after = PictureCamera(scenario.rig.cam1).light(truth.scene(), truth.view(1, 0.2));
  const std::int64_t later = 2 * kStamp;
  const auto grey = [](const std::vector<float>& picture, const Eigen::Vector2d& uv) {
    const Eigen::Vector2d whole = uv.array().floor(), part = uv - whole;
    const auto at = [&](int du, int dv) {
      return picture[static_cast<std::size_t>((static_cast<int>(whole.y()) + dv) * 376 +
                                              static_cast<int>(whole.x()) + du)];
    };
    return (1 - part.y()) * ((1 - part.x()) * at(0, 0) + part.x() * at(1, 0)) +
           part.y() * ((1 - part.x()) * at(0, 1) + part.x() * at(1, 1));
  };
  std::vector<double> on_boxes;
  for (const auto& [uv, place] : seen_on_a_grid(truth)) {
    const auto again = truth.pixel(1, later, place);
    if (!place.box || !again || !in_image(scenario.rig.cam1, *again, 2.0)) continue;
    const auto there = truth.place(1, later, *again);
    if (!there || (there->p - truth.scene().moved(place, 0.2)).norm() > 1e-6) continue;  // hidden
    on_boxes.push_back(std::abs(grey(before, uv) - grey(after, *again)));
  }
  ASSERT_GT(on_boxes.size(), 50u);
  std::sort(on_boxes.begin(), on_boxes.end());
  EXPECT_LT(on_boxes[on_boxes.size() / 2], 3.0);
  EXPECT_LT(on_boxes[on_boxes.size() * 9 / 10], 12.0);
}

class BoxesOf : public ::testing::TestWithParam<SceneKind> {};

TEST_P(BoxesOf, CrossTheViewAndTouchNoCamera) {
  const Scenario scenario = small_drone(20.0);
  const PictureTruth truth(scenario, {.scene = GetParam(), .moving_objects = 5}, 4, 0);
  ASSERT_EQ(truth.scene().boxes().size(), 5u);
  for (const MovingBox& box : truth.scene().boxes()) {
    const View eye = truth.view(0, box.at);
    const auto seen = truth.scene().hit(eye.T_world_cam.p, box.middle - eye.T_world_cam.p, box.at);
    EXPECT_TRUE(seen && seen->box);
    const auto middle = project(scenario.rig.cam0, eye.T_world_cam.inverse() * box.middle);
    EXPECT_TRUE(middle && in_image(scenario.rig.cam0, middle->uv));
    double path = 0.0;
    for (double t = 0.0; t < 20.0; t += 0.1) {
      path += (box.pose(t + 0.1).p - box.pose(t).p).norm();
      for (const std::size_t camera : {0u, 1u}) {
        const Pose T_box_cam = box.pose(t).inverse() * truth.view(camera, t).T_world_cam;
        EXPECT_TRUE((T_box_cam.p.array().abs() > box.half_size.array() + 0.01).any());
      }
    }
    EXPECT_GT(path, 1.0);
  }
}
INSTANTIATE_TEST_SUITE_P(Scenes, BoxesOf,
                         ::testing::Values(SceneKind::kRoom, SceneKind::kHall, SceneKind::kStreet));

TEST(MovingBoxes, AreToldInTheTruthAndDrawnFromTheSeed) {
  const testing::TemporaryFolder scratch;
  const Scenario scenario = small_drone(0.05);
  render_recording(scenario, 3, 0, {.moving_objects = 2}, scratch.path());
  const PictureTruth truth(scenario, {.moving_objects = 2}, 3, 0),
      other(scenario, {.moving_objects = 2}, 4, 0);
  EXPECT_GT((truth.scene().boxes()[0].half_size - other.scene().boxes()[0].half_size).norm(), 1e-3);
  std::ifstream table(scratch.path() / "mav0" / "scene0" / "moving_box_poses.csv");
  std::string line;
  std::getline(table, line);
  int rows = 0;
  for (; std::getline(table, line); ++rows) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream cells(line);
    std::int64_t t_ns = 0;
    std::size_t box = 0;
    Eigen::Vector3d p;
    Eigen::Quaterniond q;
    cells >> t_ns >> box >> p.x() >> p.y() >> p.z() >> q.w() >> q.x() >> q.y() >> q.z();
    const Pose expected = truth.scene().boxes().at(box).pose(1e-9 * static_cast<double>(t_ns));
    EXPECT_LT((expected.p - p).norm() + (expected.R - q.toRotationMatrix()).norm(), 1e-9);
  }
  EXPECT_EQ(rows, 2 * 6);  // 100 Hz
  EXPECT_THROW(PictureTruth(scenario, {.moving_objects = 100}, 3, 0), std::invalid_argument);
}

class PlainWallsOf : public ::testing::TestWithParam<SceneKind> {};

TEST_P(PlainWallsOf, HaveTheirShareOfTheAreaAndNextToNoTexture) {
  const Scenario scenario = small_drone(0.1);
  for (const double share : {0.3, 0.8}) {
    const PictureTruth truth(scenario, {.scene = GetParam(), .low_texture = share}, 6, 0);
    double area = 0.0, plain = 0.0;
    for (const Wall& wall : truth.scene().walls()) {
      area += wall.width * wall.height;
      plain += truth.scene().is_plain(wall) ? wall.width * wall.height : 0.0;
    }
    EXPECT_NEAR(plain / area, share, 0.05);
  }
  const auto change_from_pixel_to_pixel = [&](double share) {
    const PictureTruth truth(scenario, {.scene = GetParam(), .low_texture = share}, 6, 0);
    const std::vector<float> light =
        PictureCamera(scenario.rig.cam0).light(truth.scene(), truth.view(0, 0.0));
    std::vector<float> changes;
    for (std::size_t k = 1; k < light.size(); ++k) {
      if (light[k] != 200.0f) changes.push_back(std::abs(light[k] - light[k - 1]));  // not the sky
    }
    std::nth_element(changes.begin(), changes.begin() + static_cast<std::ptrdiff_t>(changes.size() / 2),
                     changes.end());
    return changes[changes.size() / 2];
  };
  const float textured = change_from_pixel_to_pixel(0.0), plain = change_from_pixel_to_pixel(1.0);
  EXPECT_GT(textured, 1.0f);
  EXPECT_LT(plain, 0.2f);
}
INSTANTIATE_TEST_SUITE_P(Scenes, PlainWallsOf,
                         ::testing::Values(SceneKind::kRoom, SceneKind::kHall, SceneKind::kStreet));

}  // namespace
}  // namespace limber
