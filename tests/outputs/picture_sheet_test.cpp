// SPDX-License-Identifier: Apache-2.0
// The sheet of a set: every picture stands above its caption, whatever its shape and however it is called.
#include "outputs/picture_sheet.hpp"

#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace choreo::outputs {
namespace {

SheetTile tile(cv::Size size, cv::Scalar colour, const std::string& letter = "R") {
  SheetTile out;
  out.picture = cv::Mat(size_on_sheet(size), CV_8UC3, colour);
  out.name = "IMG_0001.jpg";
  out.letter = letter;
  out.beside = "0.98, then D";
  return out;
}

// The box of all pixels of that colour.
cv::Rect where(const cv::Mat& sheet, const cv::Scalar& colour) {
  cv::Mat same;
  cv::inRange(sheet, colour, colour, same);
  std::vector<cv::Point> places;
  cv::findNonZero(same, places);
  cv::Rect box;
  for (const auto& p : places) box |= cv::Rect(p, cv::Size(1, 1));
  return box;
}

int differing(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  return cv::countNonZero(difference.reshape(1));
}

TEST(PictureSheet, HasSixPicturesARowAndNoneOverAnother) {
  std::vector<SheetTile> tiles(8, tile({640, 480}, {9, 9, 9}));
  tiles[1] = tile({640, 480}, {250, 10, 30});
  tiles[6] = tile({480, 640}, {20, 250, 40});
  const auto sheet = picture_sheet(tiles);
  const auto second = where(sheet, {250, 10, 30});
  const auto seventh = where(sheet, {20, 250, 40});
  EXPECT_EQ(second.size(), cv::Size(320, 240));
  EXPECT_EQ(seventh.size(), cv::Size(320, 427)) << "as high as it is";
  EXPECT_GT(seventh.y, second.br().y + 40) << "the caption stands between";
  EXPECT_LT(seventh.x, second.x);
  EXPECT_EQ(where(sheet, {9, 9, 9}).br().y, seventh.br().y) << "pictures of a row stand upon one line";
  EXPECT_GE(sheet.rows, seventh.br().y + 40);
}

TEST(PictureSheet, CaptionsTellLettersApartAndShowADashForNone) {
  const auto with = picture_sheet(std::vector{tile({640, 480}, {9, 9, 9}, "R")});
  const auto other = picture_sheet(std::vector{tile({640, 480}, {9, 9, 9}, "B")});
  const auto none = picture_sheet(std::vector{tile({640, 480}, {9, 9, 9}, "")});
  const auto word = picture_sheet(std::vector{tile({640, 480}, {9, 9, 9}, "NUMERALS")});
  EXPECT_GT(differing(with, other), 100);
  EXPECT_GT(differing(with, none), 100);
  // Where the letter would stand, a bar of 30 x 5 pixels.
  const cv::Mat corner = none(cv::Rect(12, 12 + 240, 50, 50));
  EXPECT_EQ(where(corner, corner.at<cv::Vec3b>(26, 20)).size(), cv::Size(30, 5));
  EXPECT_EQ(word.size(), with.size());
}

TEST(PictureSheet, NamesOfAnyLengthAndBytesKeepBelowTheirOwnPicture) {
  std::vector<SheetTile> tiles(2, tile({640, 480}, {9, 9, 9}));
  const auto usual = picture_sheet(tiles);
  tiles[0].name = std::string(300, 'W') + "\xff\n\x01.jpg";
  tiles[0].beside = std::string(300, 'W');
  const auto sheet = picture_sheet(tiles);
  ASSERT_EQ(sheet.size(), usual.size());
  const cv::Rect right(12 + 320 + 6, 0, sheet.cols - (12 + 320 + 6), sheet.rows);
  EXPECT_EQ(differing(sheet(right), usual(right)), 0);
  EXPECT_GT(differing(sheet, usual), 100);
}

TEST(PictureSheet, ThinPicturesAreThereAndTallOnesAreSqueezed) {
  EXPECT_EQ(size_on_sheet({5000, 2}), cv::Size(320, 1));
  EXPECT_EQ(size_on_sheet({2, 5000}), cv::Size(320, 640));
  EXPECT_EQ(size_on_sheet({32, 24}), cv::Size(320, 240));
  EXPECT_TRUE(picture_sheet({}).empty());
}

TEST(PictureSheet, TakesNoMoreMemoryThanItSays) {
  const std::vector<SheetTile> tiles(30, tile({100, 400}, {9, 9, 9}));
  const auto sheet = picture_sheet(tiles);
  EXPECT_LE(3 * (sheet.total() + 30 * tiles[0].picture.total()), bytes_of_sheet(30));
}

}  // namespace
}  // namespace choreo::outputs
