// SPDX-License-Identifier: Apache-2.0
// The three adapters from a frame to the state of its silhouette, on a square before a plain wall.
#include "pipeline/stages/silhouette_stages.hpp"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "pipeline/fakes.hpp"
#include "pipeline/runner.hpp"
#include "support/frames.hpp"

namespace choreo::pipeline {
namespace {

using test::frame_at;
using test::same_pixels;
using namespace std::chrono_literals;

const cv::Size kSilhouetteSize{160, 120};

cv::Mat wall() { return {kSilhouetteSize, CV_8UC3, cv::Scalar(60, 70, 80)}; }

cv::Mat with_square(cv::Rect square) {
  auto picture = wall();
  picture(square).setTo(cv::Scalar(220, 210, 200));
  return picture;
}

vision::BodyMasker masker() {
  vision::MaskOptions options;
  options.threshold = 20;
  options.follow_s = 0;
  return {wall(), 0.5, options};
}

Observation observed(const cv::Mat& picture, Nanoseconds time) {
  Observation observation;
  observation.time = time;
  observation.frame = frame_at(0, time, picture);
  return observation;
}

TEST(PictureStage, BringsTheFrameToTheWorkingSizeAndLeavesItAlone) {
  PictureStage stage({80, 60});
  const auto picture = test::noise(kSilhouetteSize, CV_8UC3, 1);
  auto observation = observed(picture.clone(), 0s);
  stage.process(observation);
  EXPECT_EQ(observation.picture.size(), cv::Size(80, 60));
  EXPECT_TRUE(same_pixels(observation.frame->bgr, picture));
}

TEST(PictureStage, BringsDepthAlongOnlyWhereItIsLookedAt) {
  auto frame = std::make_shared<devices::Frame>();
  frame->bgr = wall();
  frame->depth = cv::Mat(kSilhouetteSize, CV_16UC1, cv::Scalar(2500));
  Observation observation;
  observation.frame = frame;
  PictureStage({80, 60}).process(observation);
  EXPECT_TRUE(observation.depth_mm.empty());
  PictureStage({80, 60}, true).process(observation);
  EXPECT_TRUE(same_pixels(observation.depth_mm, cv::Mat(60, 80, CV_16UC1, cv::Scalar(2500))));
}

TEST(MaskStage, MasksTheDepthWhereASegmenterUsesIt) {
  vision::DepthBackground room;
  room.depth_mm = cv::Mat(kSilhouetteSize, CV_16UC1, cv::Scalar(3000));
  room.spread_mm = cv::Mat(kSilhouetteSize, CV_32FC1, cv::Scalar(5));
  MaskStage stage(vision::Segmenter(std::nullopt, vision::DepthMasker(room, {}, {}), {}));
  auto observation = observed(wall(), 0s);
  observation.picture = wall();
  observation.depth_mm = room.depth_mm.clone();
  observation.depth_mm(cv::Rect(40, 30, 20, 40)) = 2000;
  stage.process(observation);
  EXPECT_TRUE(observation.mask.body);
  EXPECT_EQ(cv::boundingRect(observation.mask.mask), cv::Rect(40, 30, 20, 40));
}

TEST(MaskStage, MasksThePictureAtItsTime) {
  MaskStage stage(masker());
  auto observation = observed(wall(), 0s);
  observation.picture = with_square({40, 30, 20, 40});
  stage.process(observation);
  EXPECT_TRUE(observation.mask.body);
  EXPECT_EQ(observation.mask.area, 20 * 40);
  EXPECT_EQ(observation.mask.mask.size(), kSilhouetteSize);
  EXPECT_EQ(cv::boundingRect(observation.mask.mask), cv::Rect(40, 30, 20, 40));
}

// The observation as the first two stages leave it.
Observation masked(const std::optional<cv::Rect>& body, Nanoseconds time) {
  auto observation = observed(wall(), time);
  observation.mask.mask = cv::Mat::zeros(kSilhouetteSize, CV_8UC1);
  if (body) {
    observation.mask.mask(*body).setTo(255);
    observation.mask.body = true;
    observation.mask.area = body->area();
  }
  return observation;
}

TEST(StateStage, ABodyHasAStateAndWithoutOneThereIsNone) {
  StateStage stage(0.15);
  auto with = masked(cv::Rect(40, 30, 20, 40), 0s);
  stage.process(with);
  ASSERT_TRUE(with.state);
  EXPECT_EQ(with.state->area(), 800);
  EXPECT_DOUBLE_EQ(with.contraction, 1.0) << "a box fills its box";
  EXPECT_EQ(with.quantity_of_motion, 0.0) << "the first is at rest";

  auto without = masked({}, 100ms);
  stage.process(without);
  EXPECT_FALSE(without.state);
  EXPECT_EQ(without.contraction, 0.0);
  EXPECT_EQ(without.quantity_of_motion, 0.0);
}

TEST(StateStage, MotionIsWhatWasCoveredAndIsNoMoreOverTheAreaNow) {
  StateStage stage(0.15);
  auto first = masked(cv::Rect(40, 30, 20, 40), 0s);
  auto moved = masked(cv::Rect(45, 30, 20, 40), 100ms);
  stage.process(first);
  stage.process(moved);
  EXPECT_DOUBLE_EQ(moved.quantity_of_motion, 5.0 * 40 / 800);
}

TEST(StateStage, AfterAFrameWithoutABodyThereIsNoMotionFromBefore) {
  StateStage stage(10.0);
  auto first = masked(cv::Rect(40, 30, 20, 40), 0s);
  auto gone = masked({}, 100ms);
  auto back = masked(cv::Rect(90, 30, 20, 40), 200ms);
  for (auto* observation : {&first, &gone, &back}) stage.process(*observation);
  EXPECT_EQ(back.quantity_of_motion, 0.0);
}

// What the three stages make of a clip, as one comparable text of numbers.
class Collect final : public Stage {
 public:
  explicit Collect(std::vector<std::pair<cv::Mat, std::vector<double>>>& out) : out_(out) {}
  [[nodiscard]] std::string name() const override { return "collect"; }
  void process(Observation& o) override {
    const double area = o.state ? double(o.state->area()) : -1;
    out_.push_back({o.mask.mask, {to_seconds(o.time), area, o.quantity_of_motion, o.contraction}});
  }

 private:
  std::vector<std::pair<cv::Mat, std::vector<double>>>& out_;
};

TEST(SilhouetteStages, OneThreadAndManyGiveTheSameObservations) {
  std::vector<devices::FramePtr> frames;
  for (int i = 0; i < 60; ++i) {
    // A square that crosses the picture and is gone for a while, in sensor noise.
    cv::Mat picture = i / 10 == 2 ? wall() : with_square({2 * i, 20 + i / 2, 24, 40});
    picture += test::noise(kSilhouetteSize, CV_8UC3, static_cast<std::uint64_t>(i)) / 64;
    frames.push_back(frame_at(static_cast<std::uint64_t>(i), 40ms * i, picture));
  }
  const auto with_threads = [&](int threads) {
    std::vector<std::pair<cv::Mat, std::vector<double>>> out;
    std::vector<std::unique_ptr<Stage>> stages;
    stages.push_back(std::make_unique<PictureStage>(cv::Size(80, 60)));
    auto small = wall();
    cv::resize(small, small, {80, 60});
    stages.push_back(std::make_unique<MaskStage>(vision::BodyMasker(small, 1.0, {})));
    stages.push_back(std::make_unique<StateStage>(0.15));
    stages.push_back(std::make_unique<Collect>(out));
    test::ListedSource source(frames);
    const auto report = run(source, {}, stages, {threads, 3}, test::SimulatedClock(), {});
    EXPECT_FALSE(report.problem);
    return out;
  };
  const auto one = with_threads(1);
  ASSERT_EQ(one.size(), 60u);
  EXPECT_GT(one[5].second[1], 0) << "there is a body";
  EXPECT_EQ(one[25].second[1], -1) << "and then there is none";
  EXPECT_GT(one[6].second[2], 0) << "it moves";
  for (const int threads : {0, 4}) {
    const auto many = with_threads(threads);
    ASSERT_EQ(many.size(), one.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(many[i].second, one[i].second) << "frame " << i;
      EXPECT_TRUE(same_pixels(many[i].first, one[i].first)) << "frame " << i;
    }
  }
}

}  // namespace
}  // namespace choreo::pipeline
