// SPDX-License-Identifier: MIT
#include "online_navigator.hpp"

#include <limber/clean/frame_cleaner.hpp>
#include <limber/core/divergence_error.hpp>
#include <limber/core/errors.hpp>
#include <limber/frontend/decode_image.hpp>
#include <limber/initialize/sensor_start.hpp>
#include <limber/navigate/navigator.hpp>
#include <limber/run/trajectory_row.hpp>
#include <limber/run_files/run_results.hpp>

#include <cmath>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace limber {
namespace {

constexpr std::int64_t kJumpBack = 1'000'000'000;  // [ns]
constexpr std::size_t kMostWaiting = 20;           // frames

/// Options, calibration and notes as `limber run` has them for a recording with these sensors.
RunSetup set_up(const StereoCalibration& calibration, const std::optional<ImuNoise>& noise, bool uses_imu,
                const RunOptions& options) {
  Recording recording;
  recording.name = "the node";
  recording.calibration = calibration;
  recording.imu_noise = noise;
  recording.images.resize(1);
  recording.imu.resize(uses_imu ? 1 : 0);
  return set_up_run(recording, options);
}

}  // namespace

/// Everything between one start and the next, but for samples and images that wait.
struct OnlineNavigator::Session {
  Session(const StereoCalibration& calibration, const OnlineOptions& options, RunSetup run_setup)
      : setup(std::move(run_setup)),
        tracker(calibration, options.tracker),
        cleaner(setup.calibration, options.run.cleaning),
        start(std::in_place, setup.navigator, setup.calibration) {}

  /// Samples up to the first one at or after t.
  template <typename Receiver>
  void feed(const std::deque<ImuSample>& imu, Receiver& receiver, std::int64_t t_ns) {
    while (next < imu.size() && (!fed_ns || *fed_ns < t_ns)) {
      fed_ns = imu[next].t_ns;
      receiver.add_imu(imu[next++]);
    }
  }

  RunSetup setup;
  StereoTracker tracker;
  FrameCleaner cleaner;
  std::optional<SensorStart> start;  ///< nothing once there is a navigator
  std::optional<Navigator> navigator;
  std::size_t next = 0;  ///< sample to feed
  std::optional<std::int64_t> fed_ns;
  std::shared_ptr<const CalibrationReport> told;  ///< the last one
  bool is_lost = false;
};

OnlineNavigator::OnlineNavigator(StereoCalibration calibration, std::optional<ImuNoise> imu_noise,
                                 OnlineOptions options, OnlineListener& listener)
    : calibration_(std::move(calibration)),
      imu_noise_(imu_noise),
      options_(std::move(options)),
      listener_(listener),
      uses_imu_(calibration_.body == BodyFrame::kImu) {
  if (!uses_imu_) {
    listener_.note("the calibration does not say where the IMU sits: it is not used");
  }
}

OnlineNavigator::~OnlineNavigator() = default;

void OnlineNavigator::begin_anew(const std::string& why) {
  listener_.warning(why + ": starting anew");
  session_.reset();
  imu_.clear();
  pairs_.clear();
  last_imu_ns_.reset();
  for (std::size_t c = 0; c < 2; ++c) {
    waiting_[c].clear();
    last_image_ns_[c].reset();
  }
}

bool OnlineNavigator::follows(std::int64_t t_ns, std::optional<std::int64_t>& last_ns, const char* what) {
  if (last_ns && t_ns < *last_ns - kJumpBack) {
    begin_anew(std::string("the stamps of the ") + what + " jumped back");
  }
  if (last_ns && t_ns <= *last_ns) {
    listener_.warning(std::string(what) + " at " + std::to_string(t_ns) +
                      " ns is not later than the one before: left out");
    return false;
  }
  last_ns = t_ns;
  return true;
}

void OnlineNavigator::add_imu(const ImuSample& sample) {
  if (!uses_imu_) {
    return;
  }
  if (!sample.omega_imu.allFinite() || !sample.accel_imu.allFinite()) {
    listener_.warning("an IMU sample that is not finite is left out");
  } else if (follows(sample.t_ns, last_imu_ns_, "IMU sample")) {
    imu_.push_back(sample);
    advance();
  }
}

void OnlineNavigator::add_image(std::size_t camera, std::int64_t t_ns, EncodedImage image) {
  if (follows(t_ns, last_image_ns_.at(camera), camera == 0 ? "left image" : "right image")) {
    image.bits = options_.bits;
    waiting_[camera].push_back({t_ns, std::move(image)});
    pair_up();
    advance();
  }
}

void OnlineNavigator::pair_up() {
  auto &left = waiting_[0], &right = waiting_[1];
  while (!left.empty() && !right.empty()) {
    const std::int64_t difference = right.front().t_ns - left.front().t_ns;
    if (std::abs(1e-9 * static_cast<double>(difference)) <= options_.pair_within_s) {
      pairs_.push_back({std::move(left.front()), std::move(right.front())});
      left.pop_front();
      right.pop_front();
    } else {
      listener_.warning(difference > 0 ? "a left image without a right one is left out"
                                       : "a right image without a left one is left out");
      (difference > 0 ? left : right).pop_front();
    }
  }
  for (std::size_t c = 0; c < 2; ++c) {
    while (waiting_[c].size() > kMostWaiting) {
      listener_.warning(c == 0 ? "no right images: a left one is left out"
                               : "no left images: a right one is left out");
      waiting_[c].pop_front();
    }
  }
}

bool OnlineNavigator::is_covered(std::int64_t t_ns) const {
  return !uses_imu_ || (last_imu_ns_ && *last_imu_ns_ >= t_ns);
}

void OnlineNavigator::advance() {
  while (!pairs_.empty() && (is_covered(pairs_.front()[0].t_ns) || pairs_.size() > kMostWaiting)) {
    const Pair pair = std::move(pairs_.front());
    pairs_.pop_front();
    try {
      process(pair);
    } catch (const DivergenceError& error) {
      begin_anew(error.what());
    } catch (const std::exception& error) {  // this frame; the next may be better
      listener_.warning(error.what());
    }
  }
}

void OnlineNavigator::process(const Pair& pair) {
  const std::int64_t t_ns = pair[0].t_ns;
  if (!session_) {
    if (uses_imu_ && (imu_.empty() || t_ns < imu_.front().t_ns)) {
      return;  // before the first input
    }
    begin_session(pair);
  }
  const GreyPixels left = decode_grey(pair[0].image, "left image at " + std::to_string(t_ns) + " ns");
  const GreyPixels right = decode_grey(pair[1].image, "right image at " + std::to_string(t_ns) + " ns");
  const StereoFrame frame =
      session_->cleaner.clean(session_->tracker.process(t_ns, left.view(), right.view()));
  session_->navigator ? navigate(frame) : start(frame);
}

void OnlineNavigator::begin_session(const Pair& pair) {
  Camera* const cameras[] = {&calibration_.cam0, &calibration_.cam1};
  for (std::size_t c = 0; c < 2; ++c) {
    if (cameras[c]->width == 0) {
      std::tie(cameras[c]->width, cameras[c]->height) = size_of(pair[c].image, "the first image");
    }
  }
  session_ = std::make_unique<Session>(calibration_, options_,
                                       set_up(calibration_, imu_noise_, uses_imu_, options_.run));
  for (const std::string& note : session_->setup.notes) {
    listener_.note(note);
  }
}

void OnlineNavigator::start(const StereoFrame& frame) {
  Session& session = *session_;
  session.feed(imu_, *session.start, frame.t_ns);
  const StartReport report = session.start->add_frame(frame);
  if (report.status == StartStatus::kWaiting) {
    listener_.diagnostic({frame.t_ns,
                          Diagnostic::Level::kStale,
                          "limber: navigation",
                          "starting, not known yet: " + report.missing,
                          {}});
    return;
  }
  session.navigator.emplace(session.setup.navigator, session.setup.calibration,
                            session.start->result().initial);
  session.start.reset();
  session.next = 0;  // the navigator wants the samples around its start, too
  session.fed_ns.reset();
  listener_.note("started after " + std::to_string(report.waited_s) + " s" +
                 (report.missing.empty() ? "" : "; not known: " + report.missing));
  tell_state();
}

void OnlineNavigator::navigate(const StereoFrame& frame) {
  Session& session = *session_;
  session.feed(imu_, *session.navigator, frame.t_ns);
  imu_.erase(imu_.begin(), imu_.begin() + static_cast<std::ptrdiff_t>(session.next));
  session.next = 0;
  const FrameReport report = session.navigator->process(frame);
  session.is_lost = session.is_lost || report.reset;
  tell_state();
  listener_.diagnostic(navigation_diagnostic(frame_row(report), session.is_lost));
  if (report.calibration && report.calibration != session.told) {
    session.told = report.calibration;
    listener_.diagnostic(calibration_diagnostic(health_row(frame.t_ns, *report.calibration)));
  }
}

void OnlineNavigator::tell_state() {
  const Estimate& estimate = session_->navigator->estimate();
  const TrajectoryRow row = trajectory_row(estimate.nav, estimate.layout().motion,
                                           estimate.P.diagonal_block<StateLayout::kPoseSize>(0));
  if (!row.T_world_body.p.allFinite() || !row.T_world_body.R.allFinite() || !row.covariance->allFinite()) {
    throw DivergenceError("the state is not finite");
  }
  listener_.pose(row);
}

}  // namespace limber
