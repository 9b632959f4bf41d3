// SPDX-License-Identifier: Apache-2.0
// Reads a recording of OpenNI2, by way of the helper.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "devices/device_time.hpp"
#include "devices/openni2/connection.hpp"
#include "devices/registry.hpp"

namespace choreo::devices::openni2 {

/// Whether the file begins as a recording of OpenNI2 does. False for what is no plain file or cannot be read.
[[nodiscard]] bool is_recording(const std::string& path);

/// Every picture of a recording once, in order, as fast as it is read: playing at its own speed is the pipeline's work.
///
/// Whoever wants another place opens it anew, as OpenNI2 crashes when it seeks. A recording that OpenNI2 crashes on, or
/// falls silent on, ends there; `warnings` says so.
/// @thread thread-bound
class Recording final : public Source {
 public:
  /// @param request  Action::kRecording, with the streams that are wanted.
  /// @param patience  how long OpenNI2 may stay silent.
  /// @throws Error (usage) where the file cannot be read, is no recording, is damaged from the start, or holds no
  /// frame.
  Recording(const SourceUri& uri, const Request& request, const OpenOptions& options, Nanoseconds patience);

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] FramePtr read(std::stop_token stop) override;
  [[nodiscard]] std::vector<std::string> warnings() const override;

 private:
  [[nodiscard]] FramePtr next(const std::stop_token& stop);
  [[nodiscard]] FramePtr frame_of(const Moment& moment);

  std::string path_;
  Nanoseconds patience_;
  SourceInfo info_;
  std::optional<Connection> connection_;
  FrameMaker maker_;
  FrameCounter counter_;
  FramePtr first_;  // Read when it was opened.
  bool heard_all_ = false;
  std::string broken_;  // Why it ended before its end.
  std::optional<Nanoseconds> last_time_;
  std::size_t delivered_ = 0, mended_ = 0, damaged_ = 0;
  std::vector<std::string> warnings_;
};

}  // namespace choreo::devices::openni2
