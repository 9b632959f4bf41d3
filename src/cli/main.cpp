// SPDX-License-Identifier: Apache-2.0
// The program: reads the command line, runs the command, turns what went wrong into one line and an exit status.
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>

#include "cli/commands.hpp"
#include "core/text.hpp"
#include "outputs/display_loss.hpp"

namespace choreo::cli {
namespace {

constexpr auto kManual = R"(
Where to begin:
  choreoscope analyze rehearsal.mp4 --out out/rehearsal
  choreoscope analyze synthetic://jumping-jacks --out out/jacks
  choreoscope analyze --help

Exit status: 0 done, 1 failed while running, 2 refused (usage, configuration,
source), 130 interrupted.)";

using Words = std::vector<std::string>;

// The verbs that may follow a command, none where it has none.
Words verbs_of(const CLI::App& command) {
  Words verbs;
  for (const auto* verb : command.get_subcommands([](const CLI::App*) { return true; }))
    verbs.push_back(verb->get_name());
  return verbs;
}

// Refuses words that are no commands, where commands must stand; CLI11 would only say that one is required.
// @return the command that the words name.
const CLI::App& check_verbs(const CLI::App& app, const Words& words) {
  const auto* command = &app;
  std::string said = "choreoscope";
  for (std::size_t i = 0;; ++i) {
    const auto verbs = verbs_of(*command);
    if (verbs.empty()) return *command;
    if (i == words.size()) {
      throw usage_error(fmt::format("{}: which command?", said), {},
                        fmt::format("known: {}; see {} --help", join(verbs), said));
    }
    if (words[i].starts_with("-")) return *command;  // --help and the like, or refused by CLI11.
    if (std::find(verbs.begin(), verbs.end(), words[i]) == verbs.end()) {
      throw usage_error(fmt::format("unknown command \"{} {}\"", said, words[i]), {}, hint_for_name(words[i], verbs));
    }
    command = command->get_subcommand(words[i]);
    said += " " + words[i];
  }
}

// The option that was meant, where one is mistyped; where to read otherwise.
std::string hint_for(const CLI::App& command, const Words& words) {
  Words known;
  for (const auto* option : command.get_options()) {
    for (const auto& name : option->get_lnames()) known.push_back("--" + name);
  }
  for (const auto& word : words) {
    const auto name = word.substr(0, word.find('='));
    if (!name.starts_with("--") || std::find(known.begin(), known.end(), name) != known.end()) continue;
    if (const auto near = nearest_name(name, known)) return fmt::format("did you mean \"{}\"?", *near);
  }
  std::string said;
  for (const auto* app = &command; app != nullptr; app = app->get_parent()) {
    said = app->get_name() + (said.empty() ? "" : " ") + said;
  }
  return fmt::format("see {} --help", said);
}

// What goes wrong inside of OpenCV comes back as an exception or an empty picture, and is told in our own words.
void silence_opencv() {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  cv::redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
}

int run_program(int argc, char** argv, Session& session) {
  auto& console = session.console;

  CLI::App app(
      "choreoscope: an oscilloscope for movement. Watches a moving body and shows its similarity to itself, Z,\n"
      "and to its mirror image, Z*, at every pair of times.");
  app.name("choreoscope");
  app.set_version_flag("--version", std::string("choreoscope ") + CHOREO_VERSION);
  app.footer(kManual);
  app.get_formatter()->column_width(26);
  Command chosen;
  declare_analyze(app, chosen);
  declare_live(app, chosen);
  declare_record(app, chosen);
  declare_calibrate(app, chosen);
  declare_synth(app, chosen);
  declare_devices(app, chosen);
  declare_tones(app, chosen);
  declare_config(app, chosen);

  const Words words(argv + std::min(argc, 1), argv + argc);
  const CLI::App* command = &app;
  try {
    command = &check_verbs(app, words);
    app.parse(argc, argv);
    if (!chosen) throw usage_error("choreoscope: which command?", {}, "see choreoscope --help");
  } catch (const Error& error) {
    console.error(error);
    return kRefused;
  } catch (const CLI::ParseError& problem) {
    if (problem.get_exit_code() == 0) return app.exit(problem);  // --help, --version
    console.error(usage_error(problem.what(), {}, hint_for(*command, words)));
    return kRefused;
  }
  try {
    const int status = chosen(session);
    if (std::fflush(stdout) != 0) throw failure("standard output cannot be written to");
    return status;
  } catch (const Interrupted&) {
    console.finish_progress();
    console.warn("interrupted: nothing was written");
    return kInterrupted;
  } catch (const Error& error) {
    console.finish_progress();
    console.error(error);
    return static_cast<int>(error.fault());
  } catch (const std::bad_alloc&) {
    console.finish_progress();
    console.error(failure("not enough memory", {}, "lower working.rows, or take fewer frames with --every or --span"));
    return kFailed;
  } catch (const std::exception& error) {
    // Libraries' errors that no edge restated; of standard output fmt says no more than "file".
    console.finish_progress();
    console.error(failure(std::ferror(stdout) != 0 ? "standard output cannot be written to" : error.what()));
    return kFailed;
  }
}

}  // namespace
}  // namespace choreo::cli

int main(int argc, char** argv) {
  // A full disk or a closed pipe is an error to be told of, not a death.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  choreo::cli::silence_opencv();
  choreo::cli::Interrupt interrupt;
  choreo::cli::Console console;
  choreo::cli::Session session{console, interrupt};
  const int status = choreo::cli::run_program(argc, argv, session);
  console.finish(interrupt.orderly());
  if (choreo::outputs::display_is_lost()) {
    // The display's libraries would say farewell to it and wait for an answer.
    std::fflush(nullptr);
    std::_Exit(status);
  }
  return status;
}
