// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>
#include <string>

namespace limber::testing {

/// What the error says that `call` throws; the test fails if it throws none.
template <typename Error = std::invalid_argument>
std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "no error of this type";
  return "";
}

}  // namespace limber::testing
