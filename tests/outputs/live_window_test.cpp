// SPDX-License-Identifier: Apache-2.0
// The window on SDL's driver that draws nowhere: it opens, takes frames, and ends, whoever is faster.
#include "outputs/live_window.hpp"

#include <SDL2/SDL.h>

#include <atomic>
#include <cstdlib>
#include <limits>
#include <thread>

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "support/frames.hpp"

namespace choreo::outputs {
namespace {

class LiveWindowTest : public ::testing::Test {
 protected:
  LiveWindowTest() { ::setenv("SDL_VIDEODRIVER", "dummy", 1); }

  LiveWindowOptions options() {
    LiveWindowOptions options;
    options.title = "a test";
    options.video = {64, 48};
    options.history_s = 60;
    options.on_close = [this] { ++closed_; };
    options.on_report = [this] {
      ++reports_;
      reports_.notify_all();
    };
    options.on_lost = [this](const std::string& why) {
      ADD_FAILURE() << why;
      ++lost_;
      ++reports_;  // Nobody waits any longer.
      reports_.notify_all();
    };
    return options;
  }

  // Returns once the window's thread has drawn and looked at its events since it was called.
  void see_a_round() {
    for (int k = 0; k < 2; ++k) {  // The first may have been half over.
      const int before = reports_;
      if (lost_ > 0) return;  // In this order: a loss from here on is a report, too.
      SDL_Event key{};
      key.type = SDL_KEYDOWN;
      key.key.keysym.sym = SDLK_l;
      ASSERT_EQ(SDL_PushEvent(&key), 1);
      reports_.wait(before);
    }
  }

  static void show(LiveWindow& window, int i) {
    const std::vector<float> row(std::size_t(i % 100 + 1), i % 5 == 0 ? std::numeric_limits<float>::quiet_NaN() : 0.5F);
    window.show(test::noise({64, 48}, CV_8UC3, std::uint64_t(i)), test::noise({32, 24}, CV_8UC1, std::uint64_t(i)),
                0.01 * i, row, row);
  }

  std::atomic<int> closed_{0};
  std::atomic<int> reports_{0};
  std::atomic<int> lost_{0};
};

TEST_F(LiveWindowTest, OpensShowsAndCloses) {
  {
    LiveWindow window(options());
    window.tell({"no body", "30.0 frames/s"});
    for (int i = 0; i < 200; ++i) show(window, i);
    see_a_round();
    EXPECT_NE(SDL_WasInit(SDL_INIT_VIDEO), 0U);
  }
  EXPECT_EQ(SDL_WasInit(SDL_INIT_VIDEO), 0U) << "it gave back what it had opened";
  EXPECT_EQ(reports_, 2);
  EXPECT_EQ(closed_, 0) << "nobody closed it";
  EXPECT_EQ(lost_, 0);
}

TEST_F(LiveWindowTest, ClosesAtOnceToo) {
  for (int i = 0; i < 3; ++i) {
    { const LiveWindow window(options()); }
    EXPECT_EQ(SDL_WasInit(SDL_INIT_VIDEO), 0U) << i;
  }
  EXPECT_EQ(closed_, 0);
  EXPECT_EQ(lost_, 0);
}

TEST_F(LiveWindowTest, IsShownAndToldFromSeveralThreads) {
  LiveWindow window(options());
  std::jthread teller([&] {
    for (int i = 0; i < 200; ++i) window.tell({std::to_string(i)});
  });
  for (int i = 0; i < 200; ++i) show(window, i);
  teller.join();
  see_a_round();
  EXPECT_EQ(lost_, 0) << "it still draws";
}

TEST_F(LiveWindowTest, ADriverThatIsNotThereIsToldOfInOneLine) {
  ::setenv("SDL_VIDEODRIVER", "nosuchdriver", 1);
  const auto error = test::error_of([this] { const LiveWindow window(options()); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kFailure);
  EXPECT_EQ(error->hint(), "run without a window: --headless");
}

TEST_F(LiveWindowTest, ADisplayIsOnlyThereWhereTheEnvironmentNamesOne) {
  EXPECT_TRUE(display_is_there());
  ::unsetenv("SDL_VIDEODRIVER");
  ::unsetenv("WAYLAND_DISPLAY");
  ::unsetenv("DISPLAY");
  EXPECT_FALSE(display_is_there());
  ::setenv("DISPLAY", "", 1);
  EXPECT_FALSE(display_is_there());
}

}  // namespace
}  // namespace choreo::outputs
