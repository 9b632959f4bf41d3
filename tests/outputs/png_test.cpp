// SPDX-License-Identifier: Apache-2.0
#include "outputs/png.hpp"

#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "support/frames.hpp"

namespace choreo::outputs {
namespace {

cv::Mat read_back(const std::string& file) {
  return cv::imdecode(std::vector<std::uint8_t>(file.begin(), file.end()), cv::IMREAD_UNCHANGED);
}

TEST(Png, KeepsEveryPixel) {
  const auto picture = test::noise({31, 17}, CV_8UC3, 3);
  EXPECT_TRUE(test::same_pixels(read_back(png_of(picture)), picture));
  const cv::Mat part = picture(cv::Rect(5, 2, 9, 11));
  EXPECT_TRUE(test::same_pixels(read_back(png_of(part)), part)) << "whose rows do not follow each other in memory";
}

TEST(Png, IsAsHighAsASheetOfThousands) {
  const auto picture = test::noise({3, 70000}, CV_8UC3, 4);
  EXPECT_TRUE(test::same_pixels(read_back(png_of(picture)), picture));
}

}  // namespace
}  // namespace choreo::outputs
