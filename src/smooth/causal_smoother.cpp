// SPDX-License-Identifier: MIT
#include "limber/smooth/causal_smoother.hpp"

#include <algorithm>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "limber/core/time.hpp"
#include "smoothing.hpp"

namespace limber {

using namespace detail;

namespace {

/// `to` of a guess, moved by what an estimate of `from` differs from the guess of it.
NavigationState moved_along(const NavigationState& guess_from, const NavigationState& guess_to,
                            const NavigationState& from) {
  NavigationState out = guess_to;
  const Eigen::Matrix3d turn = from.T_world_body.R * guess_from.T_world_body.R.transpose();
  out.T_world_body.R = turn * guess_to.T_world_body.R;
  out.T_world_body.p = from.T_world_body.p + turn * (guess_to.T_world_body.p - guess_from.T_world_body.p);
  out.v_world_body = from.v_world_body + turn * (guess_to.v_world_body - guess_from.v_world_body);
  out.bias_gyro = from.bias_gyro;
  out.bias_accel = from.bias_accel;
  return out;
}

/// The samples that a problem over these moments needs: some before them, to see what is usual, and one
/// after.
template <typename Sample>
std::span<const Sample> samples_over(std::span<const Sample> all, std::int64_t begin_ns,
                                     std::int64_t end_ns) {
  constexpr std::int64_t kBeforeNs = 1'000'000'000;
  const auto earlier = [](const Sample& sample, std::int64_t t_ns) { return sample.t_ns < t_ns; };
  const auto first = std::lower_bound(all.begin(), all.end(), begin_ns - kBeforeNs, earlier);
  const auto last = std::lower_bound(first, all.end(), end_ns, earlier);
  return {first, last == all.end() ? last : last + 1};
}

class MovingHorizon {
 public:
  MovingHorizon(const SmootherInput& input, const StereoCalibration& calibration,
                const SmootherOptions& options, const Horizon& horizon)
      : input_(input),
        calibration_(calibration),
        options_(options),
        horizon_(horizon),
        states_(input.start.begin(), input.start.end()),
        known_(input.frames.size()) {
    out_.converged = true;
  }

  void solve_until(std::size_t newest) {
    const std::size_t oldest = oldest_of(newest);
    const KnownState* const known = oldest > 0 ? &known_[oldest] : nullptr;
    if (newest > horizon_.first) {
      states_[newest] = moved_along(input_.start[newest - 1], input_.start[newest], states_[newest - 1]);
    }
    std::vector<StereoFrame> frames(input_.frames.begin() + static_cast<std::ptrdiff_t>(oldest),
                                    input_.frames.begin() + static_cast<std::ptrdiff_t>(newest + 1));
    if (known != nullptr) {
      frames.front().observations.clear();
    }
    const std::int64_t begin_ns = frames.front().t_ns, end_ns = frames.back().t_ns;
    const SmootherInput input{frames, samples_over(input_.imu, begin_ns, end_ns),
                              samples_over(input_.odometry, begin_ns, end_ns),
                              std::span(states_).subspan(oldest, newest - oldest + 1), input_.prior};
    SmootherOptions options = options_;
    options.covariance = newest == horizon_.first && options_.covariance;
    Smoothing smoothing(input, calibration_, options, {}, known);
    smoothing.solve();
    SmootherResult result = smoothing.result();
    known_[newest] = smoothing.newest(result.frames.back());
    for (; forgotten_ < oldest; ++forgotten_) {
      known_[forgotten_] = {};
    }
    take(std::move(result), oldest, newest);
  }

  [[nodiscard]] SmootherResult take_result() { return std::move(out_); }

 private:
  /// Never the newest itself: a gap may be longer than the window.
  [[nodiscard]] std::size_t oldest_of(std::size_t newest) const {
    std::size_t oldest = newest > 0 ? newest - 1 : 0;
    while (oldest > 0 &&
           seconds_between(input_.frames[oldest - 1].t_ns, input_.frames[newest].t_ns) <= horizon_.window_s) {
      --oldest;
    }
    return oldest < horizon_.first || newest == horizon_.first ? 0 : oldest;
  }

  void take(SmootherResult result, std::size_t oldest, std::size_t newest) {
    const std::size_t done = out_.frames.size();  // before: rows that stay as they are
    for (std::size_t k = oldest; k <= newest; ++k) {
      states_[k] = result.frames[k - oldest].nav;
      if (k >= done) {
        out_.frames.push_back(std::move(result.frames[k - oldest]));
      }
    }
    for (RefusedPixel& pixel : result.refused) {
      pixel.frame += oldest;
      if (pixel.frame >= done) {
        out_.refused.push_back(pixel);
      }
    }
    for (const auto& [id, place] : result.landmarks) {
      out_.landmarks[id] = place;
    }
    out_.squared_residuals += result.squared_residuals;
    out_.dof += result.dof;
    out_.iterations += result.iterations;
    out_.converged = out_.converged && result.converged;
  }

  const SmootherInput& input_;
  const StereoCalibration& calibration_;
  const SmootherOptions& options_;
  const Horizon& horizon_;
  std::vector<NavigationState> states_;  // as the newest problem has them, the guess's after it
  std::vector<KnownState> known_;        // of each frame in the window, when it was the newest
  std::size_t forgotten_ = 0;            // so many frames are behind the window
  SmootherResult out_;
};

}  // namespace

SmootherResult smooth_causally(const SmootherInput& input, const StereoCalibration& calibration,
                               const SmootherOptions& options, const Horizon& horizon,
                               const std::function<void(std::size_t)>& progress) {
  check(input, options);
  if (!(horizon.window_s > 0.0) || horizon.first >= input.frames.size()) {
    throw std::invalid_argument(
        "smoother: expected a window of more than 0 s and a first frame of the input");
  }
  MovingHorizon moving(input, calibration, options, horizon);
  for (std::size_t k = horizon.first; k < input.frames.size(); ++k) {
    moving.solve_until(k);
    if (progress) {
      progress(k + 1);
    }
  }
  return moving.take_result();
}

}  // namespace limber
