// SPDX-License-Identifier: Apache-2.0
#include "devices/synthetic/semaphore_script.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "core/error.hpp"
#include "devices/synthetic/moves.hpp"

namespace choreo::devices::synthetic {
namespace {

constexpr double kRaise = 0.15;
constexpr double kHold = 0.55;

}  // namespace

std::vector<SpelledSign> spelled(std::string_view text, double letters_per_minute) {
  constexpr std::size_t kMost = 10000;
  const double slot = 60 / letters_per_minute;
  std::vector<SpelledSign> signs;
  double begin = 0;
  const auto say = [&](std::string_view name) {
    signs.push_back({body::semaphore(name).value(), begin + kRaise * slot, begin + (kRaise + kHold) * slot});
    begin += slot;
  };
  bool numerals = false;
  for (const char c : text) {
    const bool digit = c >= '0' && c <= '9';
    const char upper = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    const bool letter = upper >= 'A' && upper <= 'Z';
    if (digit && !numerals) say("NUMERALS");
    if (letter && numerals) say("J");
    if (digit || letter) numerals = digit;
    if (digit) {
      say(std::string_view("KABCDEFGHI").substr(static_cast<std::size_t>(c - '0'), 1));
    } else if (letter) {
      say(std::string_view(&upper, 1));
    } else if (c == '#') {
      say("NUMERALS");
    } else if (c == '!') {
      say("CANCEL");
    } else if (c == ' ') {
      begin += slot / 2;
    } else {
      throw usage_error(fmt::format("semaphore cannot say the character with code {}", static_cast<unsigned char>(c)),
                        {}, "text is letters, digits, spaces, # (NUMERALS) and ! (CANCEL)");
    }
    if (signs.size() > kMost) throw usage_error(fmt::format("the text is longer than {} signs", kMost));
  }
  if (signs.empty()) throw usage_error(fmt::format("text \"{}\" has no letter in it", text));
  return signs;
}

double semaphore_duration(const ScriptOptions& options) {
  const double slot = 60 / options.letters_per_minute;
  return spelled(options.text, options.letters_per_minute).back().to + (1 - kRaise - kHold) * slot;
}

Move make_semaphore(const ScriptOptions& options, const Style& style) {
  const auto signs = spelled(options.text, options.letters_per_minute);
  const double raise = kRaise * 60 / options.letters_per_minute;
  const auto in_style = [style](const body::SemaphoreSign& sign) {
    auto pose = body::semaphore_pose(sign);
    for (auto& leg : pose.leg) leg.abduction = style.stance;
    return pose;
  };
  const auto rest = in_style(body::semaphore("REST").value());
  return [=](double t) {
    // The sign whose raising, holding or lowering is nearest; all before it is over.
    auto next = std::find_if(signs.begin(), signs.end(), [&](const auto& s) { return t < s.to + raise; });
    if (next == signs.end()) return body::grounded(rest);
    const double up = t < next->from ? eased((t - next->from + raise) / raise) : 1 - eased((t - next->to) / raise);
    return body::grounded(body::blended(rest, in_style(next->sign), up));
  };
}

}  // namespace choreo::devices::synthetic
