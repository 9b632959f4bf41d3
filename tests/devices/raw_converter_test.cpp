// SPDX-License-Identifier: Apache-2.0
// What becomes of the bytes that a device gives.
#include "devices/media/raw_converter.hpp"

#include <gmock/gmock.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/error.hpp"
#include "devices/fourcc.hpp"
#include "support/frames.hpp"

namespace choreo::devices {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

cv::Mat to_bgr(const Layout& layout, const std::vector<std::uint8_t>& bytes) {
  return RawConverter().to_bgr(layout, bytes);
}

// Two pixels: neutral grey of luma 126 is 1.164 (126 - 16) = 128.
TEST(RawConverter, AllFormatsShowTheSameGrey) {
  const auto grey = [](std::uint32_t fourcc, std::size_t stride, std::vector<std::uint8_t> bytes) {
    return to_bgr({fourcc, {2, 2}, stride}, bytes);
  };
  const auto is_grey = [](const cv::Mat& picture, int level) {
    return cv::countNonZero(cv::abs(picture.reshape(1) - level) > 1) == 0;
  };
  const std::uint8_t y = 126, n = 128;
  EXPECT_TRUE(is_grey(grey(kYuyv, 4, {y, n, y, n, y, n, y, n}), 128));
  EXPECT_TRUE(is_grey(grey(kUyvy, 4, {n, y, n, y, n, y, n, y}), 128));
  EXPECT_TRUE(is_grey(grey(kYvyu, 4, {y, n, y, n, y, n, y, n}), 128));
  EXPECT_TRUE(is_grey(grey(kNv12, 2, {y, y, y, y, n, n}), 128));
  EXPECT_TRUE(is_grey(grey(kGrey, 2, {99, 99, 99, 99}), 99));
  EXPECT_TRUE(is_grey(grey(kBgr3, 6, std::vector<std::uint8_t>(12, 77)), 77));
}

TEST(RawConverter, ChannelsAreInTheirPlaces) {
  const std::vector<std::uint8_t> bytes = {10, 20, 30};
  EXPECT_EQ(to_bgr({kBgr3, {1, 1}, 3}, bytes).at<cv::Vec3b>(0, 0), cv::Vec3b(10, 20, 30));
  EXPECT_EQ(to_bgr({kRgb3, {1, 1}, 3}, bytes).at<cv::Vec3b>(0, 0), cv::Vec3b(30, 20, 10));
  // Y 81, Cb 90, Cr 240: red.
  const std::vector<std::uint8_t> red = {81, 90, 81, 240};
  const auto picture = to_bgr({kYuyv, {2, 1}, 4}, red);
  EXPECT_GT(picture.at<cv::Vec3b>(0, 0)[2], 240);
  EXPECT_LT(picture.at<cv::Vec3b>(0, 0)[0], 15);
}

TEST(RawConverter, LinesMayBeLongerThanThePicture) {
  std::vector<std::uint8_t> bytes = {1, 2, 99, 3, 4, 99};
  const auto picture = to_bgr({kGrey, {2, 2}, 3}, bytes);
  EXPECT_EQ(picture.at<cv::Vec3b>(1, 1)[0], 4);
  EXPECT_EQ(bytes_of({kGrey, {2, 2}, 3}), 6U);
  EXPECT_EQ(bytes_of({kNv12, {4, 4}, 4}), 24U);
}

TEST(RawConverter, KeepsNothingOfTheDriversMemory) {
  std::vector<std::uint8_t> bytes(12, 5);
  const auto picture = to_bgr({kBgr3, {2, 2}, 6}, bytes);
  std::fill(bytes.begin(), bytes.end(), 200);
  EXPECT_EQ(picture.at<cv::Vec3b>(0, 0)[0], 5);
}

TEST(RawConverter, WhatIsKeptHasNoPadding) {
  const std::vector<std::uint8_t> bytes = {1, 2, 99, 3, 4, 99};
  EXPECT_THAT(keep_raw({kGrey, {2, 2}, 3}, bytes)->bytes, ElementsAre(1, 2, 3, 4));
  const std::vector<std::uint8_t> dense = {1, 2, 3, 4, 5, 6, 7};
  EXPECT_THAT(keep_raw({kNv12, {2, 2}, 2}, dense)->bytes, ElementsAre(1, 2, 3, 4, 5, 6)) << "the buffer is longer";
  const std::vector<std::uint8_t> padded = {1, 2, 99, 3, 4, 99, 5, 6, 99};
  EXPECT_THAT(keep_raw({kNv12, {2, 2}, 3}, padded)->bytes, ElementsAre(1, 2, 3, 4, 5, 6))
      << "the colours' line as well";
  EXPECT_THAT(keep_raw({kMjpg, {2, 2}, 0}, dense)->bytes, testing::SizeIs(7));
}

TEST(RawConverter, RefusesWhatIsNoPicture) {
  const auto refused = [](const Layout& layout, std::size_t bytes) {
    const auto error = test::error_of([&] { (void)to_bgr(layout, std::vector<std::uint8_t>(bytes)); });
    return error ? std::string(error->what()) : "converted";
  };
  EXPECT_THAT(refused({kYuyv, {3, 2}, 6}, 12), HasSubstr("YUYV 3x2")) << "two pixels share their colours";
  EXPECT_THAT(refused({kNv12, {2, 3}, 2}, 64), HasSubstr("NV12 2x3"));
  EXPECT_THAT(refused({kGrey, {4, 4}, 4}, 15), HasSubstr("15 bytes"));
  EXPECT_THAT(refused({kGrey, {0, 4}, 0}, 15), HasSubstr("no picture"));
  EXPECT_THAT(refused({fourcc("ABCD"), {4, 4}, 4}, 64), HasSubstr("ABCD"));
  EXPECT_THAT(refused({kZ16, {4, 4}, 8}, 64), HasSubstr("no colour format"));
}

class Mjpg : public ::testing::Test {
 protected:
  static cv::Mat picture(int level) {
    cv::Mat drawn(48, 64, CV_8UC3, cv::Scalar(level, 128, 255 - level));
    drawn(cv::Rect(16, 16, 32, 16)).setTo(cv::Scalar(20, 200, 30));
    return drawn;
  }
  static std::vector<std::uint8_t> jpeg(int level) {
    std::vector<std::uint8_t> bytes;
    cv::imencode(".jpg", picture(level), bytes, {cv::IMWRITE_JPEG_QUALITY, 97});
    return bytes;
  }
  const Layout layout_{kMjpg, {64, 48}, 0};
  RawConverter converter_;
};

TEST_F(Mjpg, PacketsAreDecodedOneByOne) {
  for (const int level : {0, 90, 200}) {
    const auto got = converter_.to_bgr(layout_, jpeg(level));
    ASSERT_EQ(got.size(), cv::Size(64, 48));
    EXPECT_LT(cv::norm(got, picture(level), cv::NORM_L1) / (3.0 * 64 * 48), 4) << "level " << level;
  }
}

TEST_F(Mjpg, ADamagedPacketIsRefusedAndTheNextOneIsRead) {
  auto cut = jpeg(90);
  cut.resize(cut.size() / 2);
  EXPECT_THROW((void)converter_.to_bgr(layout_, cut), Error);
  EXPECT_THROW((void)converter_.to_bgr(layout_, std::vector<std::uint8_t>(500, 7)), Error);
  EXPECT_THROW((void)converter_.to_bgr(layout_, std::vector<std::uint8_t>{}), Error);
  EXPECT_FALSE(converter_.to_bgr(layout_, jpeg(90)).empty());
}

TEST_F(Mjpg, APictureOfAnotherSizeIsRefused) {
  EXPECT_THROW((void)converter_.to_bgr({kMjpg, {32, 48}, 0}, jpeg(90)), Error);
  EXPECT_FALSE(converter_.to_bgr(layout_, jpeg(90)).empty());
}

}  // namespace
}  // namespace choreo::devices
