// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>

#include "limber/study/study_item.hpp"

namespace limber::detail {

struct Task {
  std::size_t study_case = 0;
  std::uint64_t run = 0;
};

/// What became of a task: its result, or why there is none (ItemCancelled among others).
struct Finished {
  std::optional<ItemResult> result;
  std::exception_ptr error;
};

/// @brief Whoever computes the items of a study. Used by one thread. The destructor ends what is under way.
class Workforce {
 public:
  virtual ~Workforce() = default;

  /// How many tasks it can work on at once; submit no more before some are taken.
  [[nodiscard]] virtual std::size_t capacity() const = 0;
  virtual void submit(const Task& task) = 0;
  /// A task that ended, in no particular order; nothing if none did within `patience`.
  [[nodiscard]] virtual std::optional<Finished> take(std::chrono::milliseconds patience) = 0;
  /// Frames that were processed so far, as far as known: for the progress.
  [[nodiscard]] virtual std::uint64_t frames_done() const = 0;
};

/// Threads of this process (oneTBB), each working on one item. `plan` must outlive it.
[[nodiscard]] std::unique_ptr<Workforce> make_local_workforce(const StudyPlan& plan, int threads);

}  // namespace limber::detail
