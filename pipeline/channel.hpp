// SPDX-License-Identifier: Apache-2.0
// Where threads meet: a bounded queue with a stated way to overflow.
#pragma once

#include <algorithm>
#include <cassert>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

namespace choreo::pipeline {

enum class Overflow {
  kBlock,       ///< The writer waits: nothing is lost.
  kDropOldest,  ///< The oldest waiting item goes, and is counted: the newest is never late.
};

/// What a channel has seen.
struct ChannelStats {
  std::uint64_t pushed = 0;
  std::uint64_t dropped = 0;
  std::size_t longest = 0;  ///< Most items that ever waited.
  double mean_length = 0;   ///< Mean number of items waiting as an item arrived, itself included.
};

/// A bounded first-in first-out queue between threads.
///
/// Every wait ends when the channel is closed or the given token is stopped: no wait is unbounded.
/// @thread thread-safe
template <typename T>
class Channel {
 public:
  explicit Channel(std::size_t capacity, Overflow overflow = Overflow::kBlock)
      : capacity_(capacity), overflow_(overflow) {
    assert(capacity > 0);
  }

  /// @return false, and the item is gone, where the channel is closed or `stop` was requested while waiting.
  bool push(T item, const std::stop_token& stop = {}) {
    std::optional<T> dropped;  // Destroyed after the lock is released: an item's end may be long.
    {
      std::unique_lock lock(mutex_);
      if (overflow_ == Overflow::kBlock &&
          !changed_.wait(lock, stop, [&] { return closed_ || items_.size() < capacity_; })) {
        return false;
      }
      if (closed_) return false;
      if (items_.size() == capacity_) {
        dropped = std::move(items_.front());
        items_.pop_front();
        ++stats_.dropped;
      }
      items_.push_back(std::move(item));
      ++stats_.pushed;
      stats_.longest = std::max(stats_.longest, items_.size());
      sum_of_lengths_ += items_.size();
    }
    changed_.notify_all();
    return true;
  }

  /// The oldest item; nothing once the channel is closed and empty, or when `stop` was requested while waiting.
  std::optional<T> pop(const std::stop_token& stop = {}) {
    std::optional<T> item;
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [&] { return closed_ || !items_.empty(); }) || items_.empty()) return std::nullopt;
      item = std::move(items_.front());
      items_.pop_front();
    }
    changed_.notify_all();
    return item;
  }

  /// No more items come; those waiting can still be taken.
  void close() {
    {
      const std::scoped_lock lock(mutex_);
      closed_ = true;
    }
    changed_.notify_all();
  }

  [[nodiscard]] ChannelStats stats() const {
    const std::scoped_lock lock(mutex_);
    auto stats = stats_;
    if (stats.pushed > 0) stats.mean_length = double(sum_of_lengths_) / double(stats.pushed);
    return stats;
  }

 private:
  const std::size_t capacity_;
  const Overflow overflow_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<T> items_;
  bool closed_ = false;
  ChannelStats stats_;
  std::uint64_t sum_of_lengths_ = 0;
};

}  // namespace choreo::pipeline
