// SPDX-License-Identifier: Apache-2.0
// What the tests of video files share.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "devices/video_file/video_file.hpp"
#include "outputs/video_writer.hpp"
#include "support/frames.hpp"
#include "support/make_video.hpp"
#include "support/temp_folder.hpp"

namespace choreo::devices {

class VideoFileTest : public ::testing::Test {
 protected:
  VideoFileTest() { registry_.add(video_file_driver()); }

  std::unique_ptr<Source> open(const std::string& name, int threads = 0) {
    OpenOptions options;
    options.threads = threads;
    return registry_.open(folder_ / name, options);
  }

  /// The usage error of opening `name`; fails the test where there is none.
  Error refusal(const std::string& name) {
    const auto error = test::error_of([&] { (void)open(name); });
    EXPECT_TRUE(error) << name << " was opened";
    if (!error) return usage_error("none");
    EXPECT_EQ(error->fault(), Fault::kUsage) << error->what();
    EXPECT_EQ(std::string(error->what()).find('\n'), std::string::npos) << "one line";
    EXPECT_FALSE(error->hint().empty()) << error->what();
    return *error;
  }

  /// `count` pictures of noise at 25 a second, without loss; returns them.
  std::vector<cv::Mat> write_noise(const std::string& name, int count, cv::Size size = {24, 16}, bool grey = false) {
    outputs::VideoOptions options;
    options.grey = grey;
    options.rate = {25, 1};
    outputs::VideoWriter writer(folder_ / name, size, options);
    std::vector<cv::Mat> pictures;
    for (int i = 0; i < count; ++i) {
      pictures.push_back(test::noise(size, grey ? CV_8UC1 : CV_8UC3, static_cast<std::uint64_t>(i) + 1));
      writer.write(pictures.back(), std::chrono::milliseconds(40 * i));
    }
    writer.close();
    return pictures;
  }

  test::TempFolder folder_;
  Registry registry_;
};

}  // namespace choreo::devices
