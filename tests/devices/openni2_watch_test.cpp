// SPDX-License-Identifier: Apache-2.0
// One silent stream of two is noticed, at a simulated clock.
#include "devices/openni2/stream_watch.hpp"

#include <gmock/gmock.h>

#include "devices/fourcc.hpp"

namespace choreo::devices::openni2 {
namespace {

using namespace std::chrono_literals;
using ::testing::StartsWith;

class OpenNi2Watch : public ::testing::Test {
 protected:
  // Listens for so long; what is said of stream 0, colour, and 1, depth, is heard at the end of each 10 ms.
  void listen(Nanoseconds how_long, bool colour, bool depth) {
    for (const auto end = now_ + how_long; now_ < end && lost_.empty();) {
      watch_.begin(now_);
      now_ += 10ms;
      watch_.heard(0, colour_ += colour ? 1 : 0, now_);
      watch_.heard(1, depth_ += depth ? 1 : 0, now_);
      try {
        watch_.end(now_);
      } catch (const DeviceLost& lost) {
        lost_ = lost.what();
      }
    }
  }
  Nanoseconds now_ = 100s;
  StreamWatch watch_{{{Sensor::kColour, kRgb3, 2, 1, 30}, {Sensor::kDepth, kZ16, 2, 1, 30}}, now_};
  std::uint64_t colour_ = 0, depth_ = 0;
  std::string lost_;
};

TEST_F(OpenNi2Watch, FifteenFramesOfOneStreamAreTheLimit) {
  listen(1s, true, true);
  listen(500ms, true, false);
  EXPECT_EQ(lost_, "");
  listen(20ms, true, false);
  EXPECT_THAT(lost_, StartsWith("the depth stream is silent: no picture for 0.5 s"));
}

TEST_F(OpenNi2Watch, TheFirstPictureMayTakeThreeSeconds) {
  listen(2990ms, true, false);
  EXPECT_EQ(lost_, "");
  EXPECT_FALSE(watch_.complete());
  listen(20ms, true, false);
  EXPECT_THAT(lost_, StartsWith("the depth stream is silent: no picture for 3.0 s"));
}

TEST_F(OpenNi2Watch, EitherStreamIsWatched) {
  listen(1s, true, true);
  EXPECT_TRUE(watch_.complete());
  listen(1s, false, true);
  EXPECT_THAT(lost_, StartsWith("the colour stream is silent"));
}

TEST_F(OpenNi2Watch, WhatNobodyListenedToWasNoSilence) {
  listen(1s, true, true);
  listen(300ms, true, false);
  now_ += 10s;
  listen(190ms, true, false);
  EXPECT_EQ(lost_, "");
}

TEST_F(OpenNi2Watch, WhereAllIsSilentOthersTell) {
  listen(1s, true, true);
  listen(5s, false, false);
  EXPECT_EQ(lost_, "");
}

}  // namespace
}  // namespace choreo::devices::openni2
