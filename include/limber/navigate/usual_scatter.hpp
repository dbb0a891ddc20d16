// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

namespace limber {

/// @brief How far half of the points of a frame usually are from where they were predicted,
/// GateReport::scatter, whatever noise was assumed for them.
///
/// It forgets in half a second, and takes what doubles for twice as much: something that moves shows for a
/// second or more before it is usual.
class UsualScatter {
 public:
  /// One frame. @param scatter  nothing leaves all as it was @param sigma_px  [px], with which it was judged
  void learn(const std::optional<double>& scatter, double sigma_px);

  /// What is usual beside such noise; nothing before some frames. @param sigma_px  [px], not zero
  [[nodiscard]] std::optional<double> beside(double sigma_px) const;

 private:
  double square_px_ = 0.0;
  int frames_ = 0;
};

}  // namespace limber
