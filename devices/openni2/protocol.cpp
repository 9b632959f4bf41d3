// SPDX-License-Identifier: Apache-2.0
#include "devices/openni2/protocol.hpp"

#include <algorithm>
#include <cstring>

#include "devices/fourcc.hpp"

namespace choreo::devices::openni2 {
namespace {

constexpr std::uint32_t kMagic = fourcc("CHO2");
constexpr std::size_t kMostText = 1200;  // Five of them fit a message.

// One list of fields serves both directions: `archive(field)` writes it or reads it.
template <typename Archive>
void fields(Archive& a, Mode& m) {
  a(m.sensor, Sensor::kDepth);
  a(m.fourcc);
  a(m.width);
  a(m.height);
  a(m.fps);
}
template <typename Archive>
void fields(Archive& a, Request& m) {
  a(m.action, Action::kRecording);
  a(m.video, Video::kNone);
  a(m.depth);
  a(m.registered);
  a(m.width);
  a(m.height);
  a(m.fps);
  a(m.location);
  a(m.usb_vendor);
  a(m.usb_product);
}
template <typename Archive>
void fields(Archive& a, Release& m) {
  a(m.slot);
}
template <typename Archive>
void fields(Archive&, Hello&) {}
template <typename Archive>
void fields(Archive& a, DeviceFound& m) {
  a(m.uri);
  a(m.vendor);
  a(m.name);
  a(m.serial);
  a(m.trouble);
  a(m.usb_vendor);
  a(m.usb_product);
}
template <typename Archive>
void fields(Archive& a, ModeFound& m) {
  fields(a, m.mode);
}
template <typename Archive>
void fields(Archive& a, Opened& m) {
  fields(a, m.device);
  a.count(m.streams);
  for (auto& stream : m.streams) fields(a, stream);
  a(m.frames);
}
template <typename Archive>
void fields(Archive& a, Picture& m) {
  fields(a, m.mode);
  a(m.slot);
  a(m.bytes);
  a(m.index);
  a(m.time_us);
}
template <typename Archive>
void fields(Archive& a, Warning& m) {
  a(m.text);
}
template <typename Archive>
void fields(Archive& a, Trouble& m) {
  a(m.kind, TroubleKind::kNoDrivers);
  a(m.text);
  a(m.hint);
}
template <typename Archive>
void fields(Archive&, End&) {}

class Writer {
 public:
  void operator()(std::uint32_t value) { put(&value, sizeof value); }
  void operator()(std::uint64_t value) { put(&value, sizeof value); }
  void operator()(bool value) { (*this)(std::uint32_t{value}); }
  template <typename Enum>
  void operator()(Enum value, Enum /*last*/) {
    (*this)(static_cast<std::uint32_t>(value));
  }
  void operator()(const std::string& text) {
    const auto size = std::min(text.size(), kMostText);
    (*this)(static_cast<std::uint32_t>(size));
    put(text.data(), size);
  }
  void count(const std::vector<Mode>& all) { (*this)(static_cast<std::uint32_t>(all.size())); }

  std::vector<std::uint8_t> bytes;

 private:
  void put(const void* from, std::size_t size) {
    const auto* first = static_cast<const std::uint8_t*>(from);
    bytes.insert(bytes.end(), first, first + size);
  }
};

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : left_(bytes) {}

  void operator()(std::uint32_t& value) { take(&value, sizeof value); }
  void operator()(std::uint64_t& value) { take(&value, sizeof value); }
  void operator()(bool& value) { value = number_up_to(1) == 1; }
  template <typename Enum>
  void operator()(Enum& value, Enum last) {
    value = static_cast<Enum>(number_up_to(static_cast<std::uint32_t>(last)));
  }
  void operator()(std::string& text) {
    text.resize(number_up_to(kMostText));
    take(text.data(), text.size());
  }
  void count(std::vector<Mode>& all) { all.resize(number_up_to(2)); }
  [[nodiscard]] bool at_end() const { return left_.empty(); }

 private:
  void take(void* to, std::size_t size) {
    if (left_.size() < size) throw BadMessage("a message is cut off");
    if (size > 0) std::memcpy(to, left_.data(), size);
    left_ = left_.subspan(size);
  }
  std::uint32_t number_up_to(std::size_t most) {
    std::uint32_t value = 0;
    (*this)(value);
    if (value > most) throw BadMessage("a number is out of range");
    return value;
  }

  std::span<const std::uint8_t> left_;
};

bool is_sound(const Mode& mode) {
  const bool sized = mode.width >= 1 && mode.height >= 1 && mode.width <= kMostSide && mode.height <= kMostSide;
  const auto bytes = picture_bytes(mode.fourcc, mode.width, mode.height);
  const bool known = (bytes > 0 || mode.fourcc == kMjpg) && (mode.fourcc == kZ16) == (mode.sensor == Sensor::kDepth);
  const bool sensed =
      mode.sensor == Sensor::kInfrared || mode.sensor == Sensor::kColour || mode.sensor == Sensor::kDepth;
  return sized && known && sensed && bytes <= kSlotBytes && mode.fps <= 1000;
}

void check(bool sound) {
  if (!sound) throw BadMessage("a message says what cannot be");
}

template <typename M>
void check_sense(const M& m) {
  if constexpr (std::is_same_v<M, Release>) {
    check(m.slot < kSlots);
  } else if constexpr (std::is_same_v<M, Request>) {
    check(m.width <= kMostSide && m.height <= kMostSide && m.fps <= 1000);
  } else if constexpr (std::is_same_v<M, ModeFound>) {
    check(is_sound(m.mode));
  } else if constexpr (std::is_same_v<M, Opened>) {
    check(!m.streams.empty() && std::all_of(m.streams.begin(), m.streams.end(), is_sound));
    const auto depths = std::count_if(m.streams.begin(), m.streams.end(),
                                      [](const Mode& mode) { return mode.sensor == Sensor::kDepth; });
    check(m.streams.size() == 1 || depths == 1);
  } else if constexpr (std::is_same_v<M, Picture>) {
    check(is_sound(m.mode) && m.slot < kSlots && m.bytes > 0 && m.bytes <= kSlotBytes);
    check(m.mode.fourcc == kMjpg || m.bytes == picture_bytes(m.mode.fourcc, m.mode.width, m.mode.height));
    check(m.time_us <= std::uint64_t{1} << 53U);  // 285 years.
  }
}

template <std::size_t kType = 0>
Message decode_as(std::uint32_t type, Reader& reader) {
  if constexpr (kType == std::variant_size_v<Message>) {
    throw BadMessage("a message is of no known type");
  } else {
    if (type != kType) return decode_as<kType + 1>(type, reader);
    std::variant_alternative_t<kType, Message> message;
    fields(reader, message);
    if (!reader.at_end()) throw BadMessage("a message is too long");
    check_sense(message);
    return message;
  }
}

}  // namespace

std::size_t picture_bytes(std::uint32_t fourcc, std::uint32_t width, std::uint32_t height) {
  const auto pixels = std::size_t{width} * height;
  switch (fourcc) {
    case kRgb3:
      return 3 * pixels;
    case kYuyv:
    case kUyvy:
      return width % 2 == 0 ? 2 * pixels : 0;
    case kZ16:
      return 2 * pixels;
    case kGrey:
      return pixels;
    default:
      return 0;
  }
}

std::vector<std::uint8_t> encode(const Message& message) {
  Writer writer;
  writer(kMagic);
  writer(kVersion);
  writer(static_cast<std::uint32_t>(message.index()));
  auto copy = message;
  std::visit([&](auto& m) { fields(writer, m); }, copy);
  return std::move(writer.bytes);
}

Message decode(std::span<const std::uint8_t> bytes) {
  if (bytes.size() > kMostMessage) throw BadMessage("a message is too long");
  Reader reader(bytes);
  std::uint32_t magic = 0;
  std::uint32_t version = 0;
  std::uint32_t type = 0;
  reader(magic);
  reader(version);
  reader(type);
  if (magic != kMagic) throw BadMessage("it speaks another language");
  if (version != kVersion) throw BadMessage("it is of another version of choreoscope");
  return decode_as(type, reader);
}

}  // namespace choreo::devices::openni2
