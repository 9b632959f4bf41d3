// SPDX-License-Identifier: Apache-2.0
// A take as a file: its tracks, and its frames still encoded.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "devices/media/byte_input.hpp"
#include "devices/media/libav.hpp"
#include "devices/take/take_format.hpp"

namespace choreo::devices::take {

/// What a run that recorded the take did with a frame.
enum class Fate { kUnknown, kProcessed, kOvertaken };

/// A frame as the file has it: by Part, a packet or null.
struct StoredFrame {
  Stamp stamp;
  std::array<Libav<AVPacket>, 2> packets;

  [[nodiscard]] bool is_whole() const {
    return (packets[0] != nullptr) == ((stamp.parts & Stamp::kColour) != 0) &&
           (packets[1] != nullptr) == ((stamp.parts & Stamp::kDepth) != 0);
  }
};

/// Whether a file says that it is a take, by a look at its beginning.
[[nodiscard]] bool looks_like_take(const std::string& path);

/// Reads the frames of a take in order. What is damaged is left out and counted.
/// @thread thread-bound
class TakeFile {
 public:
  /// @throws Error (usage) where the file cannot be read or is no take; (failure) where `stop` was requested.
  TakeFile(const std::string& path, std::stop_token stop);
  TakeFile(const TakeFile&) = delete;  // FFmpeg keeps pointers to members.
  TakeFile& operator=(const TakeFile&) = delete;

  [[nodiscard]] const FileFacts& facts() const { return facts_; }
  /// The tracks of pictures, by Part.
  [[nodiscard]] const std::optional<StreamFacts>& stream(Part part) const { return streams_[std::size_t(part)].facts; }
  [[nodiscard]] const AVCodecParameters& parameters(Part part) const;
  /// A run recorded it and marked the frames that it processed.
  [[nodiscard]] bool has_marks() const { return marks_index_ >= 0; }
  [[nodiscard]] bool is_regular_file() const { return bytes_.is_regular(); }
  /// Nothing where the recording was never finished.
  [[nodiscard]] std::optional<Nanoseconds> declared_duration() const;

  /// The next whole frame; nothing at the end, or when `stop` was requested.
  /// @param want_fate  read on until the frame's fate is known.
  [[nodiscard]] std::optional<StoredFrame> next(const std::stop_token& stop, bool want_fate);
  /// Of the frame that `next` gave last.
  [[nodiscard]] Fate fate() const { return fate_; }
  /// Likewise, where its fate was wanted: the run marked it as one at which a search for faces, for people was late.
  [[nodiscard]] bool late_face() const { return late_face_; }
  [[nodiscard]] bool late_person() const { return late_person_; }

  [[nodiscard]] std::uint64_t damaged() const { return damaged_; }
  /// Of the last picture that was read, since the first, to 1 ms.
  [[nodiscard]] Nanoseconds last_time() const { return last_time_; }
  [[nodiscard]] bool ended() const { return ended_; }
  /// Frames of unknown fate that had to be given up waiting for.
  [[nodiscard]] bool lost_marks() const { return lost_marks_; }
  /// FFmpeg's error that ended reading; 0 where the end was reached in order.
  [[nodiscard]] int read_error() const { return read_error_; }

 private:
  struct Track {
    std::optional<StreamFacts> facts;
    int index = -1;
  };

  void find_tracks();
  [[nodiscard]] bool pull();
  void add_picture(Libav<AVPacket> packet, Part part);
  void add_marks(const AVPacket& packet);
  [[nodiscard]] Fate fate_of(std::uint64_t sequence) const;

  std::string path_;
  std::stop_token open_stop_;
  std::stop_token read_stop_;
  ByteInput bytes_;  // Before the container, which reads from it until it is closed.
  Libav<AVFormatContext> container_;
  FileFacts facts_;
  std::array<Track, 2> streams_;
  int marks_index_ = -1;

  std::deque<StoredFrame> frames_;  // The last one may still miss a packet.
  std::size_t waiting_bytes_ = 0;   // Of frames_.
  std::optional<Stamp> last_;
  std::set<std::uint64_t> processed_;  // Marked, and not given yet.
  std::set<std::uint64_t> late_faces_, late_people_;
  std::optional<std::uint64_t> last_marked_;
  Fate fate_ = Fate::kUnknown;
  bool late_face_ = false, late_person_ = false;
  std::uint64_t damaged_ = 0;
  std::uint64_t lost_parts_ = 0;  // Of these, blocks whose frame is unknown.
  Nanoseconds last_time_{0};
  bool ended_ = false;
  bool lost_marks_ = false;
  int read_error_ = 0;
};

}  // namespace choreo::devices::take
