// SPDX-License-Identifier: Apache-2.0
// The recordings, and the performer who is made up.
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "devices/conformance.hpp"
#include "devices/image_folder/image_folder.hpp"
#include "devices/kinect_dump/kinect_dump.hpp"
#include "devices/kinect_fixture.hpp"
#include "devices/synthetic/synthetic_source.hpp"
#include "devices/video_file/video_file.hpp"
#include "outputs/video_writer.hpp"
#include "support/frames.hpp"
#include "support/takes.hpp"
#include "support/temp_folder.hpp"

namespace choreo::devices {
namespace {

constexpr int kFrames = 25;
const cv::Size kSize(48, 32);

cv::Mat picture(int index) { return test::noise(kSize, CV_8UC3, std::uint64_t(index) + 1); }

ConformanceSubject performer() {
  const std::string script = "synthetic://walking?size=80x60&duration=2";
  return {"performer", synthetic_driver(), script, script + "&fps=0"};
}

ConformanceSubject folder() {
  const auto files = std::make_shared<test::TempFolder>();
  for (int k = 0; k < kFrames; ++k) cv::imwrite(*files / std::to_string(1000 + k) + ".png", picture(k));
  return {"folder", image_folder_driver(), files->path(), files->path() + "?fps=0", {}, {}, files};
}

ConformanceSubject file() {
  const auto files = std::make_shared<test::TempFolder>();
  outputs::VideoWriter writer(*files / "clip.mkv", kSize, {});
  for (int k = 0; k < kFrames; ++k) writer.write(picture(k), std::chrono::milliseconds(40 * k));
  writer.close();
  return {"file", video_file_driver(), *files / "clip.mkv", *files / "clip.mkv?rotate=45", {}, {}, files};
}

ConformanceSubject kinect_dump() {
  const auto files = std::make_shared<test::TempFolder>();
  test::write_kinect_dump(files->path(), kFrames);
  return {"kinect_dump",
          kinect_dump_driver(),
          "kinect-dump:" + files->path(),
          "kinect-dump:" + files->path() + "?depth=deep",
          {},
          {},
          files};
}

ConformanceSubject recorded_take() {
  const auto files = std::make_shared<test::TempFolder>();
  test::write_take(*files / "take.mkv", test::plain_frames(kFrames, kSize, true));
  return {"take", take_driver(), *files / "take.mkv", *files / "take.mkv?frames=processed", {}, {}, files};
}

}  // namespace

std::vector<ConformanceCase> conformance_subjects() {
  return {{"performer", ConformanceKind::kRecording, performer},
          {"folder", ConformanceKind::kRecording, folder},
          {"file", ConformanceKind::kRecording, file},
          {"kinect_dump", ConformanceKind::kRecording, kinect_dump},
          {"take", ConformanceKind::kRecording, recorded_take}};
}

}  // namespace choreo::devices
