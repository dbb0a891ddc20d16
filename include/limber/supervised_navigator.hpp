// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "limber/health/health_monitor.hpp"
#include "limber/navigator.hpp"

namespace limber {

/// @brief A navigator of any method; for `adaptive`, with what that method needs beside its filter.
///
/// `adaptive` trusts the rig as `ekf` does, as long as two watchdogs agree: one looks at its own innovations,
/// which are sharp where the rig moves under a known map; the other is a constrained filter (lcekf) that runs
/// beside it on the same inputs and that no calibration can lead astray. When the first rejects, the filter
/// goes back to a checkpoint from before the window in which it happened and comes again with theta in
/// doubt; when the second does, it takes over the constrained filter's state. From then on the filter learns
/// how much theta stays wrong and how much of it is fresh in every frame. Where nothing but a young map fixes
/// the scale, neither could be learned: there it goes on trusting the rig, and the health report says so.
/// @note docs/derivations/adaptive.md
class SupervisedNavigator {
 public:
  /// @throws std::invalid_argument as Navigator
  SupervisedNavigator(const NavigatorOptions& options, const StereoCalibration& calibration,
                      const InitialState& initial);

  void add_imu(const ImuSample& sample);
  void add_odometry(const OdometrySample& sample);
  FrameReport process(const StereoFrame& frame);
  void assume_theta(const RigParameters& theta) { navigator_.assume_theta(theta); }

  /// The filter whose state counts. Invalidated by the next call.
  [[nodiscard]] const Navigator& navigator() const { return navigator_; }

 private:
  using Event = std::variant<ImuSample, OdometrySample, StereoFrame>;
  struct Checkpoint {
    Navigator navigator;
    std::vector<Event> events;  // since
  };
  struct Supervision {
    Navigator auditor;
    HealthMonitor own_watchdog, auditors_watchdog;
    Checkpoint older, recent;
    std::int64_t began_ns = 0;
    std::int64_t doubted_ns = 0;  // last
    int doubts = 0;               // in a row
    bool trusts = true;
    bool resigned = false;  // nobody can know how long a metre is: what is assumed stays as good as any
  };

  void log(const Event& event);
  FrameReport go_back(const HealthReport& why);
  [[nodiscard]] Doubt doubt(const HealthReport& why) const;
  [[nodiscard]] bool knows_scale(std::int64_t t_ns) const;
  void supervise(FrameReport& report, const FrameReport& audit);

  double baseline_;  // of the assumed calibration [m]
  Navigator navigator_;
  std::optional<Supervision> supervision_;  // adaptive
};

}  // namespace limber
