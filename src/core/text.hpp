// SPDX-License-Identifier: Apache-2.0
// Small text helpers: numbers that must be whole, the nearest name to a mistyped one.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace choreo {

/// A finite number that is the whole of `text`, independent of the locale; nothing otherwise.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);

/// A decimal integer that is the whole of `text`; nothing otherwise or on overflow.
[[nodiscard]] std::optional<long long> parse_integer(std::string_view text);

/// Edit distance with insertion, deletion, substitution and transposition of neighbours (optimal string alignment).
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidate nearest to `name`, if it is near enough that a person could have meant it; else the first that
/// begins with it (but "mask" is a section of "mask.steps", not its beginning).
[[nodiscard]] std::optional<std::string> nearest_name(std::string_view name, std::span<const std::string> candidates);

/// Bytes from the front of `text` that are one well-formed UTF-8 character; 0 where it begins with none.
[[nodiscard]] std::size_t utf8_length(std::string_view text);

[[nodiscard]] bool is_utf8(std::string_view text);

/// `text` as it can stand in a line for people: control characters and what is not UTF-8 written as \n, \t or \x1b.
[[nodiscard]] std::string one_line(std::string_view text);

/// The beginning of `text`, at most `most` bytes of whole characters, with "..." where there was more.
[[nodiscard]] std::string shortened(std::string_view text, std::size_t most = 60);

/// "1 frame", "2 frames": the plural is with an s.
[[nodiscard]] std::string counted(std::uint64_t count, std::string_view noun);

/// "a, b, c".
[[nodiscard]] std::string join(std::span<const std::string> parts, std::string_view separator = ", ");

/// `did you mean "x"?` where a candidate is near, otherwise `known: a, b, c`.
[[nodiscard]] std::string hint_for_name(std::string_view name, std::span<const std::string> candidates);

}  // namespace choreo
