// SPDX-License-Identifier: Apache-2.0
#include "devices/synthetic/semaphore_script.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "core/error.hpp"
#include "devices/synthetic/moves.hpp"

namespace choreo::devices::synthetic {
namespace {

constexpr double kRaise = 0.15;
constexpr double kHold = 0.55;
constexpr double kWave = 0.8;  // seconds

// A sign that is a movement: both arms wave between two abductions, in degrees, beginning and ending at the first.
struct Movement {
  char character;
  body::SemaphoreSign about;
  double low, high;
  int waves;
};
constexpr std::array<Movement, 2> kMovements = {{
    {'^', {"ATTENTION", 4, 4}, 135, 208, 4},
    {'~', {"ERROR", 6, 2}, 45, 135, 5},
}};

body::Pose pose_of(const SpelledSign& spelled, double t) {
  auto pose = body::semaphore_pose(spelled.sign);
  if (!spelled.moves) return pose;
  const auto movement = std::find_if(kMovements.begin(), kMovements.end(),
                                     [&](const auto& m) { return m.about.name == spelled.sign.name; });
  const double since = std::clamp(t, spelled.from, spelled.to) - spelled.from;
  const double up = 0.5 - 0.5 * wave_cos(phase_of(since, kWave));
  for (auto& arm : pose.arm) arm = {movement->low + (movement->high - movement->low) * up, 0, 0, 0};
  return pose;
}

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
  const auto wave = [&](const Movement& movement) {
    const double held = movement.waves * kWave;
    signs.push_back({movement.about, begin + kRaise * slot, begin + kRaise * slot + held, true});
    begin += held + (1 - kHold) * slot;
  };
  bool numerals = false;
  for (const char c : text) {
    const bool digit = c >= '0' && c <= '9';
    const char upper = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    const bool letter = upper >= 'A' && upper <= 'Z';
    if (digit && !numerals) say("NUMERALS");
    if (letter && numerals) say("J");
    if (digit || letter) numerals = digit;
    const auto movement =
        std::find_if(kMovements.begin(), kMovements.end(), [&](const auto& m) { return m.character == c; });
    if (movement != kMovements.end()) {
      wave(*movement);
    } else if (digit) {
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
                        {}, "text is letters, digits, spaces, # (NUMERALS), ! (CANCEL), ^ (ATTENTION) and ~ (ERROR)");
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
  const auto in_style = [style](body::Pose pose) {
    for (auto& leg : pose.leg) leg.abduction = style.stance;
    return pose;
  };
  const auto rest = in_style(body::semaphore_pose(body::semaphore("REST").value()));
  return [=](double t) {
    // The sign whose raising, holding or lowering is nearest; all before it is over.
    auto next = std::find_if(signs.begin(), signs.end(), [&](const auto& s) { return t < s.to + raise; });
    if (next == signs.end()) return body::grounded(rest);
    const double up = t < next->from ? eased((t - next->from + raise) / raise) : 1 - eased((t - next->to) / raise);
    return body::grounded(body::blended(rest, in_style(pose_of(*next, t)), up));
  };
}

}  // namespace choreo::devices::synthetic
