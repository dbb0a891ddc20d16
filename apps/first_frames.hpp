// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "limber/diagnose/offset_mistakes.hpp"
#include "limber/run/run_recording.hpp"

namespace limber::app {

inline constexpr std::size_t kLastLook = 600;  ///< frames in which mistakes are looked for

/// Frames at their stamps' rows, for all that knows no rows, without points that go with the camera; nothing
/// else is cleaned.
[[nodiscard]] std::vector<StereoFrame> at_stamps(std::vector<StereoFrame> frames,
                                                 const StereoCalibration& assumed);

/// @brief Frames on their way into a run, the first of which are looked at for cameras that are not where the
/// calibration puts them: exchanged, or a transform written the wrong way round; for clocks that
/// disagree, and for a mount that is turned.
///
/// Looked at are the first 100 as soon as they have come, and once more the first 600, or all at the run's
/// end: a rig that stands at first does not show how it sits on the IMU. Clocks are asked then; of the IMU's
/// it is said at the end, for the run may correct it. No frame waits for that.
class FirstFrames {
 public:
  /// Told of each mistake once, as soon as it is seen.
  using Say = std::function<void(const std::string&)>;

  /// @param recording  must outlive this
  /// @param assumed    its calibration, as the run takes it
  FirstFrames(const Recording& recording, StereoCalibration assumed, double gravity, FrameSource source,
              Say say);

  /// As it is said.
  [[nodiscard]] static std::string in_words(const std::string& mistake);
  /// As FrameSource.
  [[nodiscard]] StereoFrame operator()(std::size_t n);
  /// After the last frame, or where the run ended early. @param record  of the run, if there is one: a clock
  /// that it has corrected is no mistake
  void finish(const RunRecord* record);
  /// As those frames show them; of none before the last look, and where there are other mistakes.
  [[nodiscard]] const SensorOffsets& offsets() const { return offsets_; }
  /// Those of the calibration and of units, as sentences.
  [[nodiscard]] const std::vector<std::string>& gross() const { return gross_; }
  /// All that was said.
  [[nodiscard]] const std::vector<std::string>& mistakes() const { return mistakes_; }

 private:
  void look(const std::vector<StereoFrame>& frames);
  void look_again();
  void say(const std::vector<std::string>& found);

  const Recording& recording_;
  StereoCalibration assumed_;
  double gravity_;
  FrameSource source_;
  Say say_;
  std::vector<StereoFrame> seen_;  ///< emptied by the last look
  bool over_ = false;
  bool finished_ = false;
  SensorOffsets offsets_;
  std::vector<std::string> gross_, mistakes_;
};

}  // namespace limber::app
