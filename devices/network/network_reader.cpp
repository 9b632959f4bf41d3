// SPDX-License-Identifier: Apache-2.0
#include "devices/network/network_reader.hpp"

#include <pthread.h>

#include <deque>
#include <exception>
#include <utility>

#include "core/error.hpp"

namespace choreo::devices::network {
namespace {

// FFmpeg asks its guard ten times a second while it waits for a socket.
constexpr auto kLongestEnd = std::chrono::milliseconds(500);

// How reading ended.
struct Ending {
  enum class Kind { kAway, kRefused, kRecording, kStopped } kind = Kind::kStopped;
  std::string what;
  std::string hint;
};

}  // namespace

// Shared with the thread, which may outlive its owner.
struct Reader::State {
  Wish wish;
  Guard guard;
  std::mutex mutex;
  std::condition_variable changed;
  const Clock* clock = nullptr;  // Null once the owner has gone.
  std::deque<Picture> waiting;
  Facts facts;
  std::uint64_t damaged = 0;
  std::optional<Ending> ending;

  Nanoseconds now() {
    const std::scoped_lock lock(mutex);
    return clock == nullptr ? Nanoseconds(0) : clock->now();
  }

  void put(Picture picture, std::uint64_t damaged_so_far) {
    std::optional<Picture> old;  // Freed without the lock.
    {
      const std::scoped_lock lock(mutex);
      waiting.push_back(std::move(picture));
      if (waiting.size() > (wish.every_frame ? kMostWaiting : 1)) {
        old = std::move(waiting.front());
        waiting.pop_front();
      }
      damaged = damaged_so_far;
    }
    changed.notify_all();
  }

  void end(Ending how) {
    {
      const std::scoped_lock lock(mutex);
      ending = std::move(how);
    }
    changed.notify_all();
  }
};

Reader::Reader(const Wish& wish, const Clock& clock) : state_(std::make_shared<State>()) {
  state_->wish = wish;
  state_->clock = &clock;
  thread_ = std::thread([state = state_] { run(*state); });
}

Reader::~Reader() {
  state_->guard.stop();
  std::unique_lock lock(state_->mutex);
  const bool ended = state_->changed.wait_for(lock, kLongestEnd, [this] { return state_->ending.has_value(); });
  state_->clock = nullptr;
  lock.unlock();
  if (ended) {
    thread_.join();
  } else {
    thread_.detach();
  }
}

void Reader::run(State& state) {
  pthread_setname_np(pthread_self(), "network");
  Ending ending;
  try {
    Stream stream(state.wish, state.guard, [&state] { return state.now(); });
    if (stream.is_recording()) {
      ending.kind = Ending::Kind::kRecording;
    } else {
      {
        const std::scoped_lock lock(state.mutex);
        state.facts = {stream.codec(), stream.has_times(), stream.nominal_fps(), stream.coded_size()};
      }
      while (auto picture = stream.next()) {
        state.guard.unlimit();
        state.put(std::move(*picture), stream.damaged());
      }
    }
  } catch (const DeviceLost& lost) {
    ending = {Ending::Kind::kAway, lost.what(), {}};
  } catch (const Error& error) {
    ending = {Ending::Kind::kRefused, error.what(), error.hint()};
  } catch (const std::exception& error) {
    ending = {Ending::Kind::kAway, state.wish.name + ": " + error.what(), {}};
  }
  state.end(std::move(ending));
}

std::optional<Picture> Reader::take(Nanoseconds patience) {
  std::unique_lock lock(state_->mutex);
  state_->changed.wait_for(lock, patience, [this] { return !state_->waiting.empty() || state_->ending; });
  if (!state_->waiting.empty()) {
    std::optional<Picture> oldest(std::move(state_->waiting.front()));
    state_->waiting.pop_front();
    return oldest;
  }
  if (!state_->ending || state_->ending->kind == Ending::Kind::kRecording) return std::nullopt;
  const auto ending = *state_->ending;
  lock.unlock();
  if (ending.kind == Ending::Kind::kRefused) throw usage_error(ending.what, {}, ending.hint);
  throw DeviceLost(ending.what);
}

Facts Reader::facts() const {
  const std::scoped_lock lock(state_->mutex);
  return state_->facts;
}

bool Reader::is_recording() const {
  const std::scoped_lock lock(state_->mutex);
  return state_->ending && state_->ending->kind == Ending::Kind::kRecording;
}

std::uint64_t Reader::damaged() const {
  const std::scoped_lock lock(state_->mutex);
  return state_->damaged;
}

}  // namespace choreo::devices::network
