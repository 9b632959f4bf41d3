// SPDX-License-Identifier: Apache-2.0
// Writes text to where somebody may not read it, without holding up whoever has something to say.
#pragma once

#include <memory>
#include <stop_token>
#include <string>

namespace choreo::cli {

/// Writes in a thread of its own what others give it, in the order in which they do.
///
/// A pipe that is full, or a terminal that was stopped, takes nothing until somebody reads: what is given meanwhile
/// waits in memory. Of more than 256 KiB the oldest lines are left out, counted, and a line in their place says how
/// many. Where nobody can read any more, nothing is kept.
/// @thread thread-safe: no lock is held while anything is written.
class AsyncWriter {
 public:
  /// @param descriptor  stays open as long as the process.
  explicit AsyncWriter(int descriptor);
  /// What is not written yet is lost; see `drain`.
  ~AsyncWriter();
  AsyncWriter(const AsyncWriter&) = delete;
  AsyncWriter& operator=(const AsyncWriter&) = delete;

  /// Gives the text to be written, and does not wait for that unless the system has no thread for it, which begins with
  /// the first text.
  /// @param line  counts where it is left out.
  void put(std::string text, bool line = true);

  /// Waits until everything is written; not for long, and not at all where that was in vain since it was written last.
  /// So what is said here and on standard output is seen in its order.
  void flush_briefly();

  /// Whether `flush_briefly` was in vain: the text would only wait.
  [[nodiscard]] bool is_behind() const;

  /// Waits until everything is written, for as long as it takes; once stop is requested for half a second at the most.
  void drain(const std::stop_token& stop);

 private:
  struct State;  // Shared with the thread, which cannot be ended while it writes.

  std::shared_ptr<State> state_;
};

}  // namespace choreo::cli
