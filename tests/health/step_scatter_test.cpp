// SPDX-License-Identifier: MIT
#include "limber/health/change_test.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "sanitized.hpp"

namespace limber {
namespace {

/// Errors of windows whose covariance is said to be one, in plausible errors.
using Windows = std::vector<NormalEquations::Vector>;

/// Five ways of size one that always matter.
ChangeWays five_ways(double relevant = 0.0) {
  ChangeWays out;
  for (std::size_t k = 0; k < out.size(); ++k) {
    out[k] = {NormalEquations::Vector::Unit(static_cast<Eigen::Index>(k)), relevant};
  }
  return out;
}

/// The last windows against those before the one between, as if windows were independent.
/// @param sums   sums[k]: of the first k windows
/// @param first  the windows before this one do not count
BetaEstimate step_of(const Windows& sums, std::size_t length, std::size_t first) {
  const std::size_t end = sums.size() - 1, before = end - length - 1 - first;
  BetaEstimate out;
  out.beta = (sums[end] - sums[end - length]) / static_cast<double>(length) -
             (sums[end - length - 1] - sums[first]) / static_cast<double>(before);
  out.covariance = (1.0 / static_cast<double>(length) + 1.0 / static_cast<double>(before)) *
                   NormalEquations::Matrix::Identity();
  return out;
}

struct Watched {
  std::vector<std::size_t> alarms;  ///< windows after which there was one
  ScattersByLength at_end;
};

/// The steps of one moment, as CalibrationWatch looks at them; after an alarm it begins anew.
Watched watch(const Windows& windows, double limit, const ChangeWays& ways = five_ways()) {
  EarlierSteps earlier;
  Watched out;
  std::size_t first = 0;
  Windows sums{NormalEquations::Vector::Zero()};
  for (const NormalEquations::Vector& window : windows) {
    sums.push_back(sums.back() + window);
    const std::size_t count = sums.size() - 1;
    StepScatter scatter = earlier.along(ways);
    std::vector<BetaEstimate> looked_at;
    std::optional<std::size_t> found;
    for (std::size_t length = kShortestStep;
         length <= kLongestStep && length + 1 + kShortestStep <= count - first; ++length) {
      looked_at.push_back(step_of(sums, length, first));
      const Scatters& scatters = scatter.before(length + 1)[length - kShortestStep];
      if (kTestsOfAWindow * least_chance(looked_at.back(), ways, scatters) < limit) {
        found = count - length;
      }
    }
    earlier.begin_window();
    for (std::size_t k = 0; k < looked_at.size(); ++k) {
      earlier.add(kShortestStep + k, looked_at[k]);
    }
    if (found) {
      out.alarms.push_back(count);
      first = *found;
    }
  }
  out.at_end = earlier.along(ways).before(1);
  return out;
}

NormalEquations::Vector draw(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return NormalEquations::Vector::NullaryExpr([&] { return normal(random); });
}

/// Alarms of so many recordings of 240 windows by what is asked for.
double alarms_by_asked(int recordings, double limit, const std::function<Windows(std::mt19937&)>& fly) {
  std::mt19937 random(71);
  double alarms = 0.0;
  for (int run = 0; run < recordings; ++run) {
    alarms += static_cast<double>(watch(fly(random), limit).alarms.size());
  }
  return alarms / (240.0 * recordings * limit);
}

constexpr double kLimit = 0.004;  // 6 an hour of windows of 2.5 s
constexpr int kRecordings = 60;   // ten hours: 58 alarms are asked for

/// Windows that have nothing to do with each other.
Windows independent(std::mt19937& random) {
  Windows out(240);
  for (NormalEquations::Vector& window : out) {
    window = draw(random);
  }
  return out;
}

/// Neighbours correlate by one half: the variance of five is 2.3 times what is stated.
Windows neighbours_alike(std::mt19937& random) {
  Windows out = independent(random);
  for (std::size_t k = 1; k < out.size(); ++k) {
    out[k] = 0.5 * out[k - 1] + std::sqrt(0.75) * out[k];
  }
  return out;
}

/// Laps of five windows, the same but for a third of the error.
Windows laps(std::mt19937& random) {
  Windows out = independent(random), lap(out.begin(), out.begin() + 5);
  for (std::size_t k = 0; k < out.size(); ++k) {
    out[k] = std::sqrt(2.0 / 3.0) * lap[k % 5] + std::sqrt(1.0 / 3.0) * draw(random);
  }
  return out;
}

/// One window in ten has three times the error.
Windows with_bad_windows(std::mt19937& random) {
  Windows out = independent(random);
  for (NormalEquations::Vector& window : out) {
    window *= std::uniform_real_distribution<double>()(random) < 0.1 ? 3.0 : 1.0;
  }
  return out;
}

using Flight = Windows (*)(std::mt19937&);

void expect_as_many_alarms_as_asked_for(const std::vector<Flight>& flights) {
  for (std::size_t k = 0; k < flights.size(); ++k) {
    SCOPED_TRACE(k);  // 58 alarms are asked for, seed 71; chance alone makes 38 to 80 of them (99.9 %)
    const double share = alarms_by_asked(kRecordings, kLimit, flights[k]);
    EXPECT_GT(share, 0.4);
    EXPECT_LT(share, 2.0);
  }
}

TEST(StepScatter, AsManyAlarmsAsAskedFor) {
  if (testing::kSanitized) {
    GTEST_SKIP() << "a long statistic of what the other tests run, too";
  }
  expect_as_many_alarms_as_asked_for({neighbours_alike, with_bad_windows});
}

TEST(FullStepScatter, AsManyAlarmsAsAskedFor) { expect_as_many_alarms_as_asked_for({independent, laps}); }

TEST(StepScatter, BeforeThereAreEarlierStepsCovariancesAreBelieved) {
  const ScattersByLength scatters = EarlierSteps().along(five_ways()).before(1);
  for (const Scatters& of_length : scatters) {
    for (const Scatter& scatter : of_length) {
      EXPECT_DOUBLE_EQ(scatter.factor, 1.0);
      EXPECT_NEAR(scatter.dof, 12.0, 0.1);  // 24 steps and tails of Student's t with 24
    }
  }
}

TEST(StepScatter, LearnsWhatStepsOfEachLengthVaryBy) {
  std::mt19937 random(72);
  const ScattersByLength alike = watch(neighbours_alike(random), 0.0).at_end;
  const ScattersByLength lap = watch(laps(random), 0.0).at_end;
  for (std::size_t k = 0; k < alike.front().size(); ++k) {
    EXPECT_GT(alike.back()[k].factor, 1.5);
    EXPECT_LT(lap.back()[k].factor, 0.6);
    EXPECT_GT(lap.front()[k].factor, lap.back()[k].factor);
  }
}

TEST(StepScatter, LargeErrorsNowAndThenMakeItCareful) {
  std::mt19937 random(73);
  const double regular = watch(independent(random), 0.0).at_end.front().front().dof;
  EXPECT_LT(watch(with_bad_windows(random), 0.0).at_end.front().front().dof, 0.7 * regular);
}

TEST(StepScatter, AStepIsNoScatterOfItsOwn) {
  std::mt19937 random(74);
  for (int run = 0; run < 20; ++run) {
    Windows windows = independent(random);
    for (std::size_t k = 120; k < windows.size(); ++k) {
      windows[k] += 8.0 * NormalEquations::Vector::Unit(1);
    }
    const std::vector<std::size_t> alarms = watch(windows, 1e-4).alarms;
    ASSERT_FALSE(alarms.empty());
    EXPECT_GE(alarms.front(), 121u);
    EXPECT_LE(alarms.front(), 124u);
  }
}

TEST(StepScatter, AStepThatDoesNotMatterHidesNoneThatDoes) {
  std::mt19937 random(75);
  int found = 0;
  for (int run = 0; run < 20; ++run) {
    Windows windows = independent(random);
    for (std::size_t k = 60; k < windows.size(); ++k) {
      windows[k] += (k < 120 ? 5.0 : 25.0) * NormalEquations::Vector::Unit(1);
    }
    const std::vector<std::size_t> alarms = watch(windows, 1e-4, five_ways(10.0)).alarms;
    found += !alarms.empty() && alarms.front() <= 125 ? 1 : 0;
  }
  EXPECT_GE(found, 19);
}

}  // namespace
}  // namespace limber
