// SPDX-License-Identifier: MIT
#include "limber/run/input_summary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

#include "limber/run/run_recording.hpp"
#include "short_recording.hpp"

namespace limber {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Twenty frames a second, updated by sound inputs.
std::vector<FrameReport> sound_frames(std::size_t count) {
  std::vector<FrameReport> frames(count);
  for (std::size_t k = 0; k < count; ++k) {
    frames[k].t_ns = static_cast<std::int64_t>(k) * 50'000'000;
    frames[k].status = UpdateStatus::kUpdated;
    frames[k].inputs.status = InputStatus::kSound;
  }
  return frames;
}

TEST(InputSummary, OfASoundRunHasNothingToSay) {
  const InputSummary summary = summarize_inputs(sound_frames(100));
  EXPECT_EQ(summary.updated, 100U);
  EXPECT_EQ(summary.sound, 100U);
  EXPECT_THAT(summary.events, IsEmpty());
  EXPECT_THAT(remarks_on_inputs(summary), IsEmpty());
  EXPECT_FALSE(summary.lost_since_ns);
}

TEST(InputSummary, FramesWithTheSameTroubleAreOneEvent) {
  std::vector<FrameReport> frames = sound_frames(200);
  for (std::size_t k = 20; k < 40; ++k) {
    frames[k].inputs.status = InputStatus::kGap;
    frames[k].inputs.gap_s = 0.05;
    frames[k].inputs.faults[InputFault::kStuck] = 10;
  }
  frames[150].inputs.faults[InputFault::kStuck] = 3;
  const InputSummary summary = summarize_inputs(frames);
  EXPECT_EQ(summary.gap, 20U);
  ASSERT_EQ(summary.events.size(), 3U);
  EXPECT_EQ(summary.events[0].kind, RunEventKind::kGap);
  EXPECT_NEAR(summary.events[0].longest_s, 1.0, 1e-9);
  EXPECT_EQ(summary.events[1].kind, RunEventKind::kStuck);
  EXPECT_EQ(summary.events[1].samples, 200U);
  EXPECT_EQ(summary.events[2].samples, 3U);
  EXPECT_THAT(remarks_on_inputs(summary),
              Contains(HasSubstr("from 0.950 s to 1.950 s 200 input samples were stuck")));
}

TEST(InputSummary, SaysHowFarOffAClockIsThatStepped) {
  std::vector<FrameReport> frames = sound_frames(200);
  for (const auto& [k, offset_ns] : {std::pair(40U, 55'000'000), std::pair(45U, 60'000'000)}) {
    frames[k].inputs.contradiction = InputContradiction{};
    frames[k].inputs.contradiction->clock_offset_ns = offset_ns;
  }
  const InputSummary summary = summarize_inputs(frames);
  ASSERT_EQ(summary.events.size(), 1U);
  EXPECT_EQ(summary.events[0].kind, RunEventKind::kClockStepped);
  EXPECT_NEAR(summary.events[0].clock_offset_s, 0.06, 1e-9);
  EXPECT_THAT(remarks_on_inputs(summary),
              Contains(HasSubstr("taken 0.0600 s earlier than they are stamped")));
}

TEST(InputSummary, SaysInHowManyFramesNothingWasSeen) {
  std::vector<FrameReport> frames = sound_frames(200);
  for (const std::size_t k : {20U, 35U, 50U}) frames[k].status = UpdateStatus::kEmpty;
  EXPECT_THAT(remarks_on_inputs(summarize_inputs(frames)),
              Contains(HasSubstr("no point could be used in 3 frames: dead reckoning")));
}

TEST(InputSummary, SamplesDroppedHereAndThereAreNoLongGap) {
  std::vector<FrameReport> frames = sound_frames(200);
  for (std::size_t k = 20; k < 100; k += k < 60 ? 7 : 1) {
    frames[k].inputs.status = InputStatus::kGap;
    frames[k].inputs.gap_s = 0.01;
  }
  const InputSummary summary = summarize_inputs(frames);
  ASSERT_EQ(summary.events.size(), 1U);
  EXPECT_NEAR(summary.events[0].longest_s, 0.01, 1e-9);
  EXPECT_THAT(remarks_on_inputs(summary), IsEmpty());
}

TEST(InputSummary, SaysSinceWhenARunIsLost) {
  std::vector<FrameReport> frames = sound_frames(100);
  frames[60].status = UpdateStatus::kSingularInnovation;
  frames[60].reset = true;
  const InputSummary summary = summarize_inputs(frames);
  EXPECT_EQ(summary.singular, 1U);
  EXPECT_EQ(summary.lost_since_ns, frames[60].t_ns);
  EXPECT_THAT(remarks_on_inputs(summary), Contains(HasSubstr("the run is lost since 3.000 s")));
}

TEST(InputSummary, ARunIsLostFromItsBeginWhereNoFrameCorrectedTheState) {
  std::vector<FrameReport> frames = sound_frames(40);
  for (FrameReport& frame : frames) frame.status = UpdateStatus::kEmpty;
  const InputSummary summary = summarize_inputs(frames);
  EXPECT_EQ(summary.lost_since_ns, frames.front().t_ns);
  EXPECT_THAT(remarks_on_inputs(summary), Contains(HasSubstr("lost from its begin: no frame corrected")));
  frames[20].status = UpdateStatus::kUpdated;
  EXPECT_FALSE(summarize_inputs(frames).lost_since_ns);
}

TEST(InputSummary, ARunIsLostWhereMostPointsContradictTheStateByFarForASecond) {
  std::vector<FrameReport> frames = sound_frames(100);
  const auto contradict = [&](std::size_t from, std::size_t to, double nis) {
    for (std::size_t k = from; k < to; ++k) {
      frames[k].gate_overruled = true;
      frames[k].dof = 100;
      frames[k].nis = nis * 100.0;
    }
  };
  contradict(5, 20, 1000.0);  // for less than a second
  contradict(25, 55, 30.0);   // as a wrong rig has it
  EXPECT_FALSE(summarize_inputs(frames).lost_since_ns);
  contradict(60, 90, 1000.0);
  const InputSummary summary = summarize_inputs(frames);
  EXPECT_EQ(summary.lost_since_ns, frames[60].t_ns);
  EXPECT_THAT(remarks_on_inputs(summary), Contains(HasSubstr("most points contradict the state by far")));
}

TEST(InputSummary, SaysWherePointsThatLedAstrayWereTakenForNewOnes) {
  std::vector<FrameReport> frames = sound_frames(100);
  frames[40].led_astray = frames[45].led_astray = true;
  const InputSummary summary = summarize_inputs(frames);
  EXPECT_THAT(remarks_on_inputs(summary), Contains(HasSubstr("put them farther off, 2 times")));
  EXPECT_FALSE(summary.lost_since_ns);
}

TEST(InputSummary, SaysWhereTheBodyLeapsByManyOfItsSigmasForPointsThatContradictIt) {
  std::vector<FrameReport> frames = sound_frames(100);
  for (const std::size_t k : {40U, 60U}) {
    frames[k].correction = 30.0;  // an input that failed, and points that agree
    frames[k].dof = 100;
    frames[k].nis = 1000.0 * 100.0;
  }
  EXPECT_THAT(summarize_inputs(frames).events, IsEmpty());
  frames[60].gate_overruled = true;
  EXPECT_THAT(remarks_on_inputs(summarize_inputs(frames)),
              Contains("at 3.000 s the body leapt by more than 10 of its own sigmas"));
}

/// Noise that is learned from innovations grows with them, and hides them.
TEST(InputSummary, ARunIsLostWhereTheContradictionIsLargeInPixelsWhateverNoiseIsAssumed) {
  std::vector<FrameReport> frames = sound_frames(100);
  for (std::size_t k = 40; k < 80; ++k) {
    frames[k].gate_overruled = true;
    frames[k].dof = 100;
    frames[k].nis = 6.0 * 100.0;
    frames[k].sigma_px = 4.0;
  }
  EXPECT_FALSE(summarize_inputs(frames).lost_since_ns) << "9.8 px";
  for (FrameReport& frame : frames) frame.sigma_px = 5.0;
  EXPECT_EQ(summarize_inputs(frames).lost_since_ns, frames[40].t_ns) << "12 px";
  for (FrameReport& frame : frames) frame.gate_overruled = false;
  EXPECT_FALSE(summarize_inputs(frames).lost_since_ns) << "most points agree";
}

TEST(InputSummary, SaysWhereMostPointsWereOverruledForASecondOrLonger) {
  std::vector<FrameReport> frames = sound_frames(100);
  const auto remark = HasSubstr("from 1.950 s to 3.450 s most points contradict the rig or the state");
  for (std::size_t k = 40; k < 50; ++k) frames[k].gate_overruled = true;
  EXPECT_THAT(remarks_on_inputs(summarize_inputs(frames)), IsEmpty());
  for (std::size_t k = 50; k < 70; ++k) frames[k].gate_overruled = true;
  const InputSummary summary = summarize_inputs(frames);
  EXPECT_THAT(remarks_on_inputs(summary), Contains(remark));
  EXPECT_EQ(summary.events.at(0).frames, 30U);
  EXPECT_FALSE(summary.lost_since_ns);
}

TEST(InputSummary, OfARunWithAGapNamesItAndCountsItsFrames) {
  Recording recording = testing::short_recording();
  std::erase_if(recording.imu,
                [](const ImuSample& s) { return s.t_ns > 500'000'000 && s.t_ns < 1'200'000'000; });
  RunOptions options;
  options.start = StartMode::kGroundTruth;
  const RunRecord record = run_recording(recording, options, matched_frames(recording));
  EXPECT_GE(summarize_inputs(record.frames).gap, 14U);
  EXPECT_THAT(record.notes, Contains(HasSubstr("s without a usable input sample")));
}

}  // namespace
}  // namespace limber
