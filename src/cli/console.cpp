// SPDX-License-Identifier: Apache-2.0
#include "cli/console.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>

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

std::string warning(std::string_view line) { return fmt::format("choreoscope: warning: {}", flat(line)); }

}  // namespace

Console::Console() : writer_(STDERR_FILENO) {
  const auto* term = std::getenv("TERM");
  terminal_ = ::isatty(STDERR_FILENO) != 0 && term != nullptr && std::string_view(term) != "dumb";
}

void Console::progress(std::string_view step, double share) {
  {
    const std::scoped_lock lock(mutex_);
    if (terminal_ && writer_.is_behind()) return;  // A bar that is read late is of no use.
    std::string text;
    if (step != step_) {
      text = bar_cleared();
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
      writer_.put(text + fmt::format("\r[{}] {:3d} %  {}\x1b[K", bar, percent, step_), false);
      bar_ = true;
    } else {
      const int fifth = percent / 20;
      if (fifth <= shown_ && shown_ >= 0) return;
      shown_ = fifth;
      writer_.put(fifth == 0 ? fmt::format("choreoscope: {}\n", step_)
                             : fmt::format("choreoscope: {}: {} %\n", step_, fifth * 20));
    }
  }
  writer_.flush_briefly();
}

void Console::finish_progress() {
  {
    const std::scoped_lock lock(mutex_);
    if (auto text = bar_cleared(); !text.empty()) writer_.put(std::move(text), false);
    step_.clear();
    shown_ = -1;
  }
  writer_.flush_briefly();
}

// What removes the bar, empty where there is none.
std::string Console::bar_cleared() { return std::exchange(bar_, false) ? "\r\x1b[K" : ""; }

void Console::put_line(std::string_view line) {
  const std::scoped_lock lock(mutex_);
  writer_.put(fmt::format("{}{}\n", bar_cleared(), line));
}

void Console::say(std::string_view line) {
  put_line(line);
  writer_.flush_briefly();
}

void Console::warn_later(std::string_view line) { put_line(warning(line)); }

void Console::warn(std::string_view line) { say(warning(line)); }

void Console::error(std::string_view line) { say(fmt::format("choreoscope: error: {}", flat(line))); }

void Console::error(const Error& problem) {
  error(problem.what());
  if (!problem.hint().empty()) say("hint: " + flat(problem.hint()));
}

}  // namespace choreo::cli
