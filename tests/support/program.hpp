// SPDX-License-Identifier: Apache-2.0
// Runs a program as a person would: arguments, environment, what it says, how it ends.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace choreo::test {

/// A signal that is sent once the program has said something.
struct Poke {
  std::string after;  ///< Sent when standard error holds this text behind what the poke before it waited for.
  int signal = 0;
};

struct RunOptions {
  std::vector<std::pair<std::string, std::string>> environment;  ///< Added to that of the test.
  std::chrono::seconds limit{90};                                ///< Then it is killed; a guard against hanging only.
  std::optional<std::uint64_t> file_size_limit;                  ///< Bytes no file may grow beyond, as on a full disk.
  std::string folder;                                            ///< Where it runs; the test's own where empty.
  std::vector<Poke> pokes;                                       ///< In this order.
  std::function<void(int process)> started;                      ///< Told the process id; read is what comes after.
  bool full_err = false;  ///< Standard error is a pipe that takes not a byte until `started` returns.
};

/// What a program did.
struct Outcome {
  int status = -1;         ///< Exit status; -1 where it did not exit by itself.
  int signal = 0;          ///< What killed it, 0 for nothing.
  bool timed_out = false;  ///< The limit was reached.
  std::size_t poked = 0;   ///< How many pokes were sent.
  std::string out;
  std::string err;

  /// Standard error line by line.
  [[nodiscard]] std::vector<std::string> err_lines() const;
  /// Those that begin with `start`, without it.
  [[nodiscard]] std::vector<std::string> err_lines(const std::string& start) const;
  /// Everything, for the message of a failed test.
  [[nodiscard]] std::string told() const;
};

/// @throws std::runtime_error where the program cannot be started.
[[nodiscard]] Outcome run_program(const std::string& path, const std::vector<std::string>& arguments,
                                  const RunOptions& options = {});

/// Waits until the program has ended, without forgetting how. @return false where it has not within `limit`.
[[nodiscard]] bool ends_within(int process, std::chrono::seconds limit);

}  // namespace choreo::test
