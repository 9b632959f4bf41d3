// SPDX-License-Identifier: Apache-2.0
#include "devices/media/byte_input.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <new>
#include <system_error>

#include <fmt/format.h>

#include "core/error.hpp"
#include "devices/media/libav.hpp"

namespace choreo::devices {
namespace {

constexpr int kBufferBytes = 64 * 1024;

std::string system_text(int number) { return std::generic_category().message(number); }

}  // namespace

ByteInput::ByteInput(const std::string& path, std::function<bool()> stopped) : stopped_(std::move(stopped)) {
  // Not blocking, so that a FIFO without a writer opens; it makes no difference to regular files.
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
  if (descriptor_ < 0) {
    const int number = errno;
    throw usage_error(fmt::format("\"{}\" cannot be read: {}", path, system_text(number)), {},
                      number == EACCES ? "ask for permission to read it, or run as a user who may" : "");
  }
  // From here on the destructor does not run for a throw.
  struct stat status {};
  std::string problem;
  if (::fstat(descriptor_, &status) != 0) {
    problem = fmt::format("\"{}\" cannot be read: {}", path, system_text(errno));
  } else if (S_ISDIR(status.st_mode)) {
    problem = fmt::format("\"{}\" is a folder, not a video file", path);
  } else if (S_ISREG(status.st_mode) && status.st_size == 0) {
    problem = fmt::format("\"{}\" is empty", path);
  }
  if (!problem.empty()) {
    ::close(descriptor_);
    throw usage_error(problem, {}, "give a video file such as clip.mp4, or a folder of numbered images");
  }
  regular_ = S_ISREG(status.st_mode);
  const bool seekable = ::lseek(descriptor_, 0, SEEK_CUR) >= 0 && (regular_ || S_ISBLK(status.st_mode));

  auto* buffer = static_cast<unsigned char*>(av_malloc(kBufferBytes));
  context_ = buffer == nullptr ? nullptr
                               : avio_alloc_context(buffer, kBufferBytes, 0, this, &ByteInput::read_bytes, nullptr,
                                                    seekable ? &ByteInput::seek : nullptr);
  if (context_ == nullptr) {
    av_free(buffer);
    ::close(descriptor_);
    throw std::bad_alloc();
  }
}

ByteInput::~ByteInput() {
  av_freep(&context_->buffer);
  avio_context_free(&context_);
  ::close(descriptor_);
}

int ByteInput::read_bytes(void* self, unsigned char* buffer, int size) {
  auto& input = *static_cast<ByteInput*>(self);
  for (;;) {
    if (input.stopped_()) return AVERROR_EXIT;
    if (!input.regular_) {
      // A FIFO that nobody has opened for writing yet reads as ended, but polls as silent.
      pollfd waiting{input.descriptor_, POLLIN, 0};
      const int ready = ::poll(&waiting, 1, 100);
      if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
      if (ready < 0) return AVERROR(errno);
    }
    const auto count = ::read(input.descriptor_, buffer, static_cast<std::size_t>(size));
    if (count > 0) return static_cast<int>(count);
    if (count == 0) return AVERROR_EOF;
    if (errno != EINTR && errno != EAGAIN) return AVERROR(errno);
  }
}

std::int64_t ByteInput::seek(void* self, std::int64_t offset, int whence) {
  const auto& input = *static_cast<ByteInput*>(self);
  if ((whence & AVSEEK_SIZE) != 0) {
    struct stat status {};
    return ::fstat(input.descriptor_, &status) == 0 && status.st_size > 0 ? status.st_size : AVERROR(ENOSYS);
  }
  const auto position = ::lseek(input.descriptor_, offset, whence & ~AVSEEK_FORCE);
  return position >= 0 ? position : AVERROR(errno);
}

}  // namespace choreo::devices
