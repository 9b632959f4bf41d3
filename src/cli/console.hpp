// SPDX-License-Identifier: Apache-2.0
// What the user sees while the program works: progress, warnings, errors.
#pragma once

#include <mutex>
#include <string>
#include <string_view>

#include "core/error.hpp"

namespace choreo::cli {

/// Standard error: a progress bar on a terminal, plain lines otherwise.
/// @thread thread-safe
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
  void error(const Error& error);
  void error(std::string_view line);

 private:
  void clear_bar();

  std::mutex mutex_;
  bool terminal_;
  std::string step_;
  int shown_ = -1;  // The last percentage, or fifth, that was shown.
  bool bar_ = false;
};

}  // namespace choreo::cli
