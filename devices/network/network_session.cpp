// SPDX-License-Identifier: Apache-2.0
#include "devices/network/network_session.hpp"

#include <array>
#include <cstring>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"
#include "devices/fourcc.hpp"

namespace choreo::devices::network {
namespace {

constexpr int kMostSide = 32767;
constexpr Nanoseconds kGrace = std::chrono::milliseconds(200);

}  // namespace

Session::Session(const Wish& wish, const Clock& clock) : wish_(wish), reader_(wish, clock) {}

bool Session::is_ready(Nanoseconds wait) {
  if (first_) return true;
  const auto picture = reader_.take(wait);
  if (picture) {
    facts_ = reader_.facts();
    const auto coded = picture->frame ? cv::Size(picture->frame->width, picture->frame->height) : facts_.coded;
    if (coded.width < 1 || coded.height < 1 || coded.width > kMostSide || coded.height > kMostSide) {
      throw usage_error(fmt::format("\"{}\": pictures of {}x{} are not read", wish_.name, coded.width, coded.height),
                        {}, fmt::format("sides up to {} pixels are", kMostSide));
    }
    first_ = converted(*picture);
  }
  if (first_) {
    info_.name = wish_.name;
    info_.size = first_->bgr.size();
    info_.nominal_fps = facts_.nominal_fps;
    info_.repeatable = false;
    return true;
  }
  // The reader watches the time as well, but for damaged pictures, and while it asks for the name of a host.
  if (std::chrono::steady_clock::now() - begin_ > wish_.patience + kGrace) {
    throw DeviceLost(fmt::format("\"{}\" does not answer: no {} came within {} s", wish_.name,
                                 damaged_ ? "whole picture" : "picture", to_seconds(wish_.patience)));
  }
  return false;
}

std::optional<DeviceFrame> Session::wait(Nanoseconds patience) {
  auto first = std::exchange(first_, std::nullopt);
  if (first && wish_.every_frame) return first;
  const auto picture = reader_.take(first ? Nanoseconds(0) : patience);
  if (!picture) return first;
  auto frame = converted(*picture);
  if (!frame) return first;
  if (frame->bgr.size() != info_.size) {
    throw DeviceLost(fmt::format("\"{}\": the picture changes from {}x{} to {}x{}", wish_.name, info_.size.width,
                                 info_.size.height, frame->bgr.cols, frame->bgr.rows));
  }
  return frame;
}

// Nothing where the picture is damaged.
std::optional<DeviceFrame> Session::converted(const Picture& picture) {
  DeviceFrame frame;
  frame.counter = picture.counter;
  frame.device_time = picture.stamp;
  frame.arrival = picture.arrival;
  try {
    if (picture.jpeg) {
      const Layout layout{kMjpg, facts_.coded, 0};
      const std::span<const std::uint8_t> bytes(picture.jpeg->data, std::size_t(picture.jpeg->size));
      frame.bgr = jpegs_.to_bgr(layout, bytes);
      if (wish_.keep_raw) frame.raw_colour = keep_raw(layout, bytes);
    } else {
      frame.bgr = upright(*picture.frame);
    }
  } catch (const Error&) {
    damaged_ = true;
    return std::nullopt;
  }
  return frame;
}

cv::Mat Session::upright(const AVFrame& frame) {
  if (!maker_) maker_.emplace(facts_.codec);
  Orientation orientation;
  const auto* side = av_frame_get_side_data(&frame, AV_FRAME_DATA_DISPLAYMATRIX);
  if (side != nullptr && side->size >= 9 * sizeof(std::int32_t)) {
    std::array<std::int32_t, 9> matrix{};
    std::memcpy(matrix.data(), side->data, sizeof matrix);
    orientation = hanging_of(matrix.data()).orientation;
  }
  return maker_->make(frame, frame.sample_aspect_ratio, orientation);
}

std::vector<std::string> Session::take_warnings() {
  damaged_ = damaged_ || reader_.damaged() > 0;
  if (!damaged_ || std::exchange(told_damaged_, true)) return {};
  return {fmt::format("\"{}\" gave damaged pictures, which were left out", wish_.name)};
}

}  // namespace choreo::devices::network
