// SPDX-License-Identifier: Apache-2.0
// The performer before a camera of OpenNI2, live and recorded: depth and colour are a picture's own, and so is the
// mask.
#include <fstream>

#include <opencv2/imgproc.hpp>

#include "devices/openni2_fixture.hpp"
#include "support/rehearsal.hpp"

namespace choreo::test {
namespace {

class OpenNi2MaskTest : public OpenNi2Test {
 protected:
  OpenNi2MaskTest() {
    const auto file = folder_ / "scene";
    std::ofstream out(file, std::ios::binary);
    for (const int number : {size_.width, size_.height, int(rehearsal_.truth.size())}) {
      out.write(reinterpret_cast<const char*>(&number), sizeof number);
    }
    for (const auto& performance : rehearsal_.truth) {
      cv::Mat rgb;
      cv::cvtColor(performance.bgr, rgb, cv::COLOR_BGR2RGB);
      for (const cv::Mat& picture : {rgb, performance.depth}) {
        out.write(reinterpret_cast<const char*>(picture.data),
                  static_cast<std::streamsize>(picture.total() * picture.elemSize()));
      }
    }
    ::setenv("CHOREO_TEST_ONI_SCENE", file.c_str(), 1);
  }
  ~OpenNi2MaskTest() override { ::unsetenv("CHOREO_TEST_ONI_SCENE"); }

  // Reads until every picture came, and masks them by their depth.
  double masked(const std::string& name, const std::string& from) {
    const auto source = open(from);
    std::vector<Nanoseconds> ages;
    std::vector<cv::Mat> pictures(rehearsal_.truth.size()), depths(pictures.size());
    for (std::size_t k = 0, came = 0; k < 200 && came < pictures.size(); ++k) {
      const auto frame = source->read({});
      if (!frame || frame->depth.empty()) continue;
      ages.push_back(clock_.now() - frame->device_time);
      const auto is_it = [&](const auto& performance) { return same_pixels(performance.bgr, frame->bgr); };
      const auto which = std::ranges::find_if(rehearsal_.truth, is_it) - rehearsal_.truth.begin();
      if (which == std::ssize(rehearsal_.truth)) {
        ADD_FAILURE() << "a picture that was not before the camera";
        return 0;
      }
      const auto at = std::size_t(which);
      EXPECT_TRUE(same_pixels(rehearsal_.truth[at].depth, frame->depth));
      if (pictures[at].empty()) ++came;
      pictures[at] = frame->bgr;
      depths[at] = frame->depth;
    }
    for (const auto& picture : pictures) {
      if (picture.empty()) {
        ADD_FAILURE() << "a picture never came";
        return 0;
      }
    }
    if (source->info().live) {
      std::sort(ages.begin(), ages.end());
      std::printf("OpenNI2 320x240 at 30: age of a moment when the pipeline gets it: median %.1f ms, at most %.1f ms\n",
                  1e3 * to_seconds(ages[ages.size() / 2]), 1e3 * to_seconds(ages.back()));
    }
    return mean_iou(name, rehearsal_, pictures, depths);
  }

  const cv::Size size_{320, 240};
  const Rehearsal rehearsal_{size_, true};
};

TEST_F(OpenNi2MaskTest, OfTheCamera) { EXPECT_GT(masked("openni2", "openni2://"), 0.95); }

TEST_F(OpenNi2MaskTest, OfItsRecording) {
  const auto take = folder_ / "take.oni";
  record(take, int(rehearsal_.truth.size()) + 10);
  EXPECT_GT(masked("oni", take), 0.95);
}

}  // namespace
}  // namespace choreo::test
