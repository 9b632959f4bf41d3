// SPDX-License-Identifier: Apache-2.0
#include "devices/kinect_dump/dump_index.hpp"

#include <algorithm>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo::devices::kinect_dump {
namespace {

constexpr std::string_view kHowItLooks =
    "a line is T-SECONDS-TICKS.EXTENSION with T one of r, d and a, such as r-1290450193.124921-3431872.ppm, and ends "
    "in a line feed alone";
constexpr std::uint64_t kMostSeconds = 4'000'000'000;  // The year 2096.
constexpr Nanoseconds kLongest = std::chrono::hours(24);

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Takes decimal digits off the front. Nothing where there are none, or too many for `most`.
std::optional<std::uint64_t> take_number(std::string_view& text, std::uint64_t most) {
  std::uint64_t value = 0;
  std::size_t digits = 0;
  for (; digits < text.size() && is_digit(text[digits]); ++digits) {
    value = value * 10 + static_cast<std::uint64_t>(text[digits] - '0');
    if (value > most) return std::nullopt;
  }
  if (digits == 0) return std::nullopt;
  text.remove_prefix(digits);
  return value;
}

bool take(std::string_view& text, char c) {
  if (!text.starts_with(c)) return false;
  text.remove_prefix(1);
  return true;
}

struct Line {
  char kind = 0;
  Picture picture;
};

std::optional<Line> parse_line(std::string_view line) {
  Line out;
  out.picture.name = std::string(line);
  if (line.empty() || (line[0] != 'r' && line[0] != 'd' && line[0] != 'a')) return std::nullopt;
  out.kind = line[0];
  line.remove_prefix(1);
  if (!take(line, '-')) return std::nullopt;
  const auto seconds = take_number(line, kMostSeconds);
  if (!seconds || !take(line, '.')) return std::nullopt;
  const auto before = line.size();
  auto fraction = take_number(line, 999'999'999);
  const auto digits = before - line.size();
  if (!fraction || digits > 9) return std::nullopt;
  for (auto k = digits; k < 9; ++k) *fraction *= 10;
  if (!take(line, '-')) return std::nullopt;
  const auto ticks = take_number(line, std::numeric_limits<std::uint32_t>::max());
  if (!ticks || !take(line, '.')) return std::nullopt;
  constexpr std::size_t kLongestExtension = 8;
  if (line.empty() || line.size() > kLongestExtension ||
      !std::all_of(line.begin(), line.end(), [](char c) { return is_digit(c) || (c >= 'a' && c <= 'z'); })) {
    return std::nullopt;
  }
  out.picture.time = std::chrono::seconds(*seconds) + Nanoseconds(*fraction);
  out.picture.ticks = static_cast<std::uint32_t>(*ticks);
  return out;
}

// The place in `all` whose time is nearest to `time`, looking from `from` on.
std::size_t nearest(const std::vector<Picture>& all, Nanoseconds time, std::size_t from) {
  while (from + 1 < all.size() &&
         std::chrono::abs(all[from + 1].time - time) < std::chrono::abs(all[from].time - time)) {
    ++from;
  }
  return from;
}

}  // namespace

Index parse_index(std::string_view text, const std::string& where) {
  Index index;
  std::size_t number = 0;
  std::optional<Nanoseconds> first;
  while (!text.empty()) {
    ++number;
    const auto end = text.find('\n');
    if (end == std::string_view::npos) {
      index.cut_off = true;
      break;
    }
    const auto line = text.substr(0, end);
    text.remove_prefix(end + 1);
    auto parsed = parse_line(line);
    if (!parsed) {
      throw usage_error(fmt::format("\"{}\" is no picture of a Kinect's dump", shortened(one_line(line))),
                        fmt::format("{}:{}", where, number), std::string(kHowItLooks));
    }
    if (parsed->kind == 'a') continue;
    auto& stream = parsed->kind == 'r' ? index.colour : index.depth;
    if (!first) first = parsed->picture.time;
    if (std::chrono::abs(parsed->picture.time - *first) > kLongest) {
      throw usage_error(fmt::format("\"{}\" is more than a day away from the first picture", parsed->picture.name),
                        fmt::format("{}:{}", where, number), "times are in seconds; put each dump into its own folder");
    }
    if (!stream.empty() && parsed->picture.time <= stream.back().time) {
      ++index.late;
    } else {
      stream.push_back(std::move(parsed->picture));
    }
  }
  return index;
}

bool looks_like_index(std::string_view beginning) {
  const auto end = beginning.find('\n');
  return end != std::string_view::npos && parse_line(beginning.substr(0, end)).has_value();
}

std::vector<std::pair<std::size_t, std::size_t>> pairs_by_time(const Index& index) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  if (index.depth.empty()) return pairs;
  std::size_t depth = 0;
  std::size_t back = 0;
  for (std::size_t colour = 0; colour < index.colour.size(); ++colour) {
    const auto time = index.colour[colour].time;
    depth = nearest(index.depth, time, depth);
    if (std::chrono::abs(index.depth[depth].time - time) > kPairWithin) continue;
    back = nearest(index.colour, index.depth[depth].time, back);
    if (back == colour) pairs.emplace_back(colour, depth);
  }
  return pairs;
}

}  // namespace choreo::devices::kinect_dump
