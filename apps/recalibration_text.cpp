// SPDX-License-Identifier: MIT
#include "recalibration_text.hpp"

#include <fmt/format.h>

#include <cmath>

#include "limber/io/parameter_text.hpp"
#include "limber/sensors/parameters.hpp"
#include "ordered_json.hpp"

namespace limber::app {
namespace {

std::string verdict_in_words(const Recalibration& found) {
  switch (found.verdict) {
    case RecalibrationVerdict::kBetter:
      return "the given calibration is off; the corrected one is better, also where it was not made";
    case RecalibrationVerdict::kWithinTolerance:
      return "the given calibration is good enough: keep it";
    case RecalibrationVerdict::kNotBetter:
      return "something differs, but the rest of the recording does not confirm the corrected calibration: "
             "keep the "
             "given one";
    case RecalibrationVerdict::kCannotTell:
      break;
  }
  return "cannot tell: what the recording says leaves both sides of the tolerance open, or lies outside by "
         "no "
         "more than accepted calibrations of one rig differ by (0.1 px, 2 % of depth); keep the given "
         "calibration";
}

/// In degrees or millimetres.
double shown(Eigen::Index axis, double value) { return axis < 3 ? value * 180.0 / M_PI : 1e3 * value; }

std::string axes_text(const Recalibration& found) {
  std::string out;
  const RigParameters change = found.fitted.theta - found.given.theta;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const auto axis = static_cast<std::size_t>(k);
    const double sigma = shown(k, std::sqrt(found.fit.covariance(k, k)));
    const char* unit = k < 3 ? "deg" : "mm";
    if (!found.fit.seen[axis]) {
      out += fmt::format("  {}  not seen, left as given (± {:.3f} {} are taken for it)\n",
                         kParameterNames.at(axis), sigma, unit);
      continue;
    }
    out += fmt::format("  {}  {:+.3f} ± {:.3f} {}\n", kParameterNames.at(axis), shown(k, change(k)), sigma,
                       unit);
  }
  if (!found.length_seen) {
    out += "  the baseline's length was not seen: nothing else in the recording fixes the scale\n";
  }
  return out;
}

std::string depth_text(const DepthChange& change) {
  return std::isfinite(change.share) ? fmt::format("{:+.1f} ± {:.1f} % at {:.3g} m", 100.0 * change.share,
                                                   100.0 * change.sigma, change.depth)
                                     : fmt::format("nothing measured at {:.3g} m", change.depth);
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json pair(const BeforeAfter& value) {
  return {{"given", number(value.given)}, {"corrected", number(value.fitted)}};
}

Json depth(const DepthChange& change) {
  return {{"depth_m", change.depth}, {"share", number(change.share)}, {"sigma", number(change.sigma)}};
}

Json covariance(const RigMatrix& matrix) {
  Json out = Json::array();
  for (Eigen::Index k = 0; k < 6; ++k) {
    const Eigen::RowVectorXd row = matrix.row(k);
    out.push_back(std::vector<double>(row.data(), row.data() + row.size()));
  }
  return out;
}

Json axes(const Recalibration& found) {
  Json out;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const auto axis = static_cast<std::size_t>(k);
    out[std::string(kParameterNames.at(axis))] = {{"seen", found.fit.seen[axis]},
                                                  {"given", shown(k, found.given.theta(k))},
                                                  {"corrected", shown(k, found.fitted.theta(k))},
                                                  {"sigma", shown(k, std::sqrt(found.fit.covariance(k, k)))},
                                                  {"unit", k < 3 ? "deg" : "mm"}};
  }
  return out;
}

}  // namespace

std::string to_text(const Recalibration& found, const std::string& dataset,
                    const std::optional<BeforeAfter>& ate, const std::string& written) {
  std::string out = fmt::format("{}: {}\n", dataset, verdict_in_words(found));
  out += "correction (true minus given):\n" + axes_text(found);
  out += fmt::format(
      "epipolar error  {:.2f} -> {:.2f} px (the correction moves points by {:.2f} ± {:.2f} px)\n",
      found.epipolar_px.given, found.epipolar_px.fitted, found.epipolar_change_px, found.epipolar_sigma_px);
  out += "depth with the given calibration is wrong by " + depth_text(found.at_tolerance);
  for (const DepthChange& change : found.depths) {
    out += ", " + depth_text(change);
  }
  out += fmt::format("\nheld out: squared distance {:.1f} -> {:.1f}, from {} windows with {} keyframes\n",
                     found.held_out.given, found.held_out.fitted, found.windows.size(), found.keyframes);
  if (ate) {
    out += fmt::format("ATE of ekf  {:.4f} -> {:.4f} m\n", ate->given, ate->fitted);
  }
  return out + (written.empty() ? "no calibration was written\n" : fmt::format("written to {}\n", written));
}

std::string to_json(const Recalibration& found, const std::string& dataset,
                    const std::optional<BeforeAfter>& ate, const std::vector<std::string>& files) {
  Json out;
  out["recalibration"] = to_string(found.verdict);
  out["dataset"] = dataset;
  out["axes"] = axes(found);
  out["covariance"] = covariance(found.fit.covariance);  // [rad, m]
  out["spread"] = found.fit.spread;
  out["baseline_length_seen"] = found.length_seen;
  out["epipolar_px"] = pair(found.epipolar_px);
  out["epipolar_change_px"] = {{"size", found.epipolar_change_px}, {"sigma", found.epipolar_sigma_px}};
  out["depth_at_tolerance"] = depth(found.at_tolerance);
  out["depths"] = Json::array();
  for (const DepthChange& change : found.depths) {
    out["depths"].push_back(depth(change));
  }
  out["held_out"] = pair({found.held_out.given, found.held_out.fitted});
  out["windows"] = found.windows.size();
  out["keyframes"] = found.keyframes;
  out["ate_ekf_m"] = ate ? pair(*ate) : Json(nullptr);
  out["files"] = files;
  out["notes"] = found.notes;
  return json_text(out);
}

}  // namespace limber::app
