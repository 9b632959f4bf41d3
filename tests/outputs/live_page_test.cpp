// SPDX-License-Identifier: Apache-2.0
// The live page: everything inside the window and nothing on top of another, whatever its size.
#include "outputs/live_page.hpp"

#include <gtest/gtest.h>

namespace choreo::outputs {
namespace {

// Where the triangle's left or right side is at a height.
double left_side(const Box& triangle, double y) { return triangle.x + (triangle.y + triangle.height - y); }
double right_side(const Box& triangle, double y) {
  return triangle.x + triangle.width - (triangle.y + triangle.height - y);
}

TEST(LiveLayout, VideoTriangleAndFiguresStandApartInsideTheWindow) {
  for (const auto window : {cv::Size(320, 240), cv::Size(640, 480), cv::Size(1280, 720), cv::Size(1920, 1080),
                            cv::Size(1024, 1366), cv::Size(3840, 1080)}) {
    for (const auto video : {cv::Size(640, 480), cv::Size(1920, 1080), cv::Size(1080, 1920), cv::Size(1, 1)}) {
      for (const auto leading : {Leading::kTriangle, Leading::kVideo}) {
        const auto l = live_layout(window.width, window.height, video, leading);
        const auto what = testing::Message() << window.width << "x" << window.height << ", video " << video.width << "x"
                                             << video.height << (leading == Leading::kVideo ? " leads" : "");
        EXPECT_NEAR(l.triangle.width, 2 * l.triangle.height, 1e-9) << what;
        EXPECT_GE(l.triangle.x, 0) << what;
        EXPECT_LE(l.triangle.x + l.triangle.width, window.width) << what;
        EXPECT_GE(l.triangle.y, 0) << what;
        EXPECT_LT(l.triangle.y + l.triangle.height, window.height) << what;
        EXPECT_NEAR(l.video.width / l.video.height, double(video.width) / video.height, 1e-9) << what;
        const double bottom = l.video.y + l.video.height;
        EXPECT_LT(bottom, window.height) << what;
        if (bottom > l.triangle.y) {
          EXPECT_LT(l.video.x + l.video.width, left_side(l.triangle, bottom)) << what;
        }
        const double lowest = l.figures.y + l.figures.height;
        EXPECT_LE(l.figures.x + l.figures.width, window.width) << what;
        if (lowest > l.triangle.y && l.figures.width > 1) {
          EXPECT_GT(l.figures.x, right_side(l.triangle, lowest)) << what;
        }
        if (leading == Leading::kVideo) {
          EXPECT_LT(l.video.x + l.video.width, l.figures.x) << what;
        }
      }
    }
  }
}

TEST(LiveLayout, AVideoThatLeadsFillsMostOfTheWindow) {
  for (const auto window : {cv::Size(640, 480), cv::Size(1280, 720), cv::Size(1920, 1080)}) {
    const auto l = live_layout(window.width, window.height, {640, 480}, Leading::kVideo);
    EXPECT_GT(l.video.height, 0.55 * window.height);
    EXPECT_GT(l.video.height, 1.5 * live_layout(window.width, window.height, {640, 480}).video.height);
    EXPECT_GT(l.triangle.height, 0.2 * window.height) << "still to be read";
  }
}

TEST(LivePage, IsDrawnAtTheWindowsSizeEvenASmallOne) {
  for (const auto window : {cv::Size(1, 1), cv::Size(320, 240), cv::Size(1280, 720)}) {
    const auto layout = live_layout(window.width, window.height, {640, 480});
    for (const double span : {1.0, 30.0, 600.0, 86400.0}) {
      const auto page = draw_live_page(layout, window.width, window.height, span);
      EXPECT_EQ(page.size(), window);
      EXPECT_EQ(page.type(), CV_8UC3);
    }
    const auto figures = draw_live_figures(layout, {"Z*(t,t) 0.93", "30.0 frames/s", std::string(500, 'x'), "\xff"});
    EXPECT_GE(figures.cols, 1);
    EXPECT_LE(figures.cols, std::max(1, window.width));
  }
}

}  // namespace
}  // namespace choreo::outputs
