// SPDX-License-Identifier: MIT
#include "limber/navigate/stereo_filter.hpp"
#include "limber/core/factors.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "message_of.hpp"
#include "small_scene.hpp"
#include "state/small_map.hpp"

/// What a caller of the navigator may rely on, frame by frame.
namespace limber {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::Feeder;
using testing::kMs;
using testing::make_scene;
using testing::message_of;
using testing::Scene;
using testing::SceneOptions;
using testing::small_scene;
using testing::Snapshot;
using testing::snapshot;
using testing::with_method;

/// The state as it can be compared bit by bit.
struct State {
  std::int64_t t_ns;
  Snapshot all;
  bool operator==(const State&) const = default;
};

State state(const StereoFilter& navigator) {
  return {navigator.estimate().nav().t_ns, snapshot(navigator.estimate())};
}

TEST(StereoFilter, BadFramesAreRefusedAndLeaveTheStateAsItWas) {
  const Scene scene = small_scene();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  struct Bad {
    std::string says;
    std::function<void(StereoFrame&)> spoil;
  };
  const std::vector<Bad> bad = {
      {"older", [](StereoFrame& f) { f.t_ns -= 60 * kMs; }},
      {"not finite", [&](StereoFrame& f) { f.observations[3].uv_cam0.x() = nan; }},
      {"not finite", [&](StereoFrame& f) { f.observations[4].uv_cam1.y() = inf; }},
      {"1e+300", [](StereoFrame& f) { f.observations[3].uv_cam1.x() = -1e300; }},
      {"1e+300",
       [](StereoFrame& f) {
         for (StereoObservation& o : f.observations) o.uv_cam0.setConstant(1e300);
       }},
      {"twice", [](StereoFrame& f) { f.observations[5].track_id = f.observations[2].track_id; }},
  };
  for (const Method method : kAllMethods) {
    Feeder feeder(scene, with_method(scene, method));
    Feeder clean(scene, with_method(scene, method));
    for (std::size_t k = 0; k < 6; ++k) {
      (void)feeder.process(scene.frames[k]);
      (void)clean.process(scene.frames[k]);
    }
    const State before = state(feeder.navigator);
    for (const Bad& b : bad) {
      StereoFrame frame = scene.frames[6];
      b.spoil(frame);
      feeder.feed_inputs(scene.frames[6].t_ns);
      const std::string message = message_of([&] { (void)feeder.navigator.process(frame); });
      EXPECT_NE(message.find(b.says), std::string::npos) << message;
      EXPECT_NE(message.find(std::to_string(frame.t_ns)), std::string::npos) << message;
      EXPECT_TRUE(state(feeder.navigator) == before) << b.says << ", " << to_string(method);
    }
    // And the run goes on as if nothing had happened.
    (void)feeder.process(scene.frames[6]);
    (void)clean.process(scene.frames[6]);
    EXPECT_TRUE(state(feeder.navigator) == state(clean.navigator)) << to_string(method);
  }
}

TEST(StereoFilter, APixelThatNobodySawMayBeAnything) {
  const Scene scene = small_scene();
  Feeder feeder(scene, scene.options);
  StereoFrame frame = scene.frames[0];
  frame.observations[0].in_cam1 = false;
  frame.observations[0].uv_cam1.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NO_THROW((void)feeder.process(frame));
  EXPECT_TRUE(feeder.navigator.estimate().P().dense().allFinite());
}

TEST(StereoFilter, AnEmptyFrameOnlyPredicts) {
  const Scene scene = small_scene();
  for (const Method method : kAllMethods) {
    Feeder feeder(scene, with_method(scene, method));
    (void)feeder.process(scene.frames[0]);
    Feeder twin = feeder;
    StereoFrame empty;
    empty.t_ns = scene.frames[1].t_ns;
    const FrameReport report = feeder.process(empty);
    EXPECT_EQ(report.status, UpdateStatus::kEmpty);
    EXPECT_EQ(report.t_ns, empty.t_ns);
    EXPECT_EQ(report.observed, 0U);
    EXPECT_EQ(report.used, 0U);
    EXPECT_EQ(report.initialized, 0U);
    twin.feed_inputs(empty.t_ns);
    twin.navigator.predict_to(empty.t_ns);
    EXPECT_TRUE(state(feeder.navigator) == state(twin.navigator)) << to_string(method);
  }
}

TEST(StereoFilter, ARunOfEmptyFramesFollowsTheInputs) {
  SceneOptions options;
  options.noise = false;
  const Scene scene = make_scene(options);
  Feeder feeder(scene, scene.options);
  for (StereoFrame frame : scene.frames) {
    frame.observations.clear();
    (void)feeder.process(frame);
  }
  EXPECT_LE(testing::position_error(feeder.navigator, scene.truth.back()), 1e-9);
}

TEST(StereoFilter, PredictingBackwardsDoesNothing) {
  const Scene scene = small_scene();
  Feeder feeder(scene, scene.options);
  (void)feeder.process(scene.frames[0]);
  (void)feeder.process(scene.frames[1]);
  const State before = state(feeder.navigator);
  feeder.navigator.predict_to(scene.frames[0].t_ns);
  feeder.navigator.predict_to(scene.frames[1].t_ns);
  EXPECT_TRUE(state(feeder.navigator) == before);
}

TEST(StereoFilter, PointsThatLeaveAndComeBackAreStillKnown) {
  const Scene scene = small_scene();
  for (const Method method : kAllMethods) {
    Feeder feeder(scene, with_method(scene, method));
    std::size_t missing_used = 0;
    for (std::size_t k = 0; k < scene.frames.size(); ++k) {
      StereoFrame frame = scene.frames[k];
      if (k >= 8 && k < 12) {
        std::erase_if(frame.observations, [](const StereoObservation& o) { return o.track_id % 2 == 0; });
      }
      const std::size_t known = feeder.navigator.estimate().landmarks().size();
      const FrameReport report = feeder.process(frame);
      if (k >= 8 && k < 12) {
        EXPECT_GE(feeder.navigator.estimate().landmarks().size(), known);
      }
      if (k == 12) {
        for (const StereoObservation& o : frame.observations) {
          missing_used +=
              o.track_id % 2 == 0 && feeder.navigator.estimate().find(o.track_id) != nullptr ? 1 : 0;
        }
        EXPECT_LE(report.initialized, 3U) << to_string(method);
        EXPECT_GE(report.used + 5, report.observed) << to_string(method);
      }
    }
    EXPECT_GE(missing_used, 8U) << to_string(method);
  }
}

TEST(StereoFilter, APointOfTheRightCameraAloneIsNotInitializedButUsedOnceKnown) {
  const Scene scene = small_scene();
  Feeder feeder(scene, with_method(scene, Method::kLcekf));
  StereoFrame frame = scene.frames[0];
  const std::int64_t id = frame.observations[0].track_id;
  frame.observations[0].in_cam0 = false;
  const FrameReport first = feeder.process(frame);
  EXPECT_EQ(feeder.navigator.estimate().find(id), nullptr);
  const auto right_only = std::count_if(frame.observations.begin(), frame.observations.end(),
                                        [](const StereoObservation& o) { return !o.in_cam0; });
  EXPECT_EQ(first.initialized + static_cast<std::size_t>(right_only), first.observed);

  (void)feeder.process(scene.frames[1]);
  ASSERT_NE(feeder.navigator.estimate().find(id), nullptr);
  frame = scene.frames[2];
  frame.observations[0].in_cam0 = false;
  ASSERT_EQ(frame.observations[0].track_id, id);
  (void)feeder.process(frame);
  EXPECT_EQ(feeder.navigator.estimate().find(id)->last_seen_ns, frame.t_ns);
}

TEST(StereoFilter, APointOfTheLeftCameraAloneIsInitializedAndItsDepthFoundFromMotion) {
  SceneOptions options;
  options.duration_s = 3.0;
  options.points = 40;
  const Scene scene = make_scene(options);
  for (const Method method : {Method::kEkf, Method::kLcekf, Method::kMonoLeft}) {
    Feeder feeder(scene, with_method(scene, method));
    for (StereoFrame frame : scene.frames) {
      for (StereoObservation& o : frame.observations) {
        o.in_cam1 = o.in_cam1 && o.track_id >= 20;
      }
      (void)feeder.process(frame);
    }
    const Estimate& estimate = feeder.navigator.estimate();
    int judged = 0;
    for (const Landmark& landmark : estimate.landmarks()) {
      if (landmark.track_id < 20 && landmark.last_seen_ns == scene.frames.back().t_ns) {
        Eigen::Matrix3d P;
        const Vector3d p = estimate.landmark_position(landmark, &P);
        const Vector3d e = p - scene.landmarks[static_cast<std::size_t>(landmark.track_id)];
        EXPECT_LE(e.dot(Cholesky(P).solve(e)), 40.0) << to_string(method);
        judged += std::sqrt(P.trace()) < 0.2 * p.norm() ? 1 : 0;
      }
    }
    EXPECT_GE(judged, 5) << to_string(method);
  }
}

TEST(StereoFilter, TheMapKeepsToItsSize) {
  SceneOptions options;
  options.duration_s = 1.0;
  options.points = 40;
  const Scene scene = make_scene(options);
  NavigatorOptions few = scene.options;
  few.map.max_landmarks = 25;
  Feeder feeder(scene, few);
  std::size_t removed = 0;
  for (std::size_t k = 0; k < scene.frames.size(); ++k) {
    StereoFrame frame = scene.frames[k];
    // 12 points in view at a time, all of them in turn.
    std::erase_if(frame.observations, [&](const StereoObservation& o) {
      return (static_cast<std::size_t>(o.track_id) + 40 - 2 * k % 40) % 40 >= 12;
    });
    removed += feeder.process(frame).removed;
    EXPECT_LE(feeder.navigator.estimate().landmarks().size(), 25U);
  }
  EXPECT_GT(removed, 0U);
}

TEST(StereoFilter, TakesAsManyPointsAsItMayAndIsItsTwinThatIsShownThoseAlone) {
  const Scene scene = small_scene();
  constexpr std::size_t kMost = 15;
  NavigatorOptions few = scene.options;
  few.map.points_per_update = kMost;
  ASSERT_GT(scene.frames.front().observations.size(), 2 * kMost);
  Feeder with(scene, few), twin(scene, scene.options);
  LandmarkBudget budget(scene.calibration, kMost);
  std::int64_t previous_ns = std::numeric_limits<std::int64_t>::min();
  std::size_t left_out = 0;
  for (const StereoFrame& frame : scene.frames) {
    const StereoFrame chosen = budget.choose(frame, twin.navigator.estimate(), previous_ns);
    const FrameReport report = with.process(frame);
    (void)twin.process(chosen);
    EXPECT_EQ(report.observed, frame.observations.size());
    EXPECT_LE(report.used, kMost);
    left_out += frame.observations.size() - chosen.observations.size();
    previous_ns = frame.t_ns;
  }
  EXPECT_GT(left_out, 10 * scene.frames.size());
  EXPECT_TRUE(state(with.navigator) == state(twin.navigator));
}

TEST(StereoFilter, NewLandmarksThatContradictTheirFrameLeaveNoTrace) {
  const Scene scene = small_scene();
  for (const LandmarkKind kind : {LandmarkKind::kInverseDepth, LandmarkKind::kCartesian}) {
    Feeder with(scene, with_method(scene, Method::kLcekf, kind));
    Feeder without(scene, with_method(scene, Method::kLcekf, kind));
    for (std::size_t k = 0; k < 10; ++k) {
      StereoFrame frame = scene.frames[k];
      const FrameReport clean = without.process(frame);
      std::vector<std::int64_t> wrong;
      if (k > 3) {
        // Four that agree with each other hide well behind the huge covariance of Cartesian new landmarks.
        for (std::int64_t id = 1000; id < (kind == LandmarkKind::kCartesian ? 1001 : 1004); ++id) {
          StereoObservation o = frame.observations[static_cast<std::size_t>(id - 1000)];
          o.track_id = id + 10 * static_cast<std::int64_t>(k);
          o.uv_cam1.y() += 150.0;  // no depth explains that
          frame.observations.push_back(o);
          wrong.push_back(o.track_id);
        }
      }
      const FrameReport report = with.process(frame);
      EXPECT_EQ(report.used, clean.used);
      EXPECT_EQ(report.refused.size(), clean.refused.size() + wrong.size());
      for (const std::int64_t id : wrong) {
        EXPECT_EQ(with.navigator.estimate().find(id), nullptr);
      }
      const Snapshot a = snapshot(with.navigator.estimate());
      const Snapshot b = snapshot(without.navigator.estimate());
      ASSERT_EQ(a.track_ids, b.track_ids);
      EXPECT_LE((a.mean - b.mean).cwiseAbs().maxCoeff(), 1e-8) << k;
      EXPECT_EQ(with.navigator.estimate().size(), without.navigator.estimate().size());
    }
  }
}

TEST(StereoFilter, OutliersAreRefusedAndNamed) {
  const Scene scene = small_scene();
  for (const Method method : kAllMethods) {
    Feeder feeder(scene, with_method(scene, method));
    for (std::size_t k = 0; k < 10; ++k) {
      (void)feeder.process(scene.frames[k]);
    }
    StereoFrame frame = scene.frames[10];
    std::int64_t id = -1;
    for (StereoObservation& o : frame.observations) {
      const Landmark* landmark = feeder.navigator.estimate().find(o.track_id);
      if (o.in_cam0 && landmark != nullptr) {
        o.uv_cam0 += Vector2d(30.0, -25.0);
        id = o.track_id;
        break;
      }
    }
    const FrameReport report = feeder.process(frame);
    bool named = false;
    for (const Refusal& r : report.refused) {
      named |= r.track_id == id && r.reason == RefusalReason::kGate && r.distance > r.threshold;
    }
    EXPECT_TRUE(named) << to_string(method);
    ASSERT_NE(feeder.navigator.estimate().find(id), nullptr);
    EXPECT_EQ(feeder.navigator.estimate().find(id)->refusals, 1);
    // Seen well again, it is forgiven.
    (void)feeder.process(scene.frames[11]);
    EXPECT_EQ(feeder.navigator.estimate().find(id)->refusals, 0) << to_string(method);
  }
}

TEST(StereoFilter, WithTheGateOffNothingIsRefused) {
  const Scene scene = small_scene();
  NavigatorOptions options = scene.options;
  options.gate = false;
  Feeder feeder(scene, options);
  for (const StereoFrame& frame : scene.frames) {
    EXPECT_TRUE(feeder.process(frame).refused.empty());
  }
}

}  // namespace
}  // namespace limber

/// Tells a filter what Navigator would tell it.
struct limber::testing::StereoFilterDoubt {
  static void begin(StereoFilter& filter, const CalibrationPrior& prior) { filter.distrust(prior); }
};

namespace limber {
namespace {

/// With a degree of doubt a right pixel that is 15 px off contradicts nothing but the other points.
TEST(StereoFilter, InDoubtPointsAreJudgedBesideEachOther) {
  SceneOptions options;
  options.duration_s = 2.0;
  options.theta_error = [](double t) {
    return t < 1.0 ? RigParameters(RigParameters::Zero()) : testing::scene_theta_error();
  };
  const Scene scene = make_scene(options);
  testing::Feeder feeder(scene, testing::with_method(scene, Method::kAdaptive));
  std::size_t mismatched = 0, found = 0, others = 0;
  for (std::size_t k = 0; k < scene.frames.size(); ++k) {
    feeder.feed_inputs(scene.frames[k].t_ns);
    if (k == 19) {
      testing::StereoFilterDoubt::begin(feeder.navigator, {100.0 * Eigen::Matrix<double, 6, 6>::Identity(),
                                                           WhiteSize::Vector6::Constant(10.0)});
    }
    StereoFrame frame = scene.frames[k];
    std::vector<std::int64_t> wrong;
    for (StereoObservation& o : frame.observations) {
      if (k >= 22 && o.in_cam0 && o.in_cam1 && o.track_id % 8 == static_cast<std::int64_t>(k % 8) &&
          feeder.navigator.estimate().find(o.track_id) != nullptr) {
        o.uv_cam1.x() += 15.0;
        wrong.push_back(o.track_id);
      }
    }
    const FrameReport report = feeder.process(frame);
    mismatched += wrong.size();
    for (const Refusal& refusal : report.refused) {
      const bool is_wrong = std::find(wrong.begin(), wrong.end(), refusal.track_id) != wrong.end();
      found += is_wrong ? 1 : 0;
      others += k >= 22 && !is_wrong ? 1 : 0;
    }
  }
  ASSERT_GT(mismatched, 50U);
  EXPECT_GE(static_cast<double>(found), 0.95 * static_cast<double>(mismatched));
  EXPECT_LE(others, 2U);
}

}  // namespace
}  // namespace limber
