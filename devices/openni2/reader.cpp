// SPDX-License-Identifier: Apache-2.0
#include "devices/openni2/reader.hpp"

#include <OniCAPI.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "devices/fourcc.hpp"
#include "devices/openni2/file_position.hpp"
#include "devices/openni2/mode_choice.hpp"

namespace choreo::devices::openni2 {
namespace {

constexpr auto kRecording = "/proc/self/fd/4";  // kRecordingDescriptor: OpenNI2 cuts long paths.
constexpr int kSlice = 50;                      // Milliseconds.
// A wait that is begun again asks a recording for one more picture, which may push out one that is just arriving: in
// the middle of a recording, only a wait as long as this one is begun again.
constexpr int kLongSlice = 250;

struct Events {
  std::atomic<bool> lost = false, at_end = false;
  std::string uri;
};

void device_is_gone(const OniDeviceInfo* info, void* cookie) {
  auto& events = *static_cast<Events*>(cookie);
  if (info != nullptr && events.uri == info->uri) events.lost = true;
}

void device_changed(const OniDeviceInfo* info, OniDeviceState state, void* cookie) {
  auto& events = *static_cast<Events*>(cookie);
  if (info == nullptr || events.uri != info->uri) return;
  if (state == ONI_DEVICE_STATE_EOF) events.at_end = true;
  if (state == ONI_DEVICE_STATE_ERROR) events.lost = true;
}

std::uint32_t fourcc_of(OniPixelFormat format) {
  switch (format) {
    case ONI_PIXEL_FORMAT_RGB888:
      return kRgb3;
    case ONI_PIXEL_FORMAT_YUYV:
      return kYuyv;
    case ONI_PIXEL_FORMAT_YUV422:
      return kUyvy;
    case ONI_PIXEL_FORMAT_GRAY8:
    case ONI_PIXEL_FORMAT_GRAY16:
      return kGrey;
    case ONI_PIXEL_FORMAT_JPEG:
      return kMjpg;
    case ONI_PIXEL_FORMAT_DEPTH_1_MM:
    case ONI_PIXEL_FORMAT_DEPTH_100_UM:
      return kZ16;
    default:
      return 0;
  }
}

// Of format 0 where it is none that can be sent.
Mode mode_of(Sensor sensor, const OniVideoMode& mode) {
  const bool sized = mode.resolutionX > 0 && mode.resolutionY > 0 && mode.resolutionX <= kMostSide &&
                     mode.resolutionY <= kMostSide && mode.fps >= 0 && mode.fps <= 1000;
  if (!sized) return {sensor, 0, 0, 0, 0};
  Mode told{sensor, fourcc_of(mode.pixelFormat), static_cast<std::uint32_t>(mode.resolutionX),
            static_cast<std::uint32_t>(mode.resolutionY), static_cast<std::uint32_t>(mode.fps)};
  const auto bytes = picture_bytes(told.fourcc, told.width, told.height);
  const bool fits = (bytes > 0 || told.fourcc == kMjpg) && bytes <= kSlotBytes;
  if (!fits || (told.fourcc == kZ16) != (sensor == Sensor::kDepth)) told.fourcc = 0;
  return told;
}

OniSensorType type_of(Sensor sensor) { return static_cast<OniSensorType>(sensor); }

const char* name_of(Sensor sensor) {
  constexpr std::array kNames = {"", "infrared", "colour", "depth"};
  return kNames[static_cast<std::size_t>(sensor)];
}

struct Stream {
  OniStreamHandle handle = nullptr;
  Mode mode;
  OniPixelFormat format = ONI_PIXEL_FORMAT_RGB888;
  int most = 1023;  // Of infrared in 16 bits: what is white.
};

// Bytes that a pixel has where OpenNI2 has it.
std::size_t pixel_bytes(OniPixelFormat format) { return static_cast<std::size_t>(oniFormatBytesPerPixel(format)); }

// Copies a picture without padding; a part of one is put where it belongs. @return bytes, 0 where it is damaged.
std::size_t copy_picture(const Stream& stream, const OniFrame& frame, std::span<std::uint8_t> to) {
  const auto data_size = static_cast<std::size_t>(std::max(frame.dataSize, 0));
  const auto* data = static_cast<const std::uint8_t*>(frame.data);
  if (data == nullptr || data_size == 0 || frame.videoMode.pixelFormat != stream.format) return 0;
  if (stream.mode.fourcc == kMjpg) {
    if (data_size > to.size()) return 0;
    std::memcpy(to.data(), data, data_size);
    return data_size;
  }
  const auto full_width = static_cast<int>(stream.mode.width);
  const auto full_height = static_cast<int>(stream.mode.height);
  const int left = frame.croppingEnabled != 0 ? frame.cropOriginX : 0;
  const int top = frame.croppingEnabled != 0 ? frame.cropOriginY : 0;
  if (frame.width <= 0 || frame.height <= 0 || left < 0 || top < 0 || frame.width > full_width - left ||
      frame.height > full_height - top) {
    return 0;
  }
  if (frame.croppingEnabled == 0 && (frame.width != full_width || frame.height != full_height)) return 0;
  const auto from_pixel = pixel_bytes(stream.format);
  const auto line = static_cast<std::size_t>(frame.width) * from_pixel;
  const auto stride = static_cast<std::size_t>(std::max(frame.stride, 0));
  if (stride < line || data_size < stride * static_cast<std::size_t>(frame.height - 1) + line) return 0;
  const auto bytes = picture_bytes(stream.mode.fourcc, stream.mode.width, stream.mode.height);
  const auto to_pixel = bytes / (std::size_t{stream.mode.width} * stream.mode.height);
  if (frame.croppingEnabled != 0) std::memset(to.data(), 0, bytes);
  for (int y = 0; y < frame.height; ++y) {
    const auto* from = data + static_cast<std::size_t>(y) * stride;
    auto* into =
        to.data() + (static_cast<std::size_t>(y + top) * stream.mode.width + static_cast<std::size_t>(left)) * to_pixel;
    if (stream.format != ONI_PIXEL_FORMAT_GRAY16 && stream.format != ONI_PIXEL_FORMAT_DEPTH_100_UM) {
      std::memcpy(into, from, line);
      continue;
    }
    for (int x = 0; x < frame.width; ++x) {
      std::uint16_t value = 0;
      std::memcpy(&value, from + 2 * static_cast<std::size_t>(x), sizeof value);
      if (stream.format == ONI_PIXEL_FORMAT_GRAY16) {
        into[x] = static_cast<std::uint8_t>(std::min(255, 255 * int{value} / stream.most));
      } else {
        value = static_cast<std::uint16_t>((value + 5) / 10);
        std::memcpy(into + 2 * static_cast<std::size_t>(x), &value, sizeof value);
      }
    }
  }
  return bytes;
}

class Reader {
 public:
  Reader(const Request& request, HelperLink& link) : request_(request), link_(link) {}

  void run() {
    if (oniInitialize(ONI_API_VERSION) != ONI_STATUS_OK) {
      link_.send(Trouble{TroubleKind::kNoDrivers, fmt::format("OpenNI2 finds no drivers: {}", last_error()),
                         "they lie in the folder OpenNI2/Drivers beside the library; apt-get install libopenni2-0"});
      return;
    }
    OniDeviceCallbacks callbacks{nullptr, device_is_gone, device_changed};
    OniCallbackHandle handle = nullptr;
    (void)oniRegisterDeviceCallbacks(&callbacks, &events_, &handle);
    switch (request_.action) {
      case Action::kList:
        list();
        return;
      case Action::kDevice:
        if (open_device() && start()) stream();
        close_device();
        return;
      case Action::kRecording:
        if (open_recording() && start()) stream();
        return;
    }
  }

 private:
  static std::string last_error() {
    std::string text = oniGetExtendedError();
    for (auto& c : text) {
      if (c == '\n' || c == '\t') c = ' ';
    }
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return text.empty() ? "it does not say why" : text;
  }

  bool refuse(TroubleKind kind, const std::string& text, const std::string& hint = {}) {
    link_.send(Trouble{kind, text, hint});
    return false;
  }

  static std::vector<OniDeviceInfo> devices() {
    OniDeviceInfo* first = nullptr;
    int count = 0;
    if (oniGetDeviceList(&first, &count) != ONI_STATUS_OK || count <= 0) return {};
    std::vector<OniDeviceInfo> all(first, first + count);
    oniReleaseDeviceList(first);
    return all;
  }

  std::string serial() const {
    std::array<char, 256> text{};
    int size = text.size() - 1;
    if (oniDeviceIsPropertySupported(device_, ONI_DEVICE_PROPERTY_SERIAL_NUMBER) == 0 ||
        oniDeviceGetProperty(device_, ONI_DEVICE_PROPERTY_SERIAL_NUMBER, text.data(), &size) != ONI_STATUS_OK) {
      return {};
    }
    return text.data();
  }

  // Opens it, to ask for its serial number.
  DeviceFound look_at(const OniDeviceInfo& info) {
    DeviceFound found{info.uri, info.vendor, info.name, {}, {}, info.usbVendorId, info.usbProductId};
    if (oniDeviceOpen(info.uri, &device_) != ONI_STATUS_OK) {
      device_ = nullptr;
      found.trouble = fmt::format("it cannot be opened: {}", last_error());
      return found;
    }
    found.serial = serial();
    return found;
  }

  void close_device() {
    for (auto& stream : streams_) {
      oniStreamStop(stream.handle);
      oniStreamDestroy(stream.handle);
    }
    streams_.clear();
    if (device_ != nullptr) oniDeviceClose(device_);
    device_ = nullptr;
  }

  std::vector<OniVideoMode> library_modes(Sensor sensor) const {
    const auto* info = oniDeviceGetSensorInfo(device_, type_of(sensor));
    if (info == nullptr || info->numSupportedVideoModes <= 0) return {};
    return {info->pSupportedVideoModes, info->pSupportedVideoModes + info->numSupportedVideoModes};
  }

  bool has(Sensor sensor) const { return oniDeviceGetSensorInfo(device_, type_of(sensor)) != nullptr; }

  void list() {
    for (const auto& info : devices()) {
      link_.send(look_at(info));
      if (device_ == nullptr) continue;
      for (const auto sensor : {Sensor::kColour, Sensor::kInfrared, Sensor::kDepth}) {
        for (const auto& known : library_modes(sensor)) {
          const auto mode = mode_of(sensor, known);
          if (mode.fourcc != 0) link_.send(ModeFound{mode});
        }
      }
      close_device();
    }
    link_.send(End{});
  }

  bool open_device() {
    const auto all = devices();
    std::string there;
    const OniDeviceInfo* alike = nullptr;
    std::size_t how_many_alike = 0;
    for (const auto& info : all) {
      there += (there.empty() ? "" : ", ") + std::string(info.uri);
      if (request_.usb_vendor == info.usbVendorId && request_.usb_product == info.usbProductId &&
          request_.usb_vendor != 0) {
        alike = &info;
        ++how_many_alike;
      }
      opened_.device = look_at(info);
      const bool meant = request_.location.empty() || request_.location == info.uri ||
                         (!opened_.device.serial.empty() && request_.location == opened_.device.serial);
      if (meant && device_ != nullptr) return true;
      if (meant) return refuse(TroubleKind::kLost, fmt::format("\"{}\": {}", info.uri, opened_.device.trouble));
      close_device();
    }
    if (how_many_alike == 1) {
      opened_.device = look_at(*alike);
      if (device_ != nullptr) return true;
      return refuse(TroubleKind::kLost, fmt::format("\"{}\": {}", alike->uri, opened_.device.trouble));
    }
    if (request_.location.empty()) return refuse(TroubleKind::kLost, "OpenNI2 finds no device");
    return refuse(TroubleKind::kLost, fmt::format("OpenNI2 finds no device \"{}\", but {}", request_.location,
                                                  there.empty() ? "none at all" : there));
  }

  bool open_recording() {
    if (oniDeviceOpen(kRecording, &device_) != ONI_STATUS_OK) {
      return refuse(TroubleKind::kDamaged, "OpenNI2 cannot open it", "perhaps its end is missing, where the index is");
    }
    const OniBool off = 0;
    const float as_fast_as_asked_for = -1;
    if (oniDeviceSetProperty(device_, ONI_DEVICE_PROPERTY_PLAYBACK_REPEAT_ENABLED, &off, sizeof off) != ONI_STATUS_OK ||
        oniDeviceSetProperty(device_, ONI_DEVICE_PROPERTY_PLAYBACK_SPEED, &as_fast_as_asked_for,
                             sizeof as_fast_as_asked_for) != ONI_STATUS_OK) {
      return refuse(TroubleKind::kDamaged, "OpenNI2 cannot play it");
    }
    return true;
  }

  // The sensors to read, the video first.
  std::optional<std::vector<Sensor>> wanted() {
    std::vector<Sensor> all;
    const bool colour = has(Sensor::kColour);
    const bool infrared = has(Sensor::kInfrared);
    const bool depth = has(Sensor::kDepth);
    const bool no_colour = request_.video == Video::kColour && !colour;
    const bool no_infrared = request_.video == Video::kInfrared && !infrared;
    if (no_colour || no_infrared) {
      refuse(TroubleKind::kRefused, fmt::format("there is no {}", no_colour ? "colour" : "infrared"),
             fmt::format("there is {}{}{}", colour ? "colour (video=rgb) " : "", infrared ? "infrared (video=ir) " : "",
                         depth ? "depth" : ""));
      return std::nullopt;
    }
    if (colour && (request_.video == Video::kAny || request_.video == Video::kColour)) {
      all.push_back(Sensor::kColour);
    } else if (infrared && request_.video != Video::kNone) {
      all.push_back(Sensor::kInfrared);
    }
    if (depth && request_.depth) all.push_back(Sensor::kDepth);
    if (all.empty()) {
      refuse(TroubleKind::kRefused, "there is no stream of what is asked for");
      return std::nullopt;
    }
    return all;
  }

  // Of a device; the streams of a recording are as they are.
  bool set_mode(Stream& stream) {
    const auto known = library_modes(stream.mode.sensor);
    std::vector<Mode> modes;
    for (const auto& mode : known) modes.push_back(mode_of(stream.mode.sensor, mode));
    ModeWish wish{request_.width, request_.height, request_.width > 0 && streams_.empty(), request_.fps};
    if (!streams_.empty()) {
      // Depth as the video is, where it can.
      const auto& video = streams_.front().mode;
      wish = {video.width, video.height, false, video.fps};
    }
    const auto chosen = choose_mode(modes, wish);
    if (!chosen) {
      std::string there;
      for (const auto& mode : modes) {
        if (mode.fourcc == 0) continue;
        there += fmt::format("{}{} {}x{} at {}", there.empty() ? "it has " : ", ", name_of(mode.sensor), mode.width,
                             mode.height, mode.fps);
      }
      return refuse(TroubleKind::kRefused, fmt::format("the device has no such {} mode", name_of(stream.mode.sensor)),
                    there.empty() ? "it has none that is known here" : there);
    }
    if (request_.fps > 0 && modes[*chosen].fps != request_.fps) {
      link_.send(Warning{fmt::format("the device gives {} {} frames a second, {} were asked for", modes[*chosen].fps,
                                     name_of(stream.mode.sensor), request_.fps)});
    }
    if (oniStreamSetProperty(stream.handle, ONI_STREAM_PROPERTY_VIDEO_MODE, &known[*chosen], sizeof known[*chosen]) !=
        ONI_STATUS_OK) {
      return refuse(TroubleKind::kLost,
                    fmt::format("the {} mode cannot be set: {}", name_of(stream.mode.sensor), last_error()));
    }
    const OniBool off = 0;  // As a person would look at it, not as in a mirror.
    if (oniStreamIsPropertySupported(stream.handle, ONI_STREAM_PROPERTY_MIRRORING) != 0) {
      (void)oniStreamSetProperty(stream.handle, ONI_STREAM_PROPERTY_MIRRORING, &off, sizeof off);
    }
    return true;
  }

  bool open_stream(Sensor sensor) {
    const bool recording = request_.action == Action::kRecording;
    const auto broken = recording ? TroubleKind::kDamaged : TroubleKind::kLost;
    Stream stream;
    stream.mode.sensor = sensor;
    if (oniDeviceCreateStream(device_, type_of(sensor), &stream.handle) != ONI_STATUS_OK) {
      return refuse(broken, fmt::format("no {} stream: {}", name_of(sensor), last_error()));
    }
    if (!recording && !set_mode(stream)) return false;
    OniVideoMode mode{};
    int size = sizeof mode;
    if (oniStreamGetProperty(stream.handle, ONI_STREAM_PROPERTY_VIDEO_MODE, &mode, &size) != ONI_STATUS_OK) {
      return refuse(broken, fmt::format("no mode of {}: {}", name_of(sensor), last_error()));
    }
    stream.mode = mode_of(sensor, mode);
    stream.format = mode.pixelFormat;
    if (stream.mode.fourcc == 0) {
      return refuse(broken, fmt::format("{} pictures of {}x{} in format {} cannot be read", name_of(sensor),
                                        mode.resolutionX, mode.resolutionY, static_cast<int>(mode.pixelFormat)));
    }
    int most = 0;
    size = sizeof most;
    if (oniStreamIsPropertySupported(stream.handle, ONI_STREAM_PROPERTY_MAX_VALUE) != 0 &&
        oniStreamGetProperty(stream.handle, ONI_STREAM_PROPERTY_MAX_VALUE, &most, &size) == ONI_STATUS_OK && most > 0 &&
        most <= 65535) {
      stream.most = most;
    }
    streams_.push_back(stream);
    return true;
  }

  void align(bool both) {
    if (!both) return;
    const bool wanted = request_.registered && streams_.front().mode.sensor == Sensor::kColour;
    const auto how = wanted ? ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR : ONI_IMAGE_REGISTRATION_OFF;
    const bool can =
        oniDeviceIsImageRegistrationModeSupported(device_, how) != 0 &&
        oniDeviceSetProperty(device_, ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION, &how, sizeof how) == ONI_STATUS_OK;
    if (wanted && !can) link_.send(Warning{"the device cannot bring depth onto colour: they lie side by side"});
    (void)oniDeviceEnableDepthColorSync(device_);  // Where it cannot, pairing by time does what can be done.
  }

  bool start() {
    const auto sensors = wanted();
    if (!sensors) return false;
    for (const auto sensor : *sensors) {
      if (!open_stream(sensor)) return false;
    }
    const bool recording = request_.action == Action::kRecording;
    if (!recording) align(streams_.size() > 1);
    OniDeviceInfo info{};
    if (oniDeviceGetInfo(device_, &info) == ONI_STATUS_OK) events_.uri = info.uri;
    for (auto& stream : streams_) {
      opened_.streams.push_back(stream.mode);
      if (oniStreamStart(stream.handle) != ONI_STATUS_OK) {
        return refuse(recording ? TroubleKind::kDamaged : TroubleKind::kLost,
                      fmt::format("the {} stream cannot start: {}", name_of(stream.mode.sensor), last_error()));
      }
    }
    int frames = 0;
    int size = sizeof frames;
    if (recording && oniStreamGetProperty(streams_.front().handle, ONI_STREAM_PROPERTY_NUMBER_OF_FRAMES, &frames,
                                          &size) == ONI_STATUS_OK) {
      opened_.frames = static_cast<std::uint32_t>(std::max(frames, 0));
    }
    link_.send(opened_);
    return true;
  }

  void stream() {
    const bool recording = request_.action == Action::kRecording;
    std::vector<OniStreamHandle> handles;
    for (const auto& stream : streams_) handles.push_back(stream.handle);
    for (int idle = 0;;) {  // How often nothing came though all of the file was read.
      // A recording waits until there is room; a device does not wait.
      (void)link_.receive(recording && !link_.free_slot() ? 1000 : 0);
      if (link_.closed()) return;
      if (events_.lost) {
        link_.send(Trouble{TroubleKind::kLost, "the device is gone", {}});
        return;
      }
      if (recording && !link_.free_slot()) continue;
      int which = -1;
      const bool at_end = events_.at_end;  // Before looking for a last picture.
      const int patience = at_end ? 0 : recording && !near_end() ? kLongSlice : kSlice;
      const auto status = oniWaitForAnyStream(handles.data(), static_cast<int>(handles.size()), &which, patience);
      idle = status == ONI_STATUS_TIME_OUT && recording && stands_at_end(kRecordingDescriptor) ? idle + 1 : 0;
      if (idle > 1 && !at_end) link_.send(Warning{"the recording breaks off: it was cut, or never finished"});
      if (idle > 1 || (status == ONI_STATUS_TIME_OUT && at_end)) {
        link_.send(End{});
        return;
      }
      if (status != ONI_STATUS_OK || which < 0 || which >= static_cast<int>(streams_.size())) continue;
      OniFrame* frame = nullptr;
      if (oniStreamReadFrame(handles[static_cast<std::size_t>(which)], &frame) != ONI_STATUS_OK || frame == nullptr) {
        continue;
      }
      if (which == 0) ++read_;
      pass_on(streams_[static_cast<std::size_t>(which)], *frame);
      oniFrameRelease(frame);
    }
  }

  bool near_end() const { return read_ >= opened_.frames; }

  void pass_on(const Stream& stream, const OniFrame& frame) {
    const auto slot = link_.free_slot();
    if (!slot) return;  // Choreoscope is slow: the number that is missing tells of it.
    const auto bytes = copy_picture(stream, frame, link_.slot(*slot));
    if (bytes == 0) {
      if (!std::exchange(told_damaged_, true)) link_.send(Warning{"OpenNI2 gave damaged frames, which were left out"});
      return;
    }
    Picture picture;
    picture.mode = stream.mode;
    picture.slot = *slot;
    picture.bytes = static_cast<std::uint32_t>(bytes);
    picture.index = static_cast<std::uint32_t>(frame.frameIndex);
    constexpr std::uint64_t kLatest = std::uint64_t{1} << 53U;
    picture.time_us = std::min<std::uint64_t>(frame.timestamp, kLatest);
    link_.send_picture(picture);
  }

  const Request& request_;
  HelperLink& link_;
  Events events_;
  OniDeviceHandle device_ = nullptr;
  std::vector<Stream> streams_;
  Opened opened_;
  std::uint32_t read_ = 0;
  bool told_damaged_ = false;
};

}  // namespace

void serve(const Request& request, HelperLink& link) { Reader(request, link).run(); }

}  // namespace choreo::devices::openni2
