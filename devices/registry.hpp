// SPDX-License-Identifier: Apache-2.0
// Which drivers there are, and which one opens a SOURCE.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "devices/device_list.hpp"
#include "devices/device_state.hpp"
#include "devices/source.hpp"
#include "devices/source_uri.hpp"

namespace choreo::devices {

/// What a driver is told beside the SOURCE itself.
struct OpenOptions {
  int threads = 0;              ///< Decoder threads; 0 lets the driver choose. Never changes what is delivered.
  std::stop_token stop = {};    ///< Ends a wait inside opening or reading.
  OnDeviceEvent on_event = {};  ///< Told what becomes of a device; may be empty.
  bool every_frame = false;     ///< Of a device: frames that waited are delivered too, as far as the driver has room
                                ///< for them (a few: a short pause loses nothing), not the newest alone.
  bool keep_raw = false;        ///< Frames carry what the device gave (Frame::raw_colour, raw_depth).
  bool sets = false;            ///< A folder may be a set of pictures without an order in time (SourceInfo::stills).
};

/// One kind of source.
struct Driver {
  std::string scheme;                     ///< "synthetic"; SOURCES of this scheme are this driver's.
  std::vector<std::string> also_schemes;  ///< Further schemes it opens: "http", "rtsp".
  std::string example;                    ///< A SOURCE one could type.
  std::string summary;                    ///< One line.
  std::function<std::unique_ptr<Source>(const SourceUri&, SettingReader&, const OpenOptions&)> open;
  std::function<DeviceList()> list = {};  ///< What is plugged in; empty for drivers of files.
  /// Whether a plain path that exists is this driver's: one quick look, no error. May be empty.
  std::function<bool(const std::string& path)> claims = {};
  /// Likewise, as a set of pictures, where OpenOptions::sets allows it and nobody claims it otherwise.
  std::function<bool(const std::string& path)> claims_as_set = {};
};

/// Stands for a driver that this build lacks: opening says so and what to install.
[[nodiscard]] Driver absent_driver(std::string scheme, std::string summary, std::string remedy);

/// The drivers by scheme. A plain path goes to the first driver that claims it; else to "folder" where it is a folder
/// and to "file" otherwise.
///
/// Every source honours `rotate=0|90|180|270` (clockwise degrees) and `flip=none|horizontal|vertical|both`, applied
/// after the file's own orientation, the rotation first.
class Registry {
 public:
  void add(Driver driver);

  /// @throws Error (usage) where nothing is at the location, the scheme is unknown (listing the known ones), a
  ///   setting is unknown or out of range, or the driver cannot open it.
  [[nodiscard]] std::unique_ptr<Source> open(const std::string& source, const OpenOptions& options = {}) const;

  [[nodiscard]] const std::vector<Driver>& drivers() const { return drivers_; }

 private:
  [[nodiscard]] const Driver* find(std::string_view scheme) const;
  [[nodiscard]] std::string scheme_of_path(const std::string& path, bool is_folder, bool sets) const;

  std::vector<Driver> drivers_;
};

}  // namespace choreo::devices
