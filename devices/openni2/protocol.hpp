// SPDX-License-Identifier: Apache-2.0
// What choreoscope and its helper for OpenNI2 say to each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace choreo::devices::openni2 {

/// Both sides are built together; a helper of another build is refused.
inline constexpr std::uint32_t kVersion = 1;
/// Pixels lie in shared memory of `kSlots` places; the helper fills a free one, names it, and has it back by `Release`.
inline constexpr std::uint32_t kSlots = 16;
inline constexpr std::size_t kSlotBytes = std::size_t{16} << 20U;
inline constexpr int kMostSide = 4096;
/// Of a whole message. One datagram of a SOCK_SEQPACKET socket is one message.
inline constexpr std::size_t kMostMessage = 8192;
/// File descriptors of the helper: what it inherits.
inline constexpr int kSocketDescriptor = 0, kMemoryDescriptor = 3, kRecordingDescriptor = 4;

/// The numbers are OpenNI2's.
enum class Sensor : std::uint32_t { kInfrared = 1, kColour = 2, kDepth = 3 };

/// A mode, or a stream in it.
struct Mode {
  Sensor sensor = Sensor::kColour;
  std::uint32_t fourcc = 0;  ///< RGB3, YUYV, UYVY, GREY or MJPG; Z16 for depth in millimetres.
  std::uint32_t width = 0, height = 0;
  std::uint32_t fps = 0;  ///< Hz, 0 where unknown.
  bool operator==(const Mode&) const = default;
};

/// Bytes of a picture with lines without padding; 0 where packets differ (MJPG) or the format is unknown.
[[nodiscard]] std::size_t picture_bytes(std::uint32_t fourcc, std::uint32_t width, std::uint32_t height);

enum class Action : std::uint32_t { kList, kDevice, kRecording };
enum class Video : std::uint32_t { kAny, kColour, kInfrared, kNone };

/// To the helper, first and once: what to do.
struct Request {
  Action action = Action::kList;
  Video video = Video::kAny;                     ///< kAny is colour, else infrared, else none.
  bool depth = true;                             ///< Wanted where there is one.
  bool registered = true;                        ///< Depth brought onto colour where the device can.
  std::uint32_t width = 0, height = 0, fps = 0;  ///< 0 is open.
  std::string location;                          ///< A device's URI or serial number; empty is any.
  /// Of the device that was there before, whose URI changes with the port: taken where `location` is not there.
  std::uint32_t usb_vendor = 0, usb_product = 0;
  bool operator==(const Request&) const = default;
};

/// To the helper: a place is free again.
struct Release {
  std::uint32_t slot = 0;
  bool operator==(const Release&) const = default;
};

/// From the helper, first and once, before it touches the library.
struct Hello {
  bool operator==(const Hello&) const = default;
};

/// A device that is plugged in; its modes follow.
struct DeviceFound {
  std::string uri, vendor, name, serial;
  std::string trouble;  ///< Why it cannot be opened; empty where it can.
  std::uint32_t usb_vendor = 0, usb_product = 0;
  bool operator==(const DeviceFound&) const = default;
};

struct ModeFound {
  Mode mode;
  bool operator==(const ModeFound&) const = default;
};

/// What was asked for is open, and pictures follow.
struct Opened {
  DeviceFound device;         ///< Empty for a recording.
  std::vector<Mode> streams;  ///< One or two: depth, and colour or infrared.
  std::uint32_t frames = 0;   ///< Of the first stream, as the recording declares; 0 where unknown.
  bool operator==(const Opened&) const = default;
};

/// A picture lies in a slot.
struct Picture {
  Mode mode;
  std::uint32_t slot = 0;
  std::uint32_t bytes = 0;
  std::uint32_t index = 0;    ///< The device's own count.
  std::uint64_t time_us = 0;  ///< The device's own clock.
  bool operator==(const Picture&) const = default;
};

struct Warning {
  std::string text;
  bool operator==(const Warning&) const = default;
};

enum class TroubleKind : std::uint32_t {
  kLost,       ///< The device is not there, or went away.
  kRefused,    ///< It can never give what was asked for.
  kDamaged,    ///< The recording cannot be opened.
  kNoDrivers,  ///< The library has no drivers: nothing can be opened.
};

/// Nothing more will come.
struct Trouble {
  TroubleKind kind = TroubleKind::kLost;
  std::string text, hint;
  bool operator==(const Trouble&) const = default;
};

/// The list, or the recording, is at its end.
struct End {
  bool operator==(const End&) const = default;
};

using Message = std::variant<Request, Release, Hello, DeviceFound, ModeFound, Opened, Picture, Warning, Trouble, End>;

/// The other side sent what it never sends.
class BadMessage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// @return at most `kMostMessage` bytes. Texts are cut where they are too long to fit.
[[nodiscard]] std::vector<std::uint8_t> encode(const Message& message);

/// Takes a message apart and trusts nothing: numbers in range, sizes that fit a slot, sensors with formats that they
/// can have, no byte too many. What it returns, `encode` turns into the same bytes.
/// @throws BadMessage
[[nodiscard]] Message decode(std::span<const std::uint8_t> bytes);

}  // namespace choreo::devices::openni2
