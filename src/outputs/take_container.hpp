// SPDX-License-Identifier: Apache-2.0
// The Matroska file of a take: grows packet by packet, and is good up to the last of them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "devices/take/take_format.hpp"
#include "outputs/take_encoder.hpp"

namespace choreo::outputs {

/// @thread thread-bound
class TakeContainer {
 public:
  /// Makes the file, empty. What is there already is never touched: it may be all that is left of a rehearsal.
  /// @throws Error (usage) where it cannot be made.
  explicit TakeContainer(std::string path);
  ~TakeContainer();
  TakeContainer(const TakeContainer&) = delete;
  TakeContainer& operator=(const TakeContainer&) = delete;

  /// Writes what precedes the first packet. @param encoders  the tracks, at least one.
  /// @param marks  whether there is a track for marks.
  void begin(const devices::take::FileFacts& facts, std::span<const std::unique_ptr<TakeEncoder>> encoders, bool marks);
  [[nodiscard]] bool has_begun() const { return begun_; }

  /// Appends a picture; the stamp's checksum is filled in here. @param time  since the first frame, not negative.
  /// @param length  how long it is shown.
  void write(AVPacket& packet, devices::take::Stamp stamp, devices::take::Part part, Nanoseconds time,
             Nanoseconds length);
  void write(const std::vector<devices::take::Mark>& marks);
  /// Everything written so far is with the operating system afterwards. All of these throw Error (failure), as on a
  /// full disk; what came before stays readable.
  void flush();
  /// Everything written so far is on the disk afterwards, whatever becomes of the machine.
  void sync();
  /// Writes index and length, and closes the file; it is on the disk then.
  void finish();

 private:
  struct Closer {
    void operator()(AVFormatContext* context) const;
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  [[noreturn]] void give_up(int code) const;
  void append(AVPacket& packet, AVStream& stream);

  std::string path_;
  std::unique_ptr<std::FILE, Closer> file_;  // FFmpeg has one of its own.
  std::unique_ptr<AVFormatContext, Closer> container_;
  std::array<AVStream*, 2> pictures_{};  // By Part.
  AVStream* marks_ = nullptr;
  std::int64_t last_units_ = 0;
  bool begun_ = false;
};

}  // namespace choreo::outputs
