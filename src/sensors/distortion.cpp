// SPDX-License-Identifier: MIT
#include "limber/sensors/distortion.hpp"

#include <stdexcept>
#include <string>
#include <utility>

#include "sensors/lenses/all_lenses.hpp"

namespace limber {
namespace {

using detail::LensOf;

template <std::size_t... kIndex>
std::vector<Distortion> one_of_each(std::index_sequence<kIndex...> /*indices*/) {
  return {Distortion(std::in_place_index<kIndex>)...};
}

}  // namespace

const std::vector<Distortion>& distortion_models() {
  static const std::vector<Distortion> kAll =
      one_of_each(std::make_index_sequence<std::variant_size_v<Distortion>>{});
  return kAll;
}

std::string_view model_name(const Distortion& distortion) {
  return std::visit([](const auto& d) { return LensOf<decltype(d)>::kName; }, distortion);
}

std::vector<std::string_view> coefficient_names(const Distortion& distortion) {
  return std::visit(
      [](const auto& d) {
        std::vector<std::string_view> out;
        for (const auto& coefficient : LensOf<decltype(d)>::kCoefficients) {
          out.push_back(coefficient.name);
        }
        return out;
      },
      distortion);
}

std::vector<double> coefficients(const Distortion& distortion) {
  return std::visit(
      [](const auto& d) {
        std::vector<double> out;
        for (const auto& coefficient : LensOf<decltype(d)>::kCoefficients) {
          out.push_back(d.*coefficient.value);
        }
        return out;
      },
      distortion);
}

Distortion with_coefficients(const Distortion& model, std::span<const double> values) {
  Distortion out = model;
  std::visit(
      [&](auto& d) {
        const auto& all = LensOf<decltype(d)>::kCoefficients;
        if (values.size() != all.size()) {
          throw std::invalid_argument("with_coefficients: expected " + std::to_string(all.size()) + " of " +
                                      std::string(LensOf<decltype(d)>::kName) + ", found " +
                                      std::to_string(values.size()));
        }
        for (std::size_t k = 0; k < all.size(); ++k) {
          d.*all[k].value = values[k];
        }
      },
      out);
  return out;
}

}  // namespace limber
