// SPDX-License-Identifier: Apache-2.0
#include "vision/face_track.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"

namespace choreo::vision {
namespace {

const cv::Size kTrackedSize(640, 480);
constexpr double kStep_s = 0.1;

Face face_at(double x, double y, double width = 40, double confidence = 0.8) {
  return {{x - width / 2, y - width / 2, width, width}, confidence};
}

// One search of everything a tenth of a second; what is found takes effect at once.
class Following {
 public:
  explicit Following(const FaceTrackOptions& options = {}) : tracker_(options) {}

  FaceReport see(const std::vector<Face>& faces, const cv::Mat& body = {}) {
    FaceSighting sighting;
    sighting.query = {{{0, 0}, kTrackedSize}, 1, 480, FaceLook::kFront};
    sighting.time_s = time_s_;
    sighting.faces = faces;
    sighting.body = body;
    const auto report = tracker_.update(time_s_, kTrackedSize, &sighting);
    time_s_ += kStep_s;
    return report;
  }
  FaceReport wait() {
    const auto report = tracker_.update(time_s_, kTrackedSize, nullptr);
    time_s_ += kStep_s;
    return report;
  }
  [[nodiscard]] const FaceTracker& tracker() const { return tracker_; }

 private:
  FaceTracker tracker_;
  double time_s_ = 0;
};

cv::Mat body_over(const cv::Rect& where) {
  cv::Mat mask = cv::Mat::zeros(kTrackedSize, CV_8UC1);
  mask(where).setTo(255);
  return mask;
}

TEST(FaceTracker, AFaceCountsOnceItWasSeenOftenEnough) {
  Following following;
  EXPECT_FALSE(following.see({face_at(300, 100)}).face);
  EXPECT_FALSE(following.see({face_at(302, 100)}).face);
  const auto report = following.see({face_at(301, 101)});
  ASSERT_TRUE(report.face);
  EXPECT_EQ(report.in_sight, 1);
  EXPECT_NEAR(report.face->centre.x, 301, 2);
  EXPECT_NEAR(report.face->centre.y, 100, 2);
  EXPECT_NEAR(report.face->width, 40, 1e-9);
  EXPECT_NEAR(report.face->confidence, 0.8, 1e-9);
  EXPECT_NEAR(report.face->age_s, 0.2, 1e-9);
  EXPECT_EQ(report.face->unseen_s, 0);
}

TEST(FaceTracker, HitsAtOtherPlacesAreNotTheSameFace) {
  Following following;
  EXPECT_FALSE(following.see({face_at(100, 100)}).face);
  EXPECT_FALSE(following.see({face_at(300, 300)}).face);
  EXPECT_FALSE(following.see({face_at(500, 100)}).face);
}

TEST(FaceTracker, AFaceThatIsNotSeenStaysForAWhileAndGrowsUncertain) {
  Following following;
  for (int i = 0; i < 5; ++i) (void)following.see({face_at(300, 100)});
  double last = 1;
  for (int i = 1; i <= 10; ++i) {
    const auto report = i % 2 == 0 ? following.see({}) : following.wait();
    ASSERT_TRUE(report.face) << i;
    EXPECT_LT(report.face->confidence, last);
    EXPECT_GT(report.face->confidence, 0);
    EXPECT_NEAR(report.face->unseen_s, 0.1 * i, 1e-9);
    EXPECT_NEAR(report.face->centre.x, 300, 0.01);
    last = report.face->confidence;
  }
  EXPECT_FALSE(following.wait().face) << "coast_s is a second";
}

TEST(FaceTracker, AMovingFaceIsFollowed) {
  Following following;
  for (int i = 0; i < 30; ++i) {
    const double x = 100 + 10 * i;  // 2.5 face widths a second.
    const auto report = following.see({face_at(x, 100)});
    if (i < 4) continue;
    ASSERT_TRUE(report.face) << i;
    EXPECT_NEAR(report.face->centre.x, x, 8) << i;
  }
  EXPECT_EQ(following.tracker().candidates().size(), 1U);
}

TEST(FaceTracker, WhereTheBodyIsKnownAFaceBesideItIsAPoster) {
  Following following;
  const auto body = body_over({250, 60, 100, 400});
  for (int i = 0; i < 20; ++i) {
    const auto report = following.see({face_at(100, 100, 80), face_at(300, 100)}, body);
    if (i < 3) continue;
    ASSERT_TRUE(report.face);
    EXPECT_NEAR(report.face->centre.x, 300, 1);
    EXPECT_EQ(report.in_sight, 1);
  }
  for (int i = 0; i < 40; ++i) {
    const auto report = following.see({face_at(100, 100, 80)}, cv::Mat::zeros(kTrackedSize, CV_8UC1));
    if (report.face) {
      EXPECT_NEAR(report.face->centre.x, 300, 1) << "it may coast, and goes nowhere else";
    }
    if (i > 12) {
      EXPECT_FALSE(report.face);
    }
  }
}

TEST(FaceTracker, AFaceThatIsSeenOnTheBodyBeatsOneThatIsPresumedHidden) {
  Following following;
  const auto body = body_over({100, 60, 400, 400});
  for (int i = 0; i < 5; ++i) (void)following.see({face_at(200, 100)}, body);
  // Ducked away, and seen again farther off than a face goes; the body is where the face was.
  for (int i = 0; i < 12; ++i) ASSERT_TRUE(following.see({}, body).face) << "presumed";
  FaceReport report;
  for (int i = 0; i < 4; ++i) report = following.see({face_at(450, 300)}, body);
  ASSERT_TRUE(report.face);
  EXPECT_NEAR(report.face->centre.x, 450, 1);
}

TEST(FaceTracker, WithoutABodyThePosterDoesNotFollowAFaceThatWasLost) {
  Following following;
  for (int i = 0; i < 40; ++i) (void)following.see({face_at(300 + 3 * i, 100, 50), face_at(100, 100)});
  for (int i = 0; i < 50; ++i) {
    const auto report = following.see({face_at(100, 100)});
    if (i > 12) {
      EXPECT_FALSE(report.face) << i;
    }
  }
  // The performer is back, elsewhere.
  std::optional<TrackedFace> face;
  for (int i = 0; i < 10; ++i) face = following.see({face_at(100, 100), face_at(500, 200, 50)}).face;
  ASSERT_TRUE(face);
  EXPECT_NEAR(face->centre.x, 500, 1);
}

TEST(FaceTracker, APosterGivesWayToAFaceThatMoves) {
  Following following;
  std::optional<TrackedFace> face;
  for (int i = 0; i < 10; ++i) face = following.see({face_at(100, 100)}).face;
  ASSERT_TRUE(face) << "nothing speaks against the only face";
  for (int i = 0; i < 20; ++i) face = following.see({face_at(100, 100), face_at(300 + 4 * i, 150)}).face;
  ASSERT_TRUE(face);
  EXPECT_GT(face->centre.x, 300);
}

TEST(FaceTracker, OfSeveralTheSettingChooses) {
  for (const auto choice : {FaceChoice::kTracked, FaceChoice::kLargest}) {
    FaceTrackOptions options;
    options.choose = choice;
    Following following(options);
    for (int i = 0; i < 10; ++i) (void)following.see({face_at(300 + 5 * i, 100)});
    FaceReport report;
    for (int i = 0; i < 20; ++i) report = following.see({face_at(350, 100), face_at(500 - 4 * i, 250, 70)});
    ASSERT_TRUE(report.face);
    EXPECT_EQ(report.in_sight, 2);
    EXPECT_NEAR(report.face->width, choice == FaceChoice::kTracked ? 40 : 70, 1);
  }
}

TEST(FaceTracker, SettingsOutOfRangeAreRefused) {
  FaceTrackOptions options;
  options.persistence = 0;
  EXPECT_THROW(FaceTracker{options}, Error);
  options = {};
  options.coast_s = -1;
  EXPECT_THROW(FaceTracker{options}, Error);
}

}  // namespace
}  // namespace choreo::vision
