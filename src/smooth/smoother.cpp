// SPDX-License-Identifier: MIT
#include "limber/smooth/smoother.hpp"

#include "smoothing.hpp"

namespace limber {

double cost_of_start(const SmootherInput& input, const StereoCalibration& calibration,
                     const SmootherOptions& options) {
  detail::check(input, options);
  return detail::Smoothing(input, calibration, options).cost();
}

SmootherResult smooth(const SmootherInput& input, const StereoCalibration& calibration,
                      const SmootherOptions& options, const std::function<void(int)>& progress) {
  detail::check(input, options);
  detail::Smoothing smoothing(input, calibration, options, progress);
  smoothing.solve();
  return smoothing.result();
}

}  // namespace limber
