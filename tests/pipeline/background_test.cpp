// SPDX-License-Identifier: Apache-2.0
// How the background is asked for, which frames teach it, and that none of them is lost to the analysis.
#include "pipeline/background.hpp"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/even_sampler.hpp"
#include "pipeline/fakes.hpp"
#include "support/frames.hpp"

namespace choreo::pipeline {
namespace {

using test::error_of;
using test::frame_at;
using test::ListedSource;
using test::same_pixels;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using namespace std::chrono_literals;
using Kind = BackgroundSpec::Kind;

const cv::Size kPlateSize{32, 24};

TEST(ParseBackground, SaysWhereItComesFrom) {
  EXPECT_EQ(parse_background("auto").kind, Kind::kAuto);
  const auto first = parse_background("first:1.5s");
  EXPECT_EQ(first.kind, Kind::kFirst);
  EXPECT_EQ(first.first, 1500ms);
  EXPECT_EQ(parse_background("first:2").first, 2s);
  EXPECT_EQ(parse_background("first:10min").first, 10min);
  for (const auto* path : {"room.png", "./auto", "first", "Auto", "plates/first:1s"}) {
    const auto plate = parse_background(path);
    EXPECT_EQ(plate.kind, Kind::kPlate) << path;
    EXPECT_EQ(plate.plate, path);
  }
}

TEST(ParseBackground, ADurationThatIsNoneOrNothingIsRefused) {
  for (const auto* bad : {"first:", "first:0", "first:0s", "first:-1s", "first:x", "first:nan", "first:1001h", ""}) {
    const auto error = error_of([&] { (void)parse_background(bad); });
    ASSERT_TRUE(error) << bad;
    EXPECT_EQ(error->fault(), Fault::kUsage) << bad;
    EXPECT_FALSE(error->hint().empty()) << bad;
  }
}

class LearnBackground : public ::testing::Test {
 protected:
  // A wall that is the same in every frame.
  static std::vector<devices::FramePtr> of_wall(std::uint64_t count, const cv::Mat& wall) {
    std::vector<devices::FramePtr> frames;
    for (std::uint64_t i = 0; i < count; ++i) frames.push_back(frame_at(i, 3s + 100ms * static_cast<long>(i), wall));
    return frames;
  }
  // Grey pictures that become brighter from 0 to 200 in equal steps.
  static std::vector<devices::FramePtr> brightening(std::uint64_t count, cv::Size size = kPlateSize) {
    std::vector<cv::Mat> greys;
    for (int v = 0; v <= 200; ++v) greys.emplace_back(size, CV_8UC3, cv::Scalar::all(v));
    std::vector<devices::FramePtr> frames;
    for (std::uint64_t i = 0; i < count; ++i) {
      frames.push_back(frame_at(i, 100ms * static_cast<long>(i), greys[i * 200 / (count - 1)]));
    }
    return frames;
  }

  std::optional<LearnedBackground> learn(const std::vector<devices::FramePtr>& frames, const std::string& background,
                                         bool repeatable = true, const cv::Mat& plate = {}, int rows = 0) {
    devices::SourceInfo info;
    info.name = "clip.mkv";
    info.size = frames.empty() ? kPlateSize : frames[0]->bgr.size();
    info.repeatable = repeatable;
    info.duration = duration_;
    info.foreseeable = foreseeable_;
    auto source = std::make_unique<ListedSource>(frames, info);
    source->before_read = before_read_;
    return learn_background(
        std::move(source), parse_background(background), plate, rows,
        [=, this] {
          ++reopened_;
          return std::make_unique<ListedSource>(frames, info);
        },
        [this](double share) { progress_.push_back(share); }, stop_.get_token());
  }
  static std::vector<std::uint64_t> sequences(devices::Source& source) {
    std::vector<std::uint64_t> all;
    for (const auto& frame : test::all_frames(source)) all.push_back(frame->sequence);
    return all;
  }
  static std::vector<std::uint64_t> up_to(std::uint64_t count) {
    std::vector<std::uint64_t> all;
    for (std::uint64_t i = 0; i < count; ++i) all.push_back(i);
    return all;
  }

  const cv::Mat wall_ = test::noise(kPlateSize, CV_8UC3, 7);
  std::optional<Nanoseconds> duration_;
  bool foreseeable_ = true;
  std::function<void(std::size_t)> before_read_;
  std::stop_source stop_;
  int reopened_ = 0;
  std::vector<double> progress_;
};

TEST_F(LearnBackground, AWallThatStandsStillIsTheBackgroundWhicheverWayItIsLearned) {
  for (const auto* background : {"auto", "first:1s"}) {
    for (const bool repeatable : {true, false}) {
      const auto learned = learn(of_wall(20, wall_), background, repeatable);
      ASSERT_TRUE(learned);
      EXPECT_TRUE(same_pixels(learned->estimate.plate, wall_)) << background << " " << repeatable;
    }
  }
}

TEST_F(LearnBackground, ARepeatableSourceIsReadWholeAndOpenedAgain) {
  const auto learned = learn(of_wall(30, wall_), "auto");
  EXPECT_EQ(learned->frames_read, 30u);
  EXPECT_EQ(learned->pictures, 30u);
  EXPECT_EQ(reopened_, 1);
  EXPECT_EQ(sequences(*learned->source), up_to(30));
}

TEST_F(LearnBackground, FirstReadsTheFramesBeforeThatTimeSinceTheFirst) {
  const auto learned = learn(of_wall(30, wall_), "first:0.5s");
  EXPECT_EQ(learned->frames_read, 5u) << "0 to 0.4 s";
  EXPECT_EQ(learned->pictures, 5u);
  EXPECT_EQ(sequences(*learned->source), up_to(30));
  EXPECT_EQ(learn(of_wall(30, wall_), "first:1ms")->frames_read, 1u) << "there is always one";
  EXPECT_EQ(learn(of_wall(30, wall_), "first:1h")->frames_read, 30u);
}

TEST_F(LearnBackground, FirstIsTheMedianOfThoseFramesAlone) {
  auto frames = of_wall(30, wall_);
  const cv::Mat later(kPlateSize, CV_8UC3, cv::Scalar::all(90));
  for (std::uint64_t i = 7; i < 30; ++i) frames[i] = frame_at(i, frames[i]->device_time, later);
  EXPECT_TRUE(same_pixels(learn(frames, "first:1s")->estimate.plate, wall_)) << "7 of 10 show it";
}

TEST_F(LearnBackground, FromAnUnrepeatableSourceTheFramesReadAreGivenAgain) {
  for (const auto* background : {"auto", "first:1s"}) {
    const auto learned = learn(of_wall(30, wall_), background, false);
    EXPECT_EQ(learned->frames_read, 10u) << "auto is the first second";
    EXPECT_EQ(reopened_, 0);
    EXPECT_EQ(learned->source->info().name, "clip.mkv");
    EXPECT_THAT(learned->source->warnings(), ElementsAre("a warning of the source"));
    EXPECT_EQ(sequences(*learned->source), up_to(30));
    EXPECT_EQ(learned->source->read({}), nullptr);
  }
}

TEST_F(LearnBackground, ATakeThatStandsForADeviceTeachesWhatTheDeviceTaught) {
  foreseeable_ = false;
  for (const auto* background : {"auto", "first:1s"}) {
    const auto of_take = learn(brightening(30), background);
    const auto of_device = learn(brightening(30), background, false);
    EXPECT_EQ(of_take->frames_read, of_device->frames_read);
    EXPECT_TRUE(same_pixels(of_take->estimate.plate, of_device->estimate.plate));
    EXPECT_EQ(sequences(*of_take->source), up_to(30));
  }
  EXPECT_EQ(reopened_, 2) << "and yet it is read anew";
}

TEST_F(LearnBackground, APlateIsTakenAsItIsAndTheClipOnlyTellsTheNoise) {
  const cv::Mat plate = test::noise(kPlateSize, CV_8UC3, 8);
  for (const bool repeatable : {true, false}) {
    const auto learned = learn(of_wall(30, wall_), "room.png", repeatable, plate);
    EXPECT_TRUE(same_pixels(learned->estimate.plate, plate));
    EXPECT_EQ(learned->pictures, 0u);
    EXPECT_EQ(learned->frames_read, 10u) << "a second of them";
    EXPECT_FALSE(learned->estimate.uncertain());
    EXPECT_EQ(sequences(*learned->source), up_to(30));
  }
}

TEST_F(LearnBackground, APlateOfAnotherSizeIsRefusedWithBothSizes) {
  const auto error =
      error_of([&] { (void)learn(of_wall(3, wall_), "room.png", true, cv::Mat(24, 31, CV_8UC3, cv::Scalar())); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_STREQ(error->what(), "the plate \"room.png\" is 31 x 24 pixels, the frames of \"clip.mkv\" are 32 x 24");
}

TEST_F(LearnBackground, WithoutFramesThereIsNoBackground) {
  for (const auto* background : {"auto", "first:1s", "room.png"}) {
    for (const bool repeatable : {true, false}) {
      const auto error = error_of([&] { (void)learn({}, background, repeatable, wall_); });
      ASSERT_TRUE(error) << background;
      EXPECT_EQ(error->fault(), Fault::kUsage);
      EXPECT_STREQ(error->what(), "\"clip.mkv\" has no frames");
    }
  }
}

TEST_F(LearnBackground, StoppedMidwayThereIsNothing) {
  before_read_ = [this](std::size_t next) {
    if (next == 4) stop_.request_stop();
  };
  EXPECT_FALSE(learn(of_wall(30, wall_), "auto").has_value());
  EXPECT_EQ(reopened_, 0);
}

TEST_F(LearnBackground, WhatTheSourceThrowsComesThrough) {
  before_read_ = [](std::size_t next) {
    if (next == 0) throw failure("the disk does not answer");
  };
  EXPECT_TRUE(error_of([&] { (void)learn(of_wall(30, wall_), "auto"); }));
}

TEST_F(LearnBackground, WhatBreaksOffTeachesWithWhatItHas) {
  // The frames that break may not be among the chosen ones; if they are, reading them says so again.
  before_read_ = [](std::size_t next) {
    if (next == 4) throw failure("the frame size changes");
  };
  EXPECT_EQ(learn(of_wall(30, wall_), "auto")->frames_read, 4u);
  EXPECT_TRUE(error_of([&] { (void)learn(of_wall(30, wall_), "auto", false); })) << "a pipe gives nothing twice";
}

TEST_F(LearnBackground, IsMadeAtTheWorkingSize) {
  const auto learned = learn(of_wall(5, wall_), "auto", true, {}, 12);
  EXPECT_EQ(learned->estimate.plate.size(), cv::Size(16, 12));
  const auto plate = learn(of_wall(5, wall_), "room.png", true, wall_, 12);
  EXPECT_EQ(plate->estimate.plate.size(), cv::Size(16, 12));
  EXPECT_EQ(learned->source->read({})->bgr.size(), kPlateSize) << "the frames stay as they are";
}

TEST_F(LearnBackground, ProgressIsTheShareOfTheTimeOrSaidToBeUnknown) {
  duration_ = 2s;
  (void)learn(of_wall(20, wall_), "auto");
  ASSERT_THAT(progress_, SizeIs(20));
  EXPECT_EQ(progress_[0], 0.0);
  EXPECT_DOUBLE_EQ(progress_[10], 0.5);
  EXPECT_TRUE(std::is_sorted(progress_.begin(), progress_.end()));

  progress_.clear();
  duration_ = 1s;  // Files lie.
  (void)learn(of_wall(20, wall_), "auto");
  EXPECT_EQ(progress_.back(), 1.0);

  progress_.clear();
  duration_.reset();
  (void)learn(of_wall(20, wall_), "auto");
  EXPECT_THAT(progress_, Each(::testing::Lt(0.0)));
}

TEST_F(LearnBackground, OfLongRecordingsAtMostAHundredAndTwentyEvenlySpreadPicturesAreKept) {
  // As pictures only become brighter, the median says where in the recording the middle one of those kept lies.
  for (const std::uint64_t count : {2u, 119u, 120u, 121u, 240u, 241u, 500u, 1000u, 3001u}) {
    const auto learned = learn(brightening(count), "first:1h");
    EXPECT_EQ(learned->frames_read, count);
    EXPECT_LE(learned->pictures, 120u);
    EXPECT_GE(learned->pictures, std::min<std::uint64_t>(count, 61)) << "never thinned to less than half";
    EXPECT_NEAR(learned->estimate.plate.at<cv::Vec3b>(0, 0)[0], 100, count == 2 ? 100 : 5) << count;
  }
  EXPECT_EQ(learn(brightening(120), "first:1h")->pictures, 120u);
  EXPECT_EQ(learn(brightening(121), "first:1h")->pictures, 61u) << "frames 0, 2, ... 120";
  EXPECT_EQ(learn(brightening(241), "first:1h")->pictures, 61u) << "frames 0, 4, ... 240";
}

// A wall at 3 m with a wall's picture; every frame, or those from `first` on, has depth.
std::vector<devices::FramePtr> with_depth(std::uint64_t count, std::uint64_t first = 0) {
  std::vector<devices::FramePtr> frames;
  for (std::uint64_t i = 0; i < count; ++i) {
    auto frame = std::make_shared<devices::Frame>(
        *frame_at(i, 100ms * static_cast<long>(i), cv::Mat(kPlateSize, CV_8UC3, cv::Scalar(90, 90, 90))));
    if (i >= first) frame->depth = cv::Mat(kPlateSize, CV_16UC1, cv::Scalar(3000));
    frames.push_back(frame);
  }
  return frames;
}

std::optional<LearnedBackground> learn_by(vision::Segmentation segmentation,
                                          const std::vector<devices::FramePtr>& frames, const std::string& background,
                                          bool repeatable = true, int rows = 0) {
  devices::SourceInfo info;
  info.name = "clip.oni";
  info.size = kPlateSize;
  info.repeatable = repeatable;
  const cv::Mat plate(kPlateSize, CV_8UC3, cv::Scalar(90, 90, 90));
  return learn_background(
      std::make_unique<ListedSource>(frames, info), parse_background(background), plate, rows,
      [=] { return std::make_unique<ListedSource>(frames, info); }, [](double) {}, {}, segmentation);
}

TEST(LearnDepthBackground, IsLearnedFromTheSameFramesWhateverTheBackgroundComesFrom) {
  for (const auto segmentation : {vision::Segmentation::kDepth, vision::Segmentation::kBoth}) {
    for (const auto* background : {"auto", "first:0.5s", "room.png"}) {
      for (const bool repeatable : {true, false}) {
        const auto learned = learn_by(segmentation, with_depth(30), background, repeatable);
        ASSERT_TRUE(learned && learned->depth);
        EXPECT_EQ(cv::countNonZero(learned->depth->depth_mm != 3000), 0) << background << repeatable;
        EXPECT_EQ(learned->estimate.plate.empty(), segmentation == vision::Segmentation::kDepth);
        EXPECT_EQ(test::all_frames(*learned->source).size(), 30u);
      }
    }
  }
  EXPECT_FALSE(learn_by(vision::Segmentation::kColour, with_depth(30), "auto")->depth);
}

TEST(LearnDepthBackground, APlateTellsNothingOfDepthSoTheWholeRecordingDoes) {
  EXPECT_EQ(learn_by(vision::Segmentation::kBoth, with_depth(30), "room.png")->frames_read, 30u);
  EXPECT_EQ(learn_by(vision::Segmentation::kBoth, with_depth(30), "room.png", false)->frames_read, 10u);
}

TEST(LearnDepthBackground, IsMadeAtTheWorkingSize) {
  EXPECT_EQ(learn_by(vision::Segmentation::kDepth, with_depth(5), "auto", true, 12)->depth->depth_mm.size(),
            cv::Size(16, 12));
}

TEST(LearnDepthBackground, FirstFramesWithoutDepthAreForgivenAndASourceWithoutAnyIsRefusedAfterASecond) {
  EXPECT_TRUE(learn_by(vision::Segmentation::kBoth, with_depth(30, 9), "auto")->depth);
  for (const auto count : {1u, 30u}) {
    const auto error = error_of([&] { (void)learn_by(vision::Segmentation::kBoth, with_depth(count, 1000), "auto"); });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->fault(), Fault::kUsage);
    EXPECT_STREQ(error->what(), "segmentation: \"clip.oni\" has no depth");
    EXPECT_THAT(error->hint(), HasSubstr("Kinect"));
  }
}

// Which of so many numbers are kept.
std::vector<int> kept_of(int count, std::size_t most) {
  EvenSampler<int> sampler(most);
  for (int i = 0; i < count; ++i) sampler.add(i);
  return sampler.kept();
}

TEST(EvenSampler, KeepsEveryPictureOrEverySecondOrEveryFourth) {
  EXPECT_THAT(kept_of(0, 4), ElementsAre());
  EXPECT_THAT(kept_of(4, 4), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(kept_of(5, 4), ElementsAre(0, 2, 4));
  EXPECT_THAT(kept_of(8, 4), ElementsAre(0, 2, 4, 6));
  EXPECT_THAT(kept_of(9, 4), ElementsAre(0, 4, 8));
  EXPECT_THAT(kept_of(3, 3), ElementsAre(0, 1, 2));
  EXPECT_THAT(kept_of(6, 3), ElementsAre(0, 2, 4)) << "of an odd number too";
  EXPECT_THAT(kept_of(1000, 1), ElementsAre(0));
}

TEST(EvenSampler, TheStepIsAlwaysTheSameAndAtLeastHalfThePlacesAreUsed) {
  for (const std::size_t most : {2u, 7u, 8u, 120u}) {
    for (int count = 1; count < 1000; count += 7) {
      const auto kept = kept_of(count, most);
      ASSERT_LE(kept.size(), most);
      ASSERT_GE(kept.size(), std::min(std::size_t(count), (most + 1) / 2));
      ASSERT_EQ(kept[0], 0);
      const int step = kept.size() > 1 ? kept[1] : count;
      for (std::size_t i = 0; i < kept.size(); ++i) ASSERT_EQ(kept[i], int(i) * step);
      ASSERT_GE(kept.back() + step, count) << "up to the end";
    }
  }
}

TEST(EvenSampler, OnlyWhatIsKeptIsMade) {
  EvenSampler<int> sampler(4);
  int made = 0;
  for (int i = 0; i < 1000; ++i) {
    const int expected = made + (sampler.wants() ? 1 : 0);
    sampler.offer([&] { return ++made; });
    ASSERT_EQ(made, expected) << "it is known beforehand";
  }
  EXPECT_LT(made, 40);
}

TEST(MostPictures, LargeOnesAreKeptInSmallerNumber) {
  EXPECT_EQ(most_pictures({320, 240}), 120u);
  EXPECT_EQ(most_pictures({1, 1}), 120u);
  EXPECT_EQ(most_pictures({1920, 1080}), 43u) << "6.2 MB each";
  EXPECT_EQ(most_pictures({7680, 4320}), 8u);
  EXPECT_EQ(most_pictures({50000, 50000}), 8u) << "more bytes than an int holds";
}

}  // namespace
}  // namespace choreo::pipeline
