// SPDX-License-Identifier: Apache-2.0
#include "devices/v4l2/v4l2_controls.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <system_error>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo::devices::v4l2 {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kSpellings = {{
    {"exposure_auto", "auto_exposure"},
    {"exposure_absolute", "exposure_time_absolute"},
    {"exposure_auto_priority", "exposure_dynamic_framerate"},
    {"white_balance_temperature_auto", "white_balance_automatic"},
    {"focus_auto", "focus_automatic_continuous"},
    {"gain_auto", "gain_automatic"},
    {"hue_auto", "hue_automatic"},
}};

std::int64_t value_of(const Node& node, const Control& control) {
  v4l2_ext_control one{};
  one.id = control.id;
  v4l2_ext_controls all{};
  all.which = V4L2_CTRL_WHICH_CUR_VAL;
  all.count = 1;
  all.controls = &one;
  if (node.call(VIDIOC_G_EXT_CTRLS, &all) != 0) return control.fallback;
  if (control.type == V4L2_CTRL_TYPE_INTEGER64) return one.value64;
  return control.type == V4L2_CTRL_TYPE_BITMASK ? std::int64_t(static_cast<__u32>(one.value)) : one.value;
}

bool holds_a_number(const v4l2_query_ext_ctrl& told) {
  switch (told.type) {
    case V4L2_CTRL_TYPE_INTEGER:
    case V4L2_CTRL_TYPE_BOOLEAN:
    case V4L2_CTRL_TYPE_MENU:
    case V4L2_CTRL_TYPE_INTEGER_MENU:
    case V4L2_CTRL_TYPE_INTEGER64:
    case V4L2_CTRL_TYPE_BITMASK:
    case V4L2_CTRL_TYPE_BUTTON:
      return told.elems <= 1 && (told.flags & V4L2_CTRL_FLAG_DISABLED) == 0;
    default:
      return false;
  }
}

void read_menu(const Node& node, Control& control) {
  for (auto number = control.least; number <= control.most; ++number) {
    v4l2_querymenu entry{};
    entry.id = control.id;
    entry.index = static_cast<__u32>(number);
    if (node.call(VIDIOC_QUERYMENU, &entry) != 0) continue;
    const auto* name = reinterpret_cast<const char*>(entry.name);
    control.menu.emplace_back(number, control.type == V4L2_CTRL_TYPE_INTEGER_MENU
                                          ? std::to_string(entry.value)
                                          : std::string(name, ::strnlen(name, sizeof entry.name)));
  }
}

std::string range_of(const Control& control) {
  if (!control.menu.empty()) {
    std::vector<std::string> entries;
    for (const auto& [number, text] : control.menu) entries.push_back(fmt::format("{} ({})", number, text));
    return "one of " + join(entries);
  }
  if (control.type == V4L2_CTRL_TYPE_BOOLEAN) return "0 or 1";
  return fmt::format("from {} to {}{}", control.least, control.most,
                     control.step > 1 ? fmt::format(" in steps of {}", control.step) : "");
}

std::int64_t parse_value(const Control& control, const std::string& text) {
  for (const auto& [number, entry] : control.menu) {
    if (control_name(entry) == control_name(text)) return number;
  }
  if (control.type == V4L2_CTRL_TYPE_BUTTON) {
    if (text == "1") return 1;
    throw usage_error(fmt::format("{} is \"{}\"", control.name, text), {},
                      fmt::format("{} is a button: {}=1 pushes it", control.name, control.name));
  }
  std::int64_t value = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool number = parsed.ec == std::errc() && parsed.ptr == text.data() + text.size();
  const bool listed = control.menu.empty() || std::any_of(control.menu.begin(), control.menu.end(),
                                                          [&](const auto& entry) { return entry.first == value; });
  if (!number || value < control.least || value > control.most || !listed) {
    throw usage_error(fmt::format("{} is \"{}\"", control.name, text), {},
                      fmt::format("{} is {}", control.name, range_of(control)));
  }
  return value;
}

bool comes_first(const Control& control) {
  return control.type == V4L2_CTRL_TYPE_BOOLEAN || control.type == V4L2_CTRL_TYPE_MENU;
}

}  // namespace

bool Control::settable() const { return (flags & (V4L2_CTRL_FLAG_READ_ONLY | V4L2_CTRL_FLAG_DISABLED)) == 0; }

std::string control_name(std::string_view title) {
  std::string name;
  for (const char c : title) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    } else if (!name.empty() && name.back() != '_') {
      name += '_';
    }
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  return name;
}

std::string other_spelling(std::string_view name) {
  for (const auto& [before, now] : kSpellings) {
    if (name == before) return std::string(now);
    if (name == now) return std::string(before);
  }
  return std::string(name);
}

std::vector<Control> controls_of(const Node& node) {
  std::vector<Control> controls;
  v4l2_query_ext_ctrl told{};
  told.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  for (; node.call(VIDIOC_QUERY_EXT_CTRL, &told) == 0; told.id |= V4L2_CTRL_FLAG_NEXT_CTRL) {
    if (!holds_a_number(told)) continue;
    Control control;
    control.id = told.id;
    control.name = control_name({told.name, ::strnlen(told.name, sizeof told.name)});
    control.type = told.type;
    control.flags = told.flags;
    control.least = told.minimum;
    control.most = told.maximum;
    control.step = static_cast<std::int64_t>(told.step);
    control.fallback = told.default_value;
    if (told.type == V4L2_CTRL_TYPE_MENU || told.type == V4L2_CTRL_TYPE_INTEGER_MENU) read_menu(node, control);
    if ((told.flags & V4L2_CTRL_FLAG_WRITE_ONLY) == 0 && told.type != V4L2_CTRL_TYPE_BUTTON) {
      control.value = value_of(node, control);
    }
    controls.push_back(std::move(control));
  }
  return controls;
}

std::string settings_of(const std::vector<Control>& controls) {
  std::vector<std::string> settings;
  for (const auto& control : controls) {
    const bool readable = control.type != V4L2_CTRL_TYPE_BUTTON && (control.flags & V4L2_CTRL_FLAG_WRITE_ONLY) == 0;
    if (control.settable() && readable) settings.push_back(fmt::format("{}={}", control.name, control.value));
  }
  return join(settings, "&");
}

std::vector<std::string> set_controls(const Node& node, const std::map<std::string, std::string>& wanted) {
  if (wanted.empty()) return {};
  const auto controls = controls_of(node);
  struct Setting {
    const Control* control;
    std::int64_t value;
  };
  std::vector<Setting> settings;
  for (const auto& [name, text] : wanted) {
    const auto is = [&](const Control& c) {
      return c.settable() && (c.name == name || c.name == other_spelling(name));
    };
    const auto found = std::find_if(controls.begin(), controls.end(), is);
    if (found == controls.end()) {
      std::vector<std::string> known;
      for (const auto& c : controls) {
        if (c.settable()) known.push_back(c.name);
      }
      throw usage_error(fmt::format("\"{}\" has no control \"{}\"", node.path(), name), {}, hint_for_name(name, known));
    }
    settings.push_back({&*found, parse_value(*found, text)});
  }
  std::stable_partition(settings.begin(), settings.end(), [](const Setting& s) { return comes_first(*s.control); });
  std::vector<std::string> complaints;
  for (const auto& [control, value] : settings) {
    v4l2_ext_control one{};
    one.id = control->id;
    if (control->type == V4L2_CTRL_TYPE_INTEGER64) {
      one.value64 = value;
    } else {
      one.value = static_cast<__s32>(value);
    }
    v4l2_ext_controls all{};
    all.which = V4L2_CTRL_WHICH_CUR_VAL;
    all.count = 1;
    all.controls = &one;
    if (const int cause = node.call(VIDIOC_S_EXT_CTRLS, &all); cause != 0) {
      complaints.push_back(
          fmt::format("{} could not be set to {}: {}", control->name, value, std::generic_category().message(cause)));
    }
  }
  // Only when all are set: one may have changed another.
  for (const auto& [control, value] : settings) {
    if (control->type == V4L2_CTRL_TYPE_BUTTON || (control->flags & V4L2_CTRL_FLAG_WRITE_ONLY) != 0) continue;
    if (const auto now = value_of(node, *control); now != value) {
      complaints.push_back(fmt::format("{} was set to {} and is {}", control->name, value, now));
    }
  }
  return complaints;
}

}  // namespace choreo::devices::v4l2
