// SPDX-License-Identifier: MIT
#include "limber/frontend/stereo_tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <string>

#include "frontend/room_flight.hpp"
#include "limber/core/errors.hpp"
#include "message_of.hpp"
#include "percentile.hpp"
#include "same_frames.hpp"

namespace limber {
namespace {

using testing::Exposure;
using testing::flight;
using testing::Image;
using testing::kPeriodNs;
using testing::pair_of_frame;
using testing::percentile;
using testing::photograph;
using testing::plain_image;
using testing::process;
using testing::same;
using testing::sequence;
using testing::small_rig;
using testing::track;
using testing::true_theta;

long right_matches(const StereoFrame& frame) {
  return std::count_if(frame.observations.begin(), frame.observations.end(),
                       [](const StereoObservation& point) { return point.in_cam1; });
}

TEST(StereoTracker, FollowsPointsToATenthOfAPixelWhenTheRigIsNotAsAssumed) {
  const StereoCalibration rig = small_rig();
  const Pose T_cam1_cam0 = pose_from_rig(true_theta());
  std::map<std::int64_t, Eigen::Vector3d> landmarks;  // where a track's point is, by its first pixel
  std::map<std::int64_t, int> ages;
  std::vector<double> left_errors, right_errors;
  const auto frames = track(sequence(16), rig);
  for (int k = 0; k < 16; ++k) {
    const Pose T_world_cam0 = flight(k);
    for (const StereoObservation& point : frames[static_cast<std::size_t>(k)].observations) {
      ++ages[point.track_id];
      const auto [landmark, is_new] =
          landmarks.try_emplace(point.track_id, testing::point_seen(rig.cam0, T_world_cam0, point.uv_cam0));
      const Eigen::Vector3d p_cam0 = T_world_cam0.inverse() * landmark->second;
      if (!is_new) left_errors.push_back((project(rig.cam0, p_cam0)->uv - point.uv_cam0).norm());
      if (!point.in_cam1) continue;
      // The right match is judged by the left pixel it belongs to.
      const Eigen::Vector3d seen = testing::point_seen(rig.cam0, T_world_cam0, point.uv_cam0);
      const auto truth = project(rig.cam1, T_cam1_cam0 * (T_world_cam0.inverse() * seen));
      right_errors.push_back((truth->uv - point.uv_cam1).norm());
    }
    EXPECT_GE(frames[static_cast<std::size_t>(k)].observations.size(), 90u) << k;
    EXPECT_GE(right_matches(frames[static_cast<std::size_t>(k)]), 70) << k;
  }
  EXPECT_LT(percentile(left_errors, 0.5), 0.12);
  EXPECT_LT(percentile(left_errors, 0.95), 0.5);
  EXPECT_LT(percentile(right_errors, 0.5), 0.10);
  EXPECT_LT(percentile(right_errors, 0.95), 0.35);
  EXPECT_LT(percentile(right_errors, 1.0), 3.0);  // not one wrong match
  const auto whole =
      std::count_if(ages.begin(), ages.end(), [](const auto& age) { return age.second == 16; });
  EXPECT_GE(whole, 40);
}

TEST(StereoTracker, KeepsItsTracksWhateverExtrinsicsAreAssumed) {
  const auto pairs = sequence(6);
  StereoCalibration informed = small_rig();
  informed.theta = true_theta();
  const auto expected = track(pairs, informed), found = track(pairs, small_rig());
  int both = 0, either = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    ASSERT_EQ(expected[k].observations.size(), found[k].observations.size());
    for (std::size_t i = 0; i < found[k].observations.size(); ++i) {
      const StereoObservation &a = expected[k].observations[i], &b = found[k].observations[i];
      EXPECT_EQ(a.track_id, b.track_id);
      EXPECT_EQ(a.uv_cam0, b.uv_cam0);  // the left camera does not know of the rig at all
      either += a.in_cam1 || b.in_cam1;
      if (!a.in_cam1 || !b.in_cam1) continue;
      ++both;
      EXPECT_LT((a.uv_cam1 - b.uv_cam1).norm(), 0.05);
    }
  }
  EXPECT_GE(both, 0.97 * either);
}

TEST(StereoTracker, FollowsARigThatJumpsByTwoDegrees) {
  auto pairs = sequence(8);
  RigParameters bent = true_theta();
  bent.head<3>() += Eigen::Vector3d(0.035, -0.035, 0.035);
  for (int k = 4; k < 8; ++k) pairs[static_cast<std::size_t>(k)] = pair_of_frame(k, bent);
  const auto frames = track(pairs, small_rig());
  for (std::size_t k = 4; k < frames.size(); ++k) EXPECT_GE(right_matches(frames[k]), 50) << k;
}

TEST(StereoTracker, GivesEachTrackOnceAndInOrder) {
  std::set<std::int64_t> ended;
  std::set<std::int64_t> before;
  for (const StereoFrame& frame : track(sequence(8), small_rig())) {
    std::set<std::int64_t> now;
    std::int64_t last = -1;
    for (const StereoObservation& point : frame.observations) {
      EXPECT_GT(point.track_id, last);
      last = point.track_id;
      EXPECT_TRUE(point.in_cam0);
      EXPECT_FALSE(ended.contains(point.track_id)) << "an id came back";
      now.insert(point.track_id);
    }
    for (const std::int64_t id : before) {
      if (!now.contains(id)) ended.insert(id);
    }
    before = now;
  }
  EXPECT_FALSE(before.empty());
}

TEST(StereoTracker, LivesOnWithTheLeftCameraWhileTheRightLensIsCovered) {
  const auto pairs = sequence(9);
  const StereoCalibration rig = small_rig();
  const Image black = plain_image(rig.cam1.width, rig.cam1.height, 0);
  StereoTracker tracker(rig);
  std::set<std::int64_t> first_ids;
  for (int k = 0; k < 9; ++k) {
    const auto& pair = pairs[static_cast<std::size_t>(k)];
    const bool covered = k >= 3 && k < 6;
    const StereoFrame frame = process(tracker, k, pair.left, covered ? black : pair.right);
    EXPECT_GE(frame.observations.size(), 90u) << k;
    if (covered) {
      EXPECT_EQ(right_matches(frame), 0) << k;
    } else {
      EXPECT_GE(right_matches(frame), 70) << k;
    }
    long old = 0;
    for (const StereoObservation& point : frame.observations) {
      if (k == 0) first_ids.insert(point.track_id);
      old += first_ids.contains(point.track_id);
    }
    EXPECT_GE(old, 60) << k;
  }
}

TEST(StereoTracker, StartsAnewAfterTheLeftLensWasCovered) {
  const auto pairs = sequence(4);
  const StereoCalibration rig = small_rig();
  const Image black = plain_image(rig.cam0.width, rig.cam0.height, 0);
  StereoTracker tracker(rig);
  const StereoFrame before = process(tracker, 0, pairs[0].left, pairs[0].right);
  EXPECT_TRUE(process(tracker, 1, black, pairs[1].right).observations.empty());
  EXPECT_TRUE(process(tracker, 2, black, black).observations.empty());
  const StereoFrame after = process(tracker, 3, pairs[3].left, pairs[3].right);
  EXPECT_GE(right_matches(after), 70);
  EXPECT_GT(after.observations.front().track_id, before.observations.back().track_id);
}

TEST(StereoTracker, HoldsStillForIdenticalImagesAndWithinTheNoiseForStillOnes) {
  const auto pairs = sequence(1);
  StereoTracker frozen(small_rig());
  const StereoFrame first = process(frozen, 0, pairs[0].left, pairs[0].right);
  for (int k = 1; k < 4; ++k) {
    const StereoFrame frame = process(frozen, k, pairs[0].left, pairs[0].right);
    // The refinement of the first corners left room for a few more.
    ASSERT_GE(frame.observations.size(), first.observations.size());
    EXPECT_LE(frame.observations.size(), first.observations.size() + 8);
    for (std::size_t i = 0; i < first.observations.size(); ++i) {
      const StereoObservation &now = frame.observations[i], &before = first.observations[i];
      EXPECT_EQ(now.track_id, before.track_id);
      EXPECT_LT((now.uv_cam0 - before.uv_cam0).norm(), 0.01);
      EXPECT_EQ(now.in_cam1, before.in_cam1) << now.track_id;
      EXPECT_LT((now.uv_cam1 - before.uv_cam1).norm(), 0.05);
    }
  }
  // Fresh noise every frame: the tracks must not wander off as errors add up.
  const StereoCalibration rig = small_rig();
  StereoTracker still(rig);
  std::map<std::int64_t, Eigen::Vector2d> start;
  std::vector<double> drift;
  for (int k = 0; k < 25; ++k) {
    const Image left = photograph(rig.cam0, flight(0), {1.0, 0.0, 3.0, static_cast<std::uint64_t>(100 + k)});
    for (const StereoObservation& point : process(still, k, left, pairs[0].right).observations) {
      const auto [known, is_new] = start.try_emplace(point.track_id, point.uv_cam0);
      if (k == 24 && !is_new) drift.push_back((point.uv_cam0 - known->second).norm());
    }
  }
  EXPECT_GE(drift.size(), 80u);
  EXPECT_LT(percentile(drift, 0.95), 0.15);
}

TEST(StereoTracker, SeesNothingInImagesWithoutTexture) {
  const StereoCalibration rig = small_rig();
  StereoTracker tracker(rig);
  for (int k = 0; k < 3; ++k) {
    const auto grey = static_cast<std::uint8_t>(120 * k);
    const Image plain = plain_image(rig.cam0.width, rig.cam0.height, grey);
    EXPECT_TRUE(process(tracker, k, plain, plain).observations.empty());
  }
}

TEST(StereoTracker, FindsNoRightMatchInAnotherScene) {
  const auto pairs = sequence(1);
  const StereoCalibration rig = small_rig();
  const Pose elsewhere{so3_exp(Eigen::Vector3d(0.3, 2.5, 0.0)), Eigen::Vector3d(1.0, -0.5, 2.0)};
  StereoTracker tracker(rig);
  EXPECT_LE(right_matches(process(tracker, 0, pairs[0].left, photograph(rig.cam1, elsewhere, {}))), 3);
}

TEST(StereoTracker, GivesTheSameBitsTwiceAndOnAnyNumberOfThreads) {
  const auto pairs = sequence(6);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const auto once = track(pairs, small_rig());
  cv::theRNG().state = 12345;  // nothing may hang on OpenCV's global generator
  const auto twice = track(pairs, small_rig());
  cv::setNumThreads(4);
  const auto threaded = track(pairs, small_rig());
  cv::setNumThreads(threads);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    EXPECT_TRUE(same(once[k], twice[k])) << k;
    EXPECT_TRUE(same(once[k], threaded[k])) << k;
  }
}

TEST(StereoTracker, ReadsRowsThatAreFurtherApartThanTheyAreLong) {
  const auto pairs = sequence(2);
  const auto padded = [](const Image& image) {
    std::vector<std::uint8_t> pixels;
    for (int v = 0; v < image.height; ++v) {
      const auto row = image.pixels.begin() + static_cast<std::ptrdiff_t>(v) * image.width;
      pixels.insert(pixels.end(), row, row + image.width);
      pixels.insert(pixels.end(), 13, 255);
    }
    return pixels;
  };
  StereoTracker tight(small_rig()), loose(small_rig());
  for (int k = 0; k < 2; ++k) {
    const Image &left = pairs[static_cast<std::size_t>(k)].left,
                &right = pairs[static_cast<std::size_t>(k)].right;
    const StereoFrame expected = process(tight, k, left, right);
    const auto left_pixels = padded(left), right_pixels = padded(right);
    const StereoFrame found =
        loose.process(k * kPeriodNs, GreyImage{left.width, left.height, left.width + 13, left_pixels.data()},
                      GreyImage{right.width, right.height, right.width + 13, right_pixels.data()});
    EXPECT_TRUE(same(expected, found));
  }
}

TEST(StereoTracker, ObeysItsOptions) {
  const auto pairs = sequence(1);
  TrackerOptions options;
  options.max_tracks = 30;
  options.min_distance_px = 40.0;
  StereoTracker tracker(small_rig(), options);
  const StereoFrame frame = process(tracker, 0, pairs[0].left, pairs[0].right);
  EXPECT_GE(frame.observations.size(), 20u);
  EXPECT_LE(frame.observations.size(), 30u);
  for (const StereoObservation& a : frame.observations) {
    for (const StereoObservation& b : frame.observations) {
      if (a.track_id < b.track_id) {
        EXPECT_GT((a.uv_cam0 - b.uv_cam0).norm(), 30.0);
      }
    }
  }
}

TEST(StereoTracker, RefusesOptionsAndCalibrationsThatMakeNoSense) {
  const auto with = [](const auto& change) {
    TrackerOptions options;
    change(options);
    return options;
  };
  using Options = TrackerOptions;
  for (const Options& options :
       {with([](Options& o) { o.max_tracks = 0; }), with([](Options& o) { o.min_distance_px = 0.0; }),
        with([](Options& o) { o.min_corner_strength = -1.0; }), with([](Options& o) { o.min_ncc = 1.0; }),
        with([](Options& o) { o.max_forward_backward_px = std::nan(""); }),
        with([](Options& o) { o.max_epipolar_px = 0.0; }),
        with([](Options& o) { o.nearest_baselines = 0.0; }),
        with([](Options& o) { o.search_margin_degrees = -1.0; })}) {
    EXPECT_THROW(StereoTracker(small_rig(), options), std::invalid_argument);
  }
  StereoCalibration no_size = small_rig();
  no_size.cam1.width = 0;
  EXPECT_THROW(StereoTracker{no_size}, std::invalid_argument);
  StereoCalibration no_focus = small_rig();
  no_focus.cam0.fu = 0.0;
  EXPECT_THROW(StereoTracker{no_focus}, std::invalid_argument);
}

TEST(StereoTracker, WorksOnTheSmallestImagesItTakes) {
  StereoCalibration rig = small_rig();
  for (Camera* camera : {&rig.cam0, &rig.cam1}) *camera = {40.0, 40.0, 31.5, 31.5, 64, 64, NoDistortion{}};
  StereoTracker tracker(rig);
  for (int k = 0; k < 3; ++k) {
    const Image left = photograph(rig.cam0, flight(k), {});
    EXPECT_FALSE(process(tracker, k, left, left).observations.empty());
  }
}

TEST(StereoTracker, RefusesViewsOfTheWrongSizeAndTimeThatStandsStill) {
  const auto pairs = sequence(1);
  StereoTracker tracker(small_rig());
  const Image wide = plain_image(640, 240, 0);
  const std::string message = testing::message_of([&] { (void)process(tracker, 0, pairs[0].left, wide); });
  for (const char* const words : {"right image", "376 x 240", "640 x 240"}) {
    EXPECT_NE(message.find(words), std::string::npos) << message;
  }
  EXPECT_THROW((void)tracker.process(0, GreyImage{376, 240, 376, nullptr}, pairs[0].right.view()),
               std::invalid_argument);
  EXPECT_THROW(
      (void)tracker.process(0, GreyImage{376, 240, 375, pairs[0].left.pixels.data()}, pairs[0].right.view()),
      std::invalid_argument);
  (void)process(tracker, 5, pairs[0].left, pairs[0].right);
  EXPECT_THROW((void)process(tracker, 5, pairs[0].left, pairs[0].right), std::invalid_argument);
  EXPECT_THROW((void)process(tracker, 4, pairs[0].left, pairs[0].right), std::invalid_argument);
  EXPECT_FALSE(process(tracker, 6, pairs[0].left, pairs[0].right).observations.empty());
}

/// A folder of its own for files, removed at the end.
class StereoTrackerFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("limber_stereo_tracker_" +
               std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const Image& image) const {
    const cv::Mat matrix(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.pixels.data()));
    cv::imwrite((folder_ / name).string(), matrix);
    return folder_ / name;
  }
  std::filesystem::path write_text(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  std::filesystem::path folder_;
};

TEST_F(StereoTrackerFiles, GiveTheSameAsImagesInMemory) {
  const auto pairs = sequence(3);
  StereoTracker from_files(small_rig()), from_memory(small_rig());
  for (int k = 0; k < 3; ++k) {
    const auto& pair = pairs[static_cast<std::size_t>(k)];
    const auto left = write("left.png", pair.left), right = write("right.png", pair.right);
    EXPECT_TRUE(
        same(from_files.process(k * kPeriodNs, left, right), process(from_memory, k, pair.left, pair.right)));
  }
}

TEST_F(StereoTrackerFiles, ThatCannotBeUsedAreNamedAndLeaveTheTrackerAsItWas) {
  const auto pairs = sequence(2);
  const auto left = write("left.png", pairs[1].left), right = write("right.png", pairs[1].right);
  const auto small = write("small.png", plain_image(320, 200, 9));
  std::ifstream whole(right, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(whole), std::istreambuf_iterator<char>()};
  StereoTracker tracker(small_rig()), untroubled(small_rig());
  (void)process(tracker, 0, pairs[0].left, pairs[0].right);
  (void)process(untroubled, 0, pairs[0].left, pairs[0].right);
  for (const auto& bad :
       {folder_ / "missing.png", folder_, write_text("empty.png", ""),
        write_text("text.png", "this is no image"), write_text("torn.png", bytes.substr(0, 20)), small}) {
    for (const bool is_left : {true, false}) {
      try {
        (void)(is_left ? tracker.process(kPeriodNs, bad, right) : tracker.process(kPeriodNs, left, bad));
        FAIL() << "took " << bad;
      } catch (const DataError& error) {
        EXPECT_EQ(error.file(), bad.string());
        EXPECT_NE(std::string(error.what()).find("376 x 240"), std::string::npos) << error.what();
        if (bad == small) {
          EXPECT_NE(std::string(error.what()).find("320 x 200"), std::string::npos) << error.what();
        }
      }
    }
  }
  EXPECT_TRUE(same(tracker.process(kPeriodNs, left, right), untroubled.process(kPeriodNs, left, right)));
}

}  // namespace
}  // namespace limber
