// SPDX-License-Identifier: Apache-2.0
// The page of a live run: where the video, the triangle and the figures stand in a window of any size.
#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "outputs/plot_canvas.hpp"

namespace choreo::outputs {

/// What a live page is for: similarities, or what is read in the picture and seen from far away.
enum class Leading { kTriangle, kVideo };

/// The places of a live page, in pixels.
///
/// What leads is as large as the window allows; the video fills the corner that the triangle leaves free on the left,
/// the key and the figures the one on the right.
struct LiveLayout {
  double em = 0;  ///< Height of the type.
  Box triangle;   ///< Twice as wide as high; its base is the lower edge.
  Box video;      ///< In the proportions of the video.
  Box figures;    ///< Key and lines of text, to the right of the triangle's tip.
};

/// @param width, height  of the window, at least 1 pixel each.
/// @param video  size of the video's pictures.
[[nodiscard]] LiveLayout live_layout(int width, int height, cv::Size video, Leading leading = Leading::kTriangle);

/// The page without what moves: time axis, lags, key.
/// @param span_s  seconds across the triangle's base.
/// @return CV_8UC3, BGR, height x width.
[[nodiscard]] cv::Mat draw_live_page(const LiveLayout& layout, int width, int height, double span_s);

/// The figures, line below line, for the box LiveLayout::figures.
/// @return CV_8UC3 of that box's size.
[[nodiscard]] cv::Mat draw_live_figures(const LiveLayout& layout, const std::vector<std::string>& lines);

/// What the triangle has where nothing has been yet, BGR.
[[nodiscard]] cv::Vec3b live_blank_colour();
/// What the triangle has where there was no body, BGR.
[[nodiscard]] cv::Vec3b live_gap_colour();

}  // namespace choreo::outputs
