// SPDX-License-Identifier: Apache-2.0
// From signs of semaphore to words.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>

#include "recognition/semaphore_reader.hpp"

namespace choreo::recognition {

/// Puts signs together to text.
///
/// - A letter is itself. After NUMERALS A to I and K are 1 to 9 and 0, until J leads back to letters (and is not
///   written); other letters stay letters.
/// - REST is a space where it lasts `word_gap` times as long as the signaller's letters do (the median of the last
///   nine): between letters it is short or left out. No space begins or ends the text.
/// - CANCEL takes the last character away, ERROR the last word: the customs of scouts, where the navies' ANNUL takes
///   back what was said before. A space after what is taken away goes with it. ATTENTION writes nothing.
class SemaphoreSpeller {
 public:
  /// @throws Error (usage) by options.validate().
  explicit SemaphoreSpeller(const SemaphoreOptions& options = {});

  /// Signs in the order of their ends, as SemaphoreReader gives them.
  void add(const HeldSign& sign);

  [[nodiscard]] const std::string& text() const { return text_; }

  /// Forgets the beginning of the text, so that memory does not grow with it. What comes is written as ever; no sign
  /// takes away what was forgotten.
  /// @param most  characters of its end that stay; a space does not begin it.
  void keep_end(std::size_t most);

  /// The text if `held` ended now: what a live view shows.
  /// @param most  characters of its end that are wanted.
  /// @cost O(most), however long the text is; with ERROR, that and the word that it takes away.
  [[nodiscard]] std::string text_with(const std::optional<HeldSign>& held, std::size_t most = std::string::npos) const;

 private:
  void write(char c);

  // All that bears on the next sign but the text.
  struct State {
    double word_gap;
    std::deque<double> letter_seconds;  // of the last signs
    bool space = false;                 // before the next character
    bool numerals = false;              // letters stand for digits now
  };
  State state_;
  std::string text_;
};

}  // namespace choreo::recognition
