// SPDX-License-Identifier: Apache-2.0
// What is asked of every driver, asked of network cameras, on a server of the test's own.
#include <memory>
#include <optional>

#include "devices/conformance.hpp"
#include "devices/network/network_driver.hpp"
#include "devices/video_file/video_file.hpp"
#include "pipeline/steady_clock.hpp"
#include "support/motion_jpeg.hpp"

namespace choreo::devices {
namespace {

ConformanceSubject motion_jpeg() {
  static const pipeline::SteadyClock clock;
  const auto serve = [](test::Caller& caller) { test::serve_motion_jpeg(caller); };
  const auto server = std::make_shared<std::optional<test::LoopbackServer>>(std::in_place, serve);
  const int port = (*server)->port();
  const auto address = (*server)->address() + "/video";
  return {"motion_jpeg",
          network_driver(clock, open_remote_recording),
          address,
          address + "?silence=-1",
          [server] { server->reset(); },
          [server, serve, port] { server->emplace(serve, port); },
          server};
}

}  // namespace

std::vector<ConformanceCase> conformance_subjects() { return {{"motion_jpeg", ConformanceKind::kCamera, motion_jpeg}}; }

}  // namespace choreo::devices
