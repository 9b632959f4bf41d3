// SPDX-License-Identifier: Apache-2.0
#include "vision/face_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"

namespace choreo::vision {
namespace {

const cv::Size kSearchedSize(640, 480);

FaceCandidate performer(double x, double y, double width) {
  FaceCandidate face;
  face.id = 1;
  face.centre = {x, y};
  face.width = width;
  face.confirmed = face.chosen = true;
  return face;
}

bool covers(const FaceQuery& query, const cv::Rect2d& face) {
  const cv::Rect2d where(query.where);
  return (where & face).area() >= face.area() - 1e-6 && query.least_px <= face.width && face.width <= query.most_px;
}

TEST(FaceSearch, WhileAFaceIsFollowedMostFramesNeedNoSearch) {
  FaceSearch search({});
  int near = 0, elsewhere = 0;
  const auto face = performer(300, 100, 40);
  for (int i = 0; i < 300; ++i) {
    const auto query = search.next(kSearchedSize, {face}, {220, 70, 160, 400});
    if (!query) continue;
    const bool is_near = covers(*query, {280, 80, 40, 40}) && query->where.area() < 120 * 120;
    near += is_near ? 1 : 0;
    elsewhere += is_near ? 0 : 1;
  }
  EXPECT_GE(near, 50);
  EXPECT_LE(near, 60);
  EXPECT_GE(elsewhere, 8);
  EXPECT_LE(elsewhere, 30);
}

TEST(FaceSearch, ARoundOverThePictureMissesNoPlaceAndNoSize) {
  FaceSearch search({});
  std::vector<FaceQuery> round;
  for (int i = 0; i < 60; ++i) {
    if (const auto query = search.next(kSearchedSize, {}); query && query->look == FaceLook::kFront)
      round.push_back(*query);
  }
  cv::RNG random(5);
  for (int i = 0; i < 2000; ++i) {
    const double width = random.uniform(0.041 * 480, 0.39 * 480);
    const cv::Rect2d face(random.uniform(0.0, 640 - width), random.uniform(0.0, 480 - width), width, width);
    EXPECT_TRUE(std::any_of(round.begin(), round.end(), [&](const auto& q) { return covers(q, face); })) << face;
  }
}

// A search that lasts longer than a frame is idle would hold up the next one.
TEST(FaceSearch, BesideAKnownFacePartsAreSmallAndMissNothing) {
  FaceSearch search({});
  const cv::Rect body(170, 20, 300, 440);
  std::vector<FaceQuery> round;
  for (int i = 0; i < 6 * 30; ++i) {
    const auto query = search.next(kSearchedSize, {performer(300, 100, 40)}, body);
    if (!query) continue;
    round.push_back(*query);
    EXPECT_LT(query->where.area() / std::pow(query->least_px, 2), 90) << query->where << ' ' << query->least_px;
  }
  cv::RNG random(5);
  for (int i = 0; i < 2000; ++i) {
    const double width = random.uniform(0.041 * 480, 0.39 * 480);
    const cv::Rect2d face(170 + random.uniform(0.0, 300 - width), 20 + random.uniform(0.0, 440 - width), width, width);
    EXPECT_TRUE(std::any_of(round.begin(), round.end(), [&](const auto& q) { return covers(q, face); })) << face;
  }
}

TEST(FaceSearch, EveryLookHasItsTurn) {
  FaceSearch search({});
  int brightened = 0, profile = 0;
  for (int i = 0; i < 300; ++i) {
    const auto query = search.next(kSearchedSize, {});
    if (query) brightened += query->look == FaceLook::kBrightened ? 1 : 0;
    if (query) profile += query->look == FaceLook::kProfile ? 1 : 0;
  }
  EXPECT_GT(brightened, 0);
  EXPECT_GT(profile, 0);
  // A face that was not found where it should be is looked at in other ways.
  auto face = performer(300, 100, 40);
  face.misses = 1;
  FaceSearch other({});
  EXPECT_EQ(other.next(kSearchedSize, {face})->look, FaceLook::kBrightened);
}

TEST(FaceSearch, WhereTheBodyIsKnownOnlyItIsSearched) {
  FaceSearch search({});
  const cv::Rect body(200, 50, 150, 400);
  int queries = 0;
  for (int i = 0; i < 100; ++i) {
    if (const auto query = search.next(kSearchedSize, {}, body)) {
      ++queries;
      EXPECT_EQ(query->where & body, query->where);
    }
  }
  EXPECT_GT(queries, 20);
}

TEST(FaceSearch, QueriesLieInThePictureWhateverIsKnown) {
  cv::RNG random(7);
  int queries = 0;
  for (const cv::Size size : {cv::Size(640, 480), cv::Size(17, 480), cv::Size(480, 3), cv::Size(1, 1)}) {
    FaceSearch search({});
    for (int i = 0; i < 300; ++i) {
      auto face = performer(random.uniform(0.0, double(size.width)), random.uniform(0.0, double(size.height)),
                            random.uniform(1.0, 100.0));
      face.unseen_s = random.uniform(0.0, 3.0);
      face.chosen = i % 3 != 0;
      const auto query = search.next(size, {face});
      if (!query) continue;
      EXPECT_EQ(query->where & cv::Rect({0, 0}, size), query->where);
      EXPECT_LE(query->least_px, query->most_px);
      EXPECT_GT(query->least_px, 0);
      ++queries;
    }
  }
  EXPECT_GT(queries, 100);
}

TEST(FaceSearch, AnEmptyPictureIsNotSearched) { EXPECT_FALSE(FaceSearch({}).next({}, {})); }

TEST(FaceSearch, SettingsOutOfRangeAreRefused) {
  const auto refused = [](auto change) {
    FaceSearchOptions options;
    change(options);
    EXPECT_THROW(FaceSearch{options}, Error);
  };
  refused([](auto& o) { o.least_share = 0; });
  refused([](auto& o) { o.least_share = std::numeric_limits<double>::quiet_NaN(); });
  refused([](auto& o) { o.most_share = o.least_share; });
  refused([](auto& o) { o.near_frames = 0; });
  refused([](auto& o) { o.whole_frames = 0; });
  refused([](auto& o) { o.lost_frames = 0; });
}

}  // namespace
}  // namespace choreo::vision
