// SPDX-License-Identifier: Apache-2.0
// An X server without a screen, for tests of windows.
#pragma once

#include <string>

namespace choreo::test {

/// Xvfb on a display of its own, until it crashes or goes out of scope.
class XServer {
 public:
  XServer();
  ~XServer();
  XServer(const XServer&) = delete;
  XServer& operator=(const XServer&) = delete;

  /// What DISPLAY has to be, such as ":1"; empty where Xvfb is not installed or did not start.
  [[nodiscard]] const std::string& display() const { return display_; }
  /// Ends it at once, as a crash would.
  void crash();

 private:
  void end(int signal);

  int process_ = 0;
  std::string display_;
};

}  // namespace choreo::test
