// SPDX-License-Identifier: Apache-2.0
// What every parser of text and bytes that others write promises for any bytes whatever; the fuzzers and the corpus run
// these.
//
// Nothing but choreo::Error comes out, its message is one line, and what is accepted keeps its promises. A broken
// promise is a std::logic_error.
#pragma once

#include <ostream>
#include <string>
#include <string_view>
#include <vector>

namespace choreo::fuzz {

/// As a TOML file and as a --set: what is accepted is in range, and what `show` prints reads back the same.
void config(std::string_view text);

/// As a SOURCE: its parts, its settings, and what the synthetic performer makes of it.
void source_uri(std::string_view text);

/// As a span, a duration and a background.
void texts(std::string_view text);

/// As the INDEX.txt of a Kinect's dump: names stay in their folder, times increase, pairs belong together.
void kinect_index(std::string_view text);
/// As the stamp of a take's block, as its marks, and as its tags, one NAME=TEXT a line.
void take(std::string_view text);
/// As what OpenNI2's helper says: what is accepted is written again as the same bytes.
void openni2_message(std::string_view bytes);

/// As a TensorFlow Lite file: what is accepted can be computed in its order.
void tflite(std::string_view bytes);
/// As a tones file: what is accepted is printed and reads back the same.
void tones(std::string_view text);
/// As a CSV of labelled colours; a first line that begins with "!" says what the columns are.
void colours(std::string_view text);

struct Entry {
  std::string name;  ///< Also of its folder below tests/corpus.
  void (*run)(std::string_view);

  friend void PrintTo(const Entry& entry, std::ostream* out) { *out << entry.name; }
};

[[nodiscard]] inline std::vector<Entry> entries() {
  return {{"colours", colours},
          {"config", config},
          {"kinect_index", kinect_index},
          {"openni2_message", openni2_message},
          {"source_uri", source_uri},
          {"take", take},
          {"texts", texts},
          {"tflite", tflite},
          {"tones", tones}};
}

}  // namespace choreo::fuzz
