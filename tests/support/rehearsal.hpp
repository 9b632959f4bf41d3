// SPDX-License-Identifier: Apache-2.0
// The synthetic performer before a test's camera, and how well what the camera gave is masked.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "devices/synthetic/performer.hpp"
#include "pipeline/working_size.hpp"
#include "vision/scenes.hpp"
#include "vision/segmenter.hpp"

namespace choreo::test {

/// A few pictures of the empty room, then twice as many of the performer, with what is true of them.
struct Rehearsal {
  static constexpr std::size_t kEmpty = 8;
  std::vector<devices::synthetic::Performance> truth;

  Rehearsal(cv::Size size, bool depth) {
    devices::synthetic::PerformerSettings settings;
    settings.size = size;
    settings.depth = depth;
    const devices::synthetic::Performer performer("jumping-jacks", settings);
    for (std::size_t k = 0; k < kEmpty; ++k) truth.push_back(performer.perform(int(k)));
    for (int k = performer.first_frame() + 5; truth.size() < 3 * kEmpty; k += 9) truth.push_back(performer.perform(k));
  }
};

/// The picture with the mask's border drawn on it, above the mask.
inline cv::Mat outlined(const cv::Mat& picture, const cv::Mat& mask) {
  cv::Mat inner, white, out = picture.clone();
  cv::erode(mask, inner, {});
  out.setTo(cv::Scalar(0, 255, 255), mask & ~inner);
  cv::cvtColor(mask, white, cv::COLOR_GRAY2BGR);
  cv::vconcat(out, white, out);
  return out;
}

/// Masks what a camera gave, and expects a body exactly where the performer was there. Draws four of the masks into the
/// folder that CHOREO_PICTURES names.
/// @param name      of the camera.
/// @param pictures  CV_8UC3; the k-th shows `rehearsal.truth[k]`, at any size.
/// @param depths    CV_16UC1 of the pictures' size; empty: masked by colour.
/// @return Mean intersection over union of the masks with the truth.
inline double mean_iou(const std::string& name, const Rehearsal& rehearsal, const std::vector<cv::Mat>& pictures,
                       const std::vector<cv::Mat>& depths = {}) {
  constexpr auto kEmpty = Rehearsal::kEmpty;
  std::optional<vision::Segmenter> segmenter;
  if (depths.empty()) {
    const std::span room(pictures.data(), kEmpty);
    segmenter.emplace(vision::BodyMasker(vision::judge_plate(vision::median_plate(room), room), {}));
  } else {
    const auto room = vision::learn_depth_background({depths.data(), kEmpty});
    segmenter.emplace(std::nullopt, vision::DepthMasker(room, {}, {}), vision::MaskOptions{});
  }
  cv::Mat sheet;
  double sum = 0;
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    const auto found = segmenter->process(pictures[k], depths.empty() ? cv::Mat() : depths[k], double(k) / 30);
    EXPECT_EQ(found.body, k >= kEmpty) << name << ", picture " << k;
    if (k < kEmpty) continue;
    const cv::Mat is = pipeline::at_working_size(rehearsal.truth[k].mask, pictures[k].size()) >= 128;
    sum += iou(found.mask, is);
    if (k % 4 != 0) continue;
    const auto next = outlined(pictures[k], found.mask);
    if (sheet.empty())
      sheet = next;
    else
      cv::hconcat(sheet, next, sheet);
  }
  const auto masks = pictures.size() - kEmpty;
  std::printf("%s: mean IoU %.4f over %zu masks\n", name.c_str(), sum / double(masks), masks);
  if (const char* folder = std::getenv("CHOREO_PICTURES")) {
    EXPECT_TRUE(cv::imwrite(std::string(folder) + "/" + name + ".png", sheet));
  }
  return sum / double(masks);
}

}  // namespace choreo::test
