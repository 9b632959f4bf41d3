// SPDX-License-Identifier: Apache-2.0
// What a network camera with multipart JPEG sends: pictures that carry their number.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "support/loopback_server.hpp"

namespace choreo::test {

inline constexpr int kDigits = 10;  // Binary; a column each.

/// Noise-free picture of black and white columns, the number's digits.
inline cv::Mat numbered_picture(int number, cv::Size size = {160, 96}) {
  cv::Mat picture(size, CV_8UC3, cv::Scalar(30, 90, 60));
  const int width = size.width / kDigits;
  for (int digit = 0; digit < kDigits; ++digit) {
    const auto grey = cv::Scalar::all((number >> digit & 1) != 0 ? 230 : 20);
    picture(cv::Rect(digit * width, 0, width, size.height / 2)).setTo(grey);
  }
  return picture;
}

/// The number that `numbered_picture` drew, modulo 1024.
inline int number_of(const cv::Mat& bgr) {
  int number = 0;
  for (int digit = 0; digit < kDigits; ++digit) {
    const cv::Point middle(bgr.cols / kDigits * digit + bgr.cols / kDigits / 2, bgr.rows / 4);
    if (bgr.at<cv::Vec3b>(middle)[1] > 128) number |= 1 << digit;
  }
  return number;
}

inline std::vector<std::uint8_t> jpeg_of(const cv::Mat& picture) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, 90});
  return bytes;
}

inline bool send_multipart_head(Caller& caller) {
  return caller.send(
      "HTTP/1.0 200 OK\r\nConnection: close\r\nContent-Type: multipart/x-mixed-replace; boundary=next\r\n\r\n");
}

inline bool send_part(Caller& caller, const std::vector<std::uint8_t>& jpeg) {
  return caller.send("--next\r\nContent-Type: image/jpeg\r\nContent-Length: " + std::to_string(jpeg.size()) +
                     "\r\n\r\n") &&
         caller.send(jpeg) && caller.send("\r\n");
}

/// Sends numbered pictures until the caller hangs up.
inline void serve_motion_jpeg(Caller& caller, std::chrono::milliseconds interval = std::chrono::milliseconds(20)) {
  (void)caller.request();
  bool there = send_multipart_head(caller);
  for (int k = 0; there; ++k) there = send_part(caller, jpeg_of(numbered_picture(k))) && caller.wait(interval);
}

}  // namespace choreo::test
