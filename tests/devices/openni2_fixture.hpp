// SPDX-License-Identifier: Apache-2.0
// The real library of OpenNI2 in a folder of its own, with a camera that is made up.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <stdlib.h>

#include <gmock/gmock.h>

#include "core/error.hpp"
#include "devices/openni2/openni2_driver.hpp"
#include "pipeline/steady_clock.hpp"
#include "support/frames.hpp"
#include "support/oni_pattern.hpp"
#include "support/places.hpp"
#include "support/program.hpp"
#include "support/temp_folder.hpp"

namespace choreo::test {

/// The real library with a camera of the tests' own, in a private folder.
class OpenNi2Rig {
 public:
  OpenNi2Rig() {
    namespace fs = std::filesystem;
    // The library loads the drivers beside itself, and takes a link to it for itself.
    fs::create_symlink(fs::path(CHOREO_ONI_LIBRARIES) / "libOpenNI2.so.0", folder_ / "libOpenNI2.so.0");
    fs::create_directories(drivers());
    fs::create_symlink(fs::path(CHOREO_ONI_LIBRARIES) / "OpenNI2/Drivers/libOniFile.so.0",
                       drivers() + "/libOniFile.so.0");
    fs::create_symlink(built("libChoreoTest.so.0"), drivers() + "/libChoreoTest.so.0");
    ::setenv("LD_LIBRARY_PATH", folder_.path().c_str(), 1);
    ::setenv("CHOREO_TEST_ONI", word_file().c_str(), 1);
    ::setenv("CHOREO_OPENNI2_HELPER", built("choreoscope-openni2").c_str(), 1);
    // The library leaks, and the programs here that use it are no part of choreoscope but for the helper.
    const char* options = ::getenv("ASAN_OPTIONS");
    ::setenv("ASAN_OPTIONS", (std::string(options != nullptr ? options : "") + ":detect_leaks=0").c_str(), 1);
    registry_.add(driver());
  }

  [[nodiscard]] devices::Driver driver() const { return devices::openni2_driver(clock_, std::chrono::seconds(5)); }
  [[nodiscard]] std::string drivers() const { return folder_ / "OpenNI2/Drivers"; }
  [[nodiscard]] std::string word_file() const { return folder_ / "word"; }
  /// Tells the camera what to do; see oni_test_driver.cpp. At once: it is read while it is written.
  void tell(const std::string& word) {
    write_bytes(word_file() + ".new", word);
    std::filesystem::rename(word_file() + ".new", word_file());
  }

  /// Records at least so many pictures of the camera.
  void record(const std::string& file, int pictures) {
    RunOptions options;
    options.limit = std::chrono::seconds(20);
    Outcome run;
    // The library's recorder hangs now and then.
    for (int k = 0; k < 3 && run.status != 0; ++k)
      run = run_program(built("oni_record"), {file, std::to_string(pictures)}, options);
    ASSERT_EQ(run.status, 0) << run.told();
  }

  [[nodiscard]] std::unique_ptr<devices::Source> open(const std::string& source, devices::OpenOptions options = {}) {
    return registry_.open(source, options);
  }

  TempFolder folder_;
  pipeline::SteadyClock clock_;
  devices::Registry registry_;
};

class OpenNi2Test : public ::testing::Test, protected OpenNi2Rig {};

/// The number of the picture that a frame shows, which must be of the pattern in every pixel.
inline int picture_number(const cv::Mat& bgr) {
  const int k = bgr.at<cv::Vec3b>(0, 0)[2];
  for (int y = 0; y < bgr.rows; ++y) {
    for (int x = 0; x < bgr.cols; ++x) {
      const auto wanted = oni_colour(k, x, y);
      if (bgr.at<cv::Vec3b>(y, x) != cv::Vec3b(wanted.b, wanted.g, wanted.r)) return -1;
    }
  }
  return k;
}

/// Whether every pixel is that of picture k.
inline bool is_depth_of(const cv::Mat& depth, int k) {
  if (depth.type() != CV_16UC1 || depth.size() != cv::Size(kOniWidth, kOniHeight)) return false;
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = 0; x < depth.cols; ++x) {
      if (depth.at<std::uint16_t>(y, x) != oni_depth(k, x, y)) return false;
    }
  }
  return true;
}

}  // namespace choreo::test
