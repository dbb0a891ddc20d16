// SPDX-License-Identifier: MIT
#include "limber/health/rig_evidence.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace limber {
namespace {

using Matrix = NormalEquations::Matrix;
using Vector = NormalEquations::Vector;

/// Track `id` in window `window`, in the same place or, where tracks go on, in another.
TrackScores scores_of(std::int64_t id, int window) {
  TrackScores out;
  for (const int cell : {static_cast<int>(id) % 3, 3 + window}) {
    Vector score;
    for (Eigen::Index k = 0; k < score.size(); ++k) {
      score(k) = std::sin(static_cast<double>(k + 1) * static_cast<double>(id + 1) + window + cell);
    }
    out.cells[cell] = score;
    out.of_a_pixel[0] += 2.0 * score;
    out.of_a_pixel[1] += score.reverse();
  }
  return out;
}

/// Windows of which each sees the tracks that came with itself and the `stay` before it.
std::vector<RigEvidence> windows_with(int count, int stay) {
  std::vector<RigEvidence> out;
  for (int k = 0; k < count; ++k) {
    RigEvidence window;
    for (int id = std::max(0, k - stay); id <= k; ++id) {
      window.tracks[id] = scores_of(id, k);
      window.tracks[id + 100] = scores_of(id + 100, k);
    }
    window.products = products_of(window.tracks, window.tracks);
    append(window, out);
  }
  return out;
}

/// What the scores of all windows add up to.
ScoreProducts all_of(const std::vector<RigEvidence>& windows) {
  ScoreProducts out;
  for (std::size_t k = 0; k < windows.size(); ++k) {
    out += windows[k].products;
    for (const ScoreProducts& shared : windows[k].with_earlier) {
      out += shared;
      out += shared.transposed();
    }
  }
  return out;
}

void expect_equal(const Matrix& a, const Matrix& b) { EXPECT_LT((a - b).norm(), 1e-9 * b.norm()); }

TEST(RigEvidence, WindowsTogetherHaveOneScoreOfATrack) {
  constexpr int kWindows = 9, kStay = 4;
  const ScoreProducts all = all_of(windows_with(kWindows, kStay));
  Matrix tracks = Matrix::Zero(), both = Matrix::Zero(), of_a_pixel = Matrix::Zero();
  for (const int other : {0, 100}) {
    for (int id = other; id < other + kWindows; ++id) {
      Vector pulled = Vector::Zero();
      std::map<int, Vector> cells;
      Vector sum = Vector::Zero();
      for (int k = id - other; k <= std::min(id - other + kStay, kWindows - 1); ++k) {
        const TrackScores scores = scores_of(id, k);
        pulled += scores.of_a_pixel[1];
        for (const auto& [cell, score] : scores.cells) {
          cells.try_emplace(cell, Vector::Zero()).first->second += score;
          sum += score;
        }
      }
      tracks += sum * sum.transpose();
      of_a_pixel += pulled * pulled.transpose();
      for (const auto& [cell, score] : cells) {
        both += score * score.transpose();
      }
    }
  }
  expect_equal(all.tracks, tracks);
  expect_equal(all.both, both);
  expect_equal(all.of_a_pixel[1], of_a_pixel);
}

TEST(RigEvidence, WindowsThatShareNoTrackAreIndependent) {
  for (const RigEvidence& window : windows_with(6, 0)) {
    for (const ScoreProducts& shared : window.with_earlier) {
      EXPECT_TRUE(shared.tracks.isZero(0.0));
      EXPECT_TRUE(shared.both.isZero(0.0));
      EXPECT_TRUE(shared.of_a_pixel[0].isZero(0.0));
    }
  }
}

TEST(RigEvidence, KeepsTracksOfTheLastWindowsAlone) {
  const std::vector<RigEvidence> windows = windows_with(12, 11);
  for (std::size_t k = 0; k < windows.size(); ++k) {
    EXPECT_EQ(windows[k].tracks.empty(), k + kSharedWindows < windows.size());
    EXPECT_EQ(windows[k].with_earlier.size(), std::min(k, kSharedWindows));
  }
}

TEST(RigEvidence, HalvedWindowsAddUpToTheSame) {
  for (const int count : {2, 11, 12}) {
    std::vector<RigEvidence> windows = windows_with(count, 4);
    const ScoreProducts before = all_of(windows);
    halve(windows);
    EXPECT_EQ(windows.size(), static_cast<std::size_t>(count + 1) / 2);
    const ScoreProducts after = all_of(windows);
    expect_equal(after.tracks, before.tracks);
    expect_equal(after.both, before.both);
    expect_equal(after.of_a_pixel[0], before.of_a_pixel[0]);
  }
}

/// The tracks of the last windows go on after they were merged.
TEST(RigEvidence, AWindowAfterHalvedOnesSharesTheirTracks) {
  std::vector<RigEvidence> windows = windows_with(4, 4), halved = windows;
  halve(halved);
  RigEvidence next;
  next.tracks[1] = scores_of(1, 4);
  append(next, windows);
  append(next, halved);
  const std::vector<ScoreProducts>& apart = windows.back().with_earlier;
  ASSERT_EQ(halved.back().with_earlier.size(), 2U);
  expect_equal(halved.back().with_earlier[0].tracks, apart[0].tracks + apart[1].tracks);
  expect_equal(halved.back().with_earlier[1].both, apart[2].both + apart[3].both);
}

/// Where nothing tells the baseline's length, what is known of it is nil and may be less by rounding: a run
/// that was lost could not be written ("a number is not finite").
TEST(RigEvidence, TheVarianceOfAScaleIsOneOfThoseThatWindowsHave) {
  RigEvidence sure, unsure;
  sure.scale_sigma = 0.1;
  unsure.scale_sigma = 0.5;
  const auto mean = [&](double weight_of_sure, double weight_of_unsure) {
    sure.length_weight = weight_of_sure;
    unsure.length_weight = weight_of_unsure;
    const std::array<const RigEvidence*, 2> both = {&sure, &unsure};
    return mean_scale_variance(both);
  };
  EXPECT_NEAR(mean(3.0, 1.0), 0.75 * 0.01 + 0.25 * 0.25, 1e-12);
  EXPECT_NEAR(mean(1e-12, -0.9e-12), 0.01, 1e-12);
  EXPECT_NEAR(mean(-1e-12, -1e-12), 0.25, 1e-12);  // none tells anything: the largest
}

}  // namespace
}  // namespace limber
