// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include "fixtures.hpp"

/// What is read of a damaged fixture.
namespace limber::testing {

inline std::size_t readable_messages(const BagContents& contents) {
  std::size_t out = 0;
  for (const BagStream& stream : contents.streams) {
    out += stream.stamps_ns.size();
  }
  return out;
}

/// No byte of a sample is another than the one that went in.
inline void expect_true_samples(const BagContents& contents) {
  for (const BagStream& stream : contents.streams) {
    for (const ImuMessage& message : stream.imu) {
      const auto n = static_cast<double>((message.sample.t_ns - kStart) / kImuInterval);
      EXPECT_EQ(message.sample.omega_imu, Eigen::Vector3d(0.001 * n, -0.002 * n, 1.0 / (n + 1.0)));
      EXPECT_EQ(message.sample.accel_imu, Eigen::Vector3d(0.1, -0.01 * n, 9.81 + 1e-9 * n));
    }
  }
}

}  // namespace limber::testing
