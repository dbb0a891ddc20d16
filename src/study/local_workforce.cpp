// SPDX-License-Identifier: MIT
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>

#include "workforce.hpp"

namespace limber::detail {
namespace {

class LocalWorkforce final : public Workforce {
 public:
  LocalWorkforce(const StudyPlan& plan, int threads)
      : plan_(plan),
        threads_(threads),
        // One more than works: the thread that submits counts as one.
        parallelism_(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads) + 1),
        arena_(threads, 0) {}

  ~LocalWorkforce() override {
    cancelled_ = true;
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [this] { return under_way_ == 0; });
  }

  [[nodiscard]] std::size_t capacity() const override { return static_cast<std::size_t>(threads_); }

  void submit(const Task& task) override {
    {
      const std::lock_guard lock(mutex_);
      ++under_way_;
    }
    arena_.enqueue([this, task] { work(task); });
  }

  [[nodiscard]] std::optional<Finished> take(std::chrono::milliseconds patience) override {
    std::unique_lock lock(mutex_);
    if (!ended_.wait_for(lock, patience, [this] { return !finished_.empty(); })) {
      return std::nullopt;
    }
    Finished out = std::move(finished_.front());
    finished_.pop_front();
    return out;
  }

  [[nodiscard]] std::uint64_t frames_done() const override { return frames_; }

 private:
  void work(const Task& task) {
    Finished finished;
    try {
      finished.result = compute_item(plan_, task.study_case, task.run, [this] {
        ++frames_;
        return !cancelled_;
      });
    } catch (...) {
      finished.error = std::current_exception();
    }
    // Told under the lock: once the destructor's wait returns, nobody touches the members any more.
    const std::lock_guard lock(mutex_);
    finished_.push_back(std::move(finished));
    --under_way_;
    ended_.notify_all();
  }

  const StudyPlan& plan_;
  int threads_;
  std::atomic<bool> cancelled_ = false;
  std::atomic<std::uint64_t> frames_ = 0;
  std::mutex mutex_;
  std::condition_variable ended_;
  std::deque<Finished> finished_;
  int under_way_ = 0;
  tbb::global_control parallelism_;
  tbb::task_arena arena_;
};

}  // namespace

std::unique_ptr<Workforce> make_local_workforce(const StudyPlan& plan, int threads) {
  return std::make_unique<LocalWorkforce>(plan, threads);
}

}  // namespace limber::detail
