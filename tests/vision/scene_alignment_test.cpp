// SPDX-License-Identifier: Apache-2.0
#include "vision/scene_alignment.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "vision/scenes.hpp"

namespace choreo::vision {
namespace {

using test::in_light;
using test::with_noise;

/// A room with furniture, larger than any picture of it: rectangles and discs of many colours.
cv::Mat room(std::uint64_t seed, cv::Size size = {800, 640}) {
  cv::Mat out(size, CV_8UC3, cv::Scalar(150, 160, 170));
  cv::RNG random(seed);
  for (int i = 0; i < 60; ++i) {
    const cv::Scalar colour(random.uniform(40, 220), random.uniform(40, 220), random.uniform(40, 220));
    const cv::Point at(random.uniform(0, size.width), random.uniform(0, size.height));
    if (i % 3 == 0) {
      cv::circle(out, at, random.uniform(5, 40), colour, cv::FILLED, cv::LINE_AA);
    } else {
      cv::rectangle(out, cv::Rect(at, cv::Size(random.uniform(8, 120), random.uniform(8, 120))), colour, cv::FILLED);
    }
  }
  cv::GaussianBlur(out, out, {3, 3}, 0.8);
  return out;
}

/// The middle of the room as a camera sees it.
cv::Mat seen(const cv::Mat& room, cv::Size size, double scale, double degrees, cv::Point2d shift) {
  const double turn = degrees * CV_PI / 180;
  const double c = scale * std::cos(turn);
  const double s = scale * std::sin(turn);
  const cv::Point2d middle(0.5 * (size.width - 1), 0.5 * (size.height - 1));
  const cv::Point2d room_middle(0.5 * (room.cols - 1), 0.5 * (room.rows - 1));
  // picture = c + s R (room - middle of the room) + shift
  const cv::Matx23d picture_from_room(c, -s, middle.x + shift.x - c * room_middle.x + s * room_middle.y,  //
                                      s, c, middle.y + shift.y - s * room_middle.x - c * room_middle.y);
  cv::Mat out;
  cv::warpAffine(room, out, picture_from_room, size, cv::INTER_LINEAR, cv::BORDER_REFLECT);
  return out;
}

void put_person(cv::Mat& picture, cv::Point at, int arm_degrees) {
  const cv::Scalar shirt(120, 60, 40);
  const cv::Scalar skin(120, 150, 210);
  cv::rectangle(picture, cv::Rect(at.x - 45, at.y, 90, 300), shirt, cv::FILLED);
  cv::circle(picture, at - cv::Point(0, 30), 30, skin, cv::FILLED);
  const double turn = arm_degrees * CV_PI / 180;
  cv::line(picture, at + cv::Point(40, 20),
           at + cv::Point(40 + int(150 * std::cos(turn)), 20 + int(150 * std::sin(turn))), skin, 26);
}

const cv::Size kSceneSize(600, 450);

/// Largest distance between where the transform takes the picture's corners and where they are, px.
double error_of(const SceneAlignment& found, double scale, double degrees, cv::Point2d shift) {
  const double turn = degrees * CV_PI / 180;
  double worst = 0;
  for (const auto& corner :
       {cv::Point2d(0, 0), cv::Point2d(kSceneSize.width - 1, 0), cv::Point2d(0, kSceneSize.height - 1),
        cv::Point2d(kSceneSize.width - 1, kSceneSize.height - 1)}) {
    const cv::Point2d from_middle = corner - cv::Point2d(0.5 * (kSceneSize.width - 1), 0.5 * (kSceneSize.height - 1));
    const cv::Point2d is(0.5 * (kSceneSize.width - 1) + shift.x +
                             scale * (std::cos(turn) * from_middle.x - std::sin(turn) * from_middle.y),
                         0.5 * (kSceneSize.height - 1) + shift.y +
                             scale * (std::sin(turn) * from_middle.x + std::cos(turn) * from_middle.y));
    const auto& m = found.picture_from_reference;
    const cv::Point2d says(m(0, 0) * corner.x + m(0, 1) * corner.y + m(0, 2),
                           m(1, 0) * corner.x + m(1, 1) * corner.y + m(1, 2));
    worst = std::max(worst, cv::norm(says - is));
  }
  return worst;
}

TEST(SceneAlignment, APictureLiesOnItselfExactly) {
  const auto picture = seen(room(1), kSceneSize, 1, 0, {});
  const auto found = align_scene(picture, picture);
  EXPECT_TRUE(found.aligned);
  EXPECT_GT(found.agreement, 0.99);
  EXPECT_LT(error_of(found, 1, 0, {}), 0.02);
}

TEST(SceneAlignment, ShiftScaleAndRotationAreFoundToAFractionOfAPixelBehindAPersonWhoMoves) {
  struct Case {
    double scale, degrees;
    cv::Point2d shift;
    double gain, offset;
  };
  const Case cases[] = {{1, 0, {12, -9}, 1, 0},        {1.01, 0.5, {-12, 7}, 1.15, -8}, {0.97, -2, {20, 15}, 0.8, 10},
                        {1.03, 2, {-30, -22}, 1.2, 0}, {0.99, 0, {0.5, 0.25}, 0.9, 4},  {1.02, -1.3, {29, -5}, 1, 15}};
  std::uint64_t seed = 3;
  for (const auto& c : cases) {
    const auto all = room(++seed);
    auto reference = seen(all, kSceneSize, 1, 0, {});
    auto picture = seen(all, kSceneSize, c.scale, c.degrees, c.shift);
    put_person(reference, {250, 130}, -60);
    put_person(picture, {265, 128}, 20);
    reference = with_noise(reference, 3, seed);
    picture = with_noise(in_light(picture, c.gain, c.offset), 3, seed + 50);
    EXPECT_TRUE(SceneSketch(reference).may_share(SceneSketch(picture)))
        << c.scale << " " << c.degrees << " " << c.shift;
    const auto found = align_scene(reference, picture);
    ASSERT_TRUE(found.aligned) << c.scale << " " << c.degrees << " " << c.shift << " agreement " << found.agreement;
    EXPECT_LT(error_of(found, c.scale, c.degrees, c.shift), 1) << c.scale << " " << c.degrees << " " << c.shift;
  }
}

TEST(SceneAlignment, OtherRoomsAreNoSharedScene) {
  for (std::uint64_t seed = 20; seed < 23; ++seed) {
    auto one = seen(room(seed), kSceneSize, 1, 0, {});
    auto other = seen(room(seed + 100), kSceneSize, 1, 0, {});
    put_person(one, {250, 130}, 0);
    put_person(other, {250, 130}, 0);
    const auto found = align_scene(one, other);
    EXPECT_FALSE(found.aligned) << seed << " agreement " << found.agreement;
    EXPECT_EQ(found.picture_from_reference, cv::Matx23d(1, 0, 0, 0, 1, 0));
  }
}

TEST(SceneAlignment, WhatIsFlatOrNoiseOrTinyIsNotAligned) {
  const cv::Mat flat(kSceneSize, CV_8UC3, cv::Scalar(90, 120, 150));
  EXPECT_FALSE(align_scene(flat, flat).aligned);
  EXPECT_FALSE(align_scene(with_noise(flat, 8, 1), with_noise(flat, 8, 2)).aligned);
  EXPECT_FALSE(align_scene(flat, seen(room(1), kSceneSize, 1, 0, {})).aligned);
  EXPECT_FALSE(align_scene(seen(room(1), kSceneSize, 1, 0, {}), flat).aligned);
  const cv::Mat tiny(5, 900, CV_8UC3, cv::Scalar::all(9));
  EXPECT_FALSE(align_scene(tiny, tiny).aligned);
  const cv::Mat one(1, 1, CV_8UC3, cv::Scalar::all(9));
  EXPECT_FALSE(align_scene(one, one).aligned);
}

TEST(SceneAlignment, LargePicturesAreAlignedAsWell) {
  const auto all = room(7, {2000, 1500});
  const cv::Size large(1600, 1200);
  const auto found = align_scene(seen(all, large, 1, 0, {}), seen(all, large, 1, 0, {40, -31}));
  ASSERT_TRUE(found.aligned);
  EXPECT_NEAR(found.picture_from_reference(0, 2), 40, 0.5);
  EXPECT_NEAR(found.picture_from_reference(1, 2), -31, 0.5);
}

TEST(SceneSketch, LikensPicturesOfOneRoomAndFewOfOthers) {
  std::vector<SceneSketch> rooms;
  for (std::uint64_t seed = 0; seed < 30; ++seed) rooms.emplace_back(seen(room(200 + seed), kSceneSize, 1, 0, {}));
  int alike = 0;
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    EXPECT_NEAR(rooms[i].likeness(rooms[i]), 1, 1e-5);
    for (std::size_t k = 0; k < i; ++k) alike += rooms[i].may_share(rooms[k]) ? 1 : 0;
  }
  EXPECT_LT(alike, 435 / 20);
}

TEST(SceneSketch, WhatIsFlatOrOfOtherProportionsIsLikeNothing) {
  const SceneSketch picture(seen(room(1), kSceneSize, 1, 0, {}));
  EXPECT_EQ(picture.likeness(SceneSketch(cv::Mat(kSceneSize, CV_8UC3, cv::Scalar(90, 120, 150)))), 0);
  EXPECT_EQ(picture.likeness(SceneSketch(seen(room(1), {450, 600}, 1, 0, {}))), 0);
  EXPECT_EQ(SceneSketch(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(9))).likeness(picture), 0);
}

}  // namespace
}  // namespace choreo::vision
