// SPDX-License-Identifier: Apache-2.0
#include "devices/media/picture_check.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

namespace choreo::devices {
namespace {

using Bytes = std::span<const std::uint8_t>;

bool begins_with(Bytes file, std::string_view text, std::size_t at = 0) {
  if (file.size() < at + text.size()) return false;
  return std::equal(text.begin(), text.end(), file.begin() + static_cast<std::ptrdiff_t>(at),
                    [](char c, std::uint8_t b) { return static_cast<std::uint8_t>(c) == b; });
}

std::uint32_t big_endian(Bytes file, std::size_t at, int bytes) {
  std::uint32_t value = 0;
  for (int i = 0; i < bytes; ++i) value = value << 8 | file[at + static_cast<std::size_t>(i)];
  return value;
}

std::uint32_t little_endian(Bytes file, std::size_t at, int bytes) {
  std::uint32_t value = 0;
  for (int i = bytes; i-- > 0;) value = value << 8 | file[at + static_cast<std::size_t>(i)];
  return value;
}

// The checksum of PNG (polynomial 0x04C11DB7, bits reflected).
std::uint32_t crc32(Bytes bytes) {
  static const auto kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t c = i;
      for (int bit = 0; bit < 8; ++bit) c = (c & 1) != 0 ? 0xEDB88320u ^ (c >> 1) : c >> 1;
      table[i] = c;
    }
    return table;
  }();
  std::uint32_t crc = 0xFFFFFFFFu;
  for (const auto b : bytes) crc = kTable[(crc ^ b) & 0xFF] ^ (crc >> 8);
  return ~crc;
}

bool is_whole_png(Bytes file) {
  for (std::size_t at = 8; file.size() - at >= 12;) {
    const std::size_t length = big_endian(file, at, 4);
    if (length > file.size() - at - 12) return false;
    if (crc32(file.subspan(at + 4, 4 + length)) != big_endian(file, at + 8 + length, 4)) return false;
    if (begins_with(file, "IEND", at + 4)) return true;
    at += 12 + length;
  }
  return false;
}

bool is_whole_jpeg(Bytes file) {
  std::size_t at = 2;
  while (at + 1 < file.size()) {
    // Between segments stands a marker; inside compressed data anything up to the next one.
    const auto marker = file[at + 1];
    if (file[at] != 0xFF || marker == 0xFF || marker == 0x00) {
      ++at;
      continue;
    }
    at += 2;
    if (marker == 0xD9) return true;                                     // End of image.
    if ((marker >= 0xD0 && marker <= 0xD8) || marker == 0x01) continue;  // These stand alone.
    if (at + 2 > file.size()) return false;
    at += std::max<std::size_t>(big_endian(file, at, 2), 2);
  }
  return false;
}

bool is_whole_bmp(Bytes file) {
  if (file.size() < 54) return false;
  constexpr std::uint32_t kPlain = 0;
  constexpr std::uint32_t kMasks = 3;
  const auto compression = little_endian(file, 30, 4);
  if (little_endian(file, 14, 4) < 40 || (compression != kPlain && compression != kMasks)) return true;
  const std::uint64_t offset = little_endian(file, 10, 4);
  const std::uint64_t width = little_endian(file, 18, 4);
  const auto height = static_cast<std::int32_t>(little_endian(file, 22, 4));  // Negative: top to bottom.
  const std::uint64_t rows = static_cast<std::uint64_t>(height < 0 ? -std::int64_t{height} : std::int64_t{height});
  const std::uint64_t row_bytes = (width * little_endian(file, 28, 2) + 31) / 32 * 4;
  return offset <= file.size() && (rows == 0 || row_bytes <= (file.size() - offset) / rows);
}

// P5 and P6: width, height and largest value in digits, one white space, then the numbers.
bool is_whole_pnm(Bytes file) {
  std::array<std::uint64_t, 3> header{};
  std::size_t at = 2;
  for (auto& value : header) {
    const auto is_space = [&] { return file[at] == ' ' || (file[at] >= '\t' && file[at] <= '\r'); };
    for (; at < file.size() && (is_space() || file[at] == '#'); ++at) {
      if (file[at] == '#') {
        while (at + 1 < file.size() && file[at] != '\n') ++at;
      }
    }
    for (; at < file.size() && file[at] >= '0' && file[at] <= '9'; ++at) {
      value = value * 10 + (file[at] - '0');
      if (value > 1'000'000) return false;
    }
  }
  ++at;
  const std::uint64_t bytes = header[0] * header[1] * (file[1] == '6' ? 3 : 1) * (header[2] > 255 ? 2 : 1);
  return at <= file.size() && bytes <= file.size() - at;
}

}  // namespace

bool is_whole_picture(Bytes file) {
  if (begins_with(file, "\x89PNG\r\n\x1a\n")) return is_whole_png(file);
  if (begins_with(file, "\xff\xd8")) return is_whole_jpeg(file);
  if (begins_with(file, "BM")) return is_whole_bmp(file);
  if (begins_with(file, "P5") || begins_with(file, "P6")) return is_whole_pnm(file);
  if (begins_with(file, "RIFF") && begins_with(file, "WEBP", 8)) {
    return little_endian(file, 4, 4) <= file.size() - 8;
  }
  return !file.empty();
}

}  // namespace choreo::devices
