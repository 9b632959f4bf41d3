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

/// Who a node is. The bus and its port name a device beyond this boot; a node's number does not.
struct Identity {
  std::string card;    ///< "HD Pro Webcam C920"
  std::string bus;     ///< "usb-0000:00:14.0-2"
  std::string driver;  ///< "uvcvideo"
  bool operator==(const Identity&) const = default;
};

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
