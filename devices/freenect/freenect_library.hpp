// SPDX-License-Identifier: Apache-2.0
// Owners of what libfreenect hands out, and those of its functions that not every build of it has.
#pragma once

#include <libfreenect.h>

#include <optional>
#include <string>
#include <vector>

namespace choreo::devices::freenect {

/// The library's use of USB. What it would print goes to `complaints`.
/// @thread thread-bound
class Context {
 public:
  /// @throws Error (usage) where the library cannot use USB.
  Context();
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  [[nodiscard]] freenect_context* get() const { return context_; }

  /// How many Kinects are plugged in, whether they can be opened or not.
  /// @throws Error (usage) where USB cannot be searched.
  [[nodiscard]] int count() const;

  /// The serial numbers of those that can be opened; nothing where the library cannot tell.
  [[nodiscard]] std::optional<std::vector<std::string>> serials() const;

  /// Whether the motor and the LED of the device opened last can be had; nothing where the library cannot tell.
  [[nodiscard]] std::optional<bool> has_motor() const;

  /// The library's errors since the last call, in one line.
  [[nodiscard]] std::string take_complaints();

 private:
  freenect_context* context_ = nullptr;
};

/// What to do where USB devices may not be opened, one line.
extern const char* const kUsbRemedy;

/// Whether the library's complaint is about a permission.
[[nodiscard]] bool is_about_permission(const std::string& complaint);

}  // namespace choreo::devices::freenect
