// SPDX-License-Identifier: Apache-2.0
// letters.json: the signs that were read, of a recording or of a set of pictures.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace choreo::outputs {

/// A sign that was held.
struct ReadLetter {
  std::string letter;     ///< "A" to "Z", "REST", "NUMERALS", "CANCEL", "ATTENTION", "ERROR".
  double from = 0;        ///< Seconds since the source's first frame,
  double to = 0;          ///< and when it ended.
  double confidence = 0;  ///< 0 to 1.
};

/// What one picture shows.
struct ReadPicture {
  std::string file;                   ///< Its name in the folder.
  std::optional<std::string> letter;  ///< Nothing where it shows none.
  double confidence = 0;              ///< That the answer is right, be it a letter or none, 0 to 1.
  std::string runner_up;              ///< Empty where there is none.
};

/// {"letters": [{"letter", "from", "to", "confidence"}, ...], "text"}, indented, keys in this order; times to a
/// millisecond.
[[nodiscard]] std::string letters_json(std::span<const ReadLetter> letters, std::string_view text);

/// {"pictures": [{"file", "letter", "confidence", "runner_up"}, ...]}, likewise; `letter` and `runner_up` are null
/// where there is none. A file's name that is not UTF-8 has its broken bytes replaced.
[[nodiscard]] std::string pictures_json(std::span<const ReadPicture> pictures);

}  // namespace choreo::outputs
