// SPDX-License-Identifier: Apache-2.0
// The synthetic performer's pictures: reproducible, true to their masks, within the picture; and its driver.
#include <algorithm>
#include <cstring>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "devices/silhouettes.hpp"
#include "devices/synthetic/mannequin.hpp"
#include "devices/synthetic/synthetic_source.hpp"
#include "support/drawn_masks.hpp"
#include "support/performers.hpp"

namespace choreo::devices {
namespace {

using synthetic::Performer;
using synthetic::PerformerSettings;
using test::performer_of;
using test::same_bytes;

bool no_such_path(const std::string&) { return false; }

PerformerRequest request_of(const std::string& text) { return performer_request(parse_source_uri(text, no_such_path)); }

TEST(Performer, TheSameSettingsGiveTheSameBytesInAnyOrder) {
  const std::string text = "walking?size=96x80&seed=5&shake=1.5&flicker=4&drift=20&empty=0.1&duration=1";
  const auto one = performer_of(text);
  const auto other = performer_of(text);
  ASSERT_EQ(one.frame_count(), 33);
  std::vector<cv::Mat> forwards;
  for (int i = 0; i < one.frame_count(); ++i) forwards.push_back(one.perform(i).bgr);
  for (int i = other.frame_count() - 1; i >= 0; --i) {
    const auto frame = other.perform(i);
    EXPECT_TRUE(same_bytes(frame.bgr, forwards[static_cast<std::size_t>(i)])) << i;
  }
  EXPECT_FALSE(same_bytes(forwards[10], forwards[11]));
}

TEST(Performer, AnotherSeedGivesAnotherPicture) {
  const auto a = performer_of("stillness?size=96x80&seed=1&noise=0").perform(40);
  const auto b = performer_of("stillness?size=96x80&seed=2&noise=0").perform(40);
  EXPECT_FALSE(same_bytes(a.bgr, b.bgr));
}

TEST(Performer, FarFromTheMaskThePictureIsTheEmptyRoom) {
  for (const auto* script : {"jumping-jacks", "side-kicks", "crossing"}) {
    const auto performer = performer_of(std::string(script) + "?size=200x150&noise=0&empty=0");
    const auto room = performer.room();
    for (const int index : {0, 25, 60, 95, 140}) {
      const auto frame = performer.perform(index);
      cv::Mat near;
      cv::dilate(frame.mask, near, cv::Mat(), cv::Point(-1, -1), 2);
      double darkest_shadow = 0;
      for (int y = 0; y < room.rows; ++y) {
        for (int x = 0; x < room.cols; ++x) {
          const auto difference = cv::norm(frame.bgr.at<cv::Vec3b>(y, x), room.at<cv::Vec3b>(y, x), cv::NORM_INF);
          // Beside the picture's edge the body may be just outside it.
          if (near.at<unsigned char>(y, x) != 0 || x < 2 || x >= room.cols - 2) continue;
          // The figure's shadow on the floor is the one exception, and a faint one.
          if (y > 0.85 * room.rows) {
            darkest_shadow = std::max(darkest_shadow, difference);
          } else {
            ASSERT_EQ(difference, 0) << script << " frame " << index << " at " << x << "," << y;
          }
        }
      }
      EXPECT_LE(darkest_shadow, 19) << "two feet may shade one place";
    }
  }
}

TEST(Performer, InsideTheMaskHardlyAnyPixelLooksLikeTheWall) {
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    PerformerSettings settings;
    settings.size = {200, 150};
    settings.noise = 0;
    settings.empty = 0;
    settings.seed = seed;
    const Performer performer("jumping-jacks", settings);
    const auto frame = performer.perform(15);
    const auto room = performer.room();
    cv::Mat core;
    cv::erode(frame.mask, core, cv::Mat());
    int inside = 0;
    int alike = 0;
    for (int y = 0; y < room.rows; ++y) {
      for (int x = 0; x < room.cols; ++x) {
        if (core.at<unsigned char>(y, x) == 0) continue;
        ++inside;
        const cv::Vec3f body = frame.bgr.at<cv::Vec3b>(y, x);
        const cv::Vec3f wall = room.at<cv::Vec3b>(y, x);
        if (synthetic::colour_distance(body, wall) < 25) ++alike;
      }
    }
    ASSERT_GT(inside, 500);
    EXPECT_LT(alike, 0.02 * inside) << "seed " << seed;
  }
}

TEST(Performer, ClothesCanBeMadeToLookLikeTheWall) {
  const auto look = synthetic::choose_look(3, "auto", "auto", "wall");
  EXPECT_LE(synthetic::colour_distance(look.shirt, look.wall), 12);
  EXPECT_LE(synthetic::colour_distance(look.trousers, look.panel), 12);
  const auto other = synthetic::choose_look(3, "auto", "auto", "auto");
  EXPECT_GE(synthetic::colour_distance(other.shirt, other.wall), 35);
  EXPECT_EQ(look.skin, other.skin) << "what is set by name does not change the rest";
}

TEST(Performer, ClothesNearTheWallHaveItsHueAndAreALittleDarker) {
  const auto look = synthetic::choose_look(3, "auto", "auto", "near-wall");
  for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(look.shirt[c], 0.85F * look.wall[c]);
  EXPECT_GT(synthetic::colour_distance(look.shirt, look.wall), 12);
}

TEST(Performer, AMirroredPoseHasTheMirroredSilhouette) {
  const auto stage = synthetic::make_stage({201, 150});
  const auto look = synthetic::choose_look(2, "medium", "light", "auto");
  const auto silhouette = [&](const body::Pose& pose) {
    synthetic::Brush brush;
    cv::Mat1b mask(stage.size, static_cast<unsigned char>(0));
    EXPECT_TRUE(synthetic::draw_figure(brush, pose, look, stage, {0, 0}));
    for (int y = brush.box().y; y < brush.box().br().y; ++y) {
      for (int x = brush.box().x; x < brush.box().br().x; ++x) {
        if (2 * brush.pixel(x, y)[3] >= brush.samples_per_pixel()) mask(y, x) = 255;
      }
    }
    return mask;
  };
  for (const auto* script : {"path-repetition", "side-kicks", "crossing", "idle"}) {
    const auto pose = *synthetic::Script(script, {}).pose_at(2.3);
    cv::Mat flipped;
    cv::flip(silhouette(pose), flipped, 1);
    const cv::Mat other = silhouette(body::mirrored(pose));
    ASSERT_GT(cv::countNonZero(other), 300);
    // Samples exactly on an edge may fall to either side.
    EXPECT_LE(cv::countNonZero(flipped != other), 2) << script;
  }
}

TEST(Performer, NoiseHasTheDeviationAskedForAndNoBias) {
  const auto performer = performer_of("empty?size=320x240&noise=3");
  const auto room = performer.room();
  cv::Mat sum = cv::Mat::zeros(room.size(), CV_64FC3);
  cv::Mat difference;
  for (const int index : {0, 1, 50}) {
    cv::subtract(performer.perform(index).bgr, room, difference, cv::noArray(), CV_64F);
    cv::Scalar mean, deviation;
    cv::meanStdDev(difference, mean, deviation);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(mean[c], 0, 0.05);
      EXPECT_NEAR(deviation[c], 3, 0.08);  // rounding to bytes adds a twelfth to the variance
    }
    sum += difference;
  }
  // Three frames' noise is independent: the sum's deviation is 3 sqrt(3).
  cv::Scalar mean, deviation;
  cv::meanStdDev(sum, mean, deviation);
  EXPECT_NEAR(deviation[1], 3 * std::sqrt(3.0), 0.15);
}

TEST(Performer, DriftAndFlickerChangeTheLightAsDocumented) {
  const auto mean_at = [](const std::string& settings, int index) {
    const auto performer = performer_of("empty?size=64x48&noise=0&duration=61&" + settings);
    cv::Mat difference;
    cv::subtract(performer.perform(index).bgr, performer.room(), difference, cv::noArray(), CV_64F);
    return cv::mean(difference)[1];
  };
  EXPECT_NEAR(mean_at("drift=12", 60 * 30), 12, 0.6);
  EXPECT_NEAR(mean_at("drift=-12", 30 * 30), -6, 0.6);
  // 100 swings a second seen 30 times a second: 10/3 of a swing from frame to frame, so 1/3 is left.
  EXPECT_NEAR(mean_at("flicker=8", 0), 0, 0.5);
  EXPECT_NEAR(mean_at("flicker=8", 1), 8 * std::sqrt(3.0) / 2, 0.5);
  EXPECT_NEAR(mean_at("flicker=8", 2), -8 * std::sqrt(3.0) / 2, 0.5);
  EXPECT_NEAR(mean_at("flicker=8", 3), 0, 0.5);
}

TEST(Performer, ShakeMovesBodyAndRoomTogether) {
  const auto still = performer_of("stillness?size=320x240&noise=0");
  const auto shaken = performer_of("stillness?size=320x240&noise=0&shake=2");
  const auto centre = [](const cv::Mat& mask) {
    const auto m = cv::moments(mask, true);
    return cv::Point2d(m.m10 / m.m00, m.m01 / m.m00);
  };
  const auto rest = centre(still.perform(40).mask);
  double squares = 0;
  constexpr int kFrames = 200;
  for (int i = 40; i < 40 + kFrames; ++i) {
    const auto moved = centre(shaken.perform(i).mask) - rest;
    squares += moved.dot(moved) / 2;
  }
  EXPECT_NEAR(std::sqrt(squares / kFrames), 2, 0.3);
}

TEST(Performer, TheRoomIsEmptyBeforeAndAfter) {
  const auto performer = performer_of("jumping-jacks?size=64x48&empty=0.5&tail=0.2&duration=1&noise=0");
  ASSERT_EQ(performer.frame_count(), 15 + 30 + 6);
  EXPECT_EQ(performer.first_frame(), 15);
  for (const int index : {0, 14, 45, 50}) {
    const auto frame = performer.perform(index);
    EXPECT_FALSE(frame.present) << index;
    EXPECT_EQ(cv::countNonZero(frame.mask), 0) << index;
    EXPECT_TRUE(frame.angles.empty());
    EXPECT_TRUE(same_bytes(frame.bgr, performer.room())) << index;
  }
  for (const int index : {15, 44}) {
    const auto frame = performer.perform(index);
    EXPECT_TRUE(frame.present) << index;
    EXPECT_EQ(frame.angles.size(), body::kPoseValues);
    EXPECT_GT(cv::countNonZero(frame.mask), 100);
  }
  EXPECT_EQ(performer.perform(30).time, from_seconds(1));
}

TEST(Performer, TheFigureFitsIntoEveryPictureAndIsThreeQuartersHigh) {
  for (const cv::Size size : {cv::Size(64, 48), cv::Size(48, 64), cv::Size(96, 40), cv::Size(16, 16)}) {
    for (const auto& facts : synthetic::all_scripts()) {
      if (facts.name == "crossing" || facts.name == "empty") continue;
      PerformerSettings settings;
      settings.size = size;
      settings.noise = 0;
      settings.empty = 0;
      settings.seed = 3;
      settings.duration = std::min(facts.duration, 40.0);
      settings.letters_per_minute = 60;
      const Performer performer(facts.name, settings);
      for (int i = 0; i < performer.frame_count(); i += 7) {
        const auto frame = performer.perform(i);
        ASSERT_TRUE(frame.present) << facts.name;
        const int border = cv::countNonZero(frame.mask.row(0)) + cv::countNonZero(frame.mask.row(size.height - 1)) +
                           cv::countNonZero(frame.mask.col(0)) + cv::countNonZero(frame.mask.col(size.width - 1));
        EXPECT_EQ(border, 0) << facts.name << " " << size << " frame " << i;
      }
    }
  }
  const auto frame = performer_of("semaphore?size=640x480&text=R").perform(30);
  const auto box = cv::boundingRect(frame.mask);
  EXPECT_NEAR(box.height, 0.75 * 480, 25);  // hair may stand above the crown
  EXPECT_NEAR(box.x + box.width / 2.0, 320, 2);
}

TEST(Performer, ALargePictureIsDrawnToo) {
  const auto frame = performer_of("jumping-jacks?size=2160x3840&empty=0").perform(7);
  EXPECT_EQ(frame.bgr.size(), cv::Size(2160, 3840));
  EXPECT_TRUE(frame.present);
}

TEST(SyntheticSource, DeliversThePerformersFramesWithTheirTimes) {
  Registry registry;
  registry.add(synthetic_driver());
  const std::string text = "synthetic://jumping-jacks?size=64x48&fps=25&seed=4&duration=1&empty=0.2";
  const auto source = registry.open(text);
  EXPECT_EQ(source->info().name, text);
  EXPECT_EQ(source->info().size, cv::Size(64, 48));
  EXPECT_EQ(source->info().nominal_fps, 25);
  EXPECT_EQ(source->info().duration, from_seconds(1.2));
  EXPECT_TRUE(source->info().repeatable);
  const auto performer = performer_of(text.substr(std::string("synthetic://").size()));
  std::uint64_t count = 0;
  while (const auto frame = source->read({})) {
    EXPECT_EQ(frame->sequence, count);
    EXPECT_EQ(frame->device_time, from_seconds(static_cast<double>(count) / 25));
    EXPECT_TRUE(same_bytes(frame->bgr, performer.perform(static_cast<int>(count)).bgr));
    ++count;
  }
  EXPECT_EQ(count, 30u);
  EXPECT_EQ(source->read({}), nullptr);
}

TEST(SyntheticSource, StopsWhenAsked) {
  Registry registry;
  registry.add(synthetic_driver());
  const auto source = registry.open("synthetic://empty?size=16x16&rotate=90&flip=both");
  std::stop_source stop;
  EXPECT_NE(source->read(stop.get_token()), nullptr);
  stop.request_stop();
  EXPECT_EQ(source->read(stop.get_token()), nullptr);
}

TEST(SyntheticSource, SettingsOutOfRangeAreRefusedAsTheUsersMistake) {
  for (const auto* bad : {"size=15x16",   "size=16x15",   "size=3841x100", "size=2161x2161",
                          "size=640",     "size=x",       "size=-64x48",   "size=99999999999999x48",
                          "fps=0",        "fps=241",      "fps=nan",       "seed=-1",
                          "seed=1.5",     "noise=-1",     "noise=31",      "drift=61",
                          "flicker=-1",   "flicker=31",   "shake=11",      "empty=61",
                          "empty=-1",     "tail=61",      "duration=-1",   "duration=36001",
                          "rate=3",       "rate=61",      "build=tall",    "skin=green",
                          "clothes=none", "colour=red",   "text=%3F",      "sleeves=short",
                          "room=big",     "light=blue",   "poster=2",      "flags=x",
                          "distance=0.5", "distance=2.6", "place=0.36",    "place=-0.4",
                          "pan=",         "pan=1",        "pan=1:",        "pan=65:0",
                          "pan=0:-65",    "pan=1:2:1.2",  "pan=1:2:0.8",   "pan=1:2:1:1",
                          "pan=1:2:",     "pan=nan:0",    "exposure=0.4",  "exposure=1.6"}) {
    try {
      const auto request = request_of(std::string("synthetic://semaphore?") + bad);
      const Performer performer(request.script, request.settings);
      ADD_FAILURE() << bad;
    } catch (const Error& error) {
      EXPECT_EQ(error.fault(), Fault::kUsage) << bad;
    }
  }
  EXPECT_THROW((void)request_of("synthetic://waltz"), Error);
}

TEST(SyntheticSource, ARequestNeedsNoScheme) {
  const auto request = request_of("semaphore?text=SOS&size=320x240&seed=7&clothes=blue&rate=30&duration=2.5");
  EXPECT_EQ(request.script, "semaphore");
  EXPECT_EQ(request.settings.size, cv::Size(320, 240));
  EXPECT_EQ(request.settings.seed, 7u);
  EXPECT_EQ(request.settings.text, "SOS");
  EXPECT_EQ(request.settings.clothes, "blue");
  EXPECT_EQ(request.settings.letters_per_minute, 30);
  EXPECT_EQ(request.settings.duration, 2.5);
  const auto scene = request_of(
                         "idle?sleeves=none&room=wooden&light=dim&poster=1&flags=1&distance=2&place=-0.1&"
                         "pan=12:-7:1.01&exposure=0.8")
                         .settings;
  EXPECT_EQ(scene.sleeves, "none");
  EXPECT_EQ(scene.room, "wooden");
  EXPECT_EQ(scene.light, "dim");
  EXPECT_TRUE(scene.poster);
  EXPECT_TRUE(scene.flags);
  EXPECT_EQ(scene.distance, 2);
  EXPECT_EQ(scene.place, -0.1);
  EXPECT_EQ(scene.pan.dx, 12);
  EXPECT_EQ(scene.pan.dy, -7);
  EXPECT_EQ(scene.pan.zoom, 1.01);
  EXPECT_EQ(scene.exposure, 0.8);
  EXPECT_EQ(request_of("idle?pan=3:4").settings.pan.zoom, 1);
  EXPECT_EQ(Performer("semaphore", request_of("semaphore?text=SOS&rate=30&empty=0").settings).frame_count(), 180);
}

}  // namespace
}  // namespace choreo::devices
