// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace limber::detail {

/// Places of a path, evenly thinned while it grows: when there are too many, every second one goes, and from
/// then on half as many come in.
class ThinnedPath {
 public:
  static constexpr std::size_t kMost = 4096;  // even

  void add(double t_s, const Eigen::Vector3d& p) {
    if (count_++ % stride_ != 0) return;
    for (const double value : {t_s, p.x(), p.y(), p.z()}) {
      values_.push_back(static_cast<float>(value));
    }
    if (size() == kMost) halve();
  }

  [[nodiscard]] std::size_t size() const { return values_.size() / kColumns; }
  /// t [s], x, y, z [m] of each.
  [[nodiscard]] const std::vector<float>& values() const { return values_; }

 private:
  static constexpr std::size_t kColumns = 4;

  void halve() {
    for (std::size_t k = 0; 2 * k < size(); ++k) {
      for (std::size_t c = 0; c < kColumns; ++c) {
        values_[kColumns * k + c] = values_[2 * kColumns * k + c];
      }
    }
    values_.resize(kColumns * (kMost / 2));
    stride_ *= 2;
  }

  std::size_t count_ = 0, stride_ = 1;
  std::vector<float> values_;
};

}  // namespace limber::detail
