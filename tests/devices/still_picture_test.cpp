// SPDX-License-Identifier: Apache-2.0
// Picture files of every kind, made by OpenCV's codecs, which the program does without.
#include "devices/media/still_picture.hpp"

#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "devices/media/picture_check.hpp"
#include "support/frames.hpp"

namespace choreo::devices {
namespace {

using test::noise;
using test::same_pixels;
using Bytes = std::vector<std::uint8_t>;

Bytes encoded(const std::string& ending, const cv::Mat& picture, const std::vector<int>& settings = {}) {
  Bytes file;
  EXPECT_TRUE(cv::imencode(ending, picture, file, settings)) << ending;
  return file;
}

// Smooth, with every colour: lossy codecs keep it.
cv::Mat colours(cv::Size size) {
  cv::Mat small = noise({6, 5}, CV_8UC3, 4);
  cv::Mat picture;
  cv::resize(small, picture, size, 0, 0, cv::INTER_CUBIC);
  return picture;
}

TEST(StillPicture, LosslessKindsComeBackByteForByte) {
  const auto picture = noise({7, 5}, CV_8UC3, 1);
  for (const auto* ending : {".png", ".bmp", ".ppm", ".tif"}) {
    EXPECT_TRUE(same_pixels(decode_picture(encoded(ending, picture)), picture)) << ending;
  }
  EXPECT_TRUE(same_pixels(decode_picture(encoded(".ppm", picture, {cv::IMWRITE_PXM_BINARY, 0})), picture))
      << "in digits";
}

TEST(StillPicture, LossyKindsComeBackAsOtherDecodersHaveThem) {
  const auto picture = colours({320, 240});
  const std::vector<std::pair<std::string, std::vector<int>>> kinds = {
      {".jpg", {cv::IMWRITE_JPEG_QUALITY, 90}},
      {".jpg", {cv::IMWRITE_JPEG_QUALITY, 90, cv::IMWRITE_JPEG_PROGRESSIVE, 1}},
      {".webp", {cv::IMWRITE_WEBP_QUALITY, 90}}};
  for (const auto& [ending, settings] : kinds) {
    const auto file = encoded(ending, picture, settings);
    const auto ours = decode_picture(file);
    const cv::Mat theirs = cv::imdecode(file, cv::IMREAD_COLOR);
    ASSERT_EQ(ours.size(), theirs.size()) << ending;
    EXPECT_LT(cv::norm(ours, theirs, cv::NORM_L1) / double(3 * picture.total()), 1.0) << ending;
    EXPECT_LT(cv::norm(ours, theirs, cv::NORM_INF), 10) << ending;
    EXPECT_EQ(decode_picture(encoded(ending, colours({161, 119}), settings)).size(), cv::Size(161, 119)) << ending;
  }
}

TEST(StillPicture, SixteenBitsBecomeEightAndGreyIsSpread) {
  const cv::Mat sixteen = (cv::Mat_<std::uint16_t>(1, 3) << 0, 128 * 257, 65535);
  const cv::Mat eight = (cv::Mat_<std::uint8_t>(1, 3) << 0, 128, 255);
  const cv::Mat expected =
      (cv::Mat_<cv::Vec3b>(1, 3) << cv::Vec3b(0, 0, 0), cv::Vec3b(128, 128, 128), cv::Vec3b(255, 255, 255));
  for (const auto* ending : {".png", ".pgm", ".tif"}) {
    EXPECT_TRUE(same_pixels(decode_picture(encoded(ending, sixteen)), expected)) << ending;
    EXPECT_TRUE(same_pixels(decode_picture(encoded(ending, eight)), expected)) << ending;
  }
  const cv::Mat colour(2, 3, CV_16UC3, cv::Scalar(20 * 257, 120 * 257, 220 * 257));
  for (const auto* ending : {".png", ".ppm", ".tif"}) {
    EXPECT_TRUE(same_pixels(decode_picture(encoded(ending, colour)), cv::Mat(2, 3, CV_8UC3, cv::Scalar(20, 120, 220))))
        << ending;
  }
}

TEST(StillPicture, MasksOfOneBitAndTransparencyAreReadWithoutEither) {
  const cv::Mat mask =
      (cv::Mat_<std::uint8_t>(2, 9) << 255, 0, 255, 0, 0, 0, 0, 255, 255, 0, 0, 0, 255, 255, 0, 0, 0, 255);
  cv::Mat spread;
  cv::cvtColor(mask, spread, cv::COLOR_GRAY2BGR);
  EXPECT_TRUE(same_pixels(decode_picture(encoded(".png", mask, {cv::IMWRITE_PNG_BILEVEL, 1})), spread));
  EXPECT_TRUE(same_pixels(decode_picture(encoded(".pbm", mask)), spread));
  const cv::Mat glass(3, 4, CV_8UC4, cv::Scalar(10, 20, 30, 0));
  EXPECT_TRUE(same_pixels(decode_picture(encoded(".png", glass)), cv::Mat(3, 4, CV_8UC3, cv::Scalar(10, 20, 30))));
}

// The same JPEG with an EXIF segment that says nothing but how the camera was held.
Bytes held(const Bytes& jpeg, std::uint8_t orientation) {
  const Bytes exif = {0xff, 0xe1, 0,    34,   'E', 'x', 'i', 'f', 0, 0, 'M', 'M',         0, 42, 0, 0, 0, 8,
                      0,    1,    0x01, 0x12, 0,   3,   0,   0,   0, 1, 0,   orientation, 0, 0,  0, 0, 0, 0};
  Bytes file(jpeg.begin(), jpeg.begin() + 2);
  file.insert(file.end(), exif.begin(), exif.end());
  file.insert(file.end(), jpeg.begin() + 2, jpeg.end());
  return file;
}

TEST(StillPicture, TheOrientationInExifIsApplied) {
  // Columns and rows of a photograph of which 1 is the upper left quarter, 2 the upper right, 3 and 4 below them.
  cv::Mat picture(32, 48, CV_8UC1);
  const std::array<int, 4> grey = {30, 90, 150, 220};
  for (int k = 0; k < 4; ++k) picture(cv::Rect(k % 2 * 24, k / 2 * 16, 24, 16)).setTo(grey[std::size_t(k)]);
  const auto jpeg = encoded(".jpg", picture, {cv::IMWRITE_JPEG_QUALITY, 100});
  // EXIF 2.32, 4.6.4 A: which side of the scene row 0 and column 0 are.
  const std::array<std::array<int, 4>, 8> quarters = {
      {{0, 1, 2, 3}, {1, 0, 3, 2}, {3, 2, 1, 0}, {2, 3, 0, 1}, {0, 2, 1, 3}, {2, 0, 3, 1}, {3, 1, 2, 0}, {1, 3, 0, 2}}};
  for (std::uint8_t orientation = 1; orientation <= 8; ++orientation) {
    const auto upright = decode_picture(held(jpeg, orientation));
    ASSERT_EQ(upright.size(), orientation <= 4 ? cv::Size(48, 32) : cv::Size(32, 48)) << int(orientation);
    for (int k = 0; k < 4; ++k) {
      const cv::Point middle(upright.cols * (1 + k % 2 * 2) / 4, upright.rows * (1 + k / 2 * 2) / 4);
      EXPECT_NEAR(upright.at<cv::Vec3b>(middle)[0], grey[std::size_t(quarters[orientation - 1U][std::size_t(k)])], 3)
          << "orientation " << int(orientation) << ", quarter " << k;
    }
  }
}

TEST(StillPicture, WhatIsNoPictureIsEmptyAndSoIsADamagedOne) {
  EXPECT_TRUE(decode_picture({}).empty());
  const std::string words = "not a picture";
  EXPECT_TRUE(decode_picture(Bytes(words.begin(), words.end())).empty());
  const auto picture = noise({12, 10}, CV_8UC3, 5);
  for (const auto* ending : {".png", ".jpg", ".bmp", ".ppm", ".webp", ".tif"}) {
    const auto whole = encoded(ending, picture);
    for (std::size_t bytes = 0; bytes < 60; ++bytes) {
      EXPECT_TRUE(decode_picture(std::span(whole).first(bytes)).empty()) << ending << " cut to " << bytes;
    }
  }
  auto png = encoded(".png", picture);
  png[png.size() / 2] ^= 1;
  EXPECT_TRUE(decode_picture(png).empty()) << "a checksum is wrong";
  // A header that promises 60000 x 60000 pixels.
  const std::string huge = "P6\n60000 60000\n255\n";
  EXPECT_TRUE(decode_picture(Bytes(huge.begin(), huge.end())).empty());
}

TEST(StillPicture, ATiffWhoseRowsAreDamagedIsNone) {
  const auto whole = encoded(".tif", noise({64, 48}, CV_8UC3, 6), {cv::IMWRITE_TIFF_COMPRESSION, 5});  // LZW.
  ASSERT_FALSE(decode_picture(whole).empty());
  EXPECT_TRUE(decode_picture(std::span(whole).first(whole.size() * 3 / 4)).empty());
}

TEST(StillPicture, EveryTruncationIsFound) {
  const auto picture = noise({12, 10}, CV_8UC3, 5);
  for (const auto* ending : {".png", ".jpg", ".bmp", ".ppm", ".webp"}) {
    const auto whole = encoded(ending, picture);
    EXPECT_TRUE(is_whole_picture(whole)) << ending;
    ASSERT_GT(whole.size(), 50U) << ending;
    // With fewer bytes the format cannot be told, and the decoder refuses them itself.
    for (std::size_t bytes = 13; bytes < whole.size(); ++bytes) {
      ASSERT_FALSE(is_whole_picture({whole.data(), bytes})) << ending << " cut to " << bytes;
    }
    for (std::size_t bytes = 0; bytes < 13; ++bytes) {
      const Bytes alone(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(bytes));
      (void)is_whole_picture(alone);  // Reads nothing beyond, which AddressSanitizer watches.
    }
  }
}

}  // namespace
}  // namespace choreo::devices
