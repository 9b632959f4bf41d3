// SPDX-License-Identifier: Apache-2.0
// A TCP server on this machine that does to its callers whatever a test wants, also what no server should.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace choreo::test {

/// Whoever called.
class Caller {
 public:
  Caller(int socket, const std::atomic<bool>& closing) : socket_(socket), closing_(closing) {}

  /// What it sent up to an empty line; what came until then where it hangs up.
  [[nodiscard]] std::string request();
  /// @return false where the caller hung up, or the server closes.
  bool send(std::span<const std::uint8_t> bytes);
  bool send(std::string_view text) {
    return send(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
  }
  /// Does nothing for a while, without hanging up. @return as `send`.
  bool wait(std::chrono::milliseconds time);
  /// Does nothing until the caller hangs up or the server closes.
  void wait_for_the_end();

 private:
  int socket_;
  const std::atomic<bool>& closing_;
};

class LoopbackServer {
 public:
  /// Serves each caller in a thread of its own, and hangs up when `serve` returns.
  /// @param port  0 for any that is free.
  /// @throws std::runtime_error where the port is taken.
  explicit LoopbackServer(std::function<void(Caller&)> serve, int port = 0);
  /// Hangs up on all callers; nobody listens at the port any more.
  ~LoopbackServer();
  LoopbackServer(const LoopbackServer&) = delete;
  LoopbackServer& operator=(const LoopbackServer&) = delete;

  [[nodiscard]] int port() const { return port_; }
  /// "http://127.0.0.1:4711"
  [[nodiscard]] std::string address(const std::string& scheme = "http") const {
    return scheme + "://127.0.0.1:" + std::to_string(port_);
  }
  [[nodiscard]] int callers() const { return callers_; }

 private:
  void accept_callers();

  std::function<void(Caller&)> serve_;
  int listener_ = -1;
  int port_ = 0;
  std::atomic<bool> closing_{false};
  std::atomic<int> callers_{0};
  std::vector<std::thread> threads_;
  std::thread acceptor_;
};

/// A port where nobody listens.
[[nodiscard]] int deserted_port();

}  // namespace choreo::test
