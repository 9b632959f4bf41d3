// SPDX-License-Identifier: Apache-2.0
// Runs the program that touches OpenNI2, and hears it.
#pragma once

#include <sys/types.h>

#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/time.hpp"
#include "devices/openni2/protocol.hpp"

namespace choreo::devices::openni2 {

/// A file descriptor that is closed by itself.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() { reset(); }
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  [[nodiscard]] int number() const { return number_; }
  void reset();

 private:
  int number_;
};

/// The helper ended, crashed, or said what it never says; it is not to be spoken to any more.
class HelperGone : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The helper and the memory it shares with us.
///
/// It ends when its end of the socket does, so that it outlives neither this object nor this process, however that
/// ends. (PR_SET_PDEATHSIG would ask the thread that started it to live as long.)
/// @thread thread-bound
class HelperProcess {
 public:
  /// Starts the helper and sends the request.
  /// @param recording  what Action::kRecording reads.
  /// @throws Error (usage) where there is no helper; Error (failure) where it cannot be started.
  explicit HelperProcess(const Request& request, const Descriptor& recording = Descriptor());
  /// A device is given a second to be closed; then, as a recording at once, the helper is killed.
  ~HelperProcess();
  HelperProcess(const HelperProcess&) = delete;
  HelperProcess& operator=(const HelperProcess&) = delete;

  /// The next message; nothing where none comes within `patience`.
  /// @throws HelperGone
  [[nodiscard]] std::optional<Message> next(Nanoseconds patience);

  /// The pixels of a picture, which the helper, if it is mad, may change at any time: copy first.
  [[nodiscard]] std::span<const std::uint8_t> pixels(const Picture& picture) const;
  void release(const Picture& picture);

  /// Of the helper, for tests.
  [[nodiscard]] pid_t process() const { return process_; }

 private:
  void start(const std::string& program, const Descriptor& far_end, const Descriptor& recording);
  void send(const Message& message);
  [[nodiscard]] std::optional<int> reap(Nanoseconds patience);
  [[nodiscard]] std::string told_of_end();

  bool gentle_;
  Descriptor socket_;
  Descriptor memory_file_;
  std::uint8_t* memory_ = nullptr;
  pid_t process_ = -1;
};

/// Where the helper is: CHOREO_OPENNI2_HELPER, else beside this program, else where it is installed.
/// @throws Error (usage) where it is nowhere.
[[nodiscard]] std::string helper_program();

}  // namespace choreo::devices::openni2
