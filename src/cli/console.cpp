// SPDX-License-Identifier: Apache-2.0
#include "cli/console.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>

namespace choreo::cli {
namespace {

// One line is one line, and only text, whatever a file name contains.
std::string flat(std::string_view line) {
  std::string text(line);
  for (auto& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return text;
}

}  // namespace

Console::Console() {
  const auto* term = std::getenv("TERM");
  terminal_ = ::isatty(STDERR_FILENO) != 0 && term != nullptr && std::string_view(term) != "dumb";
}

void Console::progress(std::string_view step, double share) {
  const std::scoped_lock lock(mutex_);
  if (step != step_) {
    clear_bar();
    step_ = std::string(step);
    shown_ = -1;
  }
  // A whole hundred is said when the step is over: sources lie about their length.
  // The comparison also turns what is no number, of a source without length, into nothing done.
  const int percent = share > 0 ? static_cast<int>(std::min(share, 0.99) * 100.0) : 0;
  if (terminal_) {
    constexpr int kWidth = 30;
    if (percent == shown_) return;
    shown_ = percent;
    const int filled = percent * kWidth / 100;
    const auto bar =
        share < 0 ? std::string(kWidth, '.') : std::string(filled, '#') + std::string(kWidth - filled, ' ');
    fmt::print(stderr, "\r[{}] {:3d} %  {}\x1b[K", bar, percent, step_);
    std::fflush(stderr);
    bar_ = true;
  } else {
    const int fifth = percent / 20;
    if (fifth <= shown_ && shown_ >= 0) return;
    shown_ = fifth;
    if (fifth == 0) {
      fmt::print(stderr, "choreoscope: {}\n", step_);
    } else {
      fmt::print(stderr, "choreoscope: {}: {} %\n", step_, fifth * 20);
    }
  }
}

void Console::finish_progress() {
  const std::scoped_lock lock(mutex_);
  clear_bar();
  step_.clear();
  shown_ = -1;
}

void Console::clear_bar() {
  if (!bar_) return;
  fmt::print(stderr, "\r\x1b[K");
  std::fflush(stderr);
  bar_ = false;
}

void Console::say(std::string_view line) {
  const std::scoped_lock lock(mutex_);
  clear_bar();
  fmt::print(stderr, "{}\n", line);
}

void Console::warn(std::string_view line) { say(fmt::format("choreoscope: warning: {}", flat(line))); }

void Console::error(std::string_view line) { say(fmt::format("choreoscope: error: {}", flat(line))); }

void Console::error(const Error& problem) {
  error(problem.what());
  if (!problem.hint().empty()) say("hint: " + flat(problem.hint()));
}

}  // namespace choreo::cli
