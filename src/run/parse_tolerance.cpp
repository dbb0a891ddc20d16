// SPDX-License-Identifier: MIT
#include "limber/run/parse_tolerance.hpp"

#include <algorithm>
#include <charconv>
#include <numbers>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "limber/core/nearest_word.hpp"
#include "limber/sensors/parameters.hpp"

namespace limber {
namespace {

const std::vector<std::string> kNames = {"px", "depth", "baselines", "ax", "ay", "az", "tx", "ty", "tz"};

[[noreturn]] void fail(const std::string& item) {
  throw std::invalid_argument("tolerance: '" + item +
                              "', expected NAME=OK[:WRONG] with 0 < OK <= WRONG and NAME one of px, depth, "
                              "baselines, ax, ay, az, tx, ty, tz" +
                              did_you_mean(item.substr(0, item.find('=')), kNames));
}

double positive(const std::string& text, const std::string& item) {
  double value = 0.0;
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || at != end || !(value > 0.0) || !(value < 1e9)) {
    fail(item);
  }
  return value;
}

Band band(const std::string& text, double factor, double unit, const std::string& item) {
  const std::size_t colon = text.find(':');
  const double ok = positive(text.substr(0, colon), item);
  const double wrong = colon == std::string::npos ? factor * ok : positive(text.substr(colon + 1), item);
  if (wrong < ok) {
    fail(item);
  }
  return {unit * ok, unit * wrong};
}

}  // namespace

Tolerance parse_tolerance(const std::string& text) {
  Tolerance out;
  std::istringstream items(text);
  std::string item;
  bool any = false;
  for (; std::getline(items, item, ','); any = true) {
    const std::size_t equals = item.find('=');
    if (equals == std::string::npos) {
      fail(item);
    }
    const std::string name = in_lower_case(item.substr(0, equals)), value = item.substr(equals + 1);
    const auto axes = std::span(kParameterNames).first(6);
    const auto axis = std::find(axes.begin(), axes.end(), name);
    if (name == "px") {
      out.epipolar_px = band(value, 10.0 / 3.0, 1.0, item);
    } else if (name == "depth") {
      out.depth = band(value, 2.0, 0.01, item);
    } else if (name == "baselines") {
      out.baselines = positive(value, item);
    } else if (axis != axes.end()) {
      const auto k = static_cast<std::size_t>(axis - axes.begin());
      out.axes[k] = band(value, 2.0, k < 3 ? std::numbers::pi / 180.0 : 1e-3, item);
    } else {
      fail(item);
    }
  }
  if (!any || text.back() == ',') {
    fail(text);
  }
  return out;
}

}  // namespace limber
