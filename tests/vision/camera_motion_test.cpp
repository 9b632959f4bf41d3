// SPDX-License-Identifier: Apache-2.0
#include "vision/camera_motion.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "devices/synthetic/performer.hpp"
#include "vision/background_estimate.hpp"
#include "vision/segmenter.hpp"

namespace choreo::vision {
namespace {

// How far it takes the picture's farthest corner, px.
double farthest(const CameraShift& shift, cv::Size size) {
  double most = 0;
  for (const auto& corner : {cv::Point2d(0, 0), cv::Point2d(size.width - 1, 0), cv::Point2d(0, size.height - 1),
                             cv::Point2d(size.width - 1, size.height - 1)}) {
    const cv::Vec2d to = shift * cv::Vec3d(corner.x, corner.y, 1);
    most = std::max(most, std::hypot(to[0] - corner.x, to[1] - corner.y));
  }
  return most;
}

cv::Mat painted_room() {
  devices::synthetic::PerformerSettings settings;
  settings.size = {320, 240};
  settings.room = "cluttered";
  return devices::synthetic::Performer("idle", settings).room();
}

CameraShift turned(double degrees, double scale, cv::Point2d by) {
  CameraShift shift(cv::getRotationMatrix2D({160, 120}, degrees, scale));
  shift(0, 2) += by.x;
  shift(1, 2) += by.y;
  return shift;
}

double apart(const CameraShift& a, const CameraShift& b) {
  return farthest({1 + a(0, 0) - b(0, 0), a(0, 1) - b(0, 1), a(0, 2) - b(0, 2), a(1, 0) - b(1, 0),
                   1 + a(1, 1) - b(1, 1), a(1, 2) - b(1, 2)},
                  {320, 240});
}

TEST(CameraMotion, FindsShiftsTurnsAndScalesToAThirdOfAPixel) {
  const auto room = painted_room();
  const CameraMotion camera(room);
  for (const auto& truth : {turned(0, 1, {3.4, -2.2}), turned(1, 1, {-6, 4}), turned(-0.7, 1.02, {9, 0.5})}) {
    cv::Mat picture;
    cv::warpAffine(room, picture, truth, room.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    const auto found = camera.of(picture);
    ASSERT_TRUE(found);
    EXPECT_LT(apart(*found, truth), 0.34);
  }
}

TEST(CameraMotion, ACameraThatStandsStillDoesSoToTheLastBit) {
  auto room = painted_room();
  const CameraMotion camera(room);
  cv::Mat noise(room.size(), CV_16SC3), noisy;
  cv::RNG(7).fill(noise, cv::RNG::NORMAL, cv::Scalar::all(0), cv::Scalar::all(4));
  cv::add(room, noise, noisy, {}, CV_8U);
  EXPECT_EQ(camera.of(noisy), std::optional(kNoShift));
}

TEST(CameraMotion, WhoMovesInFrontHasNoWord) {
  const auto room = painted_room();
  const CameraMotion camera(room);
  const auto truth = turned(0, 1, {4, 2});
  cv::Mat picture;
  cv::warpAffine(room, picture, truth, room.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  for (int y = 60; y < 230; ++y) {
    for (int x = 110; x < 200; ++x) {
      picture.at<cv::Vec3b>(y, x) = (x / 6 + y / 6) % 2 == 0 ? cv::Vec3b(200, 40, 40) : cv::Vec3b(30, 30, 90);
    }
  }
  const auto found = camera.of(picture);
  ASSERT_TRUE(found);
  EXPECT_LT(apart(*found, truth), 0.34);
}

TEST(CameraMotion, OfAnotherRoomOrNoneItSaysNothing) {
  const CameraMotion camera(painted_room());
  EXPECT_FALSE(camera.of(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(90))));
  cv::Mat noise(240, 320, CV_8UC3);
  cv::RNG(7).fill(noise, cv::RNG::UNIFORM, 0, 255);
  EXPECT_FALSE(camera.of(noise));
  const CameraMotion plain(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(90)));
  EXPECT_FALSE(plain.can_tell());
  EXPECT_FALSE(plain.of(noise));
  const CameraMotion tiny(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(90)));
  EXPECT_FALSE(tiny.of(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(9))));
}

TEST(CameraMotion, AMaskOfAPictureThatIsBroughtBackIsTakenAlong) {
  const auto shift = turned(0, 1, {5, -3});
  cv::Mat mask = cv::Mat::zeros(240, 320, CV_8UC1);
  mask(cv::Rect(100, 100, 40, 60)).setTo(255);
  cv::Mat expected = cv::Mat::zeros(240, 320, CV_8UC1);
  expected(cv::Rect(105, 97, 40, 60)).setTo(255);
  EXPECT_EQ(cv::countNonZero(taken_along(mask, shift, cv::Mat::zeros(mask.size(), CV_8UC1)) != expected), 0);
  const auto room = painted_room();
  cv::Mat moved;
  cv::warpAffine(room, moved, shift, room.size(), cv::INTER_LINEAR);
  EXPECT_EQ(cv::norm(brought_back(moved, shift, room), room, cv::NORM_INF), 0) << "what is beyond is the room's";
}

TEST(CameraMotion, ABlowAtTheTripodIsNoShakingAndAPanNeither) {
  const std::optional<CameraShift> moved = turned(0, 1, {5, -3});
  std::vector<std::optional<CameraShift>> shifts(10, kNoShift);
  EXPECT_EQ(kind_of(shifts, true), CameraKind::kStill);
  shifts[4] = shifts[5] = moved;
  EXPECT_EQ(kind_of(shifts, true), CameraKind::kStill);
  shifts[7] = moved;
  EXPECT_EQ(kind_of(shifts, true), CameraKind::kShakes);
  EXPECT_EQ(kind_of(shifts, false), CameraKind::kStill);
  shifts[0] = shifts[1] = shifts[2] = std::nullopt;
  EXPECT_EQ(kind_of(shifts, true), CameraKind::kShakes);
  shifts[3] = std::nullopt;
  EXPECT_EQ(kind_of(shifts, true), CameraKind::kMayMove);
}

cv::Mat moved(const cv::Mat& picture, const CameraShift& shift) {
  cv::Mat out;
  cv::warpAffine(picture, out, shift, picture.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return out;
}

cv::Mat body_at(cv::Rect where) {
  cv::Mat mask = cv::Mat::zeros(240, 320, CV_8UC1);
  mask(where).setTo(255);
  return mask;
}

TEST(CameraMotion, ItExplainsWhatDiffersAllOverAndNotAloneWhereSomebodyLeans) {
  const auto room = painted_room();
  const auto shift = turned(0, 1, {6, 3});
  const std::vector<std::optional<CameraShift>> shifts = {shift};
  const std::vector<cv::Mat> shaken = {moved(room, shift)};
  EXPECT_TRUE(explains(shifts, shaken, room));
  std::vector<cv::Mat> leaning = {room.clone()};
  const cv::Rect middle(110, 60, 100, 120);
  shaken[0](middle).copyTo(leaning[0](middle));
  EXPECT_FALSE(explains(shifts, leaning, room));
  EXPECT_FALSE(explains(std::vector<std::optional<CameraShift>>{std::nullopt}, shaken, room));
}

PersonEvidence seen(const cv::Mat& mask) {
  PersonEvidence person;
  person.likely = mask;
  person.doubt_px = 2;
  return person;
}

BackgroundEstimate plate_of(const cv::Mat& room, CameraKind camera = CameraKind::kStill) {
  BackgroundEstimate estimate;
  estimate.plate = room;
  estimate.camera = camera;
  return estimate;
}

double overlap(const cv::Mat& a, const cv::Mat& b) {
  return double(cv::countNonZero(a & b)) / std::max(1, cv::countNonZero(a | b));
}

const cv::Rect kBody(120, 60, 60, 120);
const cv::Scalar kShirt(40, 30, 220);

TEST(SegmenterOfAMovingCamera, BeforeACameraThatShakesTheMaskIsWhereTheBodyIs) {
  const auto room = painted_room();
  auto with_body = room.clone();
  with_body.setTo(kShirt, body_at(kBody));
  Segmenter by_colour(BodyMasker(room, 1, {}));
  Segmenter of_person(PersonMasker(plate_of(room), {}));
  for (auto* segmenter : {&by_colour, &of_person}) {
    segmenter->follow_camera(plate_of(room, CameraKind::kShakes));
    double time_s = 0;
    for (const auto& shift : {turned(0, 1, {0, 0}), turned(0.5, 1, {7, -4}), turned(-1, 1.01, {-9, 3})}) {
      const auto truth = moved(body_at(kBody), shift);
      // The network rounds off.
      cv::Mat rounded;
      cv::erode(truth, rounded, cv::getStructuringElement(cv::MORPH_RECT, {7, 7}));
      const auto result = segmenter->process(moved(with_body, shift), {}, time_s += 0.1, seen(rounded));
      EXPECT_GT(overlap(result.mask, truth > 127), 0.95) << shift;
      EXPECT_EQ(result.area, cv::countNonZero(result.mask));
      EXPECT_TRUE(result.body);
    }
  }
}

TEST(SegmenterOfAMovingCamera, WhereTheRoomIsNotFoundAgainTheNetworkAloneHasAWord) {
  const auto room = painted_room();
  cv::Mat other(room.size(), CV_8UC3);
  cv::RNG(7).fill(other, cv::RNG::UNIFORM, 0, 255);
  Segmenter by_colour(BodyMasker(room, 1, {}));
  by_colour.follow_camera(plate_of(room, CameraKind::kShakes));
  EXPECT_FALSE(by_colour.process(other, {}, 0).body);
  Segmenter of_person(PersonMasker(plate_of(room), {}));
  of_person.follow_camera(plate_of(room, CameraKind::kShakes));
  EXPECT_GT(overlap(of_person.process(other, {}, 0, seen(body_at(kBody))).mask, body_at(kBody)), 0.99);
  EXPECT_FALSE(of_person.process(other, {}, 1).body);
}

TEST(SegmenterOfAMovingCamera, OfOneThatMovesTheNetworkAloneHasAWordUntilItStandsStill) {
  const auto room = painted_room();
  Segmenter segmenter(PersonMasker(plate_of(room), {}));
  segmenter.follow_camera(plate_of(room, CameraKind::kMayMove));
  double time_s = 0;
  const auto shown = [&](double pan, cv::Rect body, const cv::Mat& silhouette) {
    auto picture = moved(room, turned(0, 1, {pan, 0}));
    picture.setTo(kShirt, body_at(body));
    return segmenter.process(picture, {}, time_s += 0.1, seen(silhouette)).mask;
  };
  for (int k = 1; k <= 8; ++k) EXPECT_GT(overlap(shown(-10.0 * k, kBody, body_at(kBody)), body_at(kBody)), 0.99) << k;
  for (int k = 0; k < 8; ++k) (void)shown(-80, kBody, body_at(kBody));
  // What is behind them now was seen meanwhile: the outline is the picture's.
  const cv::Rect beside = kBody + cv::Point(80, 0);
  const cv::Rect less(beside.x + 3, beside.y + 3, beside.width - 6, beside.height - 6);
  EXPECT_GT(overlap(shown(-80, beside, body_at(less)), body_at(beside)), 0.97);
}

TEST(SegmenterOfAMovingCamera, ASlowPanAddsUpAndNobodyIsKeptWhereTheyWere) {
  const auto room = painted_room();
  Segmenter segmenter(PersonMasker(plate_of(room), {}));
  segmenter.follow_camera(plate_of(room, CameraKind::kMayMove));
  int moved_frames = 0;
  MaskResult result;
  for (int k = 1; k <= 40; ++k) {
    auto picture = moved(room, turned(0, 1, {-0.4 * k, 0}));
    picture.setTo(kShirt, body_at(kBody));
    result = segmenter.process(picture, {}, 0.04 * k, seen(body_at(kBody)));
    moved_frames += result.camera_moved ? 1 : 0;
  }
  EXPECT_GT(overlap(result.mask, body_at(kBody)), 0.97);
  EXPECT_GE(moved_frames, 4);
  // The network loses them while the camera moves on.
  EXPECT_FALSE(segmenter.process(moved(room, turned(0, 1, {-40, 0})), {}, 2, {}).body);
}

TEST(SegmenterOfAMovingCamera, SomebodyWhoStepsBeforeMostCornersIsNoMove) {
  const auto room = painted_room();
  Segmenter segmenter(BodyMasker(room, 1, {}));
  segmenter.follow_camera(plate_of(room, CameraKind::kMayMove));
  auto with_body = room.clone();
  with_body(cv::Rect(10, 10, 300, 220)).setTo(kShirt);
  for (int k = 0; k < 10; ++k) EXPECT_FALSE(segmenter.process(k < 5 ? room : with_body, {}, 0.1 * k).camera_moved) << k;
}

TEST(SegmenterOfAMovingCamera, AShakenOneThatStandsElsewhereForASecondIsTakenAsItStands) {
  const auto room = painted_room();
  cv::Mat elsewhere;
  cv::flip(room, elsewhere, 0);
  auto with_body = elsewhere.clone();
  with_body.setTo(kShirt, body_at(kBody));
  Segmenter segmenter(BodyMasker(room, 1, {}));
  segmenter.follow_camera(plate_of(room, CameraKind::kShakes));
  for (int k = 0; k < 60; ++k) (void)segmenter.process(elsewhere, {}, 0.1 * k);
  const auto result = segmenter.process(with_body, {}, 6);
  EXPECT_FALSE(result.camera_moved);
  EXPECT_GT(overlap(result.mask, body_at(kBody)), 0.95);
}

TEST(SegmenterOfAMovingCamera, ALookIsOfTheFrameItWasMadeAt) {
  const auto room = painted_room();
  auto estimate = plate_of(room, CameraKind::kShakes);
  estimate.never_seen = body_at(kBody);  // So that the network's word is the mask.
  Segmenter segmenter(PersonMasker(estimate, {}));
  segmenter.follow_camera(estimate);
  const auto then = turned(0, 1, {9, 0}), now = turned(0, 1, {-9, 0});
  auto person = seen(moved(body_at(kBody), then));
  person.seen_s = 0.1;
  (void)segmenter.process(moved(room, then), {}, 0.1, person);
  const auto mask = segmenter.process(moved(room, now), {}, 0.2, person).mask;
  EXPECT_GT(overlap(mask, moved(body_at(kBody), now)), 0.95);
}

TEST(CameraMotion, AnotherLightIsNoMovement) {
  const auto room = painted_room();
  const auto shift = turned(0, 1, {6, 3});
  cv::Mat brighter;
  moved(room, shift).convertTo(brighter, -1, 1.1, 25);
  EXPECT_TRUE(explains(std::vector<std::optional<CameraShift>>{shift}, std::vector<cv::Mat>{brighter}, room));
}

}  // namespace
}  // namespace choreo::vision
