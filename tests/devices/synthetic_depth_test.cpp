// SPDX-License-Identifier: Apache-2.0
// What the synthetic performer's depth camera sees: the room and the body at their distances, with a Kinect's faults.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "devices/synthetic/depth_camera.hpp"
#include "devices/synthetic/synthetic_source.hpp"
#include "support/drawn_masks.hpp"
#include "support/performers.hpp"

namespace choreo::devices {
namespace {

using synthetic::Performer;
using test::performer_of;
using test::same_bytes;

double median(const cv::Mat& depth, const cv::Mat& where) {
  std::vector<unsigned short> values;
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = 0; x < depth.cols; ++x) {
      const auto z = depth.at<unsigned short>(y, x);
      if (where.at<unsigned char>(y, x) != 0 && z != 0) values.push_back(z);
    }
  }
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

TEST(SyntheticDepth, IsThereOnlyWhenAskedForAndChangesNothingElse) {
  const auto without = performer_of("walking?size=96x80&seed=5&shake=1.5&duration=1");
  const auto with = performer_of("walking?size=96x80&seed=5&shake=1.5&duration=1&depth=1");
  for (const int index : {0, 31, 40}) {
    const auto a = without.perform(index);
    const auto b = with.perform(index);
    EXPECT_TRUE(a.depth.empty());
    ASSERT_EQ(b.depth.type(), CV_16UC1);
    EXPECT_EQ(b.depth.size(), b.bgr.size());
    EXPECT_TRUE(same_bytes(a.bgr, b.bgr)) << index;
    EXPECT_TRUE(same_bytes(a.mask, b.mask)) << index;
  }
  EXPECT_THROW((void)performer_of("walking?depth=2"), Error);
}

TEST(SyntheticDepth, TheSourceDeliversThePerformersDepth) {
  Registry registry;
  registry.add(synthetic_driver());
  const std::string script = "jumping-jacks?size=64x48&duration=0.2&empty=0&depth=1";
  const auto source = registry.open("synthetic://" + script);
  const auto performer = performer_of(script);
  ASSERT_EQ(performer.frame_count(), 6);
  for (int i = 0; i < performer.frame_count(); ++i) {
    const auto frame = source->read({});
    ASSERT_TRUE(frame) << i;
    EXPECT_FALSE(frame->depth.empty()) << i;
    EXPECT_TRUE(same_bytes(frame->depth, performer.perform(i).depth)) << i;
  }
}

TEST(SyntheticDepth, TheSameSettingsGiveTheSameBytesInAnyOrder) {
  const std::string text = "side-kicks?size=96x80&seed=5&shake=1.5&empty=0.1&duration=0.5&depth=1";
  const auto one = performer_of(text);
  const auto other = performer_of(text);
  std::vector<cv::Mat> forwards;
  for (int i = 0; i < one.frame_count(); ++i) forwards.push_back(one.perform(i).depth);
  for (int i = other.frame_count() - 1; i >= 0; --i) {
    EXPECT_TRUE(same_bytes(other.perform(i).depth, forwards[static_cast<std::size_t>(i)])) << i;
  }
  EXPECT_FALSE(same_bytes(forwards[0], forwards[1])) << "noise is new in every frame";
  EXPECT_FALSE(same_bytes(forwards[0], performer_of("side-kicks?size=96x80&seed=6&shake=1.5&empty=0.1&duration=0.5&"
                                                    "depth=1")
                                           .perform(0)
                                           .depth));
}

TEST(SyntheticDepth, TheRoomIsAWallAskewAndAFloorThatComesNearer) {
  const auto depth = performer_of("empty?size=640x480&depth=1").perform(0).depth;
  const auto part = [&](cv::Rect where) {
    cv::Mat mask = cv::Mat::zeros(depth.size(), CV_8UC1);
    mask(where).setTo(255);
    return median(depth, mask);
  };
  EXPECT_NEAR(part({300, 100, 40, 40}), 3500, 60);
  EXPECT_GT(part({600, 100, 40, 40}), part({0, 100, 40, 40}) + 150);
  EXPECT_NEAR(part({0, 456, 640, 1}), 2500, 100) << "under the performer's feet, at 0.95 of the height";
  EXPECT_LT(part({0, 478, 640, 2}), 2100);
  // One pixel in 200 drops out; 307200 / 200 = 1536, standard deviation 39.
  EXPECT_NEAR(double(cv::countNonZero(depth == 0)), 1536, 160);
}

TEST(SyntheticDepth, TheBodyStandsAtTwoAndAHalfMetresAndIsRound) {
  const auto performer = performer_of("stillness?size=640x480&depth=1&seed=3");
  const auto frame = performer.perform(60);
  cv::Mat core, rim;
  cv::erode(frame.mask, rim, cv::Mat(), {-1, -1}, 2);
  cv::erode(frame.mask, core, cv::Mat(), {-1, -1}, 12);
  rim.setTo(0, core);
  const double body = median(frame.depth, core);
  EXPECT_GT(body, 2200);
  EXPECT_LT(body, 2500);
  EXPECT_GT(median(frame.depth, rim), body + 30) << "the trunk's middle is nearer than rims and thin limbs";
}

TEST(SyntheticDepth, AnArmHeldForwardIsNearerThanTheTrunk) {
  const auto stage = synthetic::make_stage({640, 480});
  const auto look = synthetic::choose_look(1, "medium", "light", "auto");
  const synthetic::DepthCamera camera(stage, look, 1);
  body::Pose pose;
  pose.arm[body::kLeft].flexion = 90;
  // A stand-in for the silhouette: the hand points at the camera, and the arm's circle is inside this square.
  const auto shoulder = body::skeleton_of(pose).shoulder[body::kLeft];
  const cv::Point at(static_cast<int>(stage.centre_x + stage.unit * shoulder.x()),
                     static_cast<int>(stage.floor_y - stage.unit * shoulder.y()));
  cv::Mat body = cv::Mat::zeros(stage.size, CV_8UC1);
  body(cv::Rect(at - cv::Point(4, 4), cv::Size(8, 8))).setTo(255);
  const auto depth = camera.film(0, body, pose, {0, 0});
  // Upper arm and forearm with hand: 3/8 of 1.75 m.
  EXPECT_NEAR(median(depth, body), 2500 - 656, 60);
}

TEST(SyntheticDepth, TheProjectorsShadowLiesOnTheBodysLeftAsWideAsTheDisparitiesDiffer) {
  const auto frame = performer_of("stillness?size=640x480&depth=1").perform(60);
  // f b (1/z_body - 1/z_wall) = 43500 (1/2500 - 1/3400) = 4.6 pixels, for the trunk's rim before the wall.
  double left = 0, right = 0;
  int rows = 0;
  for (int y = 200; y < 300; ++y) {
    const auto* mask = frame.mask.ptr<unsigned char>(y);
    const int first = static_cast<int>(std::find(mask, mask + 640, 255) - mask);
    int last = 639;
    while (mask[last] == 0) --last;
    const auto* z = frame.depth.ptr<unsigned short>(y);
    for (int k = 2; k < 12; ++k) {
      left += z[first - k] == 0;
      right += z[last + k] == 0;
    }
    ++rows;
  }
  EXPECT_NEAR(left / rows, 4.6 - 1 + 0.5, 1.2) << "of ten, beginning with the second beside the body";
  EXPECT_LT(right / rows, 0.2) << "only what drops out";
}

TEST(SyntheticDepth, NoiseGrowsWithTheSquareOfTheDistanceAndValuesAreStepsOfDisparity) {
  const auto performer = performer_of("empty?size=160x120&depth=1&duration=3");
  cv::Mat1d sum = cv::Mat1d::zeros(120, 160), squares = cv::Mat1d::zeros(120, 160), seen = cv::Mat1d::zeros(120, 160);
  for (int i = 0; i < 60; ++i) {
    const auto depth = performer.perform(i).depth;
    for (int y = 0; y < depth.rows; ++y) {
      for (int x = 0; x < depth.cols; ++x) {
        const double z = depth.at<unsigned short>(y, x);
        if (z == 0) continue;
        const double step = std::round(8 * 580 * 75 / z);
        ASSERT_EQ(z, std::round(8 * 580 * 75 / step));
        sum(y, x) += z;
        squares(y, x) += z * z;
        seen(y, x) += 1;
      }
    }
  }
  const auto deviation_of_rows = [&](int from, int to) {
    double variance = 0;
    int count = 0;
    for (int y = from; y < to; ++y) {
      for (int x = 0; x < 160; ++x, ++count) {
        const double mean = sum(y, x) / seen(y, x);
        variance += squares(y, x) / seen(y, x) - mean * mean;
      }
    }
    return std::sqrt(variance / count);
  };
  // The sensor's noise and a quantisation by q = z^2 / 348000 add up to sqrt(s^2 + q^2/12) on average.
  const auto expected = [](double z) {
    const double s = 2 * (z / 2000) * (z / 2000), q = z * z / 348000;
    return std::sqrt(s * s + q * q / 12);
  };
  EXPECT_NEAR(deviation_of_rows(20, 60), expected(3500), 1.5);
  // Of the floor, where a whole row lies within one step, only that it is much less.
  EXPECT_LT(deviation_of_rows(110, 120), 0.6 * expected(3500));
}

}  // namespace
}  // namespace choreo::devices
