// SPDX-License-Identifier: Apache-2.0
#include "support/x_server.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <string>

namespace choreo::test {

XServer::XServer() {
  std::array<int, 2> number{};  // It writes here which display it took.
  if (::pipe(number.data()) != 0) return;
  process_ = ::fork();
  if (process_ == 0) {
    const int nowhere = ::open("/dev/null", O_RDWR);
    for (const int fd : {0, 1, 2}) ::dup2(nowhere, fd);
    const auto fd = std::to_string(number[1]);
    ::execlp("Xvfb", "Xvfb", "-displayfd", fd.c_str(), "-screen", "0", "800x600x24", "-nolisten", "tcp", nullptr);
    ::_exit(127);
  }
  ::close(number[1]);
  pollfd ready{number[0], POLLIN, 0};
  constexpr int kPatience_ms = 30000;
  std::array<char, 16> text{};
  if (process_ > 0 && ::poll(&ready, 1, kPatience_ms) == 1 && ::read(number[0], text.data(), text.size() - 1) > 0) {
    display_ = ":" + std::to_string(std::atoi(text.data()));
  }
  ::close(number[0]);
  if (display_.empty()) end(SIGKILL);
}

// In an orderly way: it takes its lock file with it.
XServer::~XServer() { end(SIGTERM); }

void XServer::crash() { end(SIGKILL); }

void XServer::end(int signal) {
  if (process_ <= 0) return;
  ::kill(process_, signal);
  ::waitpid(process_, nullptr, 0);
  process_ = 0;
}

}  // namespace choreo::test
