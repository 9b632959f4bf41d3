// SPDX-License-Identifier: Apache-2.0
// Outlines of people, drawn by hand.
#pragma once

#include <vector>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace choreo::test {

/// CV_8UC1, 255 inside of the body's polygons and outside of its holes, all in pixels of the frame.
inline cv::Mat filled(const nlohmann::json& body, const nlohmann::json& holes, cv::Size size) {
  cv::Mat mask = cv::Mat::zeros(size, CV_8UC1);
  const auto fill = [&](const nlohmann::json& polygons, int value) {
    for (const auto& polygon : polygons) {
      std::vector<cv::Point> points;
      for (const auto& p : polygon) points.emplace_back(cvRound(p.at(0).get<double>()), cvRound(p.at(1).get<double>()));
      cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{points}, value);
    }
  };
  fill(body, 255);
  fill(holes, 0);
  return mask;
}

}  // namespace choreo::test
