// SPDX-License-Identifier: MIT
#include "remarks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "limber/core/median.hpp"
#include "limber/core/time.hpp"

namespace limber::detail {
namespace {

constexpr double kGapInIntervals = 5.0;  // of the usual interval between samples
constexpr std::int64_t kGapNs = 100'000'000;
constexpr std::int64_t kBlindNs = 1'000'000'000;
constexpr double kLeastForce = 0.5, kLargestForce = 1.5;  // mean specific force, in gravities
constexpr double kLargestRate = 10.0;                     // [rad/s] mean, of anything that carries cameras
constexpr double kNoisyImu = 3.0;                         // times the stated noise
constexpr double kSuspiciousNis = 3.0;                    // per degree of freedom
constexpr double kLargeNoise_px = 4.0;                    // rectified tracks need 0.1 to 3.5
constexpr double kModestNis = 0.4;                        // "

/// Where a sensor was silent.
struct Gaps {
  std::size_t count = 0;
  std::int64_t longest = 0, from = 0;  // [ns]
};

/// Between two times, of `least` [ns] and some of the usual interval.
template <typename Sample>
Gaps gaps_in(const std::vector<Sample>& samples, std::int64_t begin_ns, std::int64_t end_ns,
             std::int64_t least) {
  std::vector<std::int64_t> intervals;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    intervals.push_back(samples[k].t_ns - samples[k - 1].t_ns);
  }
  double usual = 0.0;
  if (!intervals.empty()) {
    usual = static_cast<double>(upper_median(std::move(intervals)));
  }
  Gaps out;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const std::int64_t a = std::max(samples[k].t_ns, begin_ns);
    const std::int64_t b = std::min(k + 1 < samples.size() ? samples[k + 1].t_ns : end_ns, end_ns);
    if (b - a <= least || static_cast<double>(b - a) <= kGapInIntervals * usual) {
      continue;
    }
    ++out.count;
    if (b - a > out.longest) {
      out.longest = b - a;
      out.from = a;
    }
  }
  return out;
}

/// "for 2.00 s from 10.000 s on, and 2 more such gaps"
std::string in_words(const Gaps& gaps) {
  return fmt::format("for {:.2f} s from {:.3f} s on{}", to_seconds(gaps.longest), to_seconds(gaps.from),
                     gaps.count > 1 ? fmt::format(", and {} more such gaps", gaps.count - 1) : "");
}

template <typename Sample>
void remark_on_gaps(const std::vector<Sample>& samples, std::int64_t begin_ns, std::int64_t end_ns,
                    const char* sensor, std::vector<std::string>& remarks) {
  if (const Gaps gaps = gaps_in(samples, begin_ns, end_ns, kGapNs); gaps.count > 0) {
    remarks.push_back(
        fmt::format("the {} has no sample {}: the motion there is guessed", sensor, in_words(gaps)));
  }
}

/// Frames that did not come, and a right camera that saw nothing for a while, or from a time on.
void remark_on_blindness(const RunRecord& record, const PointCount& points, Method method,
                         std::vector<std::string>& remarks) {
  const std::int64_t begin_ns = record.frames.front().t_ns, end_ns = record.frames.back().t_ns;
  if (const Gaps gaps = gaps_in(record.frames, begin_ns, end_ns, kBlindNs); gaps.count > 0) {
    remarks.push_back(fmt::format("no frame came {}: what the body did there is known by the inputs alone",
                                  in_words(gaps)));
  }
  const Gaps right = gaps_in(points.seen_by_right, begin_ns, end_ns, kBlindNs);
  if (right.count > 0 && method != Method::kMonoLeft) {
    remarks.push_back(fmt::format(
        "the right camera saw no point {}: this is navigation with the left camera alone", in_words(right)));
  }
}

/// Mean length of the means of a vector over a second each: what shakes a body averages out.
double usual_length(const std::vector<ImuSample>& imu, Eigen::Vector3d ImuSample::*vector) {
  double lengths = 0.0, samples = 0.0;
  for (auto begin = imu.begin(); begin != imu.end();) {
    const auto end = std::find_if(begin, imu.end(), [&](const ImuSample& sample) {
      return seconds_between(begin->t_ns, sample.t_ns) > 1.0;
    });
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (auto sample = begin; sample != end; ++sample) {
      sum += (*sample).*vector;
    }
    lengths += sum.norm();
    samples += static_cast<double>(end - begin);
    begin = end;
  }
  return lengths / samples;
}

void remark_on_units(const std::vector<ImuSample>& imu, double gravity, std::vector<std::string>& remarks) {
  const double force = usual_length(imu, &ImuSample::accel_imu);
  const double rate = usual_length(imu, &ImuSample::omega_imu);
  if (force < kLeastForce * gravity || force > kLargestForce * gravity) {
    remarks.push_back(
        fmt::format("the accelerometer shows {:.3g} m/s^2 on average, expected about {:.3g}, gravity: are "
                    "its columns the last three, its unit m/s^2?",
                    force, gravity));
  }
  if (rate > kLargestRate) {
    remarks.push_back(fmt::format("the gyroscope shows {:.3g} rad/s on average: is its unit rad/s?", rate));
  }
}

/// Where so much pixel noise was learned that it is no noise of pixels.
void remark_on_large_noise(const std::vector<FrameReport>& frames, std::vector<std::string>& remarks) {
  const auto first =
      std::ranges::find_if(frames, [](const FrameReport& frame) { return frame.sigma_px > kLargeNoise_px; });
  if (first != frames.end()) {
    remarks.push_back(fmt::format(
        "more than {:.0f} px of pixel noise were needed from {:.3f} s on to explain the points: they "
        "contradict "
        "each other or the prediction (moving things, images of another time, a rig that bends), and sigmas "
        "are too small",
        kLargeNoise_px, to_seconds(first->t_ns)));
  }
}

/// Where images ask for much more noise than the IMU was said to have.
void remark_on_noisy_imu(const ImuNoiseFactors& imu, std::vector<std::string>& remarks) {
  if (std::max(imu.gyro, imu.accel) > kNoisyImu) {
    remarks.push_back(fmt::format(
        "the IMU errs more than its stated noise: {:.2g} times that of the gyroscope and {:.2g} times that "
        "of "
        "the accelerometer were assumed most of the time; scales or axes that are off (calibrate them), "
        "vibration, stamps that jitter, or a data sheet that promises too much",
        imu.gyro, imu.accel));
  }
}

}  // namespace

void PointCount::add(const StereoFrame& frame) {
  const std::size_t before = right;
  for (const StereoObservation& point : frame.observations) {
    left += point.in_cam0 ? 1 : 0;
    right += point.in_cam1 ? 1 : 0;
  }
  if (right > before) {
    seen_by_right.push_back({frame.t_ns});
  }
}

std::int64_t frame_time(const SensorData& sensors, std::size_t n) {
  return sensors.images.empty() ? sensors.frames[n].t_ns : sensors.images[n].t_ns;
}

std::string covered_seconds(std::int64_t begin_ns, std::int64_t end_ns) {
  return fmt::format("{:.3f} s to {:.3f} s", to_seconds(begin_ns), to_seconds(end_ns));
}

std::string covered_by_frames(const Recording& recording) {
  return covered_seconds(frame_time(recording, 0), frame_time(recording, frame_count(recording) - 1));
}

std::vector<std::string> remarks_on_input(const Recording& recording, MotionModel motion, double gravity) {
  std::vector<std::string> remarks;
  const std::int64_t begin_ns = frame_time(recording, 0);
  const std::int64_t end_ns = frame_time(recording, frame_count(recording) - 1);
  if (motion == MotionModel::kImu) {
    remark_on_gaps(recording.imu, begin_ns, end_ns, "IMU", remarks);
    remark_on_units(recording.imu, gravity, remarks);
  }
  if (motion == MotionModel::kOdometry) {
    remark_on_gaps(recording.odometry, begin_ns, end_ns, "odometry", remarks);
  }
  const auto& truth = recording.truth.motion.states;
  if (!truth.empty() && (truth.back().t_ns < begin_ns || truth.front().t_ns > end_ns)) {
    remarks.push_back(fmt::format("ground truth covers {}, the frames {}: no errors are known",
                                  covered_seconds(truth.front().t_ns, truth.back().t_ns),
                                  covered_by_frames(recording)));
  }
  return remarks;
}

std::vector<std::string> remarks_on_measurements(const RunRecord& record, Method method,
                                                 const PixelNoise& sigma_px, const PointCount& points) {
  std::vector<std::string> remarks;
  std::size_t used = 0;
  double nis = 0.0, dof = 0.0;
  for (const FrameReport& frame : record.frames) {
    used += frame.used;
    nis += frame.nis;
    dof += static_cast<double>(frame.dof);
  }
  if (points.left == 0) {
    remarks.emplace_back("the left camera saw no point in any frame: this is dead reckoning");
  } else if (used == 0) {
    remarks.emplace_back("no point could be used in any frame: this is dead reckoning");
  } else if (points.right == 0 && method != Method::kMonoLeft) {
    remarks.emplace_back(
        "the right camera saw no point in any frame: this is navigation with the left camera alone");
  } else {
    remark_on_blindness(record, points, method, remarks);
  }
  if (record.pixel_noise) {
    remark_on_large_noise(record.frames, remarks);
    remarks.push_back(fmt::format(
        "pixel noise learned: white noise of {:.2g} px is assumed at the end; a point's errors in two frames "
        "that follow each other have a correlation of {:.2g}",
        record.pixel_noise->sigma_px, record.pixel_noise->correlation));
  }
  if (record.imu_noise) {
    remark_on_noisy_imu(*record.imu_noise, remarks);
  }
  if (record.odometry_noise) {
    const auto& [v, omega] = *record.odometry_noise;
    remarks.push_back(fmt::format(
        "odometry noise learned: {:.2g}, {:.2g}, {:.2g} m/s and {:.2g}, {:.2g}, {:.2g} rad/s per "
        "sample; beside it {:.0f} % of the speed are assumed",
        v.x(), v.y(), v.z(), omega.x(), omega.y(), omega.z(), 100.0 * LearnedOdometryNoise::kLasting));
  }
  if (dof > 0.0 && nis > kSuspiciousNis * dof) {
    remarks.push_back(fmt::format(
        "NIS per degree of freedom is {:.3g}, 1 is expected: the measurements contradict the model; is the "
        "calibration wrong, or the noise larger than assumed (--sigma-px)?",
        nis / dof));
  } else if (dof > 0.0 && nis < kModestNis * dof && !record.pixel_noise) {
    const double assumed = root_mean_square(sigma_px);
    remarks.push_back(fmt::format(
        "NIS per degree of freedom is {:.2g}, 1 is expected: pixels scatter from frame to frame by about "
        "{:.2g} px where {:.2g} px are assumed; where errors do not stay along a track, --sigma-px {:.2g} is "
        "better",
        nis / dof, assumed * std::sqrt(nis / dof), assumed, assumed * std::sqrt(nis / dof)));
  }
  return remarks;
}

}  // namespace limber::detail
