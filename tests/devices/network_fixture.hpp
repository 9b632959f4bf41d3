// SPDX-License-Identifier: Apache-2.0
// What the tests of network cameras share.
#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>

#include "devices/device_state.hpp"
#include "devices/network/network_driver.hpp"
#include "devices/video_file/video_file.hpp"
#include "pipeline/steady_clock.hpp"
#include "support/frames.hpp"
#include "support/loopback_server.hpp"
#include "support/motion_jpeg.hpp"

namespace choreo::devices {

using namespace std::chrono_literals;

class NetworkTest : public ::testing::Test {
 protected:
  NetworkTest() { registry_.add(network_driver(clock_, open_remote_recording)); }

  std::unique_ptr<Source> open(const std::string& address, bool keep_raw = false, std::stop_token stop = {}) {
    OpenOptions options;
    options.on_event = [this](const DeviceEvent& event) { events_.push_back(event); };
    options.keep_raw = keep_raw;
    options.stop = std::move(stop);
    return registry_.open(address, options);
  }

  /// The usage error of opening; fails the test where there is none, or where it takes longer than `limit`.
  Error refusal(const std::string& address, Nanoseconds limit = 2500ms) {
    const auto begin = clock_.now();
    const auto error = test::error_of([&] { (void)open(address); });
    EXPECT_LT(clock_.now() - begin, limit) << address;
    EXPECT_TRUE(error) << address << " was opened";
    if (!error) return usage_error("none");
    EXPECT_EQ(error->fault(), Fault::kUsage) << error->what();
    EXPECT_EQ(std::string(error->what()).find('\n'), std::string::npos) << "one line";
    EXPECT_EQ(events_.back().state, DeviceState::kFailed);
    return *error;
  }

  /// The next frame; none where none came in time.
  FramePtr read(Source& source, std::chrono::milliseconds limit = 5s) {
    std::stop_source stop;
    const std::jthread patience([&](const std::stop_token& over) {
      std::mutex mutex;
      std::unique_lock lock(mutex);
      std::condition_variable_any never;
      if (!never.wait_for(lock, over, limit, [] { return false; }) && !over.stop_requested()) stop.request_stop();
    });
    return source.read(stop.get_token());
  }

  /// Reads until the last event is the state.
  bool read_until(Source& source, DeviceState state, Nanoseconds limit = 10s) {
    const auto until = clock_.now() + limit;
    while (clock_.now() < until) {
      (void)read(source, 60ms);
      if (!events_.empty() && events_.back().state == state) return true;
    }
    return false;
  }

  std::vector<std::string> states() const {
    std::vector<std::string> names;
    for (const auto& event : events_) names.emplace_back(name_of(event.state));
    return names;
  }

  pipeline::SteadyClock clock_;
  Registry registry_;
  std::vector<DeviceEvent> events_;
};

}  // namespace choreo::devices
