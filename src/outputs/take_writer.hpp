// SPDX-License-Identifier: Apache-2.0
// Records the frames of a source, as the device gave them, while somebody else works with them.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/time.hpp"
#include "devices/source.hpp"
#include "devices/take/take_format.hpp"
#include "outputs/take_container.hpp"
#include "outputs/take_encoder.hpp"

namespace choreo::outputs {

/// What happens to a frame that comes while the queue is full.
enum class FullQueue {
  kLeaveOut,  ///< It is missing from the take, and counted: nobody waits for the disk.
  kWait,      ///< The caller waits.
};

struct TakeOptions {
  bool colour = true;  ///< Keep Frame::raw_colour, or Frame::bgr where there is none.
  bool depth = true;   ///< Likewise; where the source has depth.
  TakeCodec codec = TakeCodec::kAuto;
  bool force = false;  ///< Replace a finished take of this name.
  bool marks = false;  ///< A run will say which frames it processes.
  FullQueue full = FullQueue::kLeaveOut;
  std::size_t queue_bytes = std::size_t{256} << 20U;  ///< Of frames that wait for the encoder.
  std::string program;                                ///< "choreoscope 0.1.0", for the file's tags.
  std::string settings;                               ///< Of the run that will mark frames, likewise.
  std::string if_there = "choose another name";       ///< The hint where a file of this name is there.
  /// Told once, from the writer's thread, where the recording breaks off.
  std::function<void(const std::string&)> on_trouble = {};
};

struct TakeReport {
  std::uint64_t frames = 0;             ///< In the file.
  std::uint64_t left_out = 0;           ///< Because the queue was full.
  std::uint64_t processed_missing = 0;  ///< Of these, frames that the run processed.
  std::uint64_t without_depth = 0;      ///< Frames whose depth came too late to be among the tracks.
  std::uint64_t gaps = 0;               ///< Frames that the source itself had lost, by its sequence numbers.
  Nanoseconds length{0};                ///< From the first frame to the last.
  std::uintmax_t bytes = 0;             ///< Of the file.
  std::string codecs;                   ///< "colour ffv1, depth ffv1"
};

/// A take being recorded.
///
/// It grows as NAME.unfinished.mkv, which any player and choreoscope itself can read at any moment, also after a crash
/// or on a full disk; `close` renames it to NAME.mkv. Pictures are encoded and written in a thread of its own.
/// @thread thread-safe
class TakeWriter {
 public:
  /// @param path    ends in .mkv.
  /// @param source  whose frames come.
  /// @throws Error (usage) where the name does not do, or is taken and not to be replaced, or the place cannot be
  ///   written to or has no room for a second of raw pictures.
  TakeWriter(std::string path, const devices::SourceInfo& source, TakeOptions options);
  /// Closes, where nobody has; nobody hears of what fails.
  ~TakeWriter();
  TakeWriter(const TakeWriter&) = delete;
  TakeWriter& operator=(const TakeWriter&) = delete;

  /// Takes a frame; with FullQueue::kWait it may wait, at most a minute. Frames come with rising sequence numbers and
  /// times.
  void add(devices::FramePtr frame);
  /// The run has brought this frame to its end; called with rising sequence numbers.
  void processed(std::uint64_t sequence);
  /// A search for faces, for people that was due at this frame was not done; called before the frame is `processed`.
  void late_face(std::uint64_t sequence) { mark(devices::take::kLateFaceMark, sequence); }
  void late_person(std::uint64_t sequence) { mark(devices::take::kLatePersonMark, sequence); }

  /// Writes what waits, finishes the file and gives it its name. Without frames there is no file.
  /// @throws Error (failure) where the recording broke off; what came before is in the unfinished file.
  TakeReport close();

  /// Ends it, and leaves no file.
  void discard();

  /// NAME.unfinished.mkv for NAME.mkv.
  [[nodiscard]] static std::string unfinished(const std::string& path);

 private:
  void mark(const char* kind, std::uint64_t sequence);
  void work();
  void write_waiting();
  void hold_or_write(devices::FramePtr frame);
  void write_held();
  void write(const devices::Frame& frame);
  void begin(const devices::Frame& frame);
  [[nodiscard]] TakeCodec measured(const devices::Frame& frame) const;
  void stop();

  std::string path_;
  devices::SourceInfo source_;
  TakeOptions options_;

  // The worker's.
  std::unique_ptr<TakeContainer> container_;
  std::vector<std::unique_ptr<TakeEncoder>> encoders_;
  std::vector<devices::FramePtr> held_;  // Until it is known which tracks there are.
  std::optional<Nanoseconds> first_;
  std::optional<Nanoseconds> last_;
  std::optional<std::uint64_t> last_sequence_;
  std::chrono::steady_clock::time_point synced_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<devices::FramePtr> waiting_;
  std::size_t waiting_bytes_ = 0;
  std::vector<devices::take::Mark> marks_;  // Not written yet.
  std::deque<std::uint64_t> left_out_;      // Whose fate is not known.
  bool ending_ = false;
  std::exception_ptr problem_;
  TakeReport report_;
  bool closed_ = false;
  std::thread thread_;
};

}  // namespace choreo::outputs
