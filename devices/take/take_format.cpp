// SPDX-License-Identifier: Apache-2.0
#include "devices/take/take_format.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

extern "C" {
#include <libavutil/crc.h>
}

#include "core/text.hpp"
#include "devices/fourcc.hpp"
#include "devices/media/kinect_depth.hpp"

namespace choreo::devices::take {
namespace {

constexpr std::array<std::uint8_t, 4> kMagic = {'C', 'H', 'T', '1'};

constexpr const char* kSource = "CHOREOSCOPE_SOURCE";
constexpr const char* kProgram = "CHOREOSCOPE_PROGRAM";
constexpr const char* kControls = "CHOREOSCOPE_CONTROLS";
constexpr const char* kSettings = "CHOREOSCOPE_SETTINGS";
constexpr const char* kFps = "CHOREOSCOPE_FPS";
constexpr const char* kForeseeable = "CHOREOSCOPE_FORESEEABLE";
constexpr const char* kPart = "CHOREOSCOPE_PART";
constexpr const char* kFormat = "CHOREOSCOPE_FORMAT";
constexpr const char* kRaw = "CHOREOSCOPE_RAW";
constexpr const char* kSize = "CHOREOSCOPE_SIZE";
constexpr const char* kTurns = "CHOREOSCOPE_QUARTER_TURNS";
constexpr const char* kFlip = "CHOREOSCOPE_FLIP";
constexpr const char* kRegistered = "CHOREOSCOPE_REGISTERED";
constexpr const char* kCodec = "CHOREOSCOPE_CODEC";

template <typename Number>
void put(std::uint8_t*& to, Number number) {
  for (std::size_t k = 0; k < sizeof number; ++k) *to++ = static_cast<std::uint8_t>(number >> (8 * k));
}

template <typename Number>
Number take(const std::uint8_t*& from) {
  Number number = 0;
  for (std::size_t k = 0; k < sizeof number; ++k) number |= static_cast<Number>(*from++) << (8 * k);
  return number;
}

const char* word(bool yes) { return yes ? "yes" : "no"; }

std::optional<bool> flag_of(const std::optional<std::string>& text) {
  if (text == "yes") return true;
  if (text == "no") return false;
  return std::nullopt;
}

std::optional<int> number_of(const std::optional<std::string>& text, int least, int most) {
  const auto number = text ? parse_integer(*text) : std::nullopt;
  if (!number || *number < least || *number > most) return std::nullopt;
  return static_cast<int>(*number);
}

std::optional<cv::Size> size_of(const std::optional<std::string>& text) {
  const auto cross = text ? text->find('x') : std::string::npos;
  if (cross == std::string::npos) return std::nullopt;
  constexpr int kMost = 16384;
  const auto width = number_of(text->substr(0, cross), 1, kMost);
  const auto height = number_of(text->substr(cross + 1), 1, kMost);
  return width && height ? std::optional(cv::Size(*width, *height)) : std::nullopt;
}

bool is_word(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c > 0x20 && c < 0x7f; });
}

}  // namespace

std::string_view name_of(Part part) { return part == Part::kColour ? "colour" : "depth"; }

std::array<std::uint8_t, kStampBytes> bytes_of(const Stamp& stamp) {
  std::array<std::uint8_t, kStampBytes> bytes{};
  auto* to = std::copy(kMagic.begin(), kMagic.end(), bytes.data());
  put(to, stamp.parts);
  put(to, stamp.checksum);
  put(to, static_cast<std::uint64_t>(stamp.time.count()));
  put(to, stamp.sequence);
  return bytes;
}

std::optional<Stamp> stamp_of(std::span<const std::uint8_t> bytes) {
  // Later versions may be longer.
  if (bytes.size() < kStampBytes || !std::equal(kMagic.begin(), kMagic.end(), bytes.begin())) return std::nullopt;
  const auto* from = bytes.data() + kMagic.size();
  Stamp stamp;
  stamp.parts = take<std::uint32_t>(from);
  stamp.checksum = take<std::uint32_t>(from);
  stamp.time = Nanoseconds(static_cast<std::int64_t>(take<std::uint64_t>(from)));
  stamp.sequence = take<std::uint64_t>(from);
  return stamp;
}

std::uint32_t checksum(Stamp stamp, std::span<const std::uint8_t> packet) {
  stamp.checksum = 0;
  const auto bytes = bytes_of(stamp);
  const auto* table = av_crc_get_table(AV_CRC_32_IEEE_LE);
  return ~av_crc(table, av_crc(table, ~std::uint32_t{0}, bytes.data(), bytes.size()), packet.data(), packet.size());
}

std::string line_of(const Mark& mark) {
  return fmt::format("{} {}{}{}\n", mark.kind, mark.sequence, mark.text.empty() ? "" : " ", one_line(mark.text));
}

std::vector<Mark> marks_of(std::string_view lines) {
  std::vector<Mark> marks;
  while (!lines.empty()) {
    const auto line = lines.substr(0, lines.find('\n'));
    lines.remove_prefix(std::min(lines.size(), line.size() + 1));
    const auto first = line.find(' ');
    if (first == std::string_view::npos) continue;
    const auto second = line.find(' ', first + 1);
    const auto number = parse_integer(line.substr(first + 1, second - std::min(second, first + 1)));
    if (!number || *number < 0 || !is_word(line.substr(0, first))) continue;
    marks.push_back({std::string(line.substr(0, first)), static_cast<std::uint64_t>(*number),
                     second == std::string_view::npos ? "" : std::string(line.substr(second + 1))});
  }
  return marks;
}

Tags tags_of(const FileFacts& facts) {
  Tags tags = {{kTakeTag, kTakeVersion},
               {kFps, fmt::format("{}", facts.nominal_fps)},  // The shortest text that reads back the same.
               {kForeseeable, word(facts.foreseeable)},
               {kProgram, one_line(facts.program)},
               {kSource, one_line(facts.source)}};
  if (!facts.controls.empty()) tags.emplace_back(kControls, one_line(facts.controls));
  if (!facts.settings.empty()) tags.emplace_back(kSettings, facts.settings);
  return tags;
}

std::optional<FileFacts> file_facts(const FindTag& find) {
  if (find(kTakeTag) != kTakeVersion) return std::nullopt;
  const double fps = parse_number(find(kFps).value_or("")).value_or(-1);
  const auto foreseeable = flag_of(find(kForeseeable));
  if (!(fps >= 0 && fps <= 1000) || !foreseeable) return std::nullopt;
  return FileFacts{find(kSource).value_or(""),
                   find(kProgram).value_or(""),
                   find(kControls).value_or(""),
                   find(kSettings).value_or(""),
                   fps,
                   *foreseeable};
}

Tags tags_of(const StreamFacts& facts) {
  const auto& o = facts.orientation;
  return {{kPart, std::string(name_of(facts.part))},
          {kFormat, name_of_fourcc(facts.fourcc)},
          {kRaw, word(facts.raw)},
          {kSize, fmt::format("{}x{}", facts.size.width, facts.size.height)},
          {kTurns, std::to_string((o.quarter_turns + (o.flip_vertical ? 2 : 0)) % 4)},
          {kFlip, word(o.flip_horizontal != o.flip_vertical)},
          {kRegistered, word(facts.registered)},
          {kCodec, facts.codec}};
}

std::optional<StreamFacts> stream_facts(const FindTag& find) {
  static constexpr std::array kColours = {kBgr3, kRgb3, kYuyv, kUyvy, kYvyu, kNv12, kMjpg, kGrey};
  static constexpr std::array kDepths = {kZ16, kKinectDepth};
  StreamFacts facts;
  const auto part = find(kPart);
  if (part != name_of(Part::kColour) && part != name_of(Part::kDepth)) return std::nullopt;
  facts.part = part == name_of(Part::kColour) ? Part::kColour : Part::kDepth;
  const auto look = [&](const auto& known) {
    const auto name = find(kFormat);
    for (const auto code : known) {
      if (name == name_of_fourcc(code)) facts.fourcc = code;
    }
  };
  if (facts.part == Part::kColour) {
    look(kColours);
  } else {
    look(kDepths);
  }
  const auto raw = flag_of(find(kRaw));
  const auto size = size_of(find(kSize));
  const auto turns = number_of(find(kTurns), 0, 3);
  const auto flip = flag_of(find(kFlip));
  if (facts.fourcc == 0 || !raw || !size || !turns || !flip) return std::nullopt;
  const bool even = facts.fourcc == kYuyv || facts.fourcc == kUyvy || facts.fourcc == kYvyu || facts.fourcc == kNv12;
  if ((even && size->width % 2 != 0) || (facts.fourcc == kNv12 && size->height % 2 != 0)) return std::nullopt;
  facts.raw = *raw;
  facts.size = *size;
  facts.orientation = {*turns, *flip, false};
  if (facts.fourcc == kKinectDepth) {
    const auto registered = flag_of(find(kRegistered));
    if (!registered || (*registered && *size != kKinectSize)) return std::nullopt;
    facts.registered = *registered;
  }
  facts.codec = find(kCodec).value_or("");
  return facts;
}

}  // namespace choreo::devices::take
