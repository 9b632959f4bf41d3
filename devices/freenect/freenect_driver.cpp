// SPDX-License-Identifier: Apache-2.0
#include "devices/freenect/freenect_driver.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/error.hpp"
#include "devices/freenect/bounded_list.hpp"
#include "devices/freenect/freenect_library.hpp"
#include "devices/freenect/freenect_session.hpp"
#include "devices/media/kinect_depth.hpp"

namespace choreo::devices {
namespace {

using freenect::DepthView;
using freenect::Wish;

constexpr Nanoseconds kListing = std::chrono::seconds(5);

// The first of each is what is taken where none is named.
const std::vector<std::string> kVideos = {"rgb", "ir"};
const std::vector<std::string> kViews = {"registered", "raw", "off"};
const std::vector<std::string> kLeds = {"unchanged", "off",         "green",           "red",
                                        "yellow",    "blink-green", "blink-red-yellow"};
constexpr int kLedNumbers[] = {-1, LED_OFF, LED_GREEN, LED_RED, LED_YELLOW, LED_BLINK_GREEN, LED_BLINK_RED_YELLOW};
constexpr double kMostTilt = 30;

std::optional<int> take_led(SettingReader& settings) {
  const auto chosen = settings.take_choice("led", kLeds.front(), kLeds);
  const int number = kLedNumbers[std::find(kLeds.begin(), kLeds.end(), chosen) - kLeds.begin()];
  return number < 0 ? std::nullopt : std::optional(number);
}

Wish take_wish(const SourceUri& uri, SettingReader& settings) {
  Wish wish;
  wish.serial = uri.location;
  wish.infrared = settings.take_choice("video", "rgb", kVideos) == "ir";
  const auto view = settings.take_choice("depth", wish.infrared ? "raw" : "registered", kViews);
  if (wish.infrared && view == "registered") {
    throw usage_error(fmt::format("source \"{}\": depth cannot be registered onto the infrared picture", uri.text), {},
                      "they come from one camera: depth=raw lies on video=ir already");
  }
  wish.depth = view == "off" ? DepthView::kOff : (view == "raw" ? DepthView::kRaw : DepthView::kRegistered);
  wish.led = take_led(settings);
  const bool tilts = uri.settings.contains("tilt");
  const double tilt = settings.take_number("tilt", 0, -kMostTilt, kMostTilt);
  if (tilts) wish.tilt = tilt;
  settings.refuse_the_rest();
  return wish;
}

std::unique_ptr<Source> open(const SourceUri& uri, SettingReader& settings, const OpenOptions& options,
                             const Clock& clock) {
  auto wish = std::make_shared<Wish>(take_wish(uri, settings));
  wish->keep_raw = options.keep_raw;
  wish->every_frame = options.every_frame;
  DeviceOptions device;
  device.on_event = options.on_event;
  device.stop = options.stop;
  const auto open_session = [wish, &clock](const std::stop_token& stop) -> std::unique_ptr<DeviceSession> {
    auto session = std::make_unique<freenect::Session>(*wish, clock, stop);
    // From now on this Kinect is meant, whichever else is plugged in.
    if (const auto serial = session->serial(); !serial.empty()) wish->serial = serial;
    wish->was_there = true;
    return session;
  };
  return std::make_unique<DeviceSource>(uri.text, open_session, clock, std::move(device));
}

DeviceEntry entry_of(const std::string& serial) {
  DeviceEntry entry;
  entry.source = "freenect://" + serial;
  entry.name = "Kinect v1";
  entry.modes = {
      {"RGB", kKinectSize, {kKinectFps}}, {"IR", kKinectSize, {kKinectFps}}, {"depth", kKinectSize, {kKinectFps}}};
  entry.settings = {{"video", kVideos, 0, 0, "", kVideos.front()},
                    {"depth", kViews, 0, 0, "", kViews.front()},
                    {"led", kLeds, 0, 0, "", kLeds.front()},
                    {"tilt", {}, -kMostTilt, kMostTilt, "degrees upwards", ""}};
  return entry;
}

DeviceList list() {
  DeviceList all;
  try {
    const freenect::Context context;
    const int count = context.count();
    const auto serials = context.serials();
    if (serials) {
      for (const auto& serial : *serials) all.devices.push_back(entry_of(serial));
    }
    while (static_cast<int>(all.devices.size()) < count) {
      auto& entry = all.devices.emplace_back(entry_of(""));
      if (!serials) continue;
      entry.trouble = "it cannot be opened, most likely for want of a permission";
      entry.remedy = freenect::kUsbRemedy;
    }
  } catch (const Error& error) {
    all.trouble = error.what();
    all.remedy = error.hint();
  }
  return all;
}

}  // namespace

Driver freenect_driver(const Clock& clock) {
  Driver driver;
  driver.scheme = "freenect";
  driver.example = "freenect://?depth=registered&led=green&tilt=5";
  driver.summary = "a Kinect v1, its colour and its depth";
  driver.open = [&clock](const SourceUri& uri, SettingReader& settings, const OpenOptions& options) {
    return open(uri, settings, options, clock);
  };
  driver.list = [] { return freenect::list_within(kListing, list); };
  return driver;
}

}  // namespace choreo::devices
