// SPDX-License-Identifier: MIT
// Is the calibration still true? A callback when the verdict changes, while the robot drives.
#include <limber/run/run_recording.hpp>
#include <limber/sensors/parameters.hpp>
#include <limber/simulate/simulator.hpp>

#include <cstdlib>
#include <functional>
#include <iostream>

namespace {

/// Calls back with the first report of every verdict that differs from the one before.
class HealthWatch {
 public:
  explicit HealthWatch(std::function<void(const limber::HealthReport&)> changed)
      : changed_(std::move(changed)) {}

  void look(const limber::FrameReport& frame) {
    if (frame.health && frame.health->verdict != verdict_) {
      verdict_ = frame.health->verdict;
      changed_(*frame.health);
    }
  }
  [[nodiscard]] limber::HealthVerdict verdict() const { return verdict_; }

 private:
  std::function<void(const limber::HealthReport&)> changed_;
  limber::HealthVerdict verdict_ = limber::HealthVerdict::kCannotTell;
};

}  // namespace

int main() {
  limber::Scenario scenario;  // in place of your robot: its right camera is bumped after six seconds
  scenario.duration = 12.0;
  scenario.decalibration.push_back({limber::paper_decalibration(), limber::StepsShape{{{6.0, 1.0}}}});
  const limber::Recording robot = limber::simulate(scenario, 1);

  HealthWatch watch([&](const limber::HealthReport& report) {
    std::cout << "at " << 1e-9 * static_cast<double>(report.t_ns) << " s: " << to_string(report.verdict);
    for (std::size_t axis = 0; axis < report.axes.size(); ++axis) {
      if (report.axes[axis] == limber::HealthVerdict::kDecalibrated) {
        std::cout << ", " << limber::kParameterNames[axis] << " moved";
      }
    }
    std::cout << "\n";
  });
  // With a Navigator of your own: watch.look(navigator.process(frame)).
  const limber::RunRecord run = limber::run_recording(
      robot, {}, limber::matched_frames(robot),
      {.observe = [&](const limber::ObservedFrame& frame) { watch.look(frame.report); }});
  std::cout << run.frames.size() << " frames\n";
  return watch.verdict() == limber::HealthVerdict::kDecalibrated ? EXIT_SUCCESS : EXIT_FAILURE;
}
