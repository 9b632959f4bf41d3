// SPDX-License-Identifier: Apache-2.0
// A function that one thread calls while another takes it away.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

namespace choreo::cli {

/// Calls a function that may be exchanged meanwhile. No lock is held while it runs.
/// @thread thread-safe
template <typename... Arguments>
class CallSlot {
 public:
  using Function = std::function<void(Arguments...)>;

  /// Empty: nothing is called from now on. Returns once no call of the one before goes on, so do not exchange a
  /// function from within itself.
  void set(Function function) {
    auto next = function ? std::make_shared<const Function>(std::move(function)) : nullptr;
    std::unique_lock lock(mutex_);
    function_.swap(next);
    idle_.wait(lock, [this] { return calls_ == 0; });
  }

  void call(Arguments... arguments) {
    std::shared_ptr<const Function> function;
    {
      const std::scoped_lock lock(mutex_);
      if (!function_) return;
      function = function_;
      ++calls_;
    }
    const Ended ended{*this};
    (*function)(std::move(arguments)...);
  }

 private:
  struct Ended {
    CallSlot& slot;
    ~Ended() {
      {
        const std::scoped_lock lock(slot.mutex_);
        --slot.calls_;
      }
      slot.idle_.notify_all();
    }
  };

  std::mutex mutex_;
  std::condition_variable idle_;
  std::shared_ptr<const Function> function_;
  std::size_t calls_ = 0;
};

}  // namespace choreo::cli
