// SPDX-License-Identifier: Apache-2.0
#include "devices/synthetic/script.hpp"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"
#include "devices/synthetic/chance.hpp"
#include "devices/synthetic/moves.hpp"

namespace choreo::devices::synthetic {
namespace {

const std::vector<ScriptEntry>& entries() {
  static const auto kEntries = [] {
    auto all = motif_scripts();
    auto more = everyday_scripts();
    std::move(more.begin(), more.end(), std::back_inserter(all));
    return all;
  }();
  return kEntries;
}

const ScriptEntry& entry_of(std::string_view name) {
  for (const auto& entry : entries()) {
    if (entry.facts.name == name) return entry;
  }
  throw usage_error(fmt::format("there is no script \"{}\"", name), {}, hint_for_name(name, script_names()));
}

}  // namespace

Style style_of(std::uint64_t seed) {
  const auto between = [&](std::uint64_t what, double least, double most) {
    return least + (most - least) * uniform(mixed(seed, 400 + what));
  };
  return {between(0, 0.92, 1.04), between(1, 4, 14), between(2, 2, 5)};
}

body::Pose standing(const Style& style) {
  body::Pose pose;
  for (auto& arm : pose.arm) {
    arm.abduction = 9;
    arm.elbow = style.elbow;
    arm.twist = -25;
  }
  for (auto& leg : pose.leg) leg.abduction = style.stance;
  return body::grounded(pose);
}

body::Pose Path::at(double seconds) const {
  if (seconds <= keys_.front().seconds) return keys_.front().pose;
  if (seconds >= keys_.back().seconds) return keys_.back().pose;
  std::size_t k = 0;
  while (seconds >= keys_[k + 1].seconds) ++k;
  // A cubic (Catmull and Rom, for keys at any distance) that rests at both ends of the path.
  const auto slope = [&](std::size_t i, std::size_t value) {
    if (i == 0 || i + 1 == keys_.size()) return 0.0;
    return (body::pose_values(keys_[i + 1].pose)[value] - body::pose_values(keys_[i - 1].pose)[value]) /
           (keys_[i + 1].seconds - keys_[i - 1].seconds);
  };
  const auto from = body::pose_values(keys_[k].pose);
  const auto to = body::pose_values(keys_[k + 1].pose);
  const double h = keys_[k + 1].seconds - keys_[k].seconds;
  const double t = (seconds - keys_[k].seconds) / h;
  auto values = from;
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = (1 + 2 * t) * (1 - t) * (1 - t) * from[i] + t * (1 - t) * (1 - t) * h * slope(k, i) +
                t * t * (3 - 2 * t) * to[i] - t * t * (1 - t) * h * slope(k + 1, i);
  }
  return body::pose_from_values(values);
}

std::span<const ScriptFacts> all_scripts() {
  static const auto kFacts = [] {
    std::vector<ScriptFacts> facts;
    for (const auto& entry : entries()) facts.push_back(entry.facts);
    return facts;
  }();
  return kFacts;
}

const std::vector<std::string>& script_names() {
  static const auto kNames = [] {
    std::vector<std::string> names;
    for (const auto& entry : entries()) names.push_back(entry.facts.name);
    return names;
  }();
  return kNames;
}

const ScriptFacts& script_facts(std::string_view name) { return entry_of(name).facts; }

Script::Script(std::string_view name, ScriptOptions options)
    : facts_(script_facts(name)), options_(std::move(options)), style_(style_of(options_.seed)) {
  const auto& entry = entry_of(name);
  if (entry.make != nullptr) move_ = entry.make(options_, style_);
  if (facts_.name == "semaphore") {
    facts_.duration = semaphore_duration(options_);
    signs_ = spelled(options_.text, options_.letters_per_minute);
  }
}

std::string_view Script::sign_at(double seconds) const {
  // The last that began before.
  const auto after = std::upper_bound(signs_.begin(), signs_.end(), seconds,
                                      [](double t, const SpelledSign& sign) { return t < sign.from; });
  if (after == signs_.begin() || seconds > std::prev(after)->to) return {};
  return std::prev(after)->sign.name;
}

std::optional<body::Pose> Script::pose_at(double seconds) const {
  if (!move_) return std::nullopt;
  return move_(seconds);
}

}  // namespace choreo::devices::synthetic
