// SPDX-License-Identifier: Apache-2.0
// What record and live --record share: a source whose frames go into a take as they are read.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cli/console.hpp"
#include "devices/source.hpp"
#include "outputs/take_writer.hpp"

namespace choreo::cli {

/// Gives the frames of another source and a copy of each to a writer.
class RecordedSource final : public devices::Source {
 public:
  /// @param writer  must outlive this.
  RecordedSource(std::unique_ptr<devices::Source> source, outputs::TakeWriter& writer)
      : source_(std::move(source)), writer_(writer) {}

  [[nodiscard]] const devices::SourceInfo& info() const override { return source_->info(); }
  [[nodiscard]] devices::FramePtr read(std::stop_token stop) override {
    auto frame = source_->read(std::move(stop));
    if (frame) writer_.add(frame);
    return frame;
  }
  [[nodiscard]] std::vector<std::string> warnings() const override { return source_->warnings(); }

 private:
  std::unique_ptr<devices::Source> source_;
  outputs::TakeWriter& writer_;
};

/// Program and room for the queue: a quarter of the memory that is free, 64 MB to 2 GB.
[[nodiscard]] outputs::TakeOptions default_take_options();

/// "take.mkv: 300 frames, 0 left out, 10.0 s, colour ffv1, 38.2 MB"
[[nodiscard]] std::string take_line(const std::string& path, const outputs::TakeReport& report);

/// Warns of what is missing from the take.
void warn_of_gaps(const outputs::TakeReport& report, Console& console);

}  // namespace choreo::cli
