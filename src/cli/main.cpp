// SPDX-License-Identifier: Apache-2.0
// The program: reads the command line, runs the command, turns what went wrong into one line and an exit status.
#include <algorithm>
#include <csignal>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "cli/commands.hpp"
#include "core/text.hpp"

namespace choreo::cli {
namespace {

constexpr auto kManual = R"(
Where to begin:
  choreoscope analyze rehearsal.mp4 --out out/rehearsal
  choreoscope analyze synthetic://jumping-jacks --out out/jacks
  choreoscope analyze --help

Exit status: 0 done, 1 failed while running, 2 refused (usage, configuration,
source), 130 interrupted.)";

// The verb that was meant, where the first word is none.
std::string hint_for(const CLI::App& app, const std::vector<std::string>& words) {
  std::vector<std::string> verbs;
  for (const auto* command : app.get_subcommands([](const CLI::App*) { return true; })) verbs.push_back(command->get_name());
  if (!words.empty() && !words[0].starts_with("-") && std::find(verbs.begin(), verbs.end(), words[0]) == verbs.end()) {
    return hint_for_name(words[0], verbs);
  }
  const bool verb_known = !words.empty() && !words[0].starts_with("-");
  return verb_known ? fmt::format("see choreoscope {} --help", words[0]) : "see choreoscope --help";
}

int run_program(int argc, char** argv) {
  // A full disk or a closed pipe is an error to be told of, not a death.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  Console console;
  Interrupt interrupt;

  CLI::App app("choreoscope: an oscilloscope for movement. Watches a moving body and shows its similarity to itself, Z,\n"
               "and to its mirror image, Z*, at every pair of times.");
  app.name("choreoscope");
  app.set_version_flag("--version", std::string("choreoscope ") + CHOREO_VERSION);
  app.require_subcommand(1);
  app.footer(kManual);
  app.get_formatter()->column_width(26);
  Command chosen;
  declare_analyze(app, chosen);
  declare_synth(app, chosen);
  declare_config(app, chosen);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& problem) {
    if (problem.get_exit_code() == 0) return app.exit(problem);  // --help, --version
    console.error(usage_error(problem.what(), {}, hint_for(app, {argv + 1, argv + argc})));
    return kRefused;
  }
  try {
    Session session{console, interrupt};
    const int status = chosen(session);
    if (std::fflush(stdout) != 0) throw failure("standard output cannot be written to");
    return status;
  } catch (const Error& error) {
    console.finish_progress();
    console.error(error);
    return static_cast<int>(error.fault());
  } catch (const std::bad_alloc&) {
    console.finish_progress();
    console.error(failure("not enough memory", {}, "lower working.rows, or take fewer frames with --every or --span"));
    return kFailed;
  } catch (const std::exception& error) {
    // Libraries' errors that no edge restated.
    console.finish_progress();
    console.error(failure(error.what()));
    return kFailed;
  }
}

}  // namespace
}  // namespace choreo::cli

int main(int argc, char** argv) { return choreo::cli::run_program(argc, argv); }
