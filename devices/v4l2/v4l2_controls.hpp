// SPDX-License-Identifier: Apache-2.0
// A camera's controls, by the names that v4l2-ctl gives them.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "devices/v4l2/v4l2_node.hpp"

namespace choreo::devices::v4l2 {

struct Control {
  std::uint32_t id = 0;
  std::string name;        ///< "exposure_time_absolute"
  std::uint32_t type = 0;  ///< V4L2_CTRL_TYPE_...
  std::uint32_t flags = 0;
  std::int64_t least = 0, most = 0, step = 1, fallback = 0;
  std::int64_t value = 0;                                  ///< Now.
  std::vector<std::pair<std::int64_t, std::string>> menu;  ///< Of a menu: number and text.

  [[nodiscard]] bool settable() const;
};

/// The controls that hold one number, a switch or a choice.
[[nodiscard]] std::vector<Control> controls_of(const Node& node);

/// The present values as settings of a SOURCE, "brightness=128&gain=0": what can be read and set again.
[[nodiscard]] std::string settings_of(const std::vector<Control>& controls);

/// "Exposure Time, Absolute" -> "exposure_time_absolute", as v4l2-ctl does.
[[nodiscard]] std::string control_name(std::string_view title);

/// Kernels before 5.17 or so had other names ("exposure_auto" for "auto_exposure"): whichever is given is found.
/// @return the name the other spelling has, or the same.
[[nodiscard]] std::string other_spelling(std::string_view name);

/// Sets controls, the switches and choices first, since they make others settable, and reads them back.
/// @param wanted  by name, either spelling; a number, or the text of a menu's entry.
/// @return one line for each that did not take its value.
/// @throws Error (usage) for a name that the device has not, with the nearest, and a value out of range.
std::vector<std::string> set_controls(const Node& node, const std::map<std::string, std::string>& wanted);

}  // namespace choreo::devices::v4l2
