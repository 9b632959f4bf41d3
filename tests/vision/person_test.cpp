// SPDX-License-Identifier: Apache-2.0
// Where a look's numbers lie in the picture, and whom a search follows.
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "vision/person/person_search.hpp"
#include "vision/tiny_pose.hpp"

namespace choreo::vision {
namespace {

using ::testing::HasSubstr;

cv::Mat black(cv::Size size) { return cv::Mat(size, CV_8UC3, cv::Scalar()); }
cv::Mat with_spot(cv::Size size, cv::Rect spot) {
  auto picture = black(size);
  picture(spot).setTo(cv::Scalar::all(255));
  return picture;
}

PersonNetwork network(std::array<float, 5> nose) {
  std::vector<std::array<float, 5>> points(39);
  points[0] = nose;
  points[33] = {128, 128, 0, 0, 0};
  points[34] = {128, 64, 0, 0, 0};
  return PersonNetwork(test::tiny_landmarks(points));
}

TEST(PersonNetwork, NumbersOfTheRegionBecomePlacesInThePicture) {
  auto net = network({192, 64, 16, 0, 100});
  // Half as many pixels as the network's: a quarter to the right and a quarter up is 32 of 128 pixels.
  const auto look = net.look(with_spot({320, 240}, {150, 100, 9, 9}), {{160, 120}, 128, 0});
  const auto& nose = look[PersonPointName::kNose];
  EXPECT_NEAR(nose.at.x, 192, 1e-3);
  EXPECT_NEAR(nose.at.y, 88, 1e-3);
  EXPECT_NEAR(nose.depth, 8, 1e-3);
  EXPECT_NEAR(nose.visibility, 0.5, 1e-6);
  EXPECT_NEAR(nose.presence, 1, 1e-6);
  EXPECT_NEAR(look.score, 1, 1e-3);
  EXPECT_NEAR(look.metres[1].x, 0.03, 1e-6);
  EXPECT_NEAR(look.metres[1].z, 0.05, 1e-6);
  EXPECT_NEAR(look.next.centre.x, 160, 1e-3);
  EXPECT_NEAR(look.next.side, 2 * 1.25 * 32, 1e-3);
  EXPECT_NEAR(look.next.angle, 0, 1e-6);
  EXPECT_LT(net.look(black({320, 240}), {{160, 120}, 128, 0}).score, 1e-3);
}

TEST(PersonNetwork, WhoLeansToTheRightIsLookedAtUpright) {
  auto net = network({128, 64, 0, 0, 0});
  const auto look = net.look(black({320, 240}), {{160, 120}, 128, std::numbers::pi / 2});
  EXPECT_NEAR(look[PersonPointName::kNose].at.x, 192, 1e-3) << "what is up for the person is right in the picture";
  EXPECT_NEAR(look[PersonPointName::kNose].at.y, 120, 1e-3);
  EXPECT_NEAR(look.next.angle, std::numbers::pi / 2, 1e-6) << "and stays so";
  EXPECT_NEAR(look.metres[1].x, -0.04, 1e-6) << "so are metres";
  EXPECT_NEAR(look.metres[1].y, 0.03, 1e-6);
}

TEST(PersonNetwork, TheSilhouetteLiesWhereItWasSeen) {
  auto net = network({});
  const cv::Rect spot(170, 90, 20, 40);
  const auto picture = with_spot({320, 240}, spot);
  for (const double angle : {0.0, 0.4, 3.0}) {
    const auto look = net.look(picture, {{160, 120}, 200, angle});
    const auto mask = silhouette_in_picture(look, picture.size()) > 127;
    cv::Mat truth = cv::Mat::zeros(picture.size(), CV_8UC1);
    truth(spot).setTo(255);
    const double both = cv::countNonZero(mask & truth);
    const double any = cv::countNonZero(mask | truth);
    EXPECT_GT(both / any, 0.9) << angle;
  }
  // Of one whose reduced height and width are rounded apart: what is low stays where it is.
  const auto odd = with_spot({1920, 1080}, {900, 1000, 40, 40});
  const auto low = silhouette_in_picture(net.look(odd, {{920, 1000}, 500, 0}), odd.size()) > 127;
  const auto moments = cv::moments(low, true);
  EXPECT_NEAR(moments.m10 / moments.m00, 919.5, 0.6);
  EXPECT_NEAR(moments.m01 / moments.m00, 1019.5, 0.6);
  // Of a picture that has many more pixels than the network.
  const auto large = with_spot({3200, 2400}, {1700, 900, 200, 400});
  const auto look = net.look(large, {{1600, 1200}, 2000, 0});
  const auto mask = silhouette_in_picture(look, large.size()) > 127;
  EXPECT_NEAR(cv::countNonZero(mask), 80000, 2500);
}

TEST(PersonDetector, HipsAndReachMakeARegion) {
  PersonDetector detector(test::tiny_detector({112, 112}, {112, 72}));
  EXPECT_TRUE(detector.detect(black({448, 336})).empty());
  const auto people = detector.detect(with_spot({448, 336}, {10, 10, 20, 20}));
  ASSERT_EQ(people.size(), 1u);
  // The square that holds the whole picture has 448 pixels, two of them one of the network's.
  EXPECT_NEAR(people[0].region.centre.x, 223.5, 0.01);
  EXPECT_NEAR(people[0].region.centre.y, 167.5, 0.01);
  EXPECT_NEAR(people[0].region.side, 2 * 1.25 * 80, 0.01);
  EXPECT_NEAR(people[0].region.angle, 0, 1e-6);
  EXPECT_GT(people[0].score, 0.99);
}

TEST(PersonNetworks, OneForTheOtherIsRefusedByName) {
  const auto refused = [](auto make, const char* words) {
    try {
      make();
      FAIL() << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.fault(), Fault::kUsage);
      EXPECT_THAT(error.what(), HasSubstr(words));
    }
  };
  const auto landmarks = test::tiny_landmarks({});
  const auto detector = test::tiny_detector({}, {});
  refused([&] { PersonNetwork net(detector); }, "256 x 256");
  refused([&] { PersonDetector net(landmarks); }, "224 x 224");
  test::TinyPose empty(256);
  empty.score();
  refused([&] { PersonNetwork net(empty.file()); }, "gives no joints");
}

TEST(PersonSearch, FollowsWhoWasFoundAndFindsAgainWhoIsLost) {
  auto search = test::tiny_search();
  PersonTrack track(PersonTrack::Seeks::kInTurns);
  const auto somebody = with_spot({224, 224}, {100, 100, 24, 24});
  EXPECT_FALSE(search.search(black({224, 224}), track.next()));
  track.update(std::nullopt);
  EXPECT_EQ(track.next().turn, 1) << "another part next time";
  const auto found = search.search(somebody, {});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->region.side, 2 * 1.25 * (50.0 / 256) * 2 * 1.25 * 40, 0.1) << "looked at twice";
  track.update(found);
  ASSERT_TRUE(track.next().region);
  EXPECT_EQ(track.next().region->side, found->next.side);
  const auto followed = search.search(somebody, track.next());
  ASSERT_TRUE(followed);
  EXPECT_EQ(followed->region.side, found->next.side) << "no detection needed";
  // Who left the region, but not the picture, is found again at once.
  PersonQuery elsewhere;
  elsewhere.region = PersonRegion{{20, 20}, 10, 0};
  EXPECT_TRUE(search.search(somebody, elsewhere));
  EXPECT_FALSE(search.search(black({224, 224}), track.next()));
}

TEST(PersonSearch, TheSquaresAtBothEndsAreSearchedToo) {
  auto search = test::tiny_search();
  // In the whole picture of 672 pixels three are one of the network's; in a square of 224 one is one.
  const auto left = with_spot({672, 224}, {100, 100, 24, 24});
  const auto right = with_spot({672, 224}, {548, 100, 24, 24});
  EXPECT_TRUE(search.search(left, {{}, 1}));
  EXPECT_FALSE(search.search(right, {{}, 1}));
  EXPECT_FALSE(search.search(left, {{}, 2}));
  const auto found = search.search(right, {{}, 2});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->region.centre.x, 448 + 111.5, 0.6) << "in pixels of the whole picture";
  const auto anywhere = search.search(right, PersonTrack().next());
  ASSERT_TRUE(anywhere) << "where there is time";
  EXPECT_EQ(anywhere->region.centre, found->region.centre);
}

PersonLook look_at(cv::Point2d where) {
  PersonLook look;
  look.region = look.next = {where, 100, 0};
  for (std::size_t k = 0; k < look.points.size(); ++k) look.points[k] = {where + cv::Point2d(double(k), 0), 0, 1, 1};
  return look;
}

TEST(OthersTrack, LooksAtAllOfThemAndForMoreNowAndThen) {
  OthersTrack track;
  EXPECT_TRUE(track.next().seek);
  EXPECT_TRUE(track.next().looked.empty());
  track.update(track.next(), {look_at({50, 50}), look_at({200, 50})}, 1);
  ASSERT_EQ(track.known().size(), 2u);
  const auto query = track.next();
  EXPECT_FALSE(query.seek);
  EXPECT_EQ(query.looked, (std::vector<std::size_t>{0, 1}));
  track.update(query, {std::nullopt, look_at({210, 50})}, 2);
  ASSERT_EQ(track.known().size(), 1u) << "who is there no more is forgotten";
  EXPECT_EQ(track.known()[0].look.next.centre.x, 210);
  EXPECT_EQ(track.known()[0].when, 2);
  int seeks = 0;
  for (int k = 0; k < 60; ++k) {
    const auto next = track.next();
    seeks += next.seek ? 1 : 0;
    track.update(next, {look_at({210, 50})}, 3 + k);
  }
  EXPECT_EQ(seeks, 4);
}

TEST(OthersTrack, InTurnsItLooksAtOneOfThemOrForMore) {
  OthersTrack track(PersonTrack::Seeks::kInTurns);
  track.update(track.next(), {look_at({50, 50}), look_at({200, 50})}, 0);
  std::set<std::optional<int>> turns;
  std::multiset<std::size_t> looked;
  for (int k = 0; k < 9; ++k) {
    const auto next = track.next();
    EXPECT_EQ(next.looked.size() + (next.seek ? 1 : 0), 1u) << "one thing at a time";
    if (next.seek) turns.insert(next.turn);
    looked.insert(next.looked.begin(), next.looked.end());
    track.update(next,
                 next.seek ? std::vector<std::optional<PersonLook>>{}
                           : std::vector{next.known.empty() ? std::optional<PersonLook>()
                                                            : std::optional(next.known[next.looked[0]])},
                 k);
  }
  EXPECT_EQ(track.known().size(), 2u);
  EXPECT_EQ(turns, (std::set<std::optional<int>>{1, 2, 3})) << "0 was the first";
  EXPECT_EQ(looked.count(0), 3u);
  EXPECT_EQ(looked.count(1), 3u);
}

TEST(PersonSearch, WhoMovesIsSearchedForMoreClosely) {
  auto search = test::tiny_search();
  EXPECT_FALSE(search.search(with_spot({672, 224}, {20, 100, 24, 24}), {{}, 3})) << "nothing is known to move";
  const auto found = search.search(with_spot({672, 224}, {30, 100, 24, 24}), {{}, 3});
  ASSERT_TRUE(found);
  EXPECT_LT(found->region.centre.x, 112) << "at the edge";
  EXPECT_FALSE(search.search(with_spot({672, 224}, {30, 100, 24, 24}), {{}, 3})) << "it stands";
  EXPECT_FALSE(search.search(with_spot({16, 2160}, {2, 100, 8, 8}), {{}, 3})) << "a column of 16";
}

TEST(PersonSearch, WhoIsLostIsNoneOfTheOthers) {
  auto search = test::tiny_search();
  const auto somebody = with_spot({224, 224}, {100, 100, 24, 24});
  const auto look = search.search(somebody, {});
  ASSERT_TRUE(look);
  EXPECT_FALSE(search.search(somebody, {{}, {}, {*look}}));
}

TEST(PersonSearch, OthersAreFoundOnceAndThePersonIsNoneOfThem) {
  auto search = test::tiny_search();
  // In each of the two squares at the ends somebody is found in the middle, in the whole picture nobody.
  auto both = with_spot({672, 224}, {100, 100, 24, 24});
  both(cv::Rect(548, 100, 24, 24)).setTo(cv::Scalar::all(255));
  const auto person = search.search(both, {{}, 1});
  ASSERT_TRUE(person);
  OthersQuery query;
  query.seek = true;
  const auto others = search.search_others(both, query, person);
  ASSERT_EQ(others.size(), 1u);
  EXPECT_NEAR(others[0]->region.centre.x, 448 + 111.5, 0.6);
  query.known = {*others[0]};
  query.looked = {0};
  const auto again = search.search_others(both, query, person);
  ASSERT_EQ(again.size(), 1u) << "and not found anew";
  EXPECT_TRUE(again[0]);
  const auto left = search.search_others(with_spot({672, 224}, {100, 100, 24, 24}), query, person);
  ASSERT_EQ(left.size(), 1u);
  EXPECT_FALSE(left[0]);
  query.known = {*person};
  query.seek = false;
  EXPECT_FALSE(search.search_others(both, query, person)[0]) << "two looks at one person";
}

// Where nothing but a look beside the person finds anybody: between the middles of the whole and of its squares.
TEST(PersonSearch, WhoStandsBesideThePersonIsFoundThere) {
  auto search = test::tiny_search();
  auto both = with_spot({672, 224}, {100, 100, 24, 24});
  both(cv::Rect(200, 100, 12, 24)).setTo(cv::Scalar::all(255));
  const auto person = search.search(both, {{}, 1});
  ASSERT_TRUE(person);
  OthersQuery query;
  query.seek = true;
  for (const int turn : {0, 2}) EXPECT_FALSE(search.search(both, {{}, turn})) << turn;
  const auto others = search.search_others(both, query, person);
  ASSERT_EQ(others.size(), 1u);
  EXPECT_NEAR(others[0]->region.centre.x, 206, 20);
}

TEST(PersonSearch, FollowsWhomItIsAskedTo) {
  const auto chosen = [](PersonChoice choice) {
    auto search = test::tiny_search(choice);
    auto three = with_spot({672, 224}, {100, 100, 24, 24});
    for (const int x : {324, 548}) three(cv::Rect(x, 100, 24, 24)).setTo(cv::Scalar::all(255));
    return search.search(three, {})->region.centre.x;
  };
  EXPECT_NEAR(chosen(PersonChoice::kLeft), 111.5, 1);
  EXPECT_NEAR(chosen(PersonChoice::kMiddle), 335.5, 1);
  EXPECT_NEAR(chosen(PersonChoice::kRight), 559.5, 1);
}

}  // namespace
}  // namespace choreo::vision
