// SPDX-License-Identifier: Apache-2.0
#include "devices/v4l2/v4l2_node.hpp"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <system_error>
#include <tuple>

#include <fmt/format.h>

#include "core/error.hpp"
#include "devices/device_state.hpp"

namespace choreo::devices::v4l2 {
namespace {

namespace fs = std::filesystem;

template <std::size_t N>
std::string text_of(const __u8 (&bytes)[N]) {
  return {reinterpret_cast<const char*>(bytes), std::size_t(std::find(bytes, bytes + N, 0) - bytes)};
}

void list_rates(const Node& node, Mode& mode) {
  auto& rates = mode.rates;
  v4l2_frmivalenum interval{};
  interval.pixel_format = mode.fourcc;
  interval.width = mode.width;
  interval.height = mode.height;
  for (; node.call(VIDIOC_ENUM_FRAMEINTERVALS, &interval) == 0; ++interval.index) {
    if (interval.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      rates.push_back({interval.discrete.numerator, interval.discrete.denominator});
      continue;
    }
    rates.push_back({interval.stepwise.min.numerator, interval.stepwise.min.denominator});
    rates.push_back({interval.stepwise.max.numerator, interval.stepwise.max.denominator});
    mode.any_rate = true;  // Of steps the driver takes the nearest.
    break;
  }
  std::stable_sort(rates.begin(), rates.end(), [](auto& a, auto& b) { return a.fps() > b.fps(); });
}

// The first line of a small file; empty where there is none.
std::string line_of(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

}  // namespace

Node::Node(std::string path) : path_(std::move(path)) {
  fd_ = ::open(path_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd_ >= 0) return;
  const int cause = errno;
  const auto told = fmt::format("\"{}\" cannot be opened: {}", path_, std::generic_category().message(cause));
  if (cause == EACCES || cause == EPERM) {
    throw usage_error(told, {}, "add yourself to the group video (sudo usermod -aG video $USER) and log in again");
  }
  throw DeviceLost(told);
}

Node::~Node() {
  if (fd_ >= 0) ::close(fd_);
}

int Node::call(unsigned long request, void* argument) const {
  while (::ioctl(fd_, request, argument) != 0) {
    if (errno != EINTR) return errno;
  }
  return 0;
}

std::optional<Identity> identity_of(const Node& node) {
  v4l2_capability told{};
  if (node.call(VIDIOC_QUERYCAP, &told) != 0) return std::nullopt;
  const auto can = (told.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? told.device_caps : told.capabilities;
  if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0 || (can & V4L2_CAP_STREAMING) == 0) return std::nullopt;
  Identity identity{text_of(told.card), text_of(told.bus_info), text_of(told.driver)};
  struct stat is {};
  if (::fstat(node.fd(), &is) != 0) return identity;
  return with_sysfs(std::move(identity), fmt::format("/sys/dev/char/{}:{}", major(is.st_rdev), minor(is.st_rdev)));
}

Identity with_sysfs(Identity identity, const std::string& folder) {
  identity.index = line_of(folder + "/index");
  identity.interface = line_of(folder + "/device/bInterfaceNumber");
  if (!identity.interface.empty()) identity.serial = line_of(folder + "/device/../serial");
  return identity;
}

Likeness likeness_of(const Identity& was, const Identity& is, bool linked) {
  const auto role = [](const Identity& of) { return std::tie(of.card, of.driver, of.interface, of.index); };
  if (role(was) != role(is)) return Likeness::kOther;
  if (linked) return Likeness::kSame;
  if (was.serial != is.serial) return Likeness::kOther;
  if (was.bus == is.bus) return Likeness::kSame;
  return was.serial.empty() ? Likeness::kOther : Likeness::kMoved;
}

FrameRate Mode::nearest_rate(double wanted) const {
  if (rates.empty()) return {};
  if (any_rate && wanted < rates.front().fps() && wanted > rates.back().fps()) {
    constexpr std::uint32_t kParts = 1000;
    const auto frames = static_cast<std::uint32_t>(std::max(1L, std::lround(wanted * kParts)));
    const auto common = std::gcd(kParts, frames);
    return {kParts / common, frames / common};
  }
  return *std::min_element(rates.begin(), rates.end(), [&](const FrameRate& a, const FrameRate& b) {
    return std::abs(a.fps() - wanted) < std::abs(b.fps() - wanted);
  });
}

cv::Size Mode::nearest(cv::Size wanted) const {
  if (!steps) return {int(width), int(height)};
  const auto on_grid = [](int value, std::uint32_t least, std::uint32_t most, std::uint32_t step) {
    const auto inside = std::clamp(std::uint32_t(std::max(value, 0)), least, std::max(least, most));
    return int(inside - (inside - least) % step);
  };
  return {on_grid(wanted.width, width, steps->most_width, steps->step_width),
          on_grid(wanted.height, height, steps->most_height, steps->step_height)};
}

std::vector<Mode> modes_of(const Node& node) {
  std::vector<Mode> modes;
  v4l2_fmtdesc format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  for (; node.call(VIDIOC_ENUM_FMT, &format) == 0; ++format.index) {
    const auto add = [&](std::uint32_t width, std::uint32_t height) {
      modes.push_back({format.pixelformat, width, height, {}});
      list_rates(node, modes.back());
    };
    const auto before = modes.size();
    v4l2_frmsizeenum size{};
    size.pixel_format = format.pixelformat;
    for (; node.call(VIDIOC_ENUM_FRAMESIZES, &size) == 0; ++size.index) {
      if (size.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
        add(size.discrete.width, size.discrete.height);
        continue;
      }
      const auto& range = size.stepwise;
      add(range.min_width, range.min_height);
      modes.back().steps = {range.max_width, range.max_height, std::max(1U, range.step_width),
                            std::max(1U, range.step_height)};
      break;
    }
    // A card that digitises what a cable brings lists no sizes: it has the one of its signal.
    v4l2_format now{};
    now.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (modes.size() == before && node.call(VIDIOC_G_FMT, &now) == 0) add(now.fmt.pix.width, now.fmt.pix.height);
  }
  return modes;
}

std::vector<std::string> video_nodes() {
  std::vector<std::pair<int, std::string>> found;
  std::error_code problem;
  for (const auto& entry : fs::directory_iterator("/dev", problem)) {
    const auto name = entry.path().filename().string();
    constexpr std::string_view kStart = "video";
    if (!name.starts_with(kStart)) continue;
    int number = 0;
    const auto* end = name.data() + name.size();
    const auto parsed = std::from_chars(name.data() + kStart.size(), end, number);
    if (parsed.ec == std::errc() && parsed.ptr == end) found.emplace_back(number, entry.path().string());
  }
  std::sort(found.begin(), found.end());
  std::vector<std::string> paths;
  for (auto& [number, path] : found) paths.push_back(std::move(path));
  return paths;
}

std::string stable_path(const std::string& path) {
  for (const auto* folder : {"/dev/v4l/by-id", "/dev/v4l/by-path"}) {
    std::error_code problem;
    for (const auto& link : fs::directory_iterator(folder, problem)) {
      std::error_code dangling;
      if (fs::equivalent(link.path(), path, dangling)) return link.path().string();
    }
  }
  return path;
}

}  // namespace choreo::devices::v4l2
