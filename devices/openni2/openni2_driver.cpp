// SPDX-License-Identifier: Apache-2.0
#include "devices/openni2/openni2_driver.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <memory>
#include <system_error>

#include <fmt/format.h>

#include "core/error.hpp"
#include "devices/device_source.hpp"
#include "devices/fourcc.hpp"
#include "devices/openni2/openni2_recording.hpp"
#include "devices/openni2/openni2_session.hpp"

namespace choreo::devices {
namespace {

using openni2::Action;
using openni2::Request;
using openni2::Video;

// In the order of Video.
const std::vector<std::string> kVideos = {"any", "rgb", "ir", "off"};
constexpr int kMostFps = 1000;
constexpr Nanoseconds kListing = std::chrono::seconds(5);

bool ends_as_recording(const std::string& path) {
  auto ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return ending == ".oni";
}

bool is_file(const std::string& path) {
  std::error_code problem;
  return std::filesystem::exists(path, problem) && !std::filesystem::is_directory(path, problem);
}

bool claims(const std::string& path) {
  if (ends_as_recording(path)) return is_file(path);
  // A pipe is only looked at by whoever reads it.
  std::error_code problem;
  return std::filesystem::is_regular_file(path, problem) && openni2::is_recording(path);
}

void take_size(SettingReader& settings, Request& request) {
  const auto text = settings.take_text("size", "");
  if (text.empty()) return;
  const auto* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, request.width);
  if (first.ec == std::errc() && first.ptr != end && *first.ptr == 'x') {
    const auto second = std::from_chars(first.ptr + 1, end, request.height);
    constexpr std::uint32_t kMost = openni2::kMostSide;
    if (second.ec == std::errc() && second.ptr == end && request.width >= 1 && request.height >= 1 &&
        request.width <= kMost && request.height <= kMost) {
      return;
    }
  }
  throw usage_error(fmt::format("size is \"{}\"", text), {}, "size is WIDTHxHEIGHT in pixels, such as 640x480");
}

void take_streams(SettingReader& settings, Request& request, const std::string& source) {
  const auto video = settings.take_choice("video", "any", kVideos);
  request.video = static_cast<Video>(std::find(kVideos.begin(), kVideos.end(), video) - kVideos.begin());
  request.depth = settings.take_flag("depth", true);
  if (request.video == Video::kNone && !request.depth) {
    throw usage_error(fmt::format("source \"{}\": neither video nor depth is left", source), {},
                      "video is off and depth is off: turn one of them on");
  }
}

std::unique_ptr<Source> open(const SourceUri& uri, SettingReader& settings, const OpenOptions& options,
                             const Clock& clock, Nanoseconds patience) {
  auto request = std::make_shared<Request>();
  take_streams(settings, *request, uri.text);
  if (is_file(uri.location) || ends_as_recording(uri.location)) {
    settings.refuse_the_rest();
    request->action = Action::kRecording;
    return std::make_unique<openni2::Recording>(uri, *request, options, patience);
  }
  request->action = Action::kDevice;
  request->location = uri.location;
  take_size(settings, *request);
  request->fps = static_cast<std::uint32_t>(settings.take_integer("fps", 0, 0, kMostFps));
  request->registered = settings.take_flag("registration", true);
  settings.refuse_the_rest();
  DeviceOptions device;
  device.on_event = options.on_event;
  device.stop = options.stop;
  device.retry = std::chrono::milliseconds(500);  // Each attempt is a process, and a look at every USB port.
  const auto open_session = [request, name = uri.text, keep_raw = options.keep_raw, patience,
                             every_frame = options.every_frame,
                             &clock](const std::stop_token& stop) -> std::unique_ptr<DeviceSession> {
    auto session = std::make_unique<openni2::Session>(*request, name, keep_raw, clock, patience, stop, every_frame);
    // From now on this device is meant, whatever port it comes back at: a URI names the port.
    const auto& is = session->device();
    request->location = is.serial.empty() ? is.uri : is.serial;
    if (is.serial.empty()) {
      request->usb_vendor = is.usb_vendor;
      request->usb_product = is.usb_product;
    }
    return session;
  };
  return std::make_unique<DeviceSource>(uri.text, open_session, clock, std::move(device));
}

// Percent signs and question marks would mean something in a SOURCE.
std::string escaped(const std::string& text) {
  std::string out;
  for (const unsigned char c : text) {
    if (c == '%' || c == '?' || c < 33 || c > 126) {
      out += fmt::format("%{:02X}", c);
    } else {
      out += static_cast<char>(c);
    }
  }
  return out;
}

DeviceEntry entry_of(const openni2::DeviceFound& found) {
  DeviceEntry entry;
  entry.source = "openni2://" + escaped(found.serial.empty() ? found.uri : found.serial);
  entry.name = found.vendor.empty() ? found.name : found.vendor + " " + found.name;
  entry.trouble = found.trouble;
  if (!entry.trouble.empty())
    entry.remedy = "close other programs that use it, and see that /dev/bus/usb may be written to";
  static const std::vector<std::string> kFlag = {"on", "off"};
  entry.settings = {{"video", kVideos, 0, 0, "", kVideos.front()},
                    {"depth", kFlag, 0, 0, "", kFlag.front()},
                    {"size", {}, 1, openni2::kMostSide, "pixels a side, such as 640x480", ""},
                    {"fps", {}, 1, kMostFps, "Hz", ""},
                    {"registration", kFlag, 0, 0, "", kFlag.front()}};
  return entry;
}

void add_mode(DeviceEntry& entry, const openni2::Mode& mode) {
  constexpr std::string_view kSensors[] = {"", "infrared", "colour", "depth"};
  const DeviceMode told{
      fmt::format("{} {}", kSensors[static_cast<std::size_t>(mode.sensor)], name_of_fourcc(mode.fourcc)),
      {static_cast<int>(mode.width), static_cast<int>(mode.height)},
      {static_cast<double>(mode.fps)}};
  const auto same = std::find_if(entry.modes.begin(), entry.modes.end(), [&](const DeviceMode& other) {
    return other.format == told.format && other.size == told.size;
  });
  if (same == entry.modes.end()) {
    entry.modes.push_back(told);
    return;
  }
  same->fps.push_back(told.fps.front());
  std::sort(same->fps.rbegin(), same->fps.rend());
}

DeviceList list() {
  DeviceList all;
  try {
    openni2::HelperProcess helper{Request()};
    for (;;) {
      auto message = helper.next(kListing);
      if (!message) throw openni2::HelperGone(fmt::format("OpenNI2 hangs: silent for {:.1f} s", to_seconds(kListing)));
      if (std::holds_alternative<openni2::End>(*message)) return all;
      if (const auto* found = std::get_if<openni2::DeviceFound>(&*message)) {
        all.devices.push_back(entry_of(*found));
      } else if (const auto* mode = std::get_if<openni2::ModeFound>(&*message)) {
        if (!all.devices.empty()) add_mode(all.devices.back(), mode->mode);
      } else if (const auto* trouble = std::get_if<openni2::Trouble>(&*message)) {
        all.trouble = trouble->text;
        all.remedy = trouble->hint;
        return all;
      }
    }
  } catch (const Error& error) {
    all.trouble = error.what();
    all.remedy = error.hint();
  } catch (const openni2::HelperGone& gone) {
    all.trouble = gone.what();
  }
  return all;
}

}  // namespace

Driver openni2_driver(const Clock& clock, Nanoseconds patience) {
  Driver driver;
  driver.scheme = "openni2";
  driver.example = "openni2://?size=640x480&registration=on";
  driver.summary = "a depth camera or an .oni recording of OpenNI2";
  driver.open = [&clock, patience](const SourceUri& uri, SettingReader& settings, const OpenOptions& options) {
    return open(uri, settings, options, clock, patience);
  };
  driver.list = list;
  driver.claims = claims;
  return driver;
}

}  // namespace choreo::devices
