// SPDX-License-Identifier: Apache-2.0
#include "devices/registry.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"
#include "devices/oriented_source.hpp"

namespace choreo::devices {
namespace {

bool path_exists(const std::string& path) {
  std::error_code problem;
  return std::filesystem::exists(path, problem);
}

Orientation take_orientation(SettingReader& settings) {
  static const std::vector<std::string> kTurns = {"0", "90", "180", "270"};
  static const std::vector<std::string> kFlips = {"none", "horizontal", "vertical", "both"};
  const auto turn = settings.take_choice("rotate", "0", kTurns);
  const auto flip = settings.take_choice("flip", "none", kFlips);
  Orientation orientation;
  orientation.quarter_turns = static_cast<int>(std::find(kTurns.begin(), kTurns.end(), turn) - kTurns.begin());
  orientation.flip_horizontal = flip == "horizontal" || flip == "both";
  orientation.flip_vertical = flip == "vertical" || flip == "both";
  return orientation;
}

}  // namespace

Driver absent_driver(std::string scheme, std::string summary, std::string remedy) {
  Driver driver;
  driver.scheme = scheme;
  driver.summary = std::move(summary);
  const auto trouble = fmt::format("this build knows no {}", scheme);
  driver.open = [trouble, remedy](const SourceUri& uri, SettingReader&, const OpenOptions&) -> std::unique_ptr<Source> {
    throw usage_error(fmt::format("source \"{}\": {}", uri.text, trouble), {}, remedy);
  };
  driver.list = [trouble, remedy] { return DeviceList{{}, trouble, remedy}; };
  return driver;
}

void Registry::add(Driver driver) { drivers_.push_back(std::move(driver)); }

const Driver* Registry::find(std::string_view scheme) const {
  for (const auto& driver : drivers_) {
    if (driver.scheme == scheme ||
        std::find(driver.also_schemes.begin(), driver.also_schemes.end(), scheme) != driver.also_schemes.end()) {
      return &driver;
    }
  }
  return nullptr;
}

std::string Registry::scheme_of_path(const std::string& path, bool is_folder, bool sets) const {
  for (const auto& driver : drivers_) {
    if (driver.claims && driver.claims(path)) return driver.scheme;
  }
  for (const auto& driver : drivers_) {
    if (sets && driver.claims_as_set && driver.claims_as_set(path)) return driver.scheme;
  }
  return is_folder ? "folder" : "file";
}

std::unique_ptr<Source> Registry::open(const std::string& source, const OpenOptions& options) const {
  auto uri = parse_source_uri(source, path_exists);
  if (uri.scheme.empty() || uri.scheme == "file") {
    std::error_code problem;
    const auto status = std::filesystem::status(uri.location, problem);
    if (status.type() == std::filesystem::file_type::not_found) {
      throw usage_error(fmt::format("\"{}\" does not exist", uri.location), {},
                        "a source is a video file, a folder of numbered images, or a URI such as synthetic://walking");
    }
    if (problem) throw usage_error(fmt::format("\"{}\" cannot be read: {}", uri.location, problem.message()));
    uri.scheme = scheme_of_path(uri.location, std::filesystem::is_directory(status), options.sets);
  }
  const auto* driver = find(uri.scheme);
  if (driver == nullptr) {
    std::vector<std::string> known;
    for (const auto& d : drivers_) {
      known.push_back(d.scheme);
      known.insert(known.end(), d.also_schemes.begin(), d.also_schemes.end());
    }
    throw usage_error(fmt::format("source \"{}\": unknown scheme \"{}\"", uri.text, uri.scheme), {},
                      fmt::format("known: {}", join(known)));
  }
  SettingReader settings(uri);
  const auto orientation = take_orientation(settings);
  return make_oriented(driver->open(uri, settings, options), orientation);
}

}  // namespace choreo::devices
