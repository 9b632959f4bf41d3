// SPDX-License-Identifier: Apache-2.0
#include "devices/image_folder/numbered_names.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo::devices {
namespace {

// "take3_0012.png": the pattern "take#_#" and the numbers "3" and "12".
struct TakenApart {
  std::string name;
  std::string pattern;
  std::vector<std::string> numbers;
};

bool is_digit(char c) { return c >= '0' && c <= '9'; }

TakenApart take_apart(const std::string& name) {
  TakenApart out;
  out.name = name;
  const auto body = std::string_view(name).substr(0, name.rfind('.'));
  for (std::size_t i = 0; i < body.size();) {
    if (!is_digit(body[i])) {
      out.pattern += body[i++];
      continue;
    }
    std::string digits;
    for (; i < body.size() && is_digit(body[i]); ++i) {
      if (digits == "0") digits.clear();  // Leading zeros say nothing.
      digits += body[i];
    }
    out.pattern += '#';
    out.numbers.push_back(std::move(digits));
  }
  return out;
}

// Without leading zeros the longer number is the larger one, however many digits it has.
bool is_less(const std::string& a, const std::string& b) { return a.size() != b.size() ? a.size() < b.size() : a < b; }

Error ambiguous(std::string_view folder, const std::set<std::string>& stems) {
  constexpr std::size_t kMostNamed = 4;
  std::vector<std::string> named;
  for (const auto& stem : stems) {
    if (named.size() == kMostNamed) {
      named.push_back("...");
      break;
    }
    named.push_back("\"" + stem + "\"");
  }
  if (std::all_of(stems.begin(), stems.end(), [](const auto& stem) { return stem.find('#') == std::string::npos; })) {
    return usage_error(fmt::format("the names of the pictures in \"{}\" hold no numbers: {}", folder, join(named)), {},
                       "number the frames of a video in the order of time");
  }
  return usage_error(fmt::format("\"{}\" holds several numbered series: {}", folder, join(named)), {},
                     "put each series into a folder of its own");
}

// The name's pattern with all numbers written out but the last.
std::string stem_of(const TakenApart& name) {
  std::string out;
  std::size_t number = 0;
  for (const char c : name.pattern) {
    if (c == '#' && number < name.numbers.size() && ++number < name.numbers.size()) {
      out += name.numbers[number - 1];
    } else {
      out += c;
    }
  }
  return out;
}

// Where in `numbers` the counting number stands.
std::optional<std::size_t> counting_place(const std::vector<TakenApart>& names, std::string_view folder) {
  std::set<std::string> patterns;
  for (const auto& name : names) patterns.insert(name.pattern);
  if (patterns.size() > 1) throw ambiguous(folder, patterns);
  std::optional<std::size_t> place;
  for (std::size_t i = 0; i < names.front().numbers.size(); ++i) {
    const bool changes = std::any_of(names.begin(), names.end(),
                                     [&](const auto& name) { return name.numbers[i] != names.front().numbers[i]; });
    if (!changes) continue;
    if (place) {
      std::set<std::string> stems;
      for (const auto& name : names) stems.insert(stem_of(name));
      throw ambiguous(folder, stems);
    }
    place = i;
  }
  return place;
}

}  // namespace

bool is_picture_name(std::string_view name) {
  static constexpr std::array<std::string_view, 9> kEndings = {"png",  "jpg",  "jpeg", "bmp", "tif",
                                                               "tiff", "webp", "pgm",  "ppm"};
  const auto dot = name.rfind('.');
  if (name.starts_with('.') || dot == std::string_view::npos) return false;
  std::string ending(name.substr(dot + 1));
  for (auto& c : ending) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

std::vector<std::string> in_number_order(const std::vector<std::string>& names, std::string_view folder) {
  if (names.empty()) return {};
  std::vector<TakenApart> parts;
  parts.reserve(names.size());
  for (const auto& name : names) parts.push_back(take_apart(name));
  const auto place = counting_place(parts, folder);
  const auto comes_before = [&](const TakenApart& a, const TakenApart& b) {
    return place && is_less(a.numbers[*place], b.numbers[*place]);
  };
  std::sort(parts.begin(), parts.end(), comes_before);
  const auto twins =
      std::adjacent_find(parts.begin(), parts.end(), [&](const auto& a, const auto& b) { return !comes_before(a, b); });
  if (twins != parts.end()) {
    const auto& [first, second] = std::minmax(twins->name, std::next(twins)->name);
    throw usage_error(fmt::format("\"{}\": \"{}\" and \"{}\" have the same number", folder, first, second), {},
                      "keep one of them");
  }
  std::vector<std::string> out;
  out.reserve(parts.size());
  for (auto& part : parts) out.push_back(std::move(part.name));
  return out;
}

std::vector<std::string> in_name_order(std::vector<std::string> names) {
  struct Key {
    std::string text;  // Small letters, numbers as their length and digits, so that 9 comes before 10.
    std::string name;
  };
  std::vector<Key> keys;
  keys.reserve(names.size());
  for (auto& name : names) {
    std::string text;
    for (std::size_t i = 0; i < name.size();) {
      if (!is_digit(name[i])) {
        const char c = name[i++];
        text += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
        continue;
      }
      std::string digits;
      for (; i < name.size() && is_digit(name[i]); ++i) {
        if (digits == "0") digits.clear();
        digits += name[i];
      }
      text += '0';                               // Numbers stand where digits stand in the alphabet.
      text += static_cast<char>(digits.size());  // A file's name has at most 255 bytes.
      text += digits;
    }
    keys.push_back({std::move(text), std::move(name)});
  }
  std::sort(keys.begin(), keys.end(),
            [](const Key& a, const Key& b) { return a.text != b.text ? a.text < b.text : a.name < b.name; });
  std::vector<std::string> out;
  out.reserve(keys.size());
  for (auto& key : keys) out.push_back(std::move(key.name));
  return out;
}

}  // namespace choreo::devices
