// SPDX-License-Identifier: MIT
#include "limber/initialize/background_navigator.hpp"

#include <gtest/gtest.h>

#include <future>
#include <limits>
#include <stdexcept>
#include <vector>

#include "feed.hpp"
#include "started.hpp"

namespace limber {
namespace {

using testing::Feed;
using testing::make_scene;
using testing::of_seed;
using testing::options_of;
using testing::Scene;
using testing::soon;

TEST(BackgroundNavigator, IsAnOnlineNavigatorBitByBitHoweverFastFramesCome) {
  const Scene scene = make_scene(of_seed(1));
  for (const Method method : {Method::kLcekf, Method::kAdaptive}) {
    const NavigatorOptions options = options_of(scene, method);
    BackgroundNavigator background(options, scene.calibration, soon());
    OnlineNavigator online(options, scene.calibration, soon());
    Feed first{scene}, second{scene};
    std::vector<std::future<BackgroundReport>> reports;
    for (const StereoFrame& frame : scene.frames) {
      first.until(background, frame.t_ns);
      reports.push_back(background.process(frame));
    }
    for (std::size_t k = 0; k < reports.size(); ++k) {
      second.until(online, scene.frames[k].t_ns);
      const OnlineReport expected = online.process(scene.frames[k]);
      const BackgroundReport found = reports[k].get();
      EXPECT_EQ(found.online.t_ns, expected.t_ns);
      EXPECT_EQ(found.online.start.has_value(), expected.start.has_value());
      EXPECT_EQ(found.online.frame.has_value(), expected.frame.has_value());
      ASSERT_EQ(found.state.has_value(), online.started());
      if (found.state) {
        const PredictedState state = online.predict(scene.frames[k].t_ns);
        EXPECT_EQ(found.state->nav.T_world_body.p, state.nav.T_world_body.p);
        EXPECT_EQ(found.state->body_covariance, state.body_covariance);
      }
    }
    EXPECT_TRUE(online.started());
    EXPECT_EQ(background.waiting(), 0U);
  }
}

TEST(BackgroundNavigator, TellsTheNextFrameWhatWasRefusedAndGoesOn) {
  const Scene scene = make_scene(of_seed(1));
  BackgroundNavigator navigator(options_of(scene, Method::kEkf), scene.calibration);
  Feed feed{scene};
  feed.until(navigator, scene.frames[0].t_ns);
  navigator.add_imu({scene.inputs[0].t_ns - 1, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
  EXPECT_THROW(navigator.process(scene.frames[0]).get(), std::invalid_argument);
  EXPECT_THROW(navigator.process(scene.frames[0]).get(), std::invalid_argument);  // given twice
  feed.until(navigator, scene.frames[1].t_ns);
  EXPECT_EQ(navigator.process(scene.frames[1]).get().online.t_ns, scene.frames[1].t_ns);
}

TEST(BackgroundNavigator, EndsWithFramesThatWaitWhoseFuturesSayIt) {
  const Scene scene = make_scene(of_seed(1));
  std::vector<std::future<BackgroundReport>> reports;
  {
    BackgroundNavigator navigator(options_of(scene, Method::kLcekf), scene.calibration, soon());
    Feed feed{scene};
    for (const StereoFrame& frame : scene.frames) {
      feed.until(navigator, frame.t_ns);
      reports.push_back(navigator.process(frame));
    }
    EXPECT_GT(navigator.waiting(), 0U);  // a start is among them
  }
  EXPECT_THROW(reports.back().get(), std::future_error);
}

TEST(BackgroundNavigator, RefusesOptionsAtOnce) {
  const Scene scene = make_scene(of_seed(1));
  NavigatorOptions options = options_of(scene, Method::kLcekf);
  options.sigma_px[0] = -1.0;
  EXPECT_THROW(BackgroundNavigator(options, scene.calibration), std::invalid_argument);
}

}  // namespace
}  // namespace limber
