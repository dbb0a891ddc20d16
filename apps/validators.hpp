// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <string>

/// Checks of option values that CLI11's own let pass (it takes "nan" for a number in any range).
namespace limber::app {

/// A finite number that `accepts` agrees with; `description` completes "expected ...".
template <typename Accepts>
CLI::Validator number_that(const std::string& description, Accepts accepts) {
  return {[description, accepts](std::string& text) {
            double value = 0.0;
            const bool good =
                CLI::detail::lexical_cast(text, value) && std::isfinite(value) && accepts(value);
            return good ? std::string() : "expected " + description + ", found '" + text + "'";
          },
          ""};
}

inline CLI::Validator positive() {
  return number_that("a positive number", [](double value) { return value > 0.0; });
}

inline CLI::Validator not_negative() {
  return number_that("a number that is not negative", [](double value) { return value >= 0.0; });
}

}  // namespace limber::app
