// SPDX-License-Identifier: Apache-2.0
#include "support/loopback_server.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>

namespace choreo::test {
namespace {

// How soon a thread sees that the server closes.
constexpr int kSliceMs = 10;

}  // namespace

std::string Caller::request() {
  std::string text;
  while (!closing_ && text.find("\r\n\r\n") == std::string::npos) {
    pollfd ready{socket_, POLLIN, 0};
    if (::poll(&ready, 1, kSliceMs) == 0) continue;
    char byte = 0;
    if (::recv(socket_, &byte, 1, 0) != 1) break;
    text += byte;
  }
  return text;
}

bool Caller::send(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty() && !closing_) {
    pollfd ready{socket_, POLLOUT, 0};
    if (::poll(&ready, 1, kSliceMs) == 0) continue;
    const auto count = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return !closing_;
}

bool Caller::wait(std::chrono::milliseconds time) {
  const auto until = std::chrono::steady_clock::now() + time;
  while (!closing_) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - std::chrono::steady_clock::now()).count();
    if (left <= 0) return true;
    pollfd gone{socket_, POLLRDHUP, 0};
    if (::poll(&gone, 1, static_cast<int>(std::min<std::int64_t>(left, kSliceMs))) > 0) return false;
  }
  return false;
}

void Caller::wait_for_the_end() {
  while (wait(std::chrono::milliseconds(1000))) continue;
}

LoopbackServer::LoopbackServer(std::function<void(Caller&)> serve, int port) : serve_(std::move(serve)) {
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int yes = 1;
  (void)::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  socklen_t size = sizeof address;
  auto* any = reinterpret_cast<sockaddr*>(&address);
  if (listener_ < 0 || ::bind(listener_, any, size) != 0 || ::listen(listener_, 16) != 0 ||
      ::getsockname(listener_, any, &size) != 0) {
    ::close(listener_);
    throw std::runtime_error("no local server");
  }
  port_ = ntohs(address.sin_port);
  acceptor_ = std::thread([this] { accept_callers(); });
}

LoopbackServer::~LoopbackServer() {
  closing_ = true;
  acceptor_.join();
  ::close(listener_);
  for (auto& thread : threads_) thread.join();
}

void LoopbackServer::accept_callers() {
  while (!closing_) {
    pollfd ready{listener_, POLLIN, 0};
    if (::poll(&ready, 1, kSliceMs) <= 0) continue;
    const int socket = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (socket < 0) continue;
    ++callers_;
    threads_.emplace_back([this, socket] {
      Caller caller(socket, closing_);
      serve_(caller);
      ::close(socket);
    });
  }
}

int deserted_port() {
  return LoopbackServer([](Caller&) {}).port();
}

}  // namespace choreo::test
