// SPDX-License-Identifier: Apache-2.0
#include "devices/freenect/bounded_list.hpp"

#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>

namespace choreo::devices::freenect {

DeviceList list_within(Nanoseconds patience, std::function<DeviceList()> list) {
  struct Answer {
    std::mutex mutex;
    std::condition_variable changed;
    std::optional<DeviceList> list;
  };
  const auto answer = std::make_shared<Answer>();
  std::thread asking([answer, list = std::move(list)] {
    DeviceList told;
    try {
      told = list();
    } catch (const std::exception& error) {
      told = {};
      told.trouble = error.what();
    }
    const std::scoped_lock lock(answer->mutex);
    answer->list = std::move(told);
    answer->changed.notify_all();
  });
  std::unique_lock lock(answer->mutex);
  if (answer->changed.wait_for(lock, patience, [&] { return answer->list.has_value(); })) {
    auto told = std::move(*answer->list);
    lock.unlock();
    asking.join();
    return told;
  }
  asking.detach();
  DeviceList none;
  none.trouble = fmt::format("libfreenect hangs: no answer for {:.1f} s", to_seconds(patience));
  none.remedy = "unplug the Kinect and plug it in again";
  return none;
}

}  // namespace choreo::devices::freenect
