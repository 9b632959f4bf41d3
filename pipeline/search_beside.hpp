// SPDX-License-Identifier: Apache-2.0
// Searches that are done beside the frames' own way and take effect later, at a frame that is known before.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace choreo::pipeline {

/// One search after another, in a thread of its own and behind everything else.
///
/// A search that is asked for at one frame takes effect at the first frame at or behind the time when it is due; where
/// it is late, at a later frame or never. So results depend on the frames and on which searches were late where, and on
/// nothing else. Times are counted by who asks: in frames, say, or in nanoseconds of the frames' own time.
/// @thread thread-bound; one thread asks, and counts the frames.
class SearchBeside {
 public:
  /// What becomes of a search that is not done when it is due.
  enum class WhenLate {
    kVoid,   ///< It has no effect.
    kDefer,  ///< It is due again at the next frame.
  };

  /// @param thread  its name, at most 15 characters.
  /// @param waits  frames wait for a search that is due; else it is late.
  SearchBeside(std::string thread, bool waits, WhenLate when_late);
  /// After the search that is going on.
  ~SearchBeside();
  SearchBeside(const SearchBeside&) = delete;
  SearchBeside& operator=(const SearchBeside&) = delete;

  enum class Due { kNothing, kDone, kLate };

  /// A frame begins. @return what becomes of the eldest search that was asked for: it is not due, it is done, or it is
  /// late.
  /// @param was_late  what is due counts as late, though it may be done: it was so in the run that is replayed.
  /// @throws what a search threw that is due or was void.
  [[nodiscard]] Due begin_frame(std::int64_t now, bool was_late);

  /// Asks for a search at the frame that began last; at most one a frame, each due later than the one before. What it
  /// writes to may be read where it is done. Where it is late it may still be running: what it writes to must be its
  /// own.
  void ask(std::function<void()> search, std::int64_t due);

  [[nodiscard]] std::uint64_t asked() const { return asked_; }  ///< Searches so far.
  [[nodiscard]] std::uint64_t late() const { return late_; }    ///< Frames at which one was late.

 private:
  struct Job;

  void work(const std::string& name);

  bool waits_;
  WhenLate when_late_;
  std::uint64_t asked_ = 0, late_ = 0;
  std::deque<std::shared_ptr<Job>> pending_;  // Asked for, and not due yet.

  std::mutex mutex_;  // Of what follows, and of the jobs.
  std::condition_variable changed_;
  std::deque<std::shared_ptr<Job>> waiting_;
  std::exception_ptr problem_;  // Of a search that was void.
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace choreo::pipeline
