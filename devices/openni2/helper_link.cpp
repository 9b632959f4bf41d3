// SPDX-License-Identifier: Apache-2.0
#include "devices/openni2/helper_link.hpp"

#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>

#include <cerrno>
#include <stdexcept>
#include <variant>

namespace choreo::devices::openni2 {

HelperLink::HelperLink() {
  auto* memory = ::mmap(nullptr, kSlots * kSlotBytes, PROT_READ | PROT_WRITE, MAP_SHARED, kMemoryDescriptor, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("no shared memory");
  memory_ = static_cast<std::uint8_t*>(memory);
}

void HelperLink::send(const Message& message) {
  const auto bytes = encode(message);
  const std::scoped_lock lock(mutex_);
  // It blocks where choreoscope does not listen, and fails where it is gone: either is noticed elsewhere.
  (void)::send(kSocketDescriptor, bytes.data(), bytes.size(), MSG_NOSIGNAL);
}

std::optional<Message> HelperLink::receive(int milliseconds) {
  for (;; milliseconds = 0) {
    pollfd ready{kSocketDescriptor, POLLIN, 0};
    if (::poll(&ready, 1, milliseconds) <= 0) return std::nullopt;
    std::array<std::uint8_t, kMostMessage> bytes{};
    const auto got = ::recv(kSocketDescriptor, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return std::nullopt;
    closed_ = got <= 0;
    if (closed_) return std::nullopt;
    auto message = decode({bytes.data(), static_cast<std::size_t>(got)});
    const auto* release = std::get_if<Release>(&message);
    if (release == nullptr) return message;
    taken_[release->slot] = false;
  }
}

std::optional<std::uint32_t> HelperLink::free_slot() const {
  for (std::uint32_t k = 0; k < kSlots; ++k) {
    if (!taken_[k]) return k;
  }
  return std::nullopt;
}

std::span<std::uint8_t> HelperLink::slot(std::uint32_t number) { return {memory_ + number * kSlotBytes, kSlotBytes}; }

void HelperLink::send_picture(const Picture& picture) {
  taken_[picture.slot] = true;
  send(picture);
}

}  // namespace choreo::devices::openni2
