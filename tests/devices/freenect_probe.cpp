// SPDX-License-Identifier: Apache-2.0
// Reads a freenect SOURCE and says what came, line by line: a process of its own, whose libfreenect is whichever the
// environment names.
//
//   freenect_probe SOURCE FRAMES SECONDS [MILLISECONDS [every]]   until there were so many or so long, pausing after
//   each freenect_probe SOURCE cycle COUNT                     opens and closes so many times freenect_probe list
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"
#include "devices/freenect/freenect_driver.hpp"
#include "devices/kinect_fixture.hpp"
#include "pipeline/steady_clock.hpp"

namespace {

using namespace choreo;
using namespace std::chrono_literals;

void say(const std::string& line) {
  std::puts(line.c_str());
  std::fflush(stdout);
}

void tell_frame(const devices::Frame& frame, Nanoseconds now) {
  std::uint64_t words = 0;
  if (frame.raw_depth) words = test::fingerprint(cv::Mat(frame.raw_depth->bytes));
  say(fmt::format("frame {} {} {} {} {} {}", frame.sequence, frame.device_time.count(),
                  (now - frame.device_time).count(), test::fingerprint(frame.bgr), test::fingerprint(frame.depth),
                  words));
}

int run(int count, char** words) {
  const pipeline::SteadyClock clock;
  const auto driver = devices::freenect_driver(clock);
  const std::string source = words[1];
  if (source == "list") {
    const auto list = driver.list();
    for (const auto& device : list.devices) {
      say(fmt::format("device {} {}", device.source, device.trouble));
      for (const auto& [name, choices, least, most, unit, fallback] : device.settings) {
        say(choices.empty() ? fmt::format("setting {} {:g} {:g} {}", name, least, most, unit)
                            : fmt::format("setting {} {}", name, join(choices, ",")));
      }
    }
    if (!list.trouble.empty()) say("trouble " + list.trouble + " / " + list.remedy);
    return 0;
  }
  if (count < 4) return 2;
  devices::Registry registry;
  registry.add(driver);
  devices::OpenOptions options;
  options.keep_raw = true;
  options.every_frame = count > 5 && std::string(words[5]) == "every";
  options.on_event = [](const devices::DeviceEvent& event) {
    say(fmt::format("event {} {}", devices::name_of(event.state), event.why));
  };
  if (std::string(words[2]) == "cycle") {
    for (int k = std::atoi(words[3]); k > 0; --k) (void)registry.open(source, options);
    return 0;
  }
  const auto opened = registry.open(source, options);
  std::stop_source stop;
  const std::jthread limit([&](const std::stop_token& over) {
    if (pipeline::sleep_until(clock.now() + from_seconds(std::atof(words[3])), over)) stop.request_stop();
  });
  const auto pause = std::chrono::milliseconds(count > 4 ? std::atoi(words[4]) : 0);
  std::vector<std::pair<devices::FramePtr, Nanoseconds>> read;
  for (int k = std::atoi(words[2]); k > 0; --k) {
    auto frame = opened->read(stop.get_token());
    if (!frame) break;
    read.emplace_back(std::move(frame), clock.now());
    std::this_thread::sleep_for(pause);
  }
  // Only now: where sanitizers watch, a fingerprint takes longer than a frame.
  for (const auto& [frame, at] : read) tell_frame(*frame, at);
  for (const auto& line : opened->warnings()) say("warning " + line);
  return 0;
}

}  // namespace

int main(int count, char** words) {
  if (count < 2) return 2;
  try {
    return run(count, words);
  } catch (const choreo::Error& error) {
    say(fmt::format("error {} {} / {}", static_cast<int>(error.fault()), error.what(), error.hint()));
    return static_cast<int>(error.fault());
  }
}
