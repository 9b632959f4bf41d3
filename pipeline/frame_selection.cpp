// SPDX-License-Identifier: Apache-2.0
#include "pipeline/frame_selection.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo::pipeline {
namespace {

[[noreturn]] void refuse(std::string_view text, std::string_view cause) {
  throw usage_error(fmt::format("span \"{}\" {}", text, cause), {},
                    "write A:B in seconds (1.5:3, half open) or in frames counted from 1 (1f:468f, both ends in)");
}

}  // namespace

FrameSelection parse_span(std::string_view text) {
  FrameSelection selection;
  const auto colon = text.find(':');
  if (colon == std::string_view::npos || text.find(':', colon + 1) != std::string_view::npos) {
    refuse(text, "is not of the form A:B");
  }
  const auto left = text.substr(0, colon);
  const auto right = text.substr(colon + 1);
  if (left.empty() && right.empty()) refuse(text, "has neither beginning nor end");
  const auto is_frame = [](std::string_view s) { return s.ends_with('f'); };
  if (!left.empty() && !right.empty() && is_frame(left) != is_frame(right)) refuse(text, "mixes seconds and frames");

  const auto frame = [&](std::string_view s) {
    const auto number = parse_integer(s.substr(0, s.size() - 1));
    if (!number || *number < 1) refuse(text, "has an end that is not a frame number from 1 on");
    return static_cast<std::uint64_t>(*number);
  };
  const auto time = [&](std::string_view s) {
    try {
      return parse_duration(s);
    } catch (const Error&) {
      refuse(text, "has an end that is no time");
    }
  };
  if (!left.empty()) {
    if (is_frame(left)) {
      selection.first_frame = frame(left);
    } else {
      selection.from = time(left);
    }
  }
  if (!right.empty()) {
    if (is_frame(right)) {
      selection.last_frame = frame(right);
    } else {
      selection.to = time(right);
    }
  }
  if (selection.to <= selection.from || selection.last_frame < selection.first_frame) {
    refuse(text, "ends before it begins");
  }
  return selection;
}

}  // namespace choreo::pipeline
