// SPDX-License-Identifier: Apache-2.0
#include "cli/device_news.hpp"

#include <utility>

#include <fmt/format.h>

namespace choreo::cli {

void DeviceNews::hear(const std::string& name, const devices::DeviceEvent& event) {
  using devices::DeviceState;
  const std::scoped_lock lock(mutex_);
  if (event.state == DeviceState::kLost) {
    lost_at_ = event.at;
    console_.warn(fmt::format("{} is lost: {}; it is taken up again when it is back", name, event.why));
    if (show_) show_({"no signal", event.why});
  } else if (event.state == DeviceState::kRunning && lost_at_) {
    console_.say(fmt::format("choreoscope: {} is back after {:.1f} s", name, to_seconds(event.at - *lost_at_)));
    lost_at_.reset();
  }
}

std::shared_ptr<void> DeviceNews::show_with(Show show) {
  const std::scoped_lock lock(mutex_);
  show_ = std::move(show);
  return {this, [](DeviceNews* news) {
            const std::scoped_lock until_shown(news->mutex_);
            news->show_ = nullptr;
          }};
}

}  // namespace choreo::cli
