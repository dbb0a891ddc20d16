// SPDX-License-Identifier: MIT
#include "limber/study/method_variant.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "limber/core/nearest_word.hpp"
#include "limber/core/split.hpp"
#include "limber/io/parameter_text.hpp"

namespace limber {
namespace {

[[noreturn]] void refuse(std::string_view text, std::string_view why) {
  throw std::invalid_argument(fmt::format("method '{}': {}", text, why));
}

std::optional<double> not_negative_number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good =
      error == std::errc() && end == text.data() + text.size() && std::isfinite(value) && value >= 0.0;
  return good ? std::optional(value) : std::nullopt;
}

/// "x10" or "1e-6/1".
std::optional<ThetaWalk> walk_from_string(std::string_view text) {
  if (!text.empty() && text.front() == 'x') {
    const auto factor = not_negative_number(text.substr(1));
    return factor ? std::optional(ThetaWalk{*factor, false, 0.0, 0.0}) : std::nullopt;
  }
  const auto parts = split(text, '/');
  if (parts.size() != 2) {
    return std::nullopt;
  }
  const auto rotation = not_negative_number(parts[0]), translation = not_negative_number(parts[1]);
  return rotation && translation ? std::optional(ThetaWalk{1.0, true, *rotation, *translation})
                                 : std::nullopt;
}

std::string to_string(const ThetaWalk& walk) {
  return walk.absolute ? fmt::format("{}/{}", walk.rotation, walk.translation)
                       : fmt::format("x{}", walk.factor);
}

struct ListOption {
  std::string_view name;
  std::string MethodVariant::*member;
  ParameterVector (*parse)(const std::string&, const StereoCalibration&);
};
constexpr std::array<ListOption, 3> kListOptions = {
    {{"estimate=", &MethodVariant::estimate, parse_parameter_sigmas},
     {"soften=", &MethodVariant::soften, parse_parameter_sigmas},
     {"assume=", &MethodVariant::assume, parse_calibration_error}}};

void apply(std::string_view option, std::string_view text, MethodVariant& variant) {
  constexpr std::string_view kWalk = "walk=";
  StereoCalibration some_rig;  // to find out whether a text can be read at all
  some_rig.theta(3) = -1.0;
  for (const auto& [name, member, parse] : kListOptions) {
    if (option.starts_with(name)) {
      variant.*member = option.substr(name.size());
      (void)parse(variant.*member, some_rig);
      return;
    }
  }
  if (option == "cartesian") {
    variant.landmarks = LandmarkKind::kCartesian;
  } else if (option.starts_with(kWalk)) {
    if (variant.method != Method::kEkfFull) {
      refuse(text, "only ekf-full lets theta walk");
    }
    variant.walk = walk_from_string(option.substr(kWalk.size()));
    if (!variant.walk) {
      refuse(text,
             "expected walk=xFACTOR or walk=ROTATION/TRANSLATION (variances per 10 ms, rad^2 and mm^2)");
    }
  } else if (variant.method == Method::kLcekf) {
    variant.constraints = constraint_set_from_string(std::string(option));
  } else {
    refuse(text, fmt::format("unknown option '{}', expected cartesian, estimate=..., soften=..., "
                             "assume=...{}",
                             option, variant.method == Method::kEkfFull ? " or walk=..." : ""));
  }
}

/// A parameter or a group of them, with or without a value and what follows it.
bool is_parameter(std::string_view text) {
  return parameters_named(text.substr(0, text.find_first_of("=:"))).has_value();
}

}  // namespace

MethodVariant method_variant_from_string(std::string_view text) {
  const std::string lower = in_lower_case(std::string(text));
  const auto parts = split(lower, ':');
  MethodVariant variant;
  variant.method = method_from_string(std::string(parts.front()));
  for (std::size_t k = 1; k < parts.size(); ++k) {
    apply(parts[k], text, variant);
  }
  return variant;
}

std::string to_string(const MethodVariant& variant) {
  std::string text = to_string(variant.method);
  if (variant.constraints) {
    text += ":" + to_string(*variant.constraints);
  }
  if (variant.landmarks == LandmarkKind::kCartesian) {
    text += ":cartesian";
  }
  if (variant.walk) {
    text += ":walk=" + to_string(*variant.walk);
  }
  for (const auto& [name, member, parse] : kListOptions) {
    if (!(variant.*member).empty()) {
      text += fmt::format(":{}{}", name, variant.*member);
    }
  }
  return text;
}

std::vector<MethodVariant> method_variants_from_string(std::string_view text) {
  std::vector<std::string> items;
  for (const std::string_view part : split(text, ',')) {
    if (!items.empty() && is_parameter(part)) {
      items.back() += "," + std::string(part);
    } else {
      items.emplace_back(part);
    }
  }
  std::vector<MethodVariant> variants;
  std::vector<std::string> labels;
  for (const std::string& item : items) {
    variants.push_back(method_variant_from_string(item));
    labels.push_back(to_string(variants.back()));
    if (std::count(labels.begin(), labels.end(), labels.back()) > 1) {
      refuse(item, "comes twice");
    }
  }
  return variants;
}

}  // namespace limber
