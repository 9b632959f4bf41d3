// SPDX-License-Identifier: Apache-2.0
#include "cli/take_recording.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "cli/memory.hpp"

namespace choreo::cli {

outputs::TakeOptions default_take_options() {
  constexpr std::uint64_t kLeast = 64ULL << 20U;
  constexpr std::uint64_t kMost = 2ULL << 30U;
  outputs::TakeOptions options;
  options.program = std::string("choreoscope ") + CHOREO_VERSION;
  options.queue_bytes = std::size_t(std::clamp(available_memory().value_or(0) / 4, kLeast, kMost));
  return options;
}

std::string take_line(const std::string& path, const outputs::TakeReport& report) {
  return fmt::format("{}: {} frame{}, {} left out, {:.1f} s, {}, {:.1f} MB", path, report.frames,
                     report.frames == 1 ? "" : "s", report.left_out, to_seconds(report.length), report.codecs,
                     1e-6 * double(report.bytes));
}

void warn_of_gaps(const outputs::TakeReport& report, Console& console) {
  if (report.left_out > 0) {
    console.warn(fmt::format(
        "the take lacks {} frame{} that could not be written fast enough{}: record to a faster disk, or fewer pixels",
        report.left_out, report.left_out == 1 ? "" : "s",
        report.processed_missing > 0
            ? fmt::format(", {} of which the run processed, and will not replay as it was", report.processed_missing)
            : ""));
  }
  if (report.without_depth > 0) {
    console.warn(fmt::format("the depth of {} frames came too late to be recorded: its first was not there after 1 s",
                             report.without_depth));
  }
  if (report.gaps > 0) {
    console.warn(fmt::format("the source itself lost {} frame{}", report.gaps, report.gaps == 1 ? "" : "s"));
  }
}

}  // namespace choreo::cli
