// SPDX-License-Identifier: Apache-2.0
#include "cli/async_writer.hpp"

#include <poll.h>
#include <pthread.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "core/text.hpp"

namespace choreo::cli {
namespace {

constexpr std::size_t kMostBytes = std::size_t{256} << 10U;
constexpr auto kPromptly = std::chrono::milliseconds(100);  // Much longer than a thread takes to be woken.
constexpr auto kAtMost = std::chrono::milliseconds(500);

void write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const auto count = ::write(descriptor, text.data(), text.size());
    if (count > 0) {
      text.remove_prefix(static_cast<std::size_t>(count));
    } else if (count < 0 && errno == EAGAIN) {
      // Somebody who has it, too, wants not to wait.
      pollfd ready{descriptor, POLLOUT, 0};
      (void)::poll(&ready, 1, -1);
    } else if (count == 0 || errno != EINTR) {
      return;  // Nobody reads any more.
    }
  }
}

}  // namespace

struct AsyncWriter::State {
  struct Piece {
    std::string text;
    bool line;
  };

  explicit State(int d) : descriptor(d) {}

  [[nodiscard]] bool idle() const { return waiting.empty() && !writing; }

  void work() {
    pthread_setname_np(pthread_self(), "console");
    std::unique_lock lock(mutex);
    for (;;) {
      given.wait(lock, [this] { return ending || !waiting.empty(); });
      if (ending) return;
      std::string text;
      if (const auto lines = std::exchange(left_out, 0); lines > 0) {
        text = fmt::format("choreoscope: warning: {} left out here, which nobody read in time\n",
                           lines == 1 ? "a line is" : counted(lines, "line") + " are");
      }
      text += waiting.front().text;
      bytes -= waiting.front().text.size();
      waiting.pop_front();
      writing = true;
      lock.unlock();
      write_all(descriptor, text);
      lock.lock();
      writing = false;
      if (waiting.empty()) behind = false;
      written.notify_all();
    }
  }

  const int descriptor;
  std::mutex mutex;
  std::condition_variable given;
  std::condition_variable_any written;
  std::deque<Piece> waiting;
  std::size_t bytes = 0;
  std::uint64_t left_out = 0;
  bool writing = false;
  bool behind = false;
  bool ending = false;
  std::thread thread;
};

AsyncWriter::AsyncWriter(int descriptor) : state_(std::make_shared<State>(descriptor)) {}

AsyncWriter::~AsyncWriter() {
  auto& s = *state_;
  std::unique_lock lock(s.mutex);
  s.ending = true;
  const bool writing = s.writing;
  lock.unlock();
  s.given.notify_one();
  if (!s.thread.joinable()) return;
  if (writing) {
    s.thread.detach();  // It keeps what it shares alive, and the end of the process ends it.
  } else {
    s.thread.join();
  }
}

void AsyncWriter::put(std::string text, bool line) {
  auto& s = *state_;
  std::unique_lock lock(s.mutex);
  if (!s.thread.joinable()) {
    try {
      s.thread = std::thread([state = state_] { state->work(); });
    } catch (const std::system_error&) {
      // The system has no thread for it.
      lock.unlock();
      write_all(s.descriptor, text);
      return;
    }
  }
  s.bytes += text.size();
  s.waiting.push_back({std::move(text), line});
  // The newest says how it ended.
  while (s.bytes > kMostBytes && s.waiting.size() > 1) {
    s.left_out += s.waiting.front().line ? 1 : 0;
    s.bytes -= s.waiting.front().text.size();
    s.waiting.pop_front();
  }
  lock.unlock();
  s.given.notify_one();
}

void AsyncWriter::flush_briefly() {
  auto& s = *state_;
  std::unique_lock lock(s.mutex);
  if (!s.behind) s.behind = !s.written.wait_for(lock, kPromptly, [&] { return s.idle(); });
}

bool AsyncWriter::is_behind() const {
  const std::scoped_lock lock(state_->mutex);
  return state_->behind;
}

void AsyncWriter::drain(const std::stop_token& stop) {
  auto& s = *state_;
  const auto idle = [&] { return s.idle(); };
  std::unique_lock lock(s.mutex);
  if (!s.written.wait(lock, stop, idle)) s.written.wait_for(lock, kAtMost, idle);
}

}  // namespace choreo::cli
