// SPDX-License-Identifier: Apache-2.0
// Ctrl-C: the first asks for an orderly end, the second for an end without results.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

#include "cli/call_slot.hpp"

namespace choreo::cli {

/// Takes SIGINT, SIGTERM and SIGHUP in a thread of its own, where anything may be done about them, and SIGUSR1, which
/// asks how things are, in another, so that it holds up none of the others.
///
/// What is called as a stop is requested (std::stop_callback) runs in the thread that takes the signals: it must not
/// wait for anything, least of all for somebody to read what it has to say (Console::warn_later).
/// Make it before any other thread: they inherit that the signals are blocked. A third signal ends the process.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  [[nodiscard]] std::stop_token orderly() const { return orderly_.get_token(); }  ///< Read no more; write what is.
  [[nodiscard]] std::stop_token now() const { return now_.get_token(); }          ///< Leave nothing behind.

  /// What SIGUSR1 calls, in the reports' thread; empty: nothing. Once this returns, the one before is not called.
  void on_report(std::function<void()> report) { report_.set(std::move(report)); }

 private:
  void take_signals(const std::stop_token& stop);
  void make_reports(const std::stop_token& stop);

  std::stop_source orderly_;
  std::stop_source now_;
  CallSlot<> report_;
  std::mutex mutex_;
  std::condition_variable_any asked_;
  bool asks_ = false;  // Guarded by mutex_, which is not held during the report.
  std::jthread reports_;
  std::jthread signals_;
};

}  // namespace choreo::cli
