// SPDX-License-Identifier: Apache-2.0
#include "devices/freenect/freenect_library.hpp"

#include <dlfcn.h>

#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo::devices::freenect {
namespace {

// libfreenect's fake, fakenect, lacks these, and so do older versions.
template <typename Function>
Function* optional_function(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_DEFAULT, name));
}

// The library tells a complaint to a function without an argument of ours; each context stays in one thread.
thread_local std::string complaints;

void take_complaint(freenect_context* /*context*/, freenect_loglevel level, const char* text) noexcept {
  constexpr std::size_t kMost = 400;
  if (level > FREENECT_LOG_ERROR || complaints.size() > kMost) return;
  try {
    std::string line(text);
    while (!line.empty() && (line.back() == '\n' || line.back() == ' ')) line.pop_back();
    if (complaints.find(line) != std::string::npos) return;
    complaints += (complaints.empty() ? "" : "; ") + one_line(line);
  } catch (...) {  // No memory for it: the error itself is still told.
  }
}

}  // namespace

const char* const kUsbRemedy =
    "install libfreenect's udev rules (Debian: libfreenect0.5), then plug the Kinect in again";

bool is_about_permission(const std::string& complaint) {
  // -3 is libusb's LIBUSB_ERROR_ACCESS.
  return complaint.find("ERROR_ACCESS") != std::string::npos || complaint.find("camera: -3") != std::string::npos ||
         complaint.find("motor: -3") != std::string::npos;
}

Context::Context() {
  complaints.clear();
  if (const int code = freenect_init(&context_, nullptr); code < 0) {
    throw usage_error(fmt::format("libfreenect cannot use USB here (error {})", code), {},
                      "USB devices must be visible: in a container, pass /dev/bus/usb into it");
  }
  freenect_set_log_callback(context_, take_complaint);
  freenect_set_log_level(context_, FREENECT_LOG_ERROR);
}

Context::~Context() { freenect_shutdown(context_); }

int Context::count() const {
  const int count = freenect_num_devices(context_);
  if (count < 0) throw usage_error("libfreenect cannot search USB for a Kinect", {}, kUsbRemedy);
  return count;
}

std::optional<std::vector<std::string>> Context::serials() const {
  const auto list = optional_function<decltype(freenect_list_device_attributes)>("freenect_list_device_attributes");
  const auto release = optional_function<decltype(freenect_free_device_attributes)>("freenect_free_device_attributes");
  if (list == nullptr || release == nullptr) return std::nullopt;
  freenect_device_attributes* first = nullptr;
  if (list(context_, &first) < 0) return std::nullopt;
  std::vector<std::string> all;
  for (const auto* each = first; each != nullptr; each = each->next) {
    all.emplace_back(each->camera_serial != nullptr ? each->camera_serial : "");
  }
  release(first);
  return all;
}

std::optional<bool> Context::has_motor() const {
  const auto enabled = optional_function<decltype(freenect_enabled_subdevices)>("freenect_enabled_subdevices");
  if (enabled == nullptr) return std::nullopt;
  // The later models move by their audio chip, and the library takes the motor's flag away from them.
  return (enabled(context_) & (FREENECT_DEVICE_MOTOR | FREENECT_DEVICE_AUDIO)) != 0;
}

std::string Context::take_complaints() { return std::exchange(complaints, {}); }

}  // namespace choreo::devices::freenect
