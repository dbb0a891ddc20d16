// SPDX-License-Identifier: MIT
#include "limber/io/parameter_text.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

#include "limber/core/nearest_word.hpp"
#include "limber/core/split.hpp"

namespace limber {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kLargestAngle = 180.0;  // [deg]
constexpr std::size_t kThetaSize = 6;

bool is_angle(std::size_t parameter) { return unit_of(parameter) == "rad"; }

/// What 100 % of a parameter is; nothing where there is no such thing.
std::optional<double> whole_of(std::size_t parameter, const StereoCalibration& calibration) {
  const std::string_view name = kParameterNames[parameter];
  if (name.size() == 2 && name.front() == 't') {
    return calibration.baseline();
  }
  const Camera& camera = name.back() == '0' ? calibration.cam0 : calibration.cam1;
  if (name.starts_with("fu")) {
    return camera.fu;
  }
  return name.starts_with("fv") ? std::optional(camera.fv) : std::nullopt;
}

/// A number in the user's units, as radians, metres, pixels or seconds.
std::optional<double> value_of(std::string text, std::size_t parameter,
                               const StereoCalibration& calibration) {
  const bool percent = !text.empty() && text.back() == '%';
  const std::optional<double> whole = whole_of(parameter, calibration);
  if (percent) {
    text.pop_back();
  }
  std::size_t used = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    return std::nullopt;
  }
  if (used != text.size() || !std::isfinite(value) || (percent && !whole) ||
      (is_angle(parameter) && std::abs(value) > kLargestAngle)) {
    return std::nullopt;
  }
  if (percent) {
    return 0.01 * value * *whole;
  }
  return is_angle(parameter) ? value * kDegree : value;
}

struct NamedValue {
  std::optional<ParameterSet> parameters;
  std::optional<std::string> value;  ///< behind "="
};

std::string_view name_in(std::string_view item) { return item.substr(0, item.find('=')); }

NamedValue named_value(std::string_view item) {
  const std::size_t equals = item.find('=');
  NamedValue out{parameters_named(name_in(item)), std::nullopt};
  if (equals != std::string_view::npos) {
    out.value = std::string(item.substr(equals + 1));
  }
  return out;
}

std::string known_names() {
  std::string names;
  for (const std::string_view name : kParameterNames) {
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  return names;
}

}  // namespace

ParameterVector parse_calibration_error(const std::string& text, const StereoCalibration& calibration) {
  const auto fail = [&](const std::string& hint = "") {
    throw std::invalid_argument(
        fmt::format("expected six numbers ax,ay,az,tx,ty,tz (degrees within ±180; metres, or % of the "
                    "baseline), NAME=VALUE for other parameters, or both, found '{}'{}; names: {}",
                    text, hint, known_names()));
  };
  const std::vector<std::string_view> items = split(text, ',');
  ParameterVector out = ParameterVector::Zero();
  ParameterSet given;
  const auto set = [&](std::size_t parameter, const std::string& value) {
    const std::optional<double> parsed = value_of(value, parameter, calibration);
    if (!parsed || given[parameter]) {
      fail();
    }
    out(static_cast<Eigen::Index>(parameter)) = *parsed;
    given.set(parameter);
  };
  const bool positional = items.front().find('=') == std::string_view::npos;
  if (positional && items.size() < kThetaSize) {
    fail();
  }
  for (std::size_t k = 0; k < items.size(); ++k) {
    if (positional && k < kThetaSize) {
      set(k, std::string(items[k]));
      continue;
    }
    const NamedValue named = named_value(items[k]);
    if (!named.parameters) {
      fail(did_you_mean(name_in(items[k]), parameter_words()));
    }
    if (named.parameters->count() != 1 || !named.value) {
      fail();
    }
    set(named.parameters->_Find_first(), *named.value);
  }
  return out;
}

ParameterVector parse_parameter_sigmas(const std::string& text, const StereoCalibration& calibration) {
  const ParameterVector plausible = plausible_errors(calibration);
  ParameterVector out = ParameterVector::Zero();
  for (const std::string_view item : split(text, ',')) {
    const NamedValue named = named_value(item);
    if (!named.parameters) {
      throw std::invalid_argument(
          fmt::format("unknown parameter '{}' in '{}'{}, expected a list of {}, or of the groups theta, "
                      "intrinsics0, intrinsics1, imu",
                      item, text, did_you_mean(name_in(item), parameter_words()), known_names()));
    }
    for (std::size_t k = 0; k < kParameterNames.size(); ++k) {
      if (!(*named.parameters)[k]) {
        continue;
      }
      const auto at = static_cast<Eigen::Index>(k);
      const auto sigma = named.value ? value_of(*named.value, k, calibration) : std::optional(plausible(at));
      if (!sigma || !(*sigma > 0.0) || out(at) != 0.0) {
        throw std::invalid_argument(
            fmt::format("'{}' in '{}': expected NAME or NAME=SIGMA with a positive number ({}), each "
                        "parameter once",
                        item, text, user_unit_of(k)));
      }
      out(at) = *sigma;
    }
  }
  return out;
}

std::string format_parameters(const ParameterVector& values) {
  std::string text;
  for (std::size_t k = 0; k < kParameterNames.size(); ++k) {
    const double value = values(static_cast<Eigen::Index>(k));
    if (value != 0.0) {
      text += fmt::format("{}{}={}", text.empty() ? "" : ",", kParameterNames[k], in_user_units(k, value));
    }
  }
  return text;
}

double in_user_units(std::size_t parameter, double value) {
  return is_angle(parameter) ? value / kDegree : value;
}

std::string user_unit_of(std::size_t parameter) {
  return is_angle(parameter) ? "deg" : std::string(unit_of(parameter));
}

}  // namespace limber
