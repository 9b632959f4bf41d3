// SPDX-License-Identifier: Apache-2.0
#include "devices/oriented_source.hpp"

#include <gtest/gtest.h>

#include "support/frames.hpp"

namespace choreo::devices {
namespace {

using test::same_pixels;

// 1 2 3
// 4 5 6
const cv::Mat kPicture = (cv::Mat_<std::uint8_t>(2, 3) << 1, 2, 3, 4, 5, 6);

TEST(OrientedSource, AQuarterTurnIsClockwise) {
  // The left column, read from below, becomes the top row.
  EXPECT_TRUE(same_pixels(oriented(kPicture, {1, false, false}), (cv::Mat_<std::uint8_t>(3, 2) << 4, 1, 5, 2, 6, 3)));
  EXPECT_TRUE(same_pixels(oriented(kPicture, {2, false, false}), (cv::Mat_<std::uint8_t>(2, 3) << 6, 5, 4, 3, 2, 1)));
  EXPECT_TRUE(same_pixels(oriented(kPicture, {3, false, false}), (cv::Mat_<std::uint8_t>(3, 2) << 3, 6, 2, 5, 1, 4)));
}

TEST(OrientedSource, FlipsExchangeLeftAndRightOrUpAndDown) {
  EXPECT_TRUE(same_pixels(oriented(kPicture, {0, true, false}), (cv::Mat_<std::uint8_t>(2, 3) << 3, 2, 1, 6, 5, 4)));
  EXPECT_TRUE(same_pixels(oriented(kPicture, {0, false, true}), (cv::Mat_<std::uint8_t>(2, 3) << 4, 5, 6, 1, 2, 3)));
}

TEST(OrientedSource, TheTurnComesBeforeTheFlip) {
  // Turned: 4 1 / 5 2 / 6 3; then left and right exchanged.
  EXPECT_TRUE(same_pixels(oriented(kPicture, {1, true, false}), (cv::Mat_<std::uint8_t>(3, 2) << 1, 4, 2, 5, 3, 6)));
}

TEST(OrientedSource, BothFlipsAreAHalfTurn) {
  EXPECT_TRUE(same_pixels(oriented(kPicture, {0, true, true}), oriented(kPicture, {2, false, false})));
  EXPECT_TRUE(same_pixels(oriented(kPicture, {2, true, true}), kPicture));
}

class ThreePictures final : public Source {
 public:
  ThreePictures() {
    info_.name = "three";
    info_.size = kPicture.size();
    info_.nominal_fps = 25;
  }
  const SourceInfo& info() const override { return info_; }
  FramePtr read(std::stop_token stop) override {
    if (stop.stop_requested() || next_ == 3) return nullptr;
    auto frame = std::make_shared<Frame>();
    frame->sequence = 7 + next_;
    frame->device_time = Nanoseconds(1000 + next_);
    frame->bgr = kPicture + next_;
    ++next_;
    return frame;
  }
  std::vector<std::string> warnings() const override { return {"dusty"}; }

 private:
  SourceInfo info_;
  int next_ = 0;
};

TEST(OrientedSource, TurnsEveryFrameAndKeepsEverythingElse) {
  const auto source = make_oriented(std::make_unique<ThreePictures>(), {1, false, false});
  EXPECT_EQ(source->info().size, cv::Size(2, 3));
  EXPECT_EQ(source->info().name, "three");
  EXPECT_EQ(source->info().nominal_fps, 25);
  const auto frames = test::all_frames(*source);
  ASSERT_EQ(frames.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(frames[i]->sequence, 7u + static_cast<unsigned>(i));
    EXPECT_EQ(frames[i]->device_time, Nanoseconds(1000 + i));
    EXPECT_EQ(frames[i]->bgr.size(), source->info().size);
    EXPECT_EQ(frames[i]->bgr.at<std::uint8_t>(0, 1), 1 + i) << "what was top left is top right";
  }
  EXPECT_EQ(source->warnings(), std::vector<std::string>{"dusty"});
}

TEST(OrientedSource, StoppingReachesTheSourceBeneath) {
  const auto source = make_oriented(std::make_unique<ThreePictures>(), {1, false, false});
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(source->read(stop.get_token()), nullptr);
}

TEST(OrientedSource, TheIdentityIsTheSourceItself) {
  auto source = std::make_unique<ThreePictures>();
  const auto* before = source.get();
  EXPECT_EQ(make_oriented(std::move(source), {}).get(), before);
}

}  // namespace
}  // namespace choreo::devices
