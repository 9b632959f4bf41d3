// SPDX-License-Identifier: Apache-2.0
// Ctrl-C: the first asks for an orderly end, the second for an end without results.
#pragma once

#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

namespace choreo::cli {

/// Takes SIGINT, SIGTERM and SIGHUP in a thread of its own, where anything may be done about them, and SIGUSR1, which
/// asks how things are.
///
/// Make it before any other thread: they inherit that the signals are blocked. A third signal ends the process.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  [[nodiscard]] std::stop_token orderly() const { return orderly_.get_token(); }  ///< Read no more; write what is.
  [[nodiscard]] std::stop_token now() const { return now_.get_token(); }          ///< Leave nothing behind.

  /// What SIGUSR1 calls, in the signals' thread; empty: nothing. Once this returns, the one before is not called.
  void on_report(std::function<void()> report);

 private:
  std::stop_source orderly_;
  std::stop_source now_;
  std::mutex report_mutex_;
  std::function<void()> report_;
  std::jthread thread_;
};

}  // namespace choreo::cli
