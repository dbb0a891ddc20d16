// SPDX-License-Identifier: MIT
#include "image_navigator.hpp"

#include <limber/clean/frame_cleaner.hpp>
#include <limber/core/divergence_error.hpp>
#include <limber/core/errors.hpp>
#include <limber/frontend/decode_image.hpp>
#include <limber/initialize/online_navigator.hpp>
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
RunSetup set_up(const StereoCalibration& calibration, const std::optional<ImuNoise>& noise,
                MotionModel motion, const RunOptions& options) {
  Recording recording;
  recording.name = "the node";
  recording.calibration = calibration;
  recording.imu_noise = noise;
  recording.images.resize(1);
  recording.imu.resize(motion == MotionModel::kImu ? 1 : 0);
  recording.odometry.resize(motion == MotionModel::kOdometry ? 1 : 0);
  return set_up_run(recording, options);
}

MotionModel motion_of(const StereoCalibration& calibration, const ImageNavigatorOptions& options) {
  if (options.uses_odometry) return MotionModel::kOdometry;
  return calibration.body == BodyFrame::kImu ? MotionModel::kImu : MotionModel::kConstantVelocity;
}

bool is_finite(const ImuSample& sample) {
  return sample.omega_imu.allFinite() && sample.accel_imu.allFinite();
}

bool is_finite(const OdometrySample& sample) {
  return sample.v_body.allFinite() && sample.omega_body.allFinite();
}

void give(OnlineNavigator& navigator, const ImuSample& sample) { navigator.add_imu(sample); }

void give(OnlineNavigator& navigator, const OdometrySample& sample) { navigator.add_odometry(sample); }

template <typename Input>
std::int64_t time_of(const Input& input) {
  return std::visit([](const auto& sample) { return sample.t_ns; }, input);
}

}  // namespace

/// Everything between one start and the next, but for samples and images that wait.
struct ImageNavigator::Session {
  Session(const StereoCalibration& calibration, const ImageNavigatorOptions& options, RunSetup run_setup)
      : setup(std::move(run_setup)),
        tracker(calibration, options.tracker),
        cleaner(setup.calibration, options.run.cleaning),
        navigator(setup.navigator, setup.calibration) {}

  /// Samples up to the first one at or after t; the rest waits.
  void feed(std::deque<Input>& inputs, std::int64_t t_ns) {
    while (!inputs.empty() && (!fed_ns || *fed_ns < t_ns)) {
      const Input input = inputs.front();
      inputs.pop_front();
      fed_ns = time_of(input);
      std::visit([&](const auto& sample) { give(navigator, sample); }, input);
    }
  }

  RunSetup setup;
  StereoTracker tracker;
  FrameCleaner cleaner;
  OnlineNavigator navigator;
  std::optional<std::int64_t> fed_ns;
  std::shared_ptr<const CalibrationReport> told;  ///< the last one
  bool is_lost = false;
};

ImageNavigator::ImageNavigator(StereoCalibration calibration, std::optional<ImuNoise> imu_noise,
                               ImageNavigatorOptions options, NavigationListener& listener)
    : calibration_(std::move(calibration)),
      imu_noise_(imu_noise),
      options_(std::move(options)),
      listener_(listener),
      motion_(motion_of(calibration_, options_)) {
  if (motion_ == MotionModel::kOdometry) {
    listener_.note("odometry is taken for velocities of the body that the calibration speaks of");
  } else if (motion_ == MotionModel::kConstantVelocity) {
    listener_.note("the calibration does not say where the IMU sits: it is not used");
  }
}

ImageNavigator::~ImageNavigator() = default;

void ImageNavigator::begin_anew(const std::string& why) {
  listener_.warning(why + ": starting anew");
  session_.reset();
  inputs_.clear();
  pairs_.clear();
  last_input_ns_.reset();
  for (std::size_t c = 0; c < 2; ++c) {
    waiting_[c].clear();
    last_image_ns_[c].reset();
  }
}

bool ImageNavigator::follows(std::int64_t t_ns, std::optional<std::int64_t>& last_ns, const char* what) {
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

void ImageNavigator::add_imu(const ImuSample& sample) {
  if (motion_ == MotionModel::kImu) add_input(sample, "IMU sample");
}

void ImageNavigator::add_odometry(const OdometrySample& sample) {
  if (motion_ == MotionModel::kOdometry) add_input(sample, "odometry sample");
}

void ImageNavigator::add_input(const Input& input, const char* what) {
  if (!std::visit([](const auto& sample) { return is_finite(sample); }, input)) {
    listener_.warning(std::string("an ") + what + " that is not finite is left out");
  } else if (follows(time_of(input), last_input_ns_, what)) {
    inputs_.push_back(input);
    advance();
  }
}

void ImageNavigator::add_image(std::size_t camera, std::int64_t t_ns, EncodedImage image) {
  if (follows(t_ns, last_image_ns_.at(camera), camera == 0 ? "left image" : "right image")) {
    image.bits = options_.bits;
    waiting_[camera].push_back({t_ns, std::move(image)});
    pair_up();
    advance();
  }
}

void ImageNavigator::pair_up() {
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

bool ImageNavigator::is_covered(std::int64_t t_ns) const {
  const std::int64_t late_ns = session_ ? session_->navigator.clock_offset_ns() : 0;
  return motion_ == MotionModel::kConstantVelocity || (last_input_ns_ && *last_input_ns_ >= t_ns + late_ns);
}

void ImageNavigator::advance() {
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

void ImageNavigator::process(const Pair& pair) {
  const std::int64_t t_ns = pair[0].t_ns;
  if (!session_) {
    const bool driven = motion_ != MotionModel::kConstantVelocity;
    if (driven && (inputs_.empty() || t_ns < time_of(inputs_.front()))) {
      return;  // before the first input
    }
    begin_session(pair);
  }
  const GreyPixels left = decode_grey(pair[0].image, "left image at " + std::to_string(t_ns) + " ns");
  const GreyPixels right = decode_grey(pair[1].image, "right image at " + std::to_string(t_ns) + " ns");
  const StereoFrame frame =
      session_->cleaner.clean(session_->tracker.process(t_ns, left.view(), right.view()));
  navigate(frame);
}

void ImageNavigator::begin_session(const Pair& pair) {
  Camera* const cameras[] = {&calibration_.cam0, &calibration_.cam1};
  for (std::size_t c = 0; c < 2; ++c) {
    if (cameras[c]->width == 0) {
      std::tie(cameras[c]->width, cameras[c]->height) = size_of(pair[c].image, "the first image");
    }
  }
  session_ = std::make_unique<Session>(calibration_, options_,
                                       set_up(calibration_, imu_noise_, motion_, options_.run));
  for (const std::string& note : session_->setup.notes) {
    listener_.note(note);
  }
}

void ImageNavigator::navigate(const StereoFrame& frame) {
  Session& session = *session_;
  session.feed(inputs_, frame.t_ns + session.navigator.clock_offset_ns());
  const OnlineReport report = session.navigator.process(frame);
  if (report.start) {
    tell_start(frame.t_ns, *report.start);
  }
  if (session.navigator.started()) {
    session.is_lost = session.is_lost || (report.frame && report.frame->reset);
    tell_state();
  }
  if (report.frame) {
    tell_frame(*report.frame);
  }
}

void ImageNavigator::tell_start(std::int64_t t_ns, const StartReport& report) {
  if (report.status == StartStatus::kWaiting) {
    listener_.diagnostic({t_ns,
                          Diagnostic::Level::kStale,
                          "limber: navigation",
                          "starting, not known yet: " + report.missing,
                          {}});
  } else {
    listener_.note("started after " + std::to_string(report.waited_s) + " s" +
                   (report.missing.empty() ? "" : "; not known: " + report.missing));
  }
}

void ImageNavigator::tell_frame(const FrameReport& report) {
  Session& session = *session_;
  listener_.diagnostic(navigation_diagnostic(frame_row(report), session.is_lost));
  if (report.calibration && report.calibration != session.told) {
    session.told = report.calibration;
    listener_.diagnostic(calibration_diagnostic(health_row(*report.calibration)));
  }
}

void ImageNavigator::tell_state() {
  const Estimate& estimate = session_->navigator.estimate();
  const TrajectoryRow row = trajectory_row(estimate.nav(), estimate.layout().motion,
                                           estimate.P().diagonal_block<StateLayout::kPoseSize>(0));
  if (!row.T_world_body.p.allFinite() || !row.T_world_body.R.allFinite() || !row.covariance->allFinite()) {
    throw DivergenceError("the state is not finite");
  }
  listener_.pose(row);
}

}  // namespace limber
