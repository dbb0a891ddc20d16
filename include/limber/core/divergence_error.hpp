// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>

namespace limber {

/// The numbers of a filter are no estimate any more: not finite, a covariance that is none, or a state that
/// has left the world. Everything else that goes wrong is another exception: it is not the filter's fault.
class DivergenceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace limber
