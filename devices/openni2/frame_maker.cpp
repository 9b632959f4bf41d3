// SPDX-License-Identifier: Apache-2.0
#include "devices/openni2/frame_maker.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include <opencv2/imgproc.hpp>

#include "devices/fourcc.hpp"

namespace choreo::devices::openni2 {
namespace {

Layout layout_of(const Mode& mode) {
  return dense_layout(mode.fourcc, cv::Size(static_cast<int>(mode.width), static_cast<int>(mode.height)));
}

}  // namespace

cv::Mat grey_of_depth(const cv::Mat& depth) {
  cv::Mat grey(depth.size(), CV_8UC1);
  for (int y = 0; y < depth.rows; ++y) {
    const auto* mm = depth.ptr<std::uint16_t>(y);
    auto* to = grey.ptr<std::uint8_t>(y);
    for (int x = 0; x < depth.cols; ++x) {
      const int in_range = std::clamp<int>(mm[x], kWhiteMm, kBlackMm);
      to[x] = mm[x] == 0 ? std::uint8_t{0}
                         : static_cast<std::uint8_t>((255 * (kBlackMm - in_range) + (kBlackMm - kWhiteMm) / 2) /
                                                     (kBlackMm - kWhiteMm));
    }
  }
  cv::Mat bgr;
  cv::cvtColor(grey, bgr, cv::COLOR_GRAY2BGR);
  return bgr;
}

Pictures FrameMaker::make(const Moment& moment) {
  Pictures all;
  if (moment.depth) {
    const auto& depth = *moment.depth;
    all.depth.create(static_cast<int>(depth.mode.height), static_cast<int>(depth.mode.width), CV_16UC1);
    std::memcpy(all.depth.data, depth.bytes.data(), depth.bytes.size());
  }
  if (!moment.video) {
    all.bgr = grey_of_depth(all.depth);
    return all;
  }
  const auto layout = layout_of(moment.video->mode);
  all.bgr = converter_.to_bgr(layout, moment.video->bytes);
  // Of RGB and grey the picture has every byte already.
  if (keep_raw_ && layout.fourcc != kRgb3 && layout.fourcc != kGrey)
    all.raw_colour = keep_raw(layout, moment.video->bytes);
  if (moment.depth && all.depth.size() != all.bgr.size()) {
    if (keep_raw_) all.raw_depth = keep_raw(layout_of(moment.depth->mode), moment.depth->bytes);
    cv::Mat scaled;
    cv::resize(all.depth, scaled, all.bgr.size(), 0, 0, cv::INTER_NEAREST);
    all.depth = scaled;
  }
  return all;
}

}  // namespace choreo::devices::openni2
