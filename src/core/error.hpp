// SPDX-License-Identifier: Apache-2.0
// What a user or the world can cause, as one exception type.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "core/text.hpp"

namespace choreo {

/// Who can mend it, which is also the exit status of the program.
enum class Fault {
  kFailure = 1,  ///< The world failed while running: disk full, a frame size that changes midway.
  kUsage = 2,    ///< What was asked for cannot be done: a missing file, a value out of range.
};

/// The one exception for everything that a user or the world can cause.
///
/// `what` is one line without a full stop that names the value in quotes, `where` is the file, file:line:column or
/// option it came from (may be empty), `hint` is what would be right (may be empty). Names that people gave may contain
/// anything: all three are made `one_line`. Bugs of our own are asserts.
class Error : public std::runtime_error {
 public:
  Error(Fault fault, const std::string& what, const std::string& where = {}, const std::string& hint = {})
      : std::runtime_error(one_line(where.empty() ? what : where + ": " + what)),
        fault_(fault),
        where_(one_line(where)),
        hint_(one_line(hint)) {}

  [[nodiscard]] Fault fault() const noexcept { return fault_; }
  [[nodiscard]] const std::string& where() const noexcept { return where_; }
  [[nodiscard]] const std::string& hint() const noexcept { return hint_; }

 private:
  Fault fault_;
  std::string where_;
  std::string hint_;
};

[[nodiscard]] inline Error usage_error(const std::string& what, const std::string& where = {},
                                       const std::string& hint = {}) {
  return {Fault::kUsage, what, where, hint};
}

[[nodiscard]] inline Error failure(const std::string& what, const std::string& where = {},
                                   const std::string& hint = {}) {
  return {Fault::kFailure, what, where, hint};
}

}  // namespace choreo
