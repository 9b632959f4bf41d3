// SPDX-License-Identifier: Apache-2.0
#include "config/colour_table.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>

#include <fmt/format.h>

#include "config/text_file.hpp"
#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo::config {
namespace {

constexpr std::uintmax_t kMostTableBytes = 256U << 20;
constexpr std::size_t kMostColumns = 64;
constexpr auto kColumnsHint = "say what the columns are, such as --columns B,G,R,label, with - for others";

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

// The separator of a file is that of its first line.
char separator_of(std::string_view line) {
  for (const char c : {',', ';', '\t'}) {
    if (line.find(c) != std::string_view::npos) return c;
  }
  return ' ';
}

void split(std::string_view line, char separator, std::vector<std::string_view>& out) {
  out.clear();
  while (out.size() <= kMostColumns) {
    const auto end = line.find(separator);
    const auto cell = trimmed(line.substr(0, end));
    if (separator != ' ' || !cell.empty()) out.push_back(cell);
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
  }
}

// 0 to 3: blue, green, red, label; nothing for another column.
std::optional<std::size_t> meaning_of(std::string_view name) {
  std::string lower;
  for (const char c : name) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  constexpr std::array<std::array<std::string_view, 3>, 4> kNames = {
      {{"b", "blue", "blue"}, {"g", "green", "green"}, {"r", "red", "red"}, {"label", "class", "skin"}}};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (std::find(kNames[i].begin(), kNames[i].end(), lower) != kNames[i].end()) return i;
  }
  return std::nullopt;
}

// Which column holds what.
struct Columns {
  std::size_t count = 4;
  std::array<std::size_t, 4> at{0, 1, 2, 3};
};

Columns columns_of(const std::vector<std::string_view>& names, const std::string& where) {
  Columns out;
  out.count = names.size();
  std::array<int, 4> times{};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto meaning = meaning_of(names[i]);
    if (!meaning) continue;
    out.at[*meaning] = i;
    ++times[*meaning];
  }
  constexpr std::array<const char*, 4> kWords = {"blue", "green", "red", "label"};
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (times[i] == 1) continue;
    throw usage_error(fmt::format("{} column is named {}", times[i] == 0 ? "no" : "more than one", kWords[i]), where,
                      kColumnsHint);
  }
  return out;
}

}  // namespace

ColourTable parse_colour_table(std::string_view text, const std::string& name, const std::string& columns) {
  std::vector<std::string_view> cells;
  std::optional<Columns> known;
  if (!columns.empty()) {
    split(columns, ',', cells);
    for (const auto cell : cells) {
      if (cell == "-" || meaning_of(cell)) continue;
      throw usage_error(fmt::format("unknown column \"{}\"", shortened(cell)), "--columns " + shortened(columns),
                        kColumnsHint);
    }
    known = columns_of(cells, "--columns " + shortened(columns));
  }
  ColourTable out;
  char separator = 0;
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = text.find('\n');
    const auto line = trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.empty()) continue;
    const auto where = [&] { return fmt::format("{}:{}", name, number); };
    const bool first = separator == 0;
    if (first) separator = separator_of(line);
    split(line, separator, cells);
    if (first) {
      const bool names =
          std::none_of(cells.begin(), cells.end(), [](auto cell) { return parse_number(cell).has_value(); });
      if (names) {
        if (!known) known = columns_of(cells, where());
        if (cells.size() != known->count) {
          throw usage_error(fmt::format("{} columns instead of {}", cells.size(), known->count), where(), kColumnsHint);
        }
        continue;
      }
      if (!known) known = Columns{};
    }
    if (cells.size() != known->count) {
      throw usage_error(fmt::format("{} columns instead of {}", cells.size(), known->count), where(), kColumnsHint);
    }
    cv::Vec3b bgr;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto cell = cells[known->at[i]];
      const auto value = parse_integer(cell);
      if (!value || *value < 0 || *value > 255) {
        throw usage_error(fmt::format("\"{}\" is no colour's value", shortened(cell)), where(),
                          "whole numbers from 0 to 255 stand here");
      }
      bgr[int(i)] = static_cast<std::uint8_t>(*value);
    }
    const auto cell = cells[known->at[3]];
    const auto label = parse_integer(cell);
    if (!label || *label < -1'000'000 || *label > 1'000'000) {
      throw usage_error(fmt::format("\"{}\" is no label", shortened(cell)), where(),
                        "a whole number stands here, 1 for skin");
    }
    out.bgr.push_back(bgr);
    out.label.push_back(static_cast<int>(*label));
  }
  if (out.bgr.empty()) throw usage_error("holds no colour", name, "one colour a line: blue, green, red, label");
  return out;
}

ColourTable load_colour_table(const std::filesystem::path& path, const std::string& columns) {
  return parse_colour_table(read_text_file(path, kMostTableBytes, "table of colours"), path.string(), columns);
}

}  // namespace choreo::config
