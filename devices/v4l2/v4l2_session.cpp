// SPDX-License-Identifier: Apache-2.0
#include "devices/v4l2/v4l2_session.hpp"

#include <poll.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <span>
#include <system_error>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"
#include "devices/fourcc.hpp"
#include "devices/v4l2/v4l2_controls.hpp"

namespace choreo::devices::v4l2 {
namespace {

constexpr std::uint32_t kBuffers = 4;
const cv::Size kCommon(640, 480);

[[noreturn]] void lost(const Node& node, std::string_view doing, int cause) {
  throw DeviceLost(fmt::format("\"{}\": {}: {}", node.path(), doing, std::generic_category().message(cause)));
}

// The node to open: the one that is named, or wherever the device that was there before is now.
Node find(const Wish& wish) {
  if (!wish.identity) return Node(wish.path);
  std::optional<Node> best;
  auto closest = Likeness::kOther;
  const auto consider = [&](const std::string& path, bool linked) {
    try {
      Node node(path);
      const auto is = identity_of(node);
      const auto likeness = is ? likeness_of(*wish.identity, *is, linked) : Likeness::kOther;
      if (likeness <= closest) return;
      closest = likeness;
      best.emplace(std::move(node));
    } catch (const std::exception&) {
      // Gone, somebody else's, or so new that its permissions are still to come.
    }
  };
  consider(wish.path, wish.path.starts_with("/dev/v4l/by-id/"));
  if (closest == Likeness::kSame) return std::move(*best);
  for (const auto& path : video_nodes()) consider(path, false);
  if (best) return std::move(*best);
  throw DeviceLost(fmt::format("\"{}\" ({}) is not there", wish.path, wish.identity->card));
}

std::size_t loss_of(std::uint32_t fourcc) {
  const auto known = known_formats();
  return std::size_t(std::find(known.begin(), known.end(), fourcc) - known.begin());
}

bool is_known(std::uint32_t fourcc) { return loss_of(fourcc) < known_formats().size(); }

std::string told_of(const std::vector<Mode>& modes) {
  std::vector<std::string> lines;
  for (const auto& m : modes) {
    auto line = fmt::format("{} {}x{}", name_of_fourcc(m.fourcc), m.width, m.height);
    if (m.steps) line += fmt::format(" to {}x{}", m.steps->most_width, m.steps->most_height);
    if (!m.rates.empty()) line += fmt::format(" at {:.4g}", m.rates.front().fps());
    if (is_known(m.fourcc)) lines.push_back(std::move(line));
  }
  return lines.empty() ? "it has no format that is known here" : "it has " + join(lines);
}

void choose_input(const Node& node, int wanted) {
  const int cause = node.call(VIDIOC_S_INPUT, &wanted);
  if (cause == 0) return;
  if (cause != EINVAL) lost(node, "the input cannot be chosen", cause);
  std::vector<std::string> known;
  for (v4l2_input input{}; node.call(VIDIOC_ENUMINPUT, &input) == 0; ++input.index) {
    known.push_back(fmt::format("{} ({})", input.index, reinterpret_cast<const char*>(input.name)));
  }
  throw usage_error(fmt::format("\"{}\" has no input {}", node.path(), wanted), {}, "it has " + join(known));
}

}  // namespace

std::optional<Mode> choose_mode(const std::vector<Mode>& modes, const Wish& wish) {
  const auto wanted_size = wish.size.value_or(kCommon);
  const Mode* best = nullptr;
  std::tuple<double, double, std::size_t> least{};
  for (const auto& mode : modes) {
    if (!is_known(mode.fourcc) || (wish.fourcc && mode.fourcc != *wish.fourcc)) continue;
    const auto size = mode.nearest(wanted_size);
    if (wish.size && size != *wish.size) continue;
    const double far = std::abs(std::log(double(size.area()) / wanted_size.area()));
    const double fastest = mode.rates.empty() ? 30.0 : mode.rates.front().fps();
    // A rate above what is wanted is as good: it can be lowered. Differences of rounding are none.
    const double slow = std::round(std::max(0.0, wish.fps.value_or(30.0) - fastest));
    const std::tuple rank{far, slow, loss_of(mode.fourcc)};
    if (best == nullptr || rank < least) {
      best = &mode;
      least = rank;
    }
  }
  if (best == nullptr) return std::nullopt;
  auto chosen = *best;
  const auto size = chosen.nearest(wanted_size);
  chosen.width = std::uint32_t(size.width);
  chosen.height = std::uint32_t(size.height);
  chosen.steps.reset();
  return chosen;
}

Session::Session(const Wish& wish, const Clock& clock)
    : clock_(clock), node_(find(wish)), every_frame_(wish.every_frame), keep_raw_(wish.keep_raw) {
  const auto identity = identity_of(node_);
  if (!identity) {
    throw usage_error(fmt::format("\"{}\" is no camera that streams video", node_.path()), {},
                      "choreoscope devices lists the cameras there are");
  }
  identity_ = *identity;
  negotiate(wish);
  for (auto& line : set_controls(node_, wish.controls)) warnings_.push_back(std::move(line));
  info_.controls = settings_of(controls_of(node_));
  share_buffers();
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int cause = node_.call(VIDIOC_STREAMON, &type); cause != 0) lost(node_, "the stream cannot start", cause);
}

Session::~Session() {
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  (void)node_.call(VIDIOC_STREAMOFF, &type);
}

Session::Buffer::~Buffer() {
  if (data != nullptr) ::munmap(data, bytes);
}

void Session::negotiate(const Wish& wish) {
  if (wish.input) choose_input(node_, *wish.input);
  const auto modes = modes_of(node_);
  const auto mode = choose_mode(modes, wish);
  if (!mode) {
    throw usage_error(fmt::format("\"{}\" has no such mode", node_.path()), {}, told_of(modes));
  }
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  format.fmt.pix.width = mode->width;
  format.fmt.pix.height = mode->height;
  format.fmt.pix.pixelformat = mode->fourcc;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  if (const int cause = node_.call(VIDIOC_S_FMT, &format); cause == EBUSY) {
    throw usage_error(fmt::format("\"{}\" is used by another program", node_.path()), {}, "close it there first");
  } else if (cause != 0) {
    lost(node_, "the format cannot be set", cause);
  }
  const auto& is = format.fmt.pix;
  if (is.pixelformat != mode->fourcc || is.width != mode->width || is.height != mode->height) {
    throw usage_error(
        fmt::format("\"{}\" gives {} {}x{} where {} {}x{} was asked for", node_.path(), name_of_fourcc(is.pixelformat),
                    is.width, is.height, name_of_fourcc(mode->fourcc), mode->width, mode->height),
        {}, told_of(modes));
  }
  layout_ = {is.pixelformat, {int(is.width), int(is.height)}, is.pixelformat == kMjpg ? 0 : is.bytesperline};
  info_.size = layout_.size;

  v4l2_streamparm rate{};
  rate.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (node_.call(VIDIOC_G_PARM, &rate) != 0) return;
  auto& interval = rate.parm.capture.timeperframe;
  if ((rate.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) != 0 && !mode->rates.empty()) {
    const auto nearest = mode->nearest_rate(wish.fps.value_or(30.0));
    interval = {nearest.numerator, nearest.denominator};
    (void)node_.call(VIDIOC_S_PARM, &rate);
  }
  if (interval.numerator > 0) info_.nominal_fps = double(interval.denominator) / interval.numerator;
  if (wish.fps && std::abs(info_.nominal_fps - *wish.fps) > 0.05 * *wish.fps) {
    warnings_.push_back(fmt::format("\"{}\" gives {:.4g} frames a second, {:.4g} were asked for", node_.path(),
                                    info_.nominal_fps, *wish.fps));
  }
}

void Session::share_buffers() {
  v4l2_requestbuffers request{};
  request.count = kBuffers;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int cause = node_.call(VIDIOC_REQBUFS, &request); cause != 0) lost(node_, "no buffers", cause);
  if (request.count < 2) throw DeviceLost(fmt::format("\"{}\": too few buffers", node_.path()));
  for (std::uint32_t index = 0; index < request.count; ++index) {
    v4l2_buffer buffer{};
    buffer.index = index;
    buffer.type = request.type;
    buffer.memory = request.memory;
    if (const int cause = node_.call(VIDIOC_QUERYBUF, &buffer); cause != 0) lost(node_, "no buffer", cause);
    auto* data = ::mmap(nullptr, buffer.length, PROT_READ, MAP_SHARED, node_.fd(), buffer.m.offset);
    if (data == MAP_FAILED) lost(node_, "a buffer cannot be shared", errno);
    buffers_.emplace_back(static_cast<std::uint8_t*>(data), buffer.length);
    host_clock_ = (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    give_back(buffer);
  }
}

void Session::give_back(v4l2_buffer& buffer) {
  if (const int cause = node_.call(VIDIOC_QBUF, &buffer); cause != 0) lost(node_, "a buffer is not taken back", cause);
}

// @return whether there was one.
bool Session::take(v4l2_buffer& buffer) {
  buffer = {};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  const int cause = node_.call(VIDIOC_DQBUF, &buffer);
  if (cause == EAGAIN) return false;
  if (cause != 0) lost(node_, "the stream broke", cause);
  return true;
}

bool Session::whole(const v4l2_buffer& buffer) {
  const bool good = (buffer.flags & V4L2_BUF_FLAG_ERROR) == 0 && buffer.bytesused >= bytes_of(layout_) &&
                    buffer.index < buffers_.size() && buffer.bytesused <= buffers_[buffer.index].bytes;
  if (!good) ++damaged_;
  return good;
}

std::optional<v4l2_buffer> Session::take_newest() {
  std::optional<v4l2_buffer> newest;
  std::size_t waited = 0;
  for (v4l2_buffer buffer{}; take(buffer); ++waited) {
    const bool good = whole(buffer);
    if (!good) give_back(buffer);
    if (!good) continue;
    if (newest) give_back(*newest);
    newest = buffer;
  }
  if (!newest || waited < buffers_.size()) return newest;
  give_back(*newest);
  return std::nullopt;
}

std::optional<v4l2_buffer> Session::take_oldest() {
  for (v4l2_buffer buffer{}; take(buffer);) {
    if (whole(buffer)) return buffer;
    give_back(buffer);
  }
  return std::nullopt;
}

std::optional<DeviceFrame> Session::wait(Nanoseconds patience) {
  pollfd ready{node_.fd(), POLLIN, 0};
  const auto milliseconds = std::chrono::ceil<std::chrono::milliseconds>(patience).count();
  const int polled = ::poll(&ready, 1, static_cast<int>(std::min<std::int64_t>(milliseconds, 60000)));
  if (polled < 0 && errno != EINTR) lost(node_, "it cannot be waited for", errno);
  if (polled <= 0) return std::nullopt;
  auto taken = every_frame_ ? take_oldest() : take_newest();
  if (!taken) {
    // An error without a frame would be polled again and again.
    if ((ready.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) lost(node_, "the stream broke", EIO);
    return std::nullopt;
  }
  DeviceFrame frame;
  frame.arrival = clock_.now();
  frame.counter = taken->sequence;
  frame.device_time =
      std::chrono::seconds(taken->timestamp.tv_sec) + std::chrono::microseconds(taken->timestamp.tv_usec);
  const std::span<const std::uint8_t> bytes(buffers_[taken->index].data, taken->bytesused);
  try {
    frame.bgr = converter_.to_bgr(layout_, bytes);
    if (keep_raw_) frame.raw_colour = keep_raw(layout_, bytes);
  } catch (const Error&) {
    ++damaged_;  // A JPEG that lost its end on a crowded bus; the next one is whole.
  }
  give_back(*taken);
  return frame.bgr.empty() ? std::nullopt : std::optional(std::move(frame));
}

std::vector<std::string> Session::take_warnings() { return std::exchange(warnings_, {}); }

}  // namespace choreo::devices::v4l2
