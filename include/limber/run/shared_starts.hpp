// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>

namespace limber {

namespace detail {
struct KeptStarts;
}

/// @brief Starts from the sensors that runs over one recording share: what a method asks of its start
/// (same_start) and one before has asked, too, is not solved again; `adaptive`, and an `ekf` that
/// learns its pixels' noise, share with the methods that leave all of theta open. The results are those of
/// runs that share nothing, bit by bit. For runs one after the other, over the same recording, its frames
/// from the same source, cleaned alike.
class SharedStarts {
 public:
  SharedStarts();
  ~SharedStarts();

  /// How many were solved.
  [[nodiscard]] std::size_t size() const;
  /// What runs have left here; for run_recording alone.
  [[nodiscard]] detail::KeptStarts& kept() { return *kept_; }

 private:
  std::unique_ptr<detail::KeptStarts> kept_;
};

}  // namespace limber
