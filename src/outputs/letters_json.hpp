// SPDX-License-Identifier: Apache-2.0
// What was signalled, as letters.json.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "recognition/semaphore_reader.hpp"

namespace choreo::outputs {

/// A sequence of pictures: a line a letter.
///
///     {
///       "letters": [
///         {"letter": "A", "from": 1.733, "to": 4.600, "confidence": 0.998}
///       ],
///       "text": "A"
///     }
///
/// Letters are "A" to "Z" as they were shown (a digit as its letter, what was cancelled too), "NUMERALS", "CANCEL",
/// "ATTENTION" and "ERROR", in the order given; REST is left out. Seconds of the source; confidence 0 to 1.
/// @param since  where letters were forgotten, as a live run's from before its history: a last member "since", in
///   seconds; letters that ended before it, and what they wrote, are missing.
[[nodiscard]] std::string letters_json(std::span<const recognition::HeldSign> signs, std::string_view text,
                                       std::optional<double> since = std::nullopt);

/// One picture of a set.
struct PictureReading {
  std::string file;  ///< Its name.
  recognition::SignReading reading;
};

/// A set of pictures: a line a picture.
///
///     {
///       "pictures": [
///         {"file": "b.jpg", "letter": "B", "confidence": 0.987, "runner_up": "C"},
///         {"file": "wall.jpg", "letter": null, "confidence": 1.000, "runner_up": null}
///       ]
///     }
///
/// The letter may be "NUMERALS" or "CANCEL"; it is null where none is shown, as where both arms hang (REST), and
/// `confidence` is then that there is none (0 where no face or no tone of arms is known: nothing can be told; near 1
/// where others of the scene show where arms would be, and none are there), `runner_up` the letter that came nearest,
/// or null where nothing at all was seen of arms. Bytes of a name that are not UTF-8 are written as U+FFFD.
[[nodiscard]] std::string pictures_json(std::span<const PictureReading> pictures);

}  // namespace choreo::outputs
