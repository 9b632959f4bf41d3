// SPDX-License-Identifier: Apache-2.0
#include "cli/device_news.hpp"

#include <utility>

#include <fmt/format.h>

namespace choreo::cli {

void DeviceNews::hear(const std::string& name, const devices::DeviceEvent& event) {
  using devices::DeviceState;
  std::optional<Nanoseconds> away;
  {
    const std::scoped_lock lock(mutex_);
    if (event.state == DeviceState::kLost) {
      lost_at_ = event.at;
    } else if (event.state == DeviceState::kRunning && lost_at_) {
      away = event.at - *std::exchange(lost_at_, std::nullopt);
    }
  }
  if (event.state == DeviceState::kLost) {
    console_.warn(fmt::format("{} is lost: {}; it is taken up again when it is back", name, event.why));
    show_.call({"no signal", event.why});
  } else if (away) {
    console_.say(fmt::format("choreoscope: {} is back after {:.1f} s", name, to_seconds(*away)));
  }
}

std::shared_ptr<void> DeviceNews::show_with(Show show) {
  show_.set(std::move(show));
  return {this, [](DeviceNews* news) { news->show_.set({}); }};
}

}  // namespace choreo::cli
