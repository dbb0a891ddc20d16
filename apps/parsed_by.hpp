// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <stdexcept>
#include <string>

namespace limber::app {

/// A CLI validator from a parser that throws std::invalid_argument.
template <typename Parse>
CLI::Validator parsed_by(Parse parse) {
  return {[parse](std::string& text) {
            try {
              (void)parse(text);
              return std::string();
            } catch (const std::invalid_argument& error) {
              return std::string(error.what());
            }
          },
          ""};
}

}  // namespace limber::app
