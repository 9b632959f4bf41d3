// SPDX-License-Identifier: Apache-2.0
// Masks of a person: where the network and the difference have a word, and where one of them has none.
#include "vision/person_masker.hpp"

#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "support/frames.hpp"
#include "vision/scenes.hpp"
#include "vision/segmenter.hpp"

namespace choreo::vision {
namespace {

using test::iou;

const cv::Size kSize(160, 120);
const cv::Rect kBody(60, 30, 30, 70);
const cv::Scalar kRed(40, 40, 200);

cv::Mat room() {
  cv::Mat wall(kSize, CV_8UC3);
  for (int y = 0; y < wall.rows; ++y) {
    for (int x = 0; x < wall.cols; ++x)
      wall.at<cv::Vec3b>(y, x) = {std::uint8_t(90 + x / 4), std::uint8_t(110 + y / 4), 120};
  }
  return wall;
}
cv::Mat with(cv::Mat picture, cv::Rect what, cv::Scalar colour) {
  picture(what).setTo(colour);
  return picture;
}
cv::Mat mask_of(cv::Rect where) {
  cv::Mat mask = cv::Mat::zeros(kSize, CV_8UC1);
  mask(where).setTo(255);
  return mask;
}
PersonEvidence likely_at(cv::Rect where, double doubt_px = 0) { return {mask_of(where), doubt_px}; }

PersonMasker masker(const cv::Mat& plate, const cv::Mat& never_seen = {}) {
  BackgroundEstimate estimate;
  estimate.plate = plate;
  estimate.noise = 1;
  estimate.never_seen = never_seen;
  MaskOptions options;
  options.min_body_percent = 0.1;
  return {estimate, options};
}

TEST(PersonMasker, TheOutlineIsThePicturesAndNotTheNetworks) {
  // The network is two pixels off, and knows it.
  const auto off = likely_at({58, 28, 34, 74}, 3);
  const auto result = masker(room()).process(with(room(), kBody, kRed), off, 0);
  ASSERT_TRUE(result.body);
  EXPECT_GT(iou(result.mask, mask_of(kBody)), 0.97);
  EXPECT_EQ(result.inferred, 0);
}

TEST(PersonMasker, WhatNoLookCallsAPersonIsNoBody) {
  auto picture = with(room(), kBody, kRed);
  picture = with(picture, {110, 70, 30, 40}, {200, 200, 30});  // A chair,
  auto m = masker(room());
  EXPECT_GT(iou(m.process(picture, likely_at(kBody, 1), 0).mask, mask_of(kBody)), 0.97);
  const auto nobody = masker(room()).process(picture, {}, 0);
  EXPECT_FALSE(nobody.body);
  EXPECT_EQ(cv::countNonZero(nobody.mask), 0);
}

// A white coat on a wall, in which the network sees an arm.
TEST(PersonMasker, AHalfHeartedWordDoesNotOutweighWhatWasSeenThere) {
  const cv::Rect coat(90, 30, 24, 30);
  for (const bool seen : {true, false}) {
    for (const int likely : {150, 240}) {
      auto evidence = likely_at(kBody, 1);
      evidence.likely(coat).setTo(likely);
      const auto unseen = seen ? cv::Mat() : mask_of(coat);
      const auto result = masker(room(), unseen).process(with(room(), kBody, kRed), evidence, 0);
      const double share = cv::countNonZero(result.mask(coat)) / double(coat.area());
      EXPECT_NEAR(share, seen && likely < 191 ? 0 : 1, 0.2) << seen << likely;
    }
  }
}

// Upside down, say.
TEST(PersonMasker, WhomTheNetworkLosesIsFollowedByTheDifferenceForThreeSeconds) {
  auto m = masker(room());
  const auto beside = [](int k) { return kBody + cv::Point(k, 0); };
  (void)m.process(with(room(), kBody, kRed), likely_at(kBody, 1), 0);
  for (int k = 1; k <= 40; ++k) {
    const auto picture = with(with(room(), beside(k / 2), kRed), {130, 90, 20, 20}, {200, 200, 30});
    const auto result = m.process(picture, {}, 0.1 * k);
    ASSERT_EQ(result.body, k <= 30) << k;
    if (result.body) {
      ASSERT_GT(iou(result.mask, mask_of(beside(k / 2))), 0.97) << k;
    }
  }
}

TEST(PersonMasker, WhatComesInAtTheSideIsBodyUntilTheNetworkHasHadASecondToKnowIt) {
  auto m = masker(room());
  (void)m.process(room(), {}, 0);
  for (int k = 1; k <= 10; ++k) {
    const cv::Rect part(0, 30, 3 * k, 70);
    const auto result = m.process(with(room(), part, kRed), {}, 0.25 * k);
    ASSERT_EQ(result.body, k <= 5) << k;
    if (result.body) {
      ASSERT_GT(iou(result.mask, mask_of(part)), 0.9) << k;
    }
  }
  EXPECT_FALSE(masker(room()).process(with(room(), kBody, kRed), {}, 0).body) << "it did not come in";
}

TEST(PersonMasker, AFirstLookThatTakesAnArmForAllOfWhoComesInLosesNothing) {
  auto m = masker(room());
  for (int k = 0; k < 4; ++k) (void)m.process(with(room(), {0, 30, 10 * k, 70}, kRed), {}, 0.1 * k);
  const cv::Rect inside(4, 30, 30, 70);  // No longer at the border,
  const auto arm = likely_at({24, 50, 10, 20}, 1);
  EXPECT_GT(iou(m.process(with(room(), inside, kRed), arm, 0.4).mask, mask_of(inside)), 0.9);
  for (int k = 5; k < 20; ++k) (void)m.process(with(room(), inside, kRed), arm, 0.1 * k);
  EXPECT_LT(iou(m.process(with(room(), inside, kRed), arm, 2).mask, mask_of(inside)), 0.4) << "but not for good";
}

// A look at another scene: of the room nothing is known but what stands beside the person.
TEST(PersonMasker, AfterACutTheNetworkDecidesUntilTheRoomIsSeen) {
  auto m = masker(room());
  (void)m.process(with(room(), kBody, kRed), likely_at(kBody, 1), 0);
  cv::Mat other(kSize, CV_8UC3, cv::Scalar(20, 160, 40));
  for (int x = 0; x < kSize.width; x += 4) {
    other = with(other, {x, 0, 1, kSize.height}, {230, 40, 220});
    other = with(other, {x + 1, 0, 1, kSize.height}, {120, 220, 90});
    other = with(other, {x + 2, 0, 1, kSize.height}, {70, 90, 160});
  }
  const auto cut = m.process(with(other, kBody, kRed), likely_at(kBody, 1), 0.1);
  EXPECT_TRUE(cut.sudden);
  EXPECT_GT(iou(cut.mask, mask_of(kBody)), 0.97);
  EXPECT_GT(cut.inferred, 0);
  const auto after = m.process(with(other, kBody, kRed), likely_at(kBody, 1), 0.2);
  EXPECT_FALSE(after.sudden);
  EXPECT_GT(iou(after.mask, mask_of(kBody)), 0.97);
}

TEST(PersonMasker, WhatAHandHoldsIsBodyToo) {
  const cv::Rect fan(100, 40, 12, 20);
  const auto picture = with(with(room(), kBody, kRed), fan, kRed);
  auto person = likely_at(kBody, 1);
  EXPECT_EQ(cv::countNonZero(masker(room()).process(picture, person, 0).mask(fan)), 0);
  person.held.push_back({{95, 50}, {95, 50}, 25});
  EXPECT_GT(cv::countNonZero(masker(room()).process(picture, person, 0).mask(fan)), 0.95 * fan.area());
}

TEST(PersonMasker, WhatAHandHoldsStaysWhereALookIsMistakenAndGoesWhereItIsPutDown) {
  const cv::Rect fan(100, 40, 12, 20);
  const auto picture = with(with(room(), kBody, kRed), fan, kRed);
  auto person = likely_at(kBody, 1);
  auto holds = person;
  holds.held.push_back({{95, 50}, {95, 50}, 25});
  auto m = masker(room());
  (void)m.process(picture, holds, 0);
  EXPECT_GT(cv::countNonZero(m.process(picture, person, 0.1).mask(fan)), 0.95 * fan.area());
  (void)m.process(picture, person, 0.2);
  EXPECT_EQ(cv::countNonZero(m.process(picture, person, 0.5).mask(fan)), 0);
}

TEST(PersonMasker, ClothesLikeTheWallAreBodyWhereTheNetworkIsSure) {
  const auto face = with(room(), {68, 30, 14, 20}, kRed);
  auto person = likely_at(kBody, 2);
  auto result = masker(room()).process(face, person, 0);
  ASSERT_TRUE(result.body) << "nothing else differs from the wall";
  const cv::Rect sure(kBody.x + 2, kBody.y + 2, kBody.width - 4, kBody.height - 4);
  EXPECT_GT(iou(result.mask, mask_of(sure)), 0.97);
  person.limbs.push_back({{75, 40}, {75, 90}, 20});
  result = masker(room()).process(face, person, 0);
  EXPECT_GT(iou(result.mask, mask_of(kBody)), 0.97) << "about its bones";
}

TEST(PersonMasker, WhereTheRoomIsAsItWasSeenTheNetworkIsMistaken) {
  EXPECT_FALSE(masker(room()).process(room(), likely_at(kBody, 2), 0).body);
  EXPECT_TRUE(masker(room(), mask_of(kBody)).process(room(), likely_at(kBody, 2), 0).body) << "not seen";
}

TEST(PersonMasker, BeforeAWallThatWasNeverSeenTheNetworkDecidesAndItIsSaid) {
  const cv::Rect unseen(50, 50, 60, 30);
  // The plate has the body's colour there: no difference, and a ghost beside it.
  const auto result =
      masker(with(room(), unseen, kRed), mask_of(unseen)).process(with(room(), kBody, kRed), likely_at(kBody, 1), 0);
  EXPECT_GT(iou(result.mask, mask_of(kBody)), 0.97);
  EXPECT_NEAR(result.inferred, (kBody & unseen).area(), 0.05 * (kBody & unseen).area());
}

TEST(PersonMasker, WhatWasNeverSeenIsKnownOnceItIsSeenForSomeLooks) {
  const cv::Rect unseen(50, 30, 30, 70);
  auto m = masker(with(room(), unseen, kRed), mask_of(unseen));
  const cv::Rect away(120, 30, 30, 70);
  const auto look_away = [&](double time_s) { (void)m.process(with(room(), away, kRed), likely_at(away, 1), time_s); };
  const auto back = likely_at({56, 26, 38, 78}, 4);  // Wide of the mark: the difference has its word once it knows.
  // The silhouette that lacks all of the person, now and then, is no look at the wall.
  for (int k = 0; k < 20; ++k) {
    const auto& person = k % 5 == 4 ? back : likely_at(away, 1);
    (void)m.process(with(room(), kBody, kRed), person, 0.01 * k);
  }
  EXPECT_GT(m.process(with(room(), kBody, kRed), back, 0.2).inferred, 0);
  for (int k = 0; k < 8; ++k) look_away(0.3 + 0.01 * k);
  const auto result = m.process(with(room(), kBody, kRed), back, 0.4);
  EXPECT_GT(iou(result.mask, mask_of(kBody)), 0.97);
  EXPECT_EQ(result.inferred, 0);
}

// As a jacket that is like the wall does: what was taken for wall fades once the wall is seen.
TEST(PersonMasker, AGhostOfWhatTheNetworkLackedFades) {
  const cv::Rect unseen(50, 30, 30, 70), away(120, 30, 30, 70), near(70, 30, 40, 70);
  auto m = masker(with(room(), unseen, kRed), mask_of(unseen));
  for (int k = 0; k < 6; ++k) (void)m.process(with(room(), kBody, kRed), likely_at(away, 1), 0.01 * k);
  for (int k = 6; k < 60; ++k) (void)m.process(with(room(), away, kRed), likely_at(away, 1), 0.01 * k);
  // Somebody comes beside it.
  const auto result = m.process(with(room(), near, kRed), likely_at(near, 8), 1);
  EXPECT_GT(iou(result.mask, mask_of(near)), 0.97);
}

TEST(PersonMasker, ALookThatIsOldLeavesTheMaskToTheDifferenceAround) {
  // The person went on by 12 pixels since, and may have gone 15.
  const cv::Rect now(kBody.x + 12, kBody.y, kBody.width, kBody.height);
  const auto result = masker(room()).process(with(room(), now, kRed), likely_at(kBody, 15), 0);
  EXPECT_GT(iou(result.mask, mask_of(now)), 0.97);
}

TEST(PersonMasker, FollowsSlowLightBesideThePerson) {
  auto m = masker(room());
  cv::Mat last;
  for (int k = 0; k <= 100; ++k) {
    cv::Mat lit;
    room().convertTo(lit, -1, 1.0, 0.3 * k);
    last = with(lit, kBody, kRed);
    (void)m.process(last, likely_at(kBody, 1), 0.5 * k);
  }
  EXPECT_GT(iou(m.process(last, likely_at(kBody, 1), 51).mask, mask_of(kBody)), 0.95);
}

TEST(PersonMasker, AsASegmenterItGivesTheSame) {
  const auto picture = with(room(), kBody, kRed);
  const auto person = likely_at(kBody, 1);
  auto direct = masker(room());
  Segmenter segmenter(masker(room()));
  EXPECT_TRUE(segmenter.wants_person());
  EXPECT_TRUE(
      test::same_pixels(segmenter.process(picture, {}, 0, person).mask, direct.process(picture, person, 0).mask));
}

TEST(BackgroundBehindPeople, IsWhatIsSeenWhereNobodyIs) {
  // Three places, one picture each: a median would be wrong in none of them, two pictures of one place in half.
  std::vector<cv::Mat> pictures;
  std::vector<PersonEvidence> people;
  for (const int x : {20, 20, 20, 70, 110}) {
    const cv::Rect body(x, 30, 30, 70);
    pictures.push_back(with(room(), body, kRed));
    people.push_back(likely_at(body, 1));
  }
  const auto estimate = background_behind_people(pictures, people);
  cv::Mat difference;
  cv::absdiff(estimate.plate, room(), difference);
  EXPECT_LE(cv::norm(difference, cv::NORM_INF), 2) << "where somebody is most of the time, too";
  EXPECT_EQ(cv::countNonZero(estimate.never_seen), 0);
  EXPECT_EQ(estimate.unseen, 0);
  EXPECT_EQ(estimate.empty, 0);
  EXPECT_FALSE(estimate.uncertain());
}

TEST(BackgroundBehindPeople, APictureInWhichTheNetworkLostSomebodyTellsNothing) {
  std::vector<cv::Mat> pictures(9, with(room(), kBody, kRed));
  std::vector<PersonEvidence> people(9, likely_at(kBody, 1));
  people[0] = people[5] = people[6] = {};
  const auto lost = background_behind_people(pictures, people);
  EXPECT_EQ(cv::countNonZero(lost.never_seen & mask_of(kBody)), kBody.area());
  for (const std::size_t k : {2U, 3U, 4U}) {
    pictures[k] = room();
    people[k] = {};
  }
  const auto left = background_behind_people(pictures, people);
  EXPECT_EQ(cv::countNonZero(left.never_seen), 0) << "the room is empty in three in a row";
}

TEST(BackgroundBehindPeople, ARoomThatWasEmptyForAMomentWasSeenHoweverLongSomebodyStandsThereAfterwards) {
  std::vector<cv::Mat> pictures(60, with(room(), kBody, kRed));
  std::vector<PersonEvidence> people(60, likely_at(kBody, 1));
  for (std::size_t k = 0; k < 3; ++k) {
    pictures[k] = room();
    people[k] = {};
  }
  const auto estimate = background_behind_people(pictures, people);
  EXPECT_EQ(cv::countNonZero(estimate.never_seen), 0);
  EXPECT_TRUE(test::same_pixels(estimate.plate, room()));
  EXPECT_FALSE(estimate.uncertain());
}

TEST(BackgroundBehindPeople, KnowsWhatItNeverSaw) {
  const std::vector<cv::Mat> pictures(4, with(room(), kBody, kRed));
  const std::vector<PersonEvidence> people(4, likely_at(kBody, 1));
  const auto estimate = background_behind_people(pictures, people);
  EXPECT_EQ(cv::countNonZero(estimate.never_seen & mask_of(kBody)), kBody.area());
  EXPECT_LT(cv::countNonZero(estimate.never_seen), 2 * kBody.area());
  EXPECT_NEAR(estimate.unseen, 1, 1e-9);
  EXPECT_TRUE(estimate.uncertain());
  const std::vector<PersonEvidence> nobody(4);
  const auto empty = background_behind_people(std::vector<cv::Mat>(4, room()), nobody);
  EXPECT_EQ(empty.empty, 1);
  EXPECT_EQ(empty.unseen, 0);
}

TEST(PersonMasker, SomebodyElseIsNoBodyHoweverNearAndNoBackground) {
  const cv::Rect other(92, 30, 30, 70);  // Two pixels off.
  auto person = likely_at(kBody, 4);
  person.others = mask_of({95, 33, 24, 64});  // Their silhouette lacks three pixels all around.
  person.about_others = mask_of({88, 26, 38, 78});
  auto m = masker(room());
  const auto picture = with(with(room(), kBody, kRed), other, {200, 60, 60});
  for (int k = 0; k < 200; ++k) (void)m.process(picture, person, 0.1 * k);
  EXPECT_GT(iou(m.process(picture, person, 20).mask, mask_of(kBody)), 0.95);
  // They change places: what was behind them is the room.
  auto swapped = likely_at(other, 4);
  EXPECT_GT(iou(m.process(with(room(), other, {200, 60, 60}), swapped, 20.1).mask, mask_of(other)), 0.97);
}

TEST(PersonEvidence, TwoTogetherAreOne) {
  auto a = likely_at(kBody, 2);
  a.limbs.push_back({{60, 30}, {90, 90}, 4});
  auto b = likely_at({100, 30, 30, 70}, 3);
  b.limbs.push_back({{100, 30}, {120, 90}, 4});
  const auto both = together(a, b);
  EXPECT_EQ(cv::countNonZero(both.likely), cv::countNonZero(a.likely) + cv::countNonZero(b.likely));
  EXPECT_EQ(both.limbs.size(), 2u);
  EXPECT_EQ(both.doubt_px, 3);
  EXPECT_EQ(cv::countNonZero(a.likely), kBody.area()) << "and stay what they were";
  EXPECT_EQ(cv::countNonZero(together({}, b).likely != b.likely), 0);
  EXPECT_EQ(cv::countNonZero(together(a, {}).likely != a.likely), 0);
}

TEST(PersonEvidence, WhereTwoOverlapWhoIsLikelierHasThePlace) {
  auto person = likely_at(kBody);
  EXPECT_EQ(cv::countNonZero(others_alone(person, kSize)), 0);
  person.others = person.about_others = mask_of({80, 30, 30, 70});
  person.likely.setTo(200, person.likely);
  EXPECT_EQ(cv::countNonZero(others_alone(person, kSize)), 30 * 70);
  person.others.setTo(150, person.others);
  EXPECT_EQ(cv::countNonZero(others_alone(person, kSize)), 20 * 70);
}

}  // namespace
}  // namespace choreo::vision
