// SPDX-License-Identifier: Apache-2.0
// What the user sees while the program works: progress, warnings, errors.
#pragma once

#include <mutex>
#include <stop_token>
#include <string>
#include <string_view>

#include "cli/async_writer.hpp"
#include "core/error.hpp"

namespace choreo::cli {

/// Standard error: a progress bar on a terminal, plain lines otherwise.
///
/// Every call returns once its text is written, but never waits long for somebody to read it: see AsyncWriter.
/// @thread thread-safe; make it where the threads that it begins take no signals.
class Console {
 public:
  Console();

  /// Says how far a step is. On a terminal the bar is redrawn; otherwise a line is written when the step begins and at
  /// every fifth of it.
  /// @param share  0 to 1; less than 0 where the end is unknown.
  void progress(std::string_view step, double share);

  /// Ends the step's bar or lines.
  void finish_progress();

  void say(std::string_view line);
  void warn(std::string_view line);
  /// Warns without waiting at all: for who must not, such as the thread that answers signals.
  void warn_later(std::string_view line);
  void error(const Error& error);
  void error(std::string_view line);

  /// Before the end of the program: waits until everything was read, once stop is requested not for long.
  void finish(const std::stop_token& stop) { writer_.drain(stop); }

 private:
  void put_line(std::string_view line);
  [[nodiscard]] std::string bar_cleared();

  AsyncWriter writer_;
  std::mutex mutex_;  // Never held while anything is written.
  bool terminal_;
  std::string step_;
  int shown_ = -1;  // The last percentage, or fifth, that was shown.
  bool bar_ = false;
};

}  // namespace choreo::cli
