// SPDX-License-Identifier: Apache-2.0
// Depth finds its picture, and pictures become frames.
#include "devices/openni2/pairing.hpp"

#include <gmock/gmock.h>
#include <opencv2/core.hpp>

#include "devices/fourcc.hpp"
#include "devices/openni2/frame_maker.hpp"

namespace choreo::devices::openni2 {
namespace {

using ::testing::ElementsAre;

const Mode kColour{Sensor::kColour, kRgb3, 2, 1, 30};
const Mode kDepth{Sensor::kDepth, kZ16, 2, 1, 30};

Taken at(const Mode& mode, std::uint64_t time_us) { return {mode, 0, time_us, {}}; }

// The pairs as "colour-depth", times in us; "-" alone is no depth.
std::vector<std::string> pairs(Pairing& pairing) {
  std::vector<std::string> all;
  while (const auto moment = pairing.next()) {
    all.push_back((moment->video ? std::to_string(moment->video->time_us) : "") + "-" +
                  (moment->depth ? std::to_string(moment->depth->time_us) : ""));
  }
  return all;
}

TEST(OpenNi2Pairing, WhatHasTheSameTimeComesAtOnce) {
  Pairing pairing({kColour, kDepth});
  pairing.add(at(kColour, 100000));
  EXPECT_THAT(pairs(pairing), ElementsAre());
  pairing.add(at(kDepth, 100000));
  EXPECT_THAT(pairs(pairing), ElementsAre("100000-100000"));
  pairing.add(at(kDepth, 133333));
  pairing.add(at(kColour, 133333));
  EXPECT_THAT(pairs(pairing), ElementsAre("133333-133333"));
}

TEST(OpenNi2Pairing, TheNearestDepthIsTakenThoughALaterOneComesFirst) {
  Pairing pairing({kColour, kDepth});
  pairing.add(at(kDepth, 88000));  // 12 ms before: a nearer one may follow.
  pairing.add(at(kColour, 100000));
  EXPECT_THAT(pairs(pairing), ElementsAre());
  pairing.add(at(kDepth, 104000));
  EXPECT_THAT(pairs(pairing), ElementsAre("100000-104000"));
}

TEST(OpenNi2Pairing, HalfAFrameAwayIsTooFar) {
  Pairing pairing({kColour, kDepth});
  pairing.add(at(kColour, 100000));
  pairing.add(at(kDepth, 117000));
  EXPECT_THAT(pairs(pairing), ElementsAre("100000-"));
  pairing.add(at(kColour, 133333));
  EXPECT_THAT(pairs(pairing), ElementsAre()) << "117 is within half a frame, but a nearer one may follow";
  pairing.end();
  EXPECT_THAT(pairs(pairing), ElementsAre("133333-117000"));
}

TEST(OpenNi2Pairing, EachDepthIsUsedOnce) {
  Pairing pairing({kColour, kDepth});
  for (const auto time : {100000, 110000, 120000}) pairing.add(at(kColour, std::uint64_t(time)));
  pairing.add(at(kDepth, 110000));
  pairing.end();
  EXPECT_THAT(pairs(pairing), ElementsAre("100000-110000", "110000-", "120000-"));
}

TEST(OpenNi2Pairing, DepthThatFallsSilentHoldsNothingUpForLong) {
  Pairing pairing({kColour, kDepth});
  std::size_t out = 0;
  for (std::uint64_t k = 0; k < 100; ++k) {
    pairing.add(at(kColour, 33333 * k));
    out += pairs(pairing).size();
    EXPECT_GE(out + 3, k + 1);
  }
}

TEST(OpenNi2Pairing, DepthWithoutPicturesIsLetGoAndCountedBetweenThem) {
  Pairing pairing({kColour, kDepth});
  for (std::uint64_t k = 0; k < 10000; ++k) pairing.add(at(kDepth, 33333 * k));
  EXPECT_EQ(pairing.unpaired_depths(), 0U) << "the first picture is still to come";
  pairing.add(at(kColour, 33333 * 9999));
  EXPECT_THAT(pairs(pairing), ElementsAre("333296667-333296667"));
  pairing.add(at(kDepth, 33333 * 10000ULL));
  pairing.add(at(kDepth, 33333 * 10001ULL));
  pairing.add(at(kColour, 33333 * 10001ULL));
  EXPECT_THAT(pairs(pairing), ElementsAre("333363333-333363333"));
  EXPECT_EQ(pairing.unpaired_depths(), 1U);
}

TEST(OpenNi2Pairing, OneStreamAloneComesAsItIs) {
  Pairing depth({kDepth});
  depth.add(at(kDepth, 5));
  EXPECT_THAT(pairs(depth), ElementsAre("-5"));
  Pairing colour({kColour});
  colour.add(at(kColour, 5));
  colour.add(at(kColour, 6));
  EXPECT_THAT(pairs(colour), ElementsAre("5-", "6-"));
}

TEST(OpenNi2Frames, NearDepthIsWhiteFarDepthIsBlackAndTheUnknownToo) {
  const cv::Mat depth = (cv::Mat_<std::uint16_t>(1, 6) << 0, 1, 500, 2750, 5000, 65535);
  const auto grey = grey_of_depth(depth);
  std::vector<int> values;
  for (int x = 0; x < grey.cols; ++x) values.push_back(grey.at<cv::Vec3b>(0, x)[1]);
  EXPECT_THAT(values, ElementsAre(0, 255, 255, 128, 0, 0));
}

TEST(OpenNi2Frames, DepthOfAnotherSizeIsBroughtToThePictures) {
  Moment moment;
  moment.video = Taken{{Sensor::kColour, kRgb3, 4, 2, 30}, 0, 0, std::vector<std::uint8_t>(24, 9)};
  moment.depth = Taken{kDepth, 0, 0, {0x10, 0x27, 0x20, 0x4E}};  // 10000 and 20000, the low byte first.
  const auto pictures = FrameMaker(true).make(moment);
  ASSERT_EQ(pictures.depth.size(), cv::Size(4, 2));
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 4; ++x) EXPECT_EQ(pictures.depth.at<std::uint16_t>(y, x), x < 2 ? 10000 : 20000);
  }
  ASSERT_TRUE(pictures.raw_depth);
  EXPECT_EQ(pictures.raw_depth->bytes, moment.depth->bytes);
  EXPECT_EQ(pictures.raw_colour, nullptr) << "the picture has every byte";
}

TEST(OpenNi2Frames, RedIsFirstForOpenNi2AndLastForUs) {
  Moment moment;
  moment.video = Taken{kColour, 0, 0, {1, 2, 3, 4, 5, 6}};
  const auto pictures = FrameMaker(false).make(moment);
  EXPECT_EQ(pictures.bgr.at<cv::Vec3b>(0, 0), cv::Vec3b(3, 2, 1));
  EXPECT_EQ(pictures.bgr.at<cv::Vec3b>(0, 1), cv::Vec3b(6, 5, 4));
  EXPECT_TRUE(pictures.depth.empty());
}

}  // namespace
}  // namespace choreo::devices::openni2
