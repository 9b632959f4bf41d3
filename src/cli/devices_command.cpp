// SPDX-License-Identifier: Apache-2.0
// choreoscope devices: what is plugged in, how it is opened, and what keeps the rest from being used.
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cli/commands.hpp"
#include "cli/drivers.hpp"
#include "core/text.hpp"
#include "pipeline/person_models.hpp"
#include "pipeline/steady_clock.hpp"

namespace choreo::cli {
namespace {

using devices::DeviceControl;
using devices::DeviceEntry;
using devices::DeviceMode;
using devices::DeviceSetting;
using nlohmann::ordered_json;

constexpr auto kDevicesManual = R"(
A line a device is the SOURCE that opens it, by a name that stays when it is
plugged in elsewhere or among others. Below it: its name, its modes, its
controls with their ranges and present values, and what else can be set, with
what it is where it is not. Modes and controls are settings of the SOURCE:
  choreoscope live 'v4l2:///dev/video0?size=1280x720&fps=60&format=MJPG'
  choreoscope live 'v4l2:///dev/video0?auto_exposure=1&exposure_time_absolute=120'

What a missing library or permission keeps from being used is listed with what
to install or do. See docs/devices.md. Below them stand the files of the person
network (docs/people.md).

Exit status: 0, also where nothing is plugged in.)";

std::string rates_of(const DeviceMode& mode) {
  std::vector<std::string> rates;
  for (const double fps : mode.fps) rates.push_back(fmt::format("{:.4g}", fps));
  return rates.empty() ? "" : " at " + join(rates);
}

// A line a format: "MJPG  1920x1080 at 30; 640x480 at 60, 30".
std::vector<std::string> mode_lines(const std::vector<DeviceMode>& modes) {
  std::vector<std::string> formats;
  std::map<std::string, std::string> sizes;
  for (const auto& mode : modes) {
    auto& line = sizes[mode.format];
    if (line.empty()) formats.push_back(mode.format);
    line += fmt::format("{}{}x{}", line.empty() ? "" : "; ", mode.size.width, mode.size.height);
    if (!mode.up_to.empty()) line += fmt::format(" to {}x{}", mode.up_to.width, mode.up_to.height);
    line += rates_of(mode);
  }
  std::vector<std::string> lines;
  for (const auto& format : formats) lines.push_back(fmt::format("{:<5} {}", format, sizes[format]));
  return lines;
}

std::string line_of(const DeviceControl& control) {
  std::string range;
  if (control.choices.empty()) {
    range = fmt::format("{} to {}{}, default {}", control.least, control.most,
                        control.step > 1 ? fmt::format(" in steps of {}", control.step) : "", control.fallback);
  } else {
    std::vector<std::string> choices;
    for (const auto& [number, text] : control.choices) choices.push_back(fmt::format("{} {}", number, text));
    range = join(choices);
  }
  return fmt::format("{}={}  ({})", control.name, control.value, range);
}

std::string line_of(const DeviceSetting& setting) {
  const auto range = setting.choices.empty() ? fmt::format("{:g} to {:g} {}", setting.least, setting.most, setting.unit)
                                             : join(setting.choices);
  return fmt::format("{}{}{}  ({})", setting.name, setting.fallback.empty() ? "" : "=", setting.fallback, range);
}

// What devices say of themselves is any bytes, and none of them shall reach a terminal as they are.
void print(std::string_view before, const std::string& text) {
  if (!text.empty()) fmt::print("{}{}\n", before, one_line(text));
}

void print(const DeviceEntry& device) {
  print("", device.source);
  print("  ", device.name);
  for (const auto& line : mode_lines(device.modes)) print("  ", line);
  for (const auto& control : device.controls) print("  ", line_of(control));
  for (const auto& setting : device.settings) print("  ", line_of(setting));
  print("  cannot be used: ", device.trouble);
  print("  ", device.remedy);
}

ordered_json json_of(const std::string& driver, const DeviceEntry& device) {
  ordered_json out = {{"source", device.source}, {"driver", driver}, {"name", device.name}};
  auto& modes = out["modes"] = ordered_json::array();
  for (const auto& mode : device.modes) {
    ordered_json one = {{"format", mode.format}, {"width", mode.size.width}, {"height", mode.size.height}};
    if (!mode.up_to.empty()) one["up_to"] = {{"width", mode.up_to.width}, {"height", mode.up_to.height}};
    one["fps"] = mode.fps;
    modes.push_back(std::move(one));
  }
  auto& controls = out["controls"] = ordered_json::array();
  for (const auto& control : device.controls) {
    ordered_json one = {{"name", control.name}, {"min", control.least},        {"max", control.most},
                        {"step", control.step}, {"default", control.fallback}, {"value", control.value}};
    for (const auto& [number, text] : control.choices) one["choices"].push_back({{"value", number}, {"text", text}});
    controls.push_back(std::move(one));
  }
  auto& settings = out["settings"] = ordered_json::array();
  for (const auto& setting : device.settings) {
    ordered_json one = {{"name", setting.name}};
    if (setting.choices.empty()) {
      one["min"] = setting.least;
      one["max"] = setting.most;
      one["unit"] = setting.unit;
    } else {
      one["choices"] = setting.choices;
    }
    if (!setting.fallback.empty()) one["default"] = setting.fallback;
    settings.push_back(std::move(one));
  }
  out["trouble"] = device.trouble;
  out["remedy"] = device.remedy;
  return out;
}

// Beside the cameras: what looks at their pictures.
void list_models(bool as_json, ordered_json& all) {
  const auto folder = std::filesystem::path(pipeline::usual_models_folder());
  auto& list = all["models"] = ordered_json::array();
  bool all_work = true;
  std::vector<std::string> lines;
  for (std::size_t k = 0; k < pipeline::kPersonModels.size(); ++k) {
    const auto& model = pipeline::kPersonModels[k];
    const auto path = (folder / model.file).string();
    std::error_code problem;
    const bool is_there = std::filesystem::is_regular_file(path, problem);
    const auto trouble = is_there ? pipeline::trouble_with_person_model(k, path) : "";
    all_work = all_work && is_there && trouble.empty();
    list.push_back({{"file", path},
                    {"summary", model.summary},
                    {"origin", pipeline::kPersonModelsOrigin},
                    {"is_there", is_there},
                    {"trouble", trouble}});
    lines.push_back(trouble.empty() ? fmt::format("  {}{}  ({})", is_there ? "" : "missing: ", path, model.summary)
                                    : "  cannot be used: " + trouble);
  }
  if (as_json) return;
  fmt::print("person network: {}\n", pipeline::kPersonModelsOrigin);
  for (const auto& line : lines) fmt::print("{}\n", one_line(line));
  if (!all_work) fmt::print("  {}\n", pipeline::kPersonModelsRemedy);
}

int list_devices(bool as_json) {
  const pipeline::SteadyClock clock;
  const auto registry = all_drivers(clock);
  ordered_json all = {{"devices", ordered_json::array()}, {"troubles", ordered_json::array()}};
  std::size_t found = 0;
  for (const auto& driver : registry.drivers()) {
    if (!driver.list) continue;
    const auto list = driver.list();
    found += list.devices.size();
    for (const auto& device : list.devices) {
      if (as_json) {
        all["devices"].push_back(json_of(driver.scheme, device));
      } else {
        print(device);
      }
    }
    if (list.trouble.empty()) continue;
    if (as_json) {
      all["troubles"].push_back({{"driver", driver.scheme}, {"trouble", list.trouble}, {"remedy", list.remedy}});
    } else {
      print(driver.scheme + ": ", list.trouble);
      print("  ", list.remedy);
    }
  }
  if (!as_json && found == 0) fmt::print("no device is plugged in\n");
  list_models(as_json, all);
  if (as_json) {
    // Names of devices are any bytes.
    fmt::print("{}\n", all.dump(2, ' ', false, ordered_json::error_handler_t::replace));
  }
  return kDone;
}

}  // namespace

void declare_devices(CLI::App& app, Command& chosen) {
  auto as_json = std::make_shared<bool>(false);
  auto* command =
      app.add_subcommand("devices", "list the cameras and depth cameras that are plugged in, and the person network");
  command->add_flag("--json", *as_json, "for programs");
  command->footer(kDevicesManual);
  command->callback([as_json, &chosen] { chosen = [as_json](Session&) { return list_devices(*as_json); }; });
}

}  // namespace choreo::cli
