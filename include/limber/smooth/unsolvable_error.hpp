// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>

namespace limber {

/// A least-squares problem that has no solution: what is asked for is not determined, or the solver gives up.
class UnsolvableError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace limber
