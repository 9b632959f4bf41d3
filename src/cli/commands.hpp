// SPDX-License-Identifier: Apache-2.0
// The commands: each declares itself and returns what to run.
#pragma once

#include <functional>

#include "cli/console.hpp"
#include "cli/interrupt.hpp"

namespace CLI {
class App;
}

namespace choreo::cli {

/// What a command may use of the world.
struct Session {
  Console& console;
  Interrupt& interrupt;
};

/// Exit statuses; see docs/command-line.md.
enum ExitStatus : int { kDone = 0, kFailed = 1, kRefused = 2, kInterrupted = 130 };

/// Thrown where a command ends because of Ctrl-C and has nothing to write.
struct Interrupted {};

/// Runs a parsed command. @return its exit status. @throws Error, Interrupted
using Command = std::function<int(Session&)>;

/// Each adds its subcommand to `app` and sets `chosen` when it was the one that was typed.
void declare_analyze(CLI::App& app, Command& chosen);
void declare_live(CLI::App& app, Command& chosen);
void declare_record(CLI::App& app, Command& chosen);
void declare_calibrate(CLI::App& app, Command& chosen);
void declare_synth(CLI::App& app, Command& chosen);
void declare_devices(CLI::App& app, Command& chosen);
void declare_tones(CLI::App& app, Command& chosen);
void declare_config(CLI::App& app, Command& chosen);

}  // namespace choreo::cli
