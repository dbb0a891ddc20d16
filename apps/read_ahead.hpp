// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

namespace limber::app {

/// @brief Makes items 0 ... count - 1 on a thread of its own, at most `most_ahead` before they are taken, one
/// after the other from the first one that is asked for. The items are the same bits as without the thread.
template <typename Item>
class ReadAhead {
 public:
  ReadAhead(std::function<Item(std::size_t)> make, std::size_t count, std::size_t most_ahead)
      : make_(std::move(make)), count_(count), most_ahead_(most_ahead) {}
  ~ReadAhead() {
    {
      const std::lock_guard lock(mutex_);
      stopped_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }
  ReadAhead(const ReadAhead&) = delete;
  ReadAhead& operator=(const ReadAhead&) = delete;

  /// Waits for item `n`, the one after that of the call before. What its making threw is thrown here.
  Item take(std::size_t n) {
    if (!thread_.joinable()) {
      next_ = n;
      thread_ = std::thread([this, n] { work(n); });
    }
    if (n != next_) throw std::logic_error("ReadAhead: items are taken one after the other");
    ++next_;
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !ready_.empty(); });
    Result result = std::move(ready_.front());
    ready_.pop_front();
    lock.unlock();
    changed_.notify_all();
    if (result.error) std::rethrow_exception(result.error);
    return std::move(*result.item);
  }

 private:
  struct Result {
    std::optional<Item> item;
    std::exception_ptr error;
  };

  void work(std::size_t first) {
    for (std::size_t n = first; n < count_; ++n) {
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return stopped_ || ready_.size() < most_ahead_; });
        if (stopped_) return;
      }
      Result result;
      try {
        result.item = make_(n);
      } catch (...) {
        result.error = std::current_exception();
      }
      const bool failed = result.error != nullptr;
      {
        const std::lock_guard lock(mutex_);
        ready_.push_back(std::move(result));
      }
      changed_.notify_all();
      if (failed) return;
    }
  }

  std::function<Item(std::size_t)> make_;
  std::size_t count_, most_ahead_, next_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Result> ready_;
  bool stopped_ = false;
  std::thread thread_;
};

}  // namespace limber::app
