// SPDX-License-Identifier: Apache-2.0
// What can be set about colour tones.
#pragma once

#include <string>
#include <vector>

namespace choreo::vision {

enum class ToneKind { kGaussian, kHistogram };

/// Where tones come from and how they are used.
struct ToneOptions {
  bool learn_skin = true;                ///< The tone "skin" is learned from the face; else it is the file's.
  std::string file;                      ///< A tones file (config/tones_file.hpp); empty: none. What is learned wins.
  ToneKind model = ToneKind::kGaussian;  ///< Of what is learned.
  double skin_prior = 0.3;               ///< Of learned skin, [0.001, 1000]: only ratios of priors matter.
  double outliers = 0.5;                 ///< Prior of all that is no tone, [0.001, 1000].
  double threshold = 0.5;                ///< Least posterior of what counts as an arm, [0.01, 0.99].
  double noise = 2;                      ///< Standard deviation of the sensor in a channel, grey levels, [0, 50].
  double learn_s = 3;                    ///< All of the first so many seconds of face counts alike, s, [0, 60].
  double adapt_s = 20;                   ///< Afterwards, time constant of forgetting, s, [0.5, 3600]; 0: never adapts.
  double rebuild_s = 0.5;                ///< A learned tone is given out at most so often, s, [0, 60].
  bool learn_clothes = true;             ///< What is worn below the face is learned as a tone of its own, "clothes".
  std::vector<std::string> arms = {"skin"};  ///< The tones that arms (gloves, flags) show; at least one.

  void validate() const;  ///< @throws Error (usage) naming the option, its value and its range.

  /// The same, and that every tone of `arms` is learned or one of those.
  /// @param given  the names of the tones in `file`.
  void validate(std::vector<std::string> given) const;
};

/// "gaussian" or "histogram". @throws Error (usage) for anything else.
[[nodiscard]] ToneKind tone_kind_named(const std::string& name);
[[nodiscard]] const char* name_of(ToneKind kind);

}  // namespace choreo::vision
