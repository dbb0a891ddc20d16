// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "limber/core/nearest_word.hpp"

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

/// Digits alone: CLI11 takes -1 for the largest number, and what is too large as well.
inline CLI::Validator whole_number(std::uint64_t least = 0,
                                   std::uint64_t most = std::numeric_limits<std::uint64_t>::max()) {
  return {[least, most](std::string& text) {
            std::uint64_t value = 0;
            const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
            const bool good =
                error == std::errc{} && end == text.data() + text.size() && value >= least && value <= most;
            return good ? std::string()
                        : "expected a whole number from " + std::to_string(least) + " to " +
                              std::to_string(most) + ", found '" + text + "'";
          },
          ""};
}

/// One of these words, in any case: for CLI::Option::transform, which puts it as it stands here.
inline CLI::Validator one_of(const std::vector<std::string>& words) {
  const std::string all = CLI::detail::join(words, ",");
  return {[words, all](std::string& text) {
            const std::string word = in_lower_case(text);
            if (std::find(words.begin(), words.end(), word) == words.end()) {
              return "'" + text + "' is not in {" + all + "}" + did_you_mean(text, words);
            }
            text = word;
            return std::string();
          },
          "{" + all + "}"};
}

inline CLI::Validator not_empty() {
  return {[](std::string& text) { return text.empty() ? std::string("expected a name, found nothing") : ""; },
          ""};
}

}  // namespace limber::app
