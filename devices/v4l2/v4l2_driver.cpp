// SPDX-License-Identifier: Apache-2.0
#include "devices/v4l2/v4l2_driver.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <memory>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"
#include "devices/fourcc.hpp"
#include "devices/v4l2/v4l2_controls.hpp"
#include "devices/v4l2/v4l2_session.hpp"

namespace choreo::devices {
namespace {

std::optional<cv::Size> take_size(SettingReader& settings) {
  const auto text = settings.take_text("size", "");
  if (text.empty()) return std::nullopt;
  int width = 0;
  int height = 0;
  const auto* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, width);
  if (first.ec == std::errc() && first.ptr != end && *first.ptr == 'x') {
    const auto second = std::from_chars(first.ptr + 1, end, height);
    constexpr int kMost = 16384;
    if (second.ec == std::errc() && second.ptr == end && width >= 1 && height >= 1 && width <= kMost &&
        height <= kMost) {
      return cv::Size(width, height);
    }
  }
  throw usage_error(fmt::format("size is \"{}\"", text), {}, "size is WIDTHxHEIGHT in pixels, such as 640x480");
}

std::optional<std::uint32_t> take_format(SettingReader& settings) {
  auto text = settings.take_text("format", "");
  if (text.empty()) return std::nullopt;
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::toupper(c)); });
  std::vector<std::string> names;
  for (const auto code : known_formats()) {
    names.push_back(name_of_fourcc(code));
    if (names.back() == text) return code;
  }
  throw usage_error(fmt::format("format is \"{}\"", text), {}, "known: " + join(names));
}

std::unique_ptr<Source> open(const SourceUri& uri, SettingReader& settings, const OpenOptions& options,
                             const Clock& clock) {
  auto wish = std::make_shared<v4l2::Wish>();
  wish->path = uri.location;
  if (const auto input = settings.take_integer("input", -1, 0, 255); input >= 0) wish->input = int(input);
  wish->size = take_size(settings);
  if (const double fps = settings.take_number("fps", 0, 0, 1000); fps > 0) wish->fps = fps;
  wish->fourcc = take_format(settings);
  wish->keep_raw = options.keep_raw;
  wish->every_frame = options.every_frame;
  wish->controls = settings.take_rest();
  if (wish->path.empty()) {
    throw usage_error(fmt::format("\"{}\" names no camera", uri.text), {},
                      "such as v4l2:///dev/video0; choreoscope devices lists the cameras there are");
  }
  DeviceOptions device;
  device.on_event = options.on_event;
  const auto open_session = [wish, &clock](const std::stop_token&) -> std::unique_ptr<DeviceSession> {
    auto session = std::make_unique<v4l2::Session>(*wish, clock);
    // From now on this camera is meant, whatever number it has when it comes back.
    wish->identity = session->identity();
    return session;
  };
  return std::make_unique<DeviceSource>(uri.text, open_session, clock, std::move(device));
}

// The modes that can be turned into pictures, and the controls that can be set.
DeviceEntry entry_of(const v4l2::Node& node, const v4l2::Identity& identity) {
  DeviceEntry entry;
  entry.source = "v4l2://" + v4l2::stable_path(node.path());
  entry.name = identity.card;
  const auto known = known_formats();
  for (const auto& mode : v4l2::modes_of(node)) {
    if (std::find(known.begin(), known.end(), mode.fourcc) == known.end()) continue;
    DeviceMode told{name_of_fourcc(mode.fourcc), {int(mode.width), int(mode.height)}, {}, {}};
    if (mode.steps) told.up_to = {int(mode.steps->most_width), int(mode.steps->most_height)};
    for (const auto& rate : mode.rates) told.fps.push_back(rate.fps());
    entry.modes.push_back(std::move(told));
  }
  for (auto& control : v4l2::controls_of(node)) {
    if (!control.settable()) continue;
    entry.controls.push_back({control.name, control.least, control.most, control.step, control.fallback, control.value,
                              std::move(control.menu)});
  }
  return entry;
}

DeviceList list() {
  DeviceList all;
  for (const auto& path : v4l2::video_nodes()) {
    try {
      const v4l2::Node node(path);
      // A camera has further nodes, for metadata or for output: nothing to read pictures from.
      if (const auto identity = v4l2::identity_of(node)) all.devices.push_back(entry_of(node, *identity));
    } catch (const Error& error) {
      DeviceEntry entry;
      entry.source = "v4l2://" + v4l2::stable_path(path);
      entry.trouble = error.what();
      entry.remedy = error.hint();
      all.devices.push_back(std::move(entry));
    } catch (const DeviceLost&) {
      continue;  // Gone since the folder was read.
    }
  }
  return all;
}

}  // namespace

Driver v4l2_driver(const Clock& clock) {
  Driver driver;
  driver.scheme = "v4l2";
  driver.example = "v4l2:///dev/video0?size=640x480&fps=60";
  driver.summary = "a camera of the Linux kernel, with any control by its v4l2-ctl name";
  driver.open = [&clock](const SourceUri& uri, SettingReader& settings, const OpenOptions& options) {
    return open(uri, settings, options, clock);
  };
  driver.list = list;
  return driver;
}

}  // namespace choreo::devices
