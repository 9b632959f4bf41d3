// SPDX-License-Identifier: Apache-2.0
// Pictures that are known, sent through a real video node, come out as they went in, and so do the masks of them.
#include <algorithm>
#include <vector>

#include <gmock/gmock.h>
#include <opencv2/core.hpp>

#include "devices/media/raw_converter.hpp"
#include "devices/vivid_loop.hpp"
#include "pipeline/working_size.hpp"
#include "support/rehearsal.hpp"

namespace choreo::devices {
namespace {

// A picture that no other one is: every byte depends on its number.
std::vector<std::uint8_t> picture(int number) {
  std::vector<std::uint8_t> bytes(kBytes);
  for (std::size_t k = 0; k < kBytes; ++k) bytes[k] = std::uint8_t(17 + (k * 31 + std::size_t(number) * 7) % 200);
  return bytes;
}

TEST_F(Loop, WhatIsSentIsWhatIsGivenByteForByte) {
  std::vector<std::vector<std::uint8_t>> sent;
  for (int number = 0; number < 8; ++number) sent.push_back(picture(number));
  const auto sender = sending(sent);
  OpenOptions options;
  options.keep_raw = true;
  const auto source = registry_.open(source_, options);
  RawConverter converter;
  std::vector<Nanoseconds> ages;
  std::vector<bool> seen(sent.size());
  for (int k = 0; k < 90; ++k) {
    const auto frame = source->read({});
    ASSERT_TRUE(frame && frame->raw_colour);
    ages.push_back(clock_.now() - frame->device_time);
    const auto which = std::find(sent.begin(), sent.end(), frame->raw_colour->bytes);
    if (which == sent.end()) {
      EXPECT_LT(k, 30) << "only before the first was sent may there be anything else";
      continue;
    }
    seen[std::size_t(which - sent.begin())] = true;
    EXPECT_EQ(cv::norm(frame->bgr, converter.to_bgr(*frame->raw_colour), cv::NORM_INF), 0);
  }
  EXPECT_THAT(seen, testing::Each(true));
  std::sort(ages.begin(), ages.end());
  std::printf("vivid's HDMI input, 640x480 at 60: age of a frame: median %.1f ms, at most %.1f ms over %zu frames\n",
              1e3 * to_seconds(ages[ages.size() / 2]), 1e3 * to_seconds(ages.back()), ages.size());
}

// BT.601 in 16 to 235, two pixels sharing the colour of both, as webcams do it.
std::vector<std::uint8_t> yuyv_of(const cv::Mat& bgr) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(bgr.total() * 2);
  for (int y = 0; y < bgr.rows; ++y) {
    for (int x = 0; x < bgr.cols; x += 2) {
      const cv::Vec3f left = bgr.at<cv::Vec3b>(y, x);
      const cv::Vec3f right = bgr.at<cv::Vec3b>(y, x + 1);
      const cv::Vec3f mean = (left + right) / 2;
      const auto luma = [](const cv::Vec3f& p) { return 16.F + 0.098F * p[0] + 0.504F * p[1] + 0.257F * p[2]; };
      for (const float value : {luma(left), 128.F + 0.439F * mean[0] - 0.291F * mean[1] - 0.148F * mean[2],  //
                                luma(right), 128.F - 0.071F * mean[0] - 0.368F * mean[1] + 0.439F * mean[2]}) {
        bytes.push_back(cv::saturate_cast<std::uint8_t>(value));
      }
    }
  }
  return bytes;
}

TEST_F(Loop, TheBodyBeforeTheCameraIsFoundAsItIs) {
  const test::Rehearsal rehearsal({kWidth, kHeight}, false);
  std::vector<std::vector<std::uint8_t>> sent;
  for (const auto& performance : rehearsal.truth) sent.push_back(yuyv_of(performance.bgr));

  std::vector<cv::Mat> pictures(sent.size());  // As the camera gave them, at the size at which they are looked at.
  const auto missing = [&] { return std::any_of(pictures.begin(), pictures.end(), [](auto& p) { return p.empty(); }); };
  const auto sender = sending(sent);
  OpenOptions options;
  options.keep_raw = true;
  const auto source = registry_.open(source_, options);
  for (int k = 0; k < 600 && missing(); ++k) {
    const auto frame = source->read({});
    ASSERT_TRUE(frame && frame->raw_colour);
    const auto which = std::find(sent.begin(), sent.end(), frame->raw_colour->bytes) - sent.begin();
    if (which == std::ssize(sent)) continue;
    pictures[std::size_t(which)] = pipeline::at_working_size(frame->bgr, {kWidth / 2, kHeight / 2});
  }
  ASSERT_FALSE(missing()) << "a picture never came through";
  EXPECT_GT(test::mean_iou("v4l2", rehearsal, pictures), 0.97);
}

}  // namespace
}  // namespace choreo::devices
