// SPDX-License-Identifier: Apache-2.0
// The program that touches OpenNI2, so that its crashes are its own. Started by choreoscope alone.
#include <poll.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <thread>
#include <variant>

#include "devices/openni2/helper_link.hpp"
#include "devices/openni2/reader.hpp"

namespace {

using namespace choreo::devices::openni2;

// A crash is expected and leaves no core; a damaged file that asks for more memory than the machine has gets none.
void limit_what_can_go_wrong() {
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
#if !defined(CHOREO_SANITIZED)
  constexpr rlim_t kMostMemory = rlim_t{4} << 30U;
  const rlimit most{kMostMemory, kMostMemory};
  ::setrlimit(RLIMIT_AS, &most);
#endif
}

// Whatever the library is stuck in, this program ends once choreoscope has hung up, however that came about. A device
// is given a second to be closed as it should.
void end_with_choreoscope() {
  pollfd socket{kSocketDescriptor, 0, 0};  // Asks for nothing: hanging up is always told.
  while (::poll(&socket, 1, -1) <= 0) {
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));
  ::_exit(0);
}

}  // namespace

int main() {
  try {
    limit_what_can_go_wrong();
    ::close_range(kRecordingDescriptor + 1, ~0U, 0);  // What others left open is none of our business.
    HelperLink link;
    std::thread(end_with_choreoscope).detach();
    link.send(Hello{});
    while (!link.closed()) {
      const auto message = link.receive(1000);
      if (!message) continue;
      if (const auto* request = std::get_if<Request>(&*message)) serve(*request, link);
      break;
    }
  } catch (const std::exception&) {
    std::fputs("choreoscope-openni2 is a part of choreoscope, which starts it where it needs it\n", stderr);
    ::_exit(2);
  }
  // The library's own end is not waited for: some of its drivers crash there, and it leaks.
  ::_exit(0);
}
