// SPDX-License-Identifier: Apache-2.0
#include "vision/shared_wall.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "vision/scene_alignment.hpp"
#include "vision/scenes.hpp"

namespace choreo::vision {
namespace {

using test::in_light;
using test::with_noise;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

const cv::Size kSetSize(320, 240);
const cv::Scalar kSkin(120, 150, 210);

cv::Mat set_room(std::uint64_t seed) {
  cv::Mat out(kSetSize + cv::Size(60, 60), CV_8UC3, cv::Scalar(150, 160, 170));
  cv::RNG random(seed);
  for (int i = 0; i < 70; ++i) {
    const cv::Scalar colour(random.uniform(60, 200), random.uniform(60, 200), random.uniform(60, 200));
    cv::rectangle(out,
                  cv::Rect(random.uniform(0, out.cols), random.uniform(0, out.rows), random.uniform(6, 60),
                           random.uniform(6, 60)),
                  colour, cv::FILLED);
  }
  cv::GaussianBlur(out, out, {3, 3}, 0.8);
  return out;
}

/// The set_room shifted by whole pixels, with an arm in place k of the picture.
cv::Mat shot(const cv::Mat& set_room, cv::Point shift, int k, double gain, std::uint64_t seed) {
  cv::Mat out = set_room(cv::Rect(cv::Point(30, 30) - shift, kSetSize)).clone();
  cv::rectangle(out, cv::Rect(40 + 40 * k + shift.x, 90 + shift.y, 20, 70), kSkin, cv::FILLED);
  return with_noise(in_light(out, gain), 2, seed);
}

TEST(SharedWall, ShowsTheRoomAndEachPicturesArmAlthoughTheCameraAndTheLightChange) {
  const auto all = set_room(3);
  const std::vector<cv::Point> shifts = {{0, 0}, {8, -5}, {-7, 6}, {3, 9}, {-9, -4}, {5, 2}};
  std::vector<cv::Mat> pictures;
  for (int k = 0; k < 6; ++k) {
    pictures.push_back(shot(all, shifts[std::size_t(k)], k, 0.9 + 0.04 * k, 10 + std::uint64_t(k)));
  }
  const auto scenes = shared_scenes(pictures).value();
  ASSERT_EQ(scenes.size(), 1u);
  ASSERT_THAT(scenes[0].members, ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_GE(scenes[0].canvas.width, kSetSize.width + 14) << "all of every picture is on the canvas";
  EXPECT_LE(scenes[0].canvas.width, kSetSize.width + 20);
  const SharedWall wall(pictures, scenes[0]);
  EXPECT_LT(wall.noise(), 3);
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    const auto& m = scenes[0].picture_from_canvas[k];
    const auto against = wall.compare(pictures[k], m);
    // The arm's middle, without its rim.
    const cv::Point at(cvRound(40 + 40 * double(k) + shifts[k].x - m(0, 2)), cvRound(90 + shifts[k].y - m(1, 2)));
    const cv::Rect arm(at + cv::Point(3, 3), cv::Size(14, 64));
    EXPECT_GT(cv::countNonZero(against.differs(arm)), 0.8 * arm.area()) << k;
    cv::Mat elsewhere = against.differs.clone();
    elsewhere(cv::Rect(at - cv::Point(3, 3), cv::Size(26, 76))).setTo(0);
    EXPECT_LT(cv::countNonZero(elsewhere), 0.03 * double(elsewhere.total())) << k;
    EXPECT_EQ(cv::countNonZero(against.differs & ~against.covered), 0) << k;
  }
}

TEST(SharedWall, ScenesAreToldApartAndStrangersAreInNone) {
  const auto one = set_room(3);
  const auto other = set_room(4);
  const std::vector<cv::Mat> pictures = {shot(one, {0, 0}, 0, 1, 1),    shot(other, {4, 2}, 1, 1, 2),
                                         shot(one, {5, 5}, 2, 1, 3),    shot(set_room(5), {0, 0}, 3, 1, 4),
                                         shot(other, {-3, 1}, 4, 1, 5), shot(one, {-6, 2}, 5, 1, 6)};
  const auto scenes = shared_scenes(pictures).value();
  ASSERT_EQ(scenes.size(), 2u);
  EXPECT_THAT(scenes[0].members, ElementsAre(0, 2, 5));
  EXPECT_THAT(scenes[1].members, ElementsAre(1, 4));
}

TEST(SharedWall, OnePictureOrNoneSharesNothing) {
  EXPECT_THAT(shared_scenes({}).value(), IsEmpty());
  const std::vector<cv::Mat> one = {shot(set_room(3), {}, 0, 1, 1)};
  EXPECT_THAT(shared_scenes(one).value(), IsEmpty());
  const std::vector<cv::Mat> sizes = {one.front(), one.front()(cv::Rect(0, 0, 200, 200)).clone()};
  EXPECT_THAT(shared_scenes(sizes).value(), IsEmpty());
}

// Every pair aligned would be 2000 alignments, a minute or two.
TEST(SharedWall, ManyStrangersCostFewAlignments) {
  std::vector<cv::Mat> pictures;
  for (int k = 0; k < 64; ++k)
    pictures.push_back(shot(set_room(100 + std::uint64_t(k)), {}, k % 6, 1, std::uint64_t(k)));
  std::size_t alike = 0;
  std::vector<SceneSketch> sketches;
  for (const auto& picture : pictures) {
    for (const auto& other : sketches) alike += SceneSketch(picture).may_share(other) ? 1 : 0;
    sketches.emplace_back(picture);
  }
  EXPECT_LT(alike, 2016 / 10U);
  double share = 0;
  EXPECT_THAT(shared_scenes(pictures, [&](double done) { share = done; }).value(), IsEmpty());
  EXPECT_LT(share, 0.8) << "more than four alignments a picture";
}

TEST(SharedWall, GroupingTellsHowFarItIsAndStopsWhereItIsAskedTo) {
  const auto all = set_room(3);
  std::vector<cv::Mat> pictures;
  for (int k = 0; k < 6; ++k) pictures.push_back(shot(all, {k, -k}, k, 1, std::uint64_t(k)));
  double before = 0;
  int reports = 0;
  ASSERT_TRUE(shared_scenes(pictures, [&](double share) {
    EXPECT_GE(share, before);
    EXPECT_LE(share, 1);
    before = share;
    ++reports;
  }));
  EXPECT_GT(reports, 0);
  EXPECT_GT(before, 0.4);
  std::stop_source stop;
  EXPECT_FALSE(shared_scenes(
      pictures, [&](double) { stop.request_stop(); }, stop.get_token()));
}

}  // namespace
}  // namespace choreo::vision
