// SPDX-License-Identifier: Apache-2.0
// The bytes of a local file or pipe for FFmpeg, without ever blocking past a stop request.
#pragma once

#include <functional>
#include <memory>
#include <string>

struct AVIOContext;

namespace choreo::devices {

/// An open local file, FIFO or device as FFmpeg reads it.
///
/// FFmpeg's own "file:" protocol would block in open() on a FIFO nobody writes to, and in read() on a silent one,
/// without asking its interrupt callback; and its image2 demuxer would take "%d" in a name for a pattern.
/// @thread thread-bound
class ByteInput {
 public:
  /// @param stopped  asked about ten times a second while waiting for bytes; true ends the wait.
  /// @throws Error (usage) where the path is missing, a folder, not permitted, or an empty file.
  ByteInput(const std::string& path, std::function<bool()> stopped);
  ~ByteInput();
  ByteInput(const ByteInput&) = delete;
  ByteInput& operator=(const ByteInput&) = delete;

  [[nodiscard]] AVIOContext* context() const { return context_; }
  /// A regular file: the same bytes every time it is opened.
  [[nodiscard]] bool is_regular() const { return regular_; }

 private:
  static int read_bytes(void* self, unsigned char* buffer, int size);
  static std::int64_t seek(void* self, std::int64_t offset, int whence);

  int descriptor_ = -1;
  bool regular_ = false;
  std::function<bool()> stopped_;
  AVIOContext* context_ = nullptr;
};

}  // namespace choreo::devices
