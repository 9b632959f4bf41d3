// SPDX-License-Identifier: Apache-2.0
// The window of a live run: the video with the body's outline, and the triangle that scrolls.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "outputs/live_page.hpp"

namespace choreo::outputs {

/// Whether there is a display that a window could open on; never asks for one.
[[nodiscard]] bool display_is_there();

struct LiveWindowOptions {
  std::string title;
  bool full_screen = false;
  Leading leading = Leading::kTriangle;
  cv::Size video;                   ///< Size of the pictures that will be shown, for the window's first layout.
  double history_s = 600;           ///< The widest span of time that is shown.
  std::function<void()> on_close;   ///< Called once, from the window's thread, where the user closes it.
  std::function<void()> on_report;  ///< Called from the window's thread where the user asks for the figures (key l).
  std::function<void()> on_joints;  ///< Likewise: show joints, or no more.
  /// Called once, from the window's thread, where the window goes though nobody closed it, with the cause in one line.
  std::function<void(const std::string& why)> on_lost;
};

/// A window with a thread of its own: whoever shows frames never waits for the display, and where the display goes away
/// only the window ends (`display_is_lost`).
///
/// Keys: q or Esc closes, f full screen, + and - change the span of time, l asks for a report, j for joints.
/// @thread thread-safe
class LiveWindow {
 public:
  /// Error (failure) where no window can be opened.
  explicit LiveWindow(LiveWindowOptions options);
  ~LiveWindow();
  LiveWindow(const LiveWindow&) = delete;
  LiveWindow& operator=(const LiveWindow&) = delete;

  /// Shows a frame and adds its row.
  /// @param picture  CV_8UC3; not changed afterwards.  @param mask  CV_8UC1, of any size of the same proportions.
  /// @param z, zstar  as ScrollingTriangle::add_row.
  void show(const cv::Mat& picture, const cv::Mat& mask, double time_s, std::span<const float> z,
            std::span<const float> zstar);

  /// The lines of text beside the key, the first stands out.
  void tell(std::vector<std::string> lines);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace choreo::outputs
