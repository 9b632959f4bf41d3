// SPDX-License-Identifier: Apache-2.0
// The choreographies: what the performer does at a time, and what is true of it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "body/figure.hpp"
#include "devices/synthetic/semaphore_script.hpp"

namespace choreo::devices::synthetic {

enum class Symmetry {
  kAlways,     ///< Every pose is its own mirror image.
  kNever,      ///< No pose is.
  kSometimes,  ///< Some are.
};

/// What is true of a script, by construction, for the poses p(t); star is the mirror image, times in seconds from the
/// script's beginning. Absent where it does not hold. All are whole numbers of frames at 30 a second.
struct ScriptFacts {
  std::string name;
  std::string summary;   ///< One line.
  double duration = 10;  ///< Natural length in seconds.
  Symmetry symmetry = Symmetry::kSometimes;
  bool still = false;                                 ///< p never changes.
  std::optional<double> period;                       ///< p(t + period) = p(t).
  std::optional<double> mirror_shift;                 ///< p(t + mirror_shift) = p(t)*.
  std::optional<double> turn;                         ///< p(turn - s) = p(turn + s) for s up to `reach`.
  std::optional<double> mirror_turn;                  ///< p(mirror_turn - s) = p(mirror_turn + s)* for s up to `reach`.
  double reach = 0;                                   ///< See turn and mirror_turn.
  std::optional<std::pair<double, double>> same;      ///< p is the same at both times and elsewhere in between.
  std::optional<std::pair<double, double>> mirrored;  ///< p is the other's mirror image, and neither is symmetric.
  std::optional<std::pair<double, double>> repeated;  ///< Paths: p(first + s) = p(second + s) for s up to `length`.
  double length = 0;                                  ///< See repeated.
};

/// What a script may depend on.
struct ScriptOptions {
  std::uint64_t seed = 1;                           ///< Of the movement style, and of what `idle` improvises.
  std::string text = "ABCDEFGHIJKLMNOPQRSTUVWXYZ";  ///< What `semaphore` says.
  double letters_per_minute = 12;                   ///< How fast.
  double half_width = 0.9;  ///< Half the picture's width in units of the body's height, for `crossing`.
};

/// How somebody moves: small differences between people that leave every fact of a script true.
struct Style {
  double reach = 1;   ///< Factor on how far movements go, 0.92 to 1.04.
  double elbow = 8;   ///< Degrees by which straight arms stay bent.
  double stance = 3;  ///< Degrees by which the legs are spread in standing.
};
[[nodiscard]] Style style_of(std::uint64_t seed);

/// Every script's facts, in the order of the manual.
[[nodiscard]] std::span<const ScriptFacts> all_scripts();
[[nodiscard]] const std::vector<std::string>& script_names();

/// @throws Error (usage) where there is no such script, naming the nearest.
[[nodiscard]] const ScriptFacts& script_facts(std::string_view name);

/// One script ready to be performed.
class Script {
 public:
  /// @throws Error (usage) for an unknown name or a text that semaphore cannot say.
  Script(std::string_view name, ScriptOptions options);

  [[nodiscard]] const ScriptFacts& facts() const { return facts_; }
  [[nodiscard]] const ScriptOptions& options() const { return options_; }

  /// Seconds; `facts().duration`, for semaphore what its text takes.
  [[nodiscard]] double duration() const { return facts_.duration; }

  /// The sign that semaphore holds at a time; empty in between, and for other scripts.
  [[nodiscard]] std::string_view sign_at(double seconds) const;

  /// The pose at a time from 0; nothing where nobody performs. Cycles go on for ever, other scripts rest at their end.
  [[nodiscard]] std::optional<body::Pose> pose_at(double seconds) const;

 private:
  ScriptFacts facts_;
  ScriptOptions options_;
  Style style_;
  std::vector<SpelledSign> signs_;          // of semaphore
  std::function<body::Pose(double)> move_;  // empty: nobody
};

}  // namespace choreo::devices::synthetic
