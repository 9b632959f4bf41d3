// SPDX-License-Identifier: Apache-2.0
// What a take says beside its pictures: the tags of the file, the stamp of every block, the marks of a run.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <opencv2/core/types.hpp>

#include "core/time.hpp"
#include "devices/orientation.hpp"

namespace choreo::devices::take {

/// The first tag of the file, by which a take is told from other Matroska files, and the format's version.
inline constexpr const char* kTakeTag = "CHOREOSCOPE_TAKE";
inline constexpr const char* kTakeVersion = "1";

enum class Part { kColour, kDepth };
[[nodiscard]] std::string_view name_of(Part part);  ///< "colour", "depth"

/// What goes with every picture into its block's additional data. Matroska's own clock is 1 ms.
struct Stamp {
  /// Bits of `parts`.
  static constexpr std::uint32_t kColour = 1;
  static constexpr std::uint32_t kDepth = 2;

  std::uint32_t parts = 0;     ///< Which pictures the frame has, in blocks of the same sequence number.
  std::uint32_t checksum = 0;  ///< See `checksum`.
  Nanoseconds time{0};         ///< Frame::device_time
  std::uint64_t sequence = 0;  ///< Frame::sequence

  [[nodiscard]] bool operator==(const Stamp&) const = default;
};

/// All numbers with the low byte first: "CHT1", parts (4), checksum (4), time (8), sequence (8).
inline constexpr std::size_t kStampBytes = 28;
[[nodiscard]] std::array<std::uint8_t, kStampBytes> bytes_of(const Stamp& stamp);
/// Nothing where these are not the bytes of a stamp.
[[nodiscard]] std::optional<Stamp> stamp_of(std::span<const std::uint8_t> bytes);
/// CRC-32, as of zlib and PNG, of the stamp's bytes with a checksum of 0 and the packet behind them.
[[nodiscard]] std::uint32_t checksum(Stamp stamp, std::span<const std::uint8_t> packet);

/// What a run had to say of a frame: one line of the track of marks, `KIND SEQUENCE TEXT`.
struct Mark {
  std::string kind;  ///< A word: "processed" for a frame that the run brought to its end.
  std::uint64_t sequence = 0;
  std::string text;  ///< May be empty.

  [[nodiscard]] bool operator==(const Mark&) const = default;
};
inline constexpr const char* kProcessedMark = "processed";
// Frame::late_face and Frame::late_person; they come before the frame's kProcessedMark.
inline constexpr const char* kLateFaceMark = "late-face";
inline constexpr const char* kLatePersonMark = "late-person";
[[nodiscard]] std::string line_of(const Mark& mark);
[[nodiscard]] std::vector<Mark> marks_of(std::string_view lines);  ///< Lines that are none are left out.

using Tags = std::vector<std::pair<std::string, std::string>>;
/// The tag's text; nothing where it is missing.
using FindTag = std::function<std::optional<std::string>(const char* name)>;

/// Of the whole file.
struct FileFacts {
  std::string source;      ///< As the user wrote it.
  std::string program;     ///< "choreoscope 0.1.0"
  std::string controls;    ///< SourceInfo::controls
  std::string settings;    ///< Of the run that recorded it, as TOML; empty where none did.
  double nominal_fps = 0;  ///< 0 to 1000, exact.
  bool foreseeable = true;
};
[[nodiscard]] Tags tags_of(const FileFacts& facts);
/// Nothing where the file is no take of this version.
[[nodiscard]] std::optional<FileFacts> file_facts(const FindTag& find);

/// Of one track of pictures.
struct StreamFacts {
  Part part = Part::kColour;
  std::uint32_t fourcc = 0;  ///< What a picture is once it is decoded and its planes are put together again.
  bool raw = false;          ///< It is what the device gave (Frame::raw_colour), not what was made of it (Frame::bgr).
  cv::Size size;             ///< Before `orientation`.
  Orientation orientation;   ///< What makes it upright.
  bool registered = false;   ///< Of kKinectDepth: millimetres are then brought onto the colour (kinect_registered).
  std::string codec;         ///< As it was taken: "ffv1", "ffvhuff", "mjpeg".

  [[nodiscard]] cv::Size upright() const {
    return orientation.swaps_sides() ? cv::Size(size.height, size.width) : size;
  }
};
[[nodiscard]] Tags tags_of(const StreamFacts& facts);
/// Nothing where a tag is missing or makes no sense; sides are 1 to 16384 pixels.
[[nodiscard]] std::optional<StreamFacts> stream_facts(const FindTag& find);

}  // namespace choreo::devices::take
