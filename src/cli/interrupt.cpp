// SPDX-License-Identifier: Apache-2.0
#include "cli/interrupt.hpp"

#include <pthread.h>

#include <csignal>
#include <ctime>
#include <utility>

namespace choreo::cli {
namespace {

sigset_t handled_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) {
    // What nohup or a script's & has set to be ignored stays so; blocked and waited for, it would arrive.
    struct sigaction before {};
    if (sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_IGN) continue;
    sigaddset(&set, signal);
  }
  return set;
}

}  // namespace

Interrupt::Interrupt() {
  const auto set = handled_signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  reports_ = std::jthread([this](const std::stop_token& stop) { make_reports(stop); });
  signals_ = std::jthread([this](const std::stop_token& stop) { take_signals(stop); });
}

Interrupt::~Interrupt() = default;

void Interrupt::take_signals(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "signals");
  const auto waited_for = handled_signals();
  const timespec tick{0, 50'000'000};  // How long the end of the program may wait for this thread.
  int seen = 0;
  while (!stop.stop_requested()) {
    const int signal = sigtimedwait(&waited_for, nullptr, &tick);
    if (signal < 0) continue;
    if (signal == SIGUSR1) {
      {
        const std::scoped_lock lock(mutex_);
        asks_ = true;
      }
      asked_.notify_one();
      continue;
    }
    ++seen;
    if (seen == 1) {
      orderly_.request_stop();
    } else if (seen == 2) {
      now_.request_stop();
      pthread_sigmask(SIG_UNBLOCK, &waited_for, nullptr);
      std::signal(signal, SIG_DFL);
    }
  }
}

// Whoever asks again while a report is made gets one more.
void Interrupt::make_reports(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "reports");
  std::unique_lock lock(mutex_);
  while (asked_.wait(lock, stop, [this] { return asks_; })) {
    asks_ = false;
    lock.unlock();
    report_.call();
    lock.lock();
  }
}

}  // namespace choreo::cli
