// SPDX-License-Identifier: Apache-2.0
// A folder with old results in it, which no refusal may touch.
#pragma once

#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "end_to_end/choreoscope_run.hpp"
#include "support/frames.hpp"

namespace choreo::test {

class RefusalTest : public ::testing::Test {
 protected:
  /// Four small frames of a synthetic clip: quick to read, whatever else is wrong.
  static constexpr auto kQuick = "synthetic://jumping-jacks?size=64x48&empty=0&duration=0.2";

  RefusalTest() {
    std::filesystem::create_directory(old());
    for (const auto* name :
         {"z.npy", "zstar.npy", "times.npy", "frames.csv", "plot.png", "triangle.png", "summary.json", "masks.npy"}) {
      write_bytes(old() + "/" + name, std::string("old results: ") + name);
    }
  }

  [[nodiscard]] std::string old() const { return folder_ / "old"; }

  /// Runs `analyze` over old results, and the first time into a new folder; both must be refused alike and leave
  /// nothing.
  /// @return what was complained about.
  std::string refused(const std::string& source, const std::vector<std::string>& more = {}, int status = 2,
                      const RunOptions& options = {}) {
    std::vector<std::string> arguments{"analyze", source, "--out", old()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    last_ = choreoscope(arguments, options);
    const auto complaint = complaint_of(last_, status);
    expect_old_results();
    if (!first_) return complaint;

    first_ = false;
    arguments[3] = folder_ / "new" + "/deep";
    EXPECT_EQ(complaint_of(choreoscope(arguments, options), status),
              std::regex_replace(complaint, std::regex(old()), arguments[3]));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "new")) << "left behind";
    return complaint;
  }

  void expect_old_results() {
    const auto names = files_in(old());
    ASSERT_EQ(names.size(), 8u) << ::testing::PrintToString(names);
    for (const auto& name : names) {
      const auto bytes = read_bytes(old() + "/" + name);
      ASSERT_TRUE(std::string(bytes.begin(), bytes.end()) == "old results: " + name) << name << " was written";
    }
  }

  [[nodiscard]] std::string hint() const { return hint_of(last_); }

  void write_png(const std::string& name, cv::Size size, std::uint64_t seed = 1) {
    ASSERT_TRUE(cv::imwrite(folder_ / name, noise(size, CV_8UC3, seed)));
  }

  TempFolder folder_;
  Outcome last_;
  bool first_ = true;
};

}  // namespace choreo::test
