// SPDX-License-Identifier: MIT
#include "limber/study/curve.hpp"

#include <stdexcept>
#include <string>

namespace limber {
namespace {

struct Entry {
  std::string_view name, unit;
};

constexpr std::array<Entry, kCurveQuantities> kEntries = {{
    {"position_squared_error", "m^2"},
    {"position_variance", "m^2"},
    {"attitude_squared_error", "rad^2"},
    {"attitude_variance", "rad^2"},
    {"landmark_squared_error", "m^2"},
    {"landmarks", "-"},
    {"pose_nees", "-"},
    {"position_nees", "-"},
    {"attitude_nees", "-"},
    {"delta_ax", "rad"},
    {"delta_ay", "rad"},
    {"delta_az", "rad"},
    {"delta_tx", "m"},
    {"delta_ty", "m"},
    {"delta_tz", "m"},
    {"theta_squared_error_ax", "rad^2"},
    {"theta_squared_error_ay", "rad^2"},
    {"theta_squared_error_az", "rad^2"},
    {"theta_squared_error_tx", "m^2"},
    {"theta_squared_error_ty", "m^2"},
    {"theta_squared_error_tz", "m^2"},
    {"theta_variance_ax", "rad^2"},
    {"theta_variance_ay", "rad^2"},
    {"theta_variance_az", "rad^2"},
    {"theta_variance_tx", "m^2"},
    {"theta_variance_ty", "m^2"},
    {"theta_variance_tz", "m^2"},
}};

const Entry& entry_of(CurveQuantity quantity) { return kEntries.at(static_cast<std::size_t>(quantity)); }

}  // namespace

std::string_view name_of(CurveQuantity quantity) { return entry_of(quantity).name; }
std::string_view unit_of(CurveQuantity quantity) { return entry_of(quantity).unit; }

CurveQuantity quantity_from_name(std::string_view name) {
  for (std::size_t k = 0; k < kEntries.size(); ++k) {
    if (kEntries[k].name == name) {
      return static_cast<CurveQuantity>(k);
    }
  }
  throw std::invalid_argument("no curve is called '" + std::string(name) + "'");
}

}  // namespace limber
