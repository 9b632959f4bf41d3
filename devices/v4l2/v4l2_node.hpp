// SPDX-License-Identifier: Apache-2.0
// An open V4L2 video node, and what it says of itself.
#pragma once

#include <linux/videodev2.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core/types.hpp>

namespace choreo::devices::v4l2 {

/// A file descriptor of a video node.
/// @thread thread-bound
class Node {
 public:
  /// Opens it for reading and writing, without waiting.
  /// @throws DeviceLost where there is no such node or it is no V4L2 capture device now; Error (usage) where it may not
  ///   be opened.
  explicit Node(std::string path);
  ~Node();
  Node(Node&& other) noexcept : path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)) {}
  Node& operator=(Node&&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] int fd() const { return fd_; }

  /// ioctl, again where a signal interrupted it. @return 0, or errno.
  int call(unsigned long request, void* argument) const;

 private:
  std::string path_;
  int fd_ = -1;
};

/// Who a node is, beyond this boot; its number says nothing.
struct Identity {
  std::string card;            ///< "HD Pro Webcam C920"
  std::string bus;             ///< "usb-0000:00:14.0-2": of USB, the port.
  std::string driver;          ///< "uvcvideo"
  std::string serial = {};     ///< Of a USB device that has one; many cheap ones share theirs.
  std::string interface = {};  ///< Of a USB device: "00". One that sees colour and infrared has one for each.
  std::string index = {};      ///< Among the nodes of its device: "0".
};

/// @param folder  the node's in sysfs.  @return `identity` and what the kernel's files add to it.
[[nodiscard]] Identity with_sysfs(Identity identity, const std::string& folder);

enum class Likeness { kOther, kMoved, kSame };

/// Whether a node is the one that was there before: the same at the same port, or at another one, which only a serial
/// number tells. Other nodes of the same device are others.
/// @param linked  it was reached by a link that names the device itself, of /dev/v4l/by-id: at whatever port.
[[nodiscard]] Likeness likeness_of(const Identity& was, const Identity& is, bool linked);

/// @return nothing where the node cannot capture video by streaming.
[[nodiscard]] std::optional<Identity> identity_of(const Node& node);

struct FrameRate {
  std::uint32_t numerator = 0;  ///< Seconds a frame is numerator / denominator, as V4L2 has it.
  std::uint32_t denominator = 0;
  [[nodiscard]] double fps() const { return numerator > 0 ? double(denominator) / numerator : 0.0; }
};

/// Sizes from the one that the mode has to this one, in these steps.
struct Steps {
  std::uint32_t most_width = 0, most_height = 0;
  std::uint32_t step_width = 1, step_height = 1;
};

/// One size of one pixel format, or a range of them, with its rates, fastest first.
struct Mode {
  std::uint32_t fourcc = 0;
  std::uint32_t width = 0, height = 0;
  std::vector<FrameRate> rates;
  std::optional<Steps> steps = {};
  bool any_rate = false;  ///< Every rate between the fastest and the slowest can be had, too.

  /// Of the rates that it has, the nearest to so many frames a second; zero where it lists none.
  [[nodiscard]] FrameRate nearest_rate(double wanted) const;
  /// Of the sizes that it has, the nearest to the one that is wanted, which is itself where it has it.
  [[nodiscard]] cv::Size nearest(cv::Size wanted) const;
};

/// All modes that a node lists, in its own order; where it lists no size, the present one.
[[nodiscard]] std::vector<Mode> modes_of(const Node& node);

/// The names of the video nodes there are, /dev/video0 and so on, by number.
[[nodiscard]] std::vector<std::string> video_nodes();

/// A name of the node that does not depend on the order of plugging: a link in /dev/v4l/by-id, else in by-path, else
/// the path itself.
[[nodiscard]] std::string stable_path(const std::string& path);

}  // namespace choreo::devices::v4l2
