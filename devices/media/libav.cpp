// SPDX-License-Identifier: Apache-2.0
#include "devices/media/libav.hpp"

#include <array>
#include <cstdarg>
#include <cstdio>
#include <mutex>

extern "C" {
#include <libavutil/error.h>
#include <libavutil/log.h>
#include <libavutil/mathematics.h>
}

namespace choreo::devices {
namespace {

std::string& message_of_this_thread() {
  static thread_local std::string message;
  return message;
}

// FFmpeg calls this from its decoder threads as well; nothing here is shared between threads.
void keep_message(void* /*context*/, int level, const char* format, va_list arguments) {
  if (level > AV_LOG_ERROR) return;
  std::array<char, 512> line{};
  std::vsnprintf(line.data(), line.size(), format, arguments);
  std::string text(line.data());
  while (!text.empty() && (text.back() == '\n' || text.back() == '.' || text.back() == ' ')) text.pop_back();
  for (auto& c : text) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  if (!text.empty()) message_of_this_thread() = std::move(text);
}

}  // namespace

std::string libav_error_text(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return text.data();
}

std::optional<Nanoseconds> libav_time(std::int64_t units, AVRational time_base) {
  constexpr std::int64_t kMost = 100LL * 366 * 24 * 3600 * 1'000'000'000;
  if (units == AV_NOPTS_VALUE || time_base.num <= 0 || time_base.den <= 0) return std::nullopt;
  const auto ns = av_rescale_q(units, time_base, AVRational{1, 1'000'000'000});
  if (ns > kMost || ns < -kMost) return std::nullopt;
  return Nanoseconds(ns);
}

void silence_libav() {
  static std::once_flag once;
  std::call_once(once, [] { av_log_set_callback(keep_message); });
}

std::string last_libav_message() { return message_of_this_thread(); }

void forget_libav_message() { message_of_this_thread().clear(); }

}  // namespace choreo::devices
