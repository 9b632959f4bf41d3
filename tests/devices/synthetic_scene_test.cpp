// SPDX-License-Identifier: Apache-2.0
// Rooms, lights, distances and cameras of the synthetic performer.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>

#include <gtest/gtest.h>
#include <opencv2/core/ocl.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>

#include "core/error.hpp"
#include "devices/synthetic/room.hpp"
#include "devices/synthetic/synthetic_source.hpp"
#include "support/drawn_masks.hpp"
#include "support/performers.hpp"

namespace choreo::devices {
namespace {

using synthetic::Performer;
using test::performer_of;
using test::same_bytes;

cv::Mat room_of(const std::string& settings) { return performer_of("stillness?size=320x240&" + settings).room(); }

// Hue in degrees, saturation and value from 0 to 1.
cv::Vec3f hsv_of(const cv::Vec3f& bgr) {
  const cv::Mat3f one(1, 1, bgr / 255.0F);
  cv::Mat3f hsv;
  cv::cvtColor(one, hsv, cv::COLOR_BGR2HSV);
  return hsv(0, 0);
}

cv::Mat where_different(const cv::Mat& a, const cv::Mat& b, double by) {
  cv::Mat difference, channels[3];
  cv::absdiff(a, b, difference);
  cv::split(difference, channels);
  return cv::max(cv::max(channels[0], channels[1]), channels[2]) > by;
}

TEST(SyntheticRoom, WoodenFurnitureHasTheHuesAndSaturationsOfSkin) {
  float least_hue = 360, most_hue = 0, least_saturation = 1, most_saturation = 0;
  for (const auto& tone : synthetic::skin_tones()) {
    const auto hsv = hsv_of(tone);
    least_hue = std::min(least_hue, hsv[0]);
    most_hue = std::max(most_hue, hsv[0]);
    least_saturation = std::min(least_saturation, hsv[1]);
    most_saturation = std::max(most_saturation, hsv[1]);
  }
  ASSERT_EQ(synthetic::skin_names().size(), 7U);
  for (const auto& skin : synthetic::skin_names().subspan(1)) {
    const auto wooden = room_of("room=wooden&skin=" + skin);
    const auto own = performer_of("empty?skin=" + skin).look().skin;
    const cv::Mat furniture = where_different(wooden, room_of("skin=" + skin), 12);
    int all = 0, like_skin = 0, like_own = 0;
    for (int y = 0; y < wooden.rows; ++y) {
      for (int x = 0; x < wooden.cols; ++x) {
        // The two pictures of the plain room are gone, and wall shows in their place.
        if (furniture.at<unsigned char>(y, x) == 0 || y < 100) continue;
        const cv::Vec3f colour = wooden.at<cv::Vec3b>(y, x);
        const auto hsv = hsv_of(colour);
        ++all;
        // The plaster's unevenness adds a few grey levels to everything.
        like_skin += hsv[0] > least_hue - 4 && hsv[0] < most_hue + 4 && hsv[1] > least_saturation - 0.06 &&
                     hsv[1] < most_saturation + 0.06;
        like_own += cv::norm(colour - own) < 0.1 * cv::norm(own);
      }
    }
    ASSERT_GT(all, 0.1 * wooden.total() * 140 / 240) << skin;
    EXPECT_GT(like_skin, 0.95 * all) << skin;
    EXPECT_GT(like_own, 0.08 * all) << skin;
  }
}

TEST(SyntheticRoom, ArmsPointAtWoodThatLooksLikeThem) {
  // At every height between hip and raised hands there is furniture of skin's hue on either side, within reach.
  const auto wooden = room_of("room=wooden&skin=medium");
  const cv::Mat furniture = where_different(wooden, room_of("skin=medium"), 8);
  const auto stage = synthetic::make_stage({320, 240});
  for (const double height : {0.55, 0.80, 1.05}) {
    const int y = static_cast<int>(stage.floor_y - height * stage.unit);
    for (const int side : {-1, 1}) {
      int covered = 0;
      for (double x = 0.25; x < 0.50; x += 0.01) {
        covered += furniture.at<unsigned char>(y, static_cast<int>(stage.centre_x + side * x * stage.unit)) != 0;
      }
      EXPECT_GE(covered, 10) << height << " " << side;
    }
  }
}

TEST(SyntheticRoom, ClutterHasEveryHueAndStrongEdgesAndStaysAsItIs) {
  const auto clutter = room_of("room=cluttered");
  cv::Mat hsv;
  cv::cvtColor(clutter, hsv, cv::COLOR_BGR2HSV);
  std::array<int, 6> hues{};
  for (int y = 0; y < hsv.rows; ++y) {
    for (int x = 0; x < hsv.cols; ++x) {
      const auto p = hsv.at<cv::Vec3b>(y, x);
      if (p[1] > 110 && p[2] > 60) ++hues.at(((p[0] + 15) / 30) % 6);
    }
  }
  for (std::size_t i = 0; i < hues.size(); ++i) EXPECT_GT(hues[i], 60) << "hue " << 60 * i;
  const auto edges = [](const cv::Mat& picture) {
    cv::Mat grey, x;
    cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
    cv::Sobel(grey, x, CV_16S, 1, 0);
    return cv::countNonZero(cv::abs(x) > 100);
  };
  EXPECT_GT(edges(clutter), 4 * edges(room_of("")));
  const auto performer = performer_of("idle?size=320x240&room=cluttered&noise=0&empty=0.2&tail=0.2&duration=0.2");
  EXPECT_TRUE(same_bytes(performer.perform(0).bgr, performer.perform(17).bgr));
}

TEST(SyntheticRoom, LightAndExposureAreFactorsOnEverything) {
  const auto neutral = room_of("");
  const std::array<std::pair<std::string, cv::Vec3d>, 4> lights = {{{"light=warm", {0.60, 0.88, 1.06}},
                                                                    {"light=dim", {0.45, 0.45, 0.45}},
                                                                    {"light=cool", {1.16, 0.94, 0.76}},
                                                                    {"exposure=0.5&light=warm", {0.30, 0.44, 0.53}}}};
  for (const auto& [setting, factor] : lights) {
    const auto lit = room_of(setting);
    for (int y = 0; y < lit.rows; y += 7) {
      for (int x = 0; x < lit.cols; x += 5) {
        for (int c = 0; c < 3; ++c) {
          const double wanted = std::min(255.0, neutral.at<cv::Vec3b>(y, x)[c] * factor[c]);
          ASSERT_NEAR(lit.at<cv::Vec3b>(y, x)[c], wanted, 1.6) << setting;
        }
      }
    }
  }
  // And on the body: skin under "cool" is bluer than it is red.
  const auto frame = performer_of("stillness?size=320x240&noise=0&empty=0&skin=light&light=cool").perform(0);
  const auto skin = cv::mean(frame.bgr, frame.bare_arm[body::kLeft]);
  EXPECT_GT(skin[0], skin[2]);
}

TEST(SyntheticCamera, APanDisplacesTheRoomAndShowsWhatWasBeside) {
  for (const auto* room : {"plain", "cluttered", "wooden"}) {
    const auto fixed = room_of(std::string("room=") + room);
    const auto moved = room_of(std::string("pan=12:-7&room=") + room);
    // The floor's boards are lines whose pixels depend a little on where they are clipped; 0.05 H is the floor's edge.
    const auto differences = [&](int rows) {
      return cv::countNonZero(where_different(moved(cv::Rect(12, 0, 308, rows)), fixed(cv::Rect(0, 7, 308, rows)), 0));
    };
    EXPECT_EQ(differences(210), 0) << room;
    EXPECT_LT(differences(233), 200) << room;
    // No border: what comes into sight continues what was there.
    EXPECT_LT(cv::norm(cv::mean(moved(cv::Rect(0, 0, 8, 60))) - cv::mean(fixed(cv::Rect(0, 7, 8, 60)))), 40) << room;
  }
  for (const auto* farthest : {"pan=64:64:0.9", "pan=-64:-64:0.9&shake=10", "pan=-64:64:1.1"}) {
    const auto frame = performer_of(std::string("empty?size=64x48&noise=0&") + farthest).perform(0).bgr;
    double darkest = 0;
    cv::minMaxLoc(frame.reshape(1), &darkest);
    EXPECT_GT(darkest, 20) << farthest;
  }
}

TEST(SyntheticCamera, AZoomEnlargesRoomAndBodyAboutTheCentre) {
  const auto fixed = performer_of("semaphore?text=U&size=320x240&noise=0&empty=0&distance=1.4").perform(60);
  const auto zoomed =
      performer_of("semaphore?text=U&size=320x240&noise=0&empty=0&distance=1.4&pan=10:5:1.1").perform(60);
  EXPECT_NEAR(cv::countNonZero(zoomed.mask), 1.21 * cv::countNonZero(fixed.mask), 0.01 * cv::countNonZero(fixed.mask));
  EXPECT_NEAR(zoomed.face.width, 1.1 * fixed.face.width, 1e-6);
  EXPECT_NEAR(zoomed.face.y, 120 + 1.1 * (fixed.face.y - 120) + 5, 1e-6);
  EXPECT_NEAR(zoomed.face.x, 160 + 1.1 * (fixed.face.x - 160) + 10, 1e-6);
  // The room too: warping the fixed picture gives the zoomed one.
  const auto room = room_of("room=cluttered");
  const cv::Matx23d map(1.1, 0, 159.5 - 1.1 * 159.5 + 10, 0, 1.1, 119.5 - 1.1 * 119.5 + 20);
  cv::Mat warped;
  cv::warpAffine(room, warped, map, room.size(), cv::INTER_LINEAR);
  const cv::Rect inside(30, 30, 260, 180);
  const auto moved = room_of("room=cluttered&pan=10:20:1.1");
  EXPECT_LT(cv::norm(moved(inside), warped(inside), cv::NORM_L1) / (3.0 * inside.area()), 0.6);
}

TEST(SyntheticCamera, DistanceScalesTheFigureAndKeepsRaisedHandsInThePicture) {
  const double width = performer_of("semaphore?size=320x240&empty=0&noise=0").perform(0).face.width;
  for (const double distance : {0.6, 1.5, 2.5}) {
    const auto text = "semaphore?size=320x240&rate=60&empty=0&noise=0&distance=" + std::to_string(distance);
    const auto performer = performer_of(text);
    EXPECT_NEAR(performer.perform(0).face.width, width / distance, 1e-6);
    for (int i = 12; i < performer.frame_count(); i += 30) {
      const auto frame = performer.perform(i);
      const auto outside = cv::countNonZero(frame.mask.row(0)) + cv::countNonZero(frame.mask.col(0)) +
                           cv::countNonZero(frame.mask.col(319));
      EXPECT_EQ(outside, 0) << distance << " " << frame.sign;
      // In O and W an arm reaches across the lower half of the face.
      EXPECT_TRUE(!frame.face.empty() || frame.sign == "O" || frame.sign == "W") << distance << " " << frame.sign;
    }
  }
  // Far away the feet stand higher, but still on the floor, whose upper edge is 0.05 H above their place.
  const auto far = cv::boundingRect(performer_of("stillness?empty=0&distance=2.5").perform(0).mask);
  EXPECT_LT(far.br().y, 452);
  EXPECT_GT(far.br().y, 456 - 0.05 * 360);
}

TEST(SyntheticCamera, PlaceMovesTheBodyBySharesOfTheWidth) {
  const auto middle = performer_of("stillness?size=320x240&empty=0&distance=1.3").perform(0);
  for (const double place : {-0.35, 0.2}) {
    const auto moved =
        performer_of("stillness?size=320x240&empty=0&distance=1.3&place=" + std::to_string(place)).perform(0);
    EXPECT_NEAR(moved.face.x - middle.face.x, 320 * place, 1e-6);
    EXPECT_NEAR(cv::boundingRect(moved.mask).x - cv::boundingRect(middle.mask).x, 320 * place, 1);
  }
}

TEST(SyntheticCamera, DepthKnowsNoOtherDistance) {
  EXPECT_THROW((void)performer_of("walking?depth=1&distance=2"), Error);
  EXPECT_THROW((void)performer_of("walking?depth=1&pan=0:0:1.05"), Error);
  const auto moved = performer_of("stillness?size=160x120&depth=1&place=0.2&pan=3:2&empty=0").perform(0);
  EXPECT_GT(cv::mean(moved.depth, moved.mask == 0)[0], cv::mean(moved.depth, moved.mask)[0] + 300);
}

class Haar : public ::testing::Test {
 protected:
  void SetUp() override {
    cv::ocl::setUseOpenCL(false);  // It loads a library of which the leak sanitizer cannot read the threads' storage.
    const std::string file = "/usr/share/opencv4/haarcascades/haarcascade_frontalface_default.xml";
    ASSERT_TRUE(std::filesystem::exists(file)) << "there is no " << file << " (package opencv-data)";
    ASSERT_TRUE(cascade_.load(file));
  }

  // Whether a face is found around a point.
  bool finds(const cv::Mat& picture, cv::Point2d at) {
    std::vector<cv::Rect> faces;
    cascade_.detectMultiScale(picture, faces, 1.1, 3, 0, {24, 24}, {80, 80});
    return std::any_of(faces.begin(), faces.end(), [&](const cv::Rect& f) { return cv::Rect2d(f).contains(at); });
  }

 private:
  cv::CascadeClassifier cascade_;
};

TEST_F(Haar, FindsThePerformersFaceInEveryRoomAndLightAndThePosters) {
  const std::array<std::string, 6> scenes = {
      "room=plain&skin=light&light=cool", "room=cluttered&skin=medium&light=dim", "room=wooden&skin=tan&light=warm",
      "room=wooden&skin=very-light",      "room=cluttered&skin=light&light=warm", "room=wooden&skin=medium&light=dim"};
  for (const auto& scene : scenes) {
    const auto frame = performer_of("semaphore?text=U&empty=0&poster=1&" + scene).perform(60);
    EXPECT_NEAR(frame.face.width, 35, 2);
    EXPECT_TRUE(finds(frame.bgr, (frame.face.tl() + frame.face.br()) / 2)) << scene;
    // The portrait's middle: -0.70 H aside, a quarter larger than a head whose chin is at 0.94 H.
    EXPECT_TRUE(finds(frame.bgr, {320 - 0.70 * 360, 456 - (0.94 + 0.06) * 360})) << scene;
  }
}

}  // namespace
}  // namespace choreo::devices
