// SPDX-License-Identifier: Apache-2.0
// What a driver knows of the devices that are plugged in.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core/types.hpp>

namespace choreo::devices {

struct DeviceMode {
  std::string format;       ///< "MJPG"
  cv::Size size;            ///< Pixels.
  std::vector<double> fps;  ///< Fastest first; empty where the device does not say.
  cv::Size up_to = {};      ///< Where any size up to this one can be had.
};

struct DeviceControl {
  std::string name;  ///< As a setting of the SOURCE: "exposure_time_absolute".
  std::int64_t least = 0, most = 0, step = 1, fallback = 0;
  std::int64_t value = 0;                                     ///< Now.
  std::vector<std::pair<std::int64_t, std::string>> choices;  ///< Of a menu: number and text.
};

/// What a SOURCE can be told beside the device's own controls.
struct DeviceSetting {
  std::string name;                  ///< "led"
  std::vector<std::string> choices;  ///< Words; empty for a number.
  double least = 0, most = 0;        ///< Of a number.
  std::string unit;                  ///< Of a number: "degrees upwards".
  std::string fallback;              ///< Where it is not named; empty where it is then left as it is.
};

struct DeviceEntry {
  std::string source;  ///< The SOURCE that opens it, by a name that stays the same when it is plugged in elsewhere or
                       ///< among others.
  std::string name;    ///< "HD Pro Webcam C920"
  std::vector<DeviceMode> modes;
  std::vector<DeviceControl> controls;
  std::vector<DeviceSetting> settings;
  std::string trouble;  ///< What keeps it from being used, one line; empty where nothing does.
  std::string remedy;   ///< What to install or do, one line.
};

struct DeviceList {
  std::vector<DeviceEntry> devices;
  std::string trouble;  ///< Why none can be found at all, such as a library that is missing; one line or empty.
  std::string remedy;
};

}  // namespace choreo::devices
