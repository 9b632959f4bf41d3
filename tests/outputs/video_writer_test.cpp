// SPDX-License-Identifier: Apache-2.0
#include "outputs/video_writer.hpp"

#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/stat.h>

#include "devices/video_file/video_file.hpp"
#include "support/frames.hpp"
#include "support/make_video.hpp"
#include "support/temp_folder.hpp"

namespace choreo::outputs {
namespace {

using test::error_of;
using test::noise;
using test::same_pixels;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using namespace std::chrono_literals;

class VideoWriterTest : public ::testing::Test {
 protected:
  std::vector<devices::FramePtr> read_back(const std::string& name) {
    devices::Registry registry;
    registry.add(devices::video_file_driver());
    const auto source = registry.open(folder_ / name);
    auto frames = test::all_frames(*source);
    EXPECT_THAT(source->warnings(), IsEmpty());
    return frames;
  }

  // A smooth picture that moves, which lossy codecs keep well.
  static cv::Mat smooth(cv::Size size, int shift) {
    cv::Mat picture(size, CV_8UC3);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        picture.at<cv::Vec3b>(y, x) =
            cv::Vec3b(cv::saturate_cast<std::uint8_t>(40 + x + shift), cv::saturate_cast<std::uint8_t>(60 + y), 120);
      }
    }
    return picture;
  }

  void write_smooth(const std::string& name, const VideoOptions& options, cv::Size size = {64, 48}) {
    VideoWriter writer(folder_ / name, size, options);
    for (int i = 0; i < 30; ++i) writer.write(smooth(size, i), 40ms * i);
    writer.close();
  }

  test::TempFolder folder_;
};

TEST_F(VideoWriterTest, LosslessPicturesAndTimesComeBackExactly) {
  const std::vector<int> times_ms = {0, 33, 67, 1000, 1001};
  for (const cv::Size size : {cv::Size(1, 1),
                              {1, 640},
                              {640, 1},
                              {2, 400},
                              {400, 2},
                              {3, 3},
                              {4, 4},
                              {65, 31},
                              {353, 5},
                              {160, 120},
                              {500, 333}}) {
    for (const bool grey : {false, true}) {
      VideoOptions options;
      options.grey = grey;
      VideoWriter writer(folder_ / "a.mkv", size, options);
      std::vector<cv::Mat> pictures;
      for (const int t : times_ms) {
        pictures.push_back(noise(size, grey ? CV_8UC1 : CV_8UC3, static_cast<std::uint64_t>(t) + 1));
        writer.write(pictures.back(), std::chrono::milliseconds(t));
      }
      writer.close();
      const auto frames = read_back("a.mkv");
      ASSERT_EQ(frames.size(), 5u) << size;
      for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_EQ(frames[i]->device_time, std::chrono::milliseconds(times_ms[i]));
        cv::Mat expected = pictures[i];
        if (grey) cv::merge(std::vector<cv::Mat>(3, pictures[i]), expected);
        EXPECT_TRUE(same_pixels(frames[i]->bgr, expected)) << size << " " << grey;
      }
    }
  }
}

TEST_F(VideoWriterTest, AGreyPictureInAColourVideoIsSpread) {
  VideoWriter writer(folder_ / "a.mkv", {5, 4});
  const auto grey = noise({5, 4}, CV_8UC1, 2);
  writer.write(grey, 0ms);
  writer.close();
  cv::Mat expected;
  cv::merge(std::vector<cv::Mat>(3, grey), expected);
  EXPECT_TRUE(same_pixels(read_back("a.mkv")[0]->bgr, expected));
}

TEST_F(VideoWriterTest, LossyVideosLookAlikeKeepTheirTimesAndLoseNoFrame) {
  for (const auto codec : {VideoCodec::kH264, VideoCodec::kMpeg4}) {
    ASSERT_TRUE(can_encode(codec)) << "this FFmpeg lacks an encoder";
    for (const auto rate : {FrameRate{25, 1}, FrameRate{}}) {
      VideoOptions options;
      options.codec = codec;
      options.rate = rate;
      write_smooth("a.mp4", options);
      const auto frames = read_back("a.mp4");
      ASSERT_EQ(frames.size(), 30u) << "the last one too";
      for (int i = 0; i < 30; ++i) {
        const auto& frame = *frames[static_cast<std::size_t>(i)];
        EXPECT_EQ(frame.device_time, 40ms * i);
        EXPECT_LT(cv::norm(frame.bgr, smooth({64, 48}, i), cv::NORM_L1) / (64 * 48 * 3), 3.0) << "mean difference";
      }
    }
  }
}

TEST_F(VideoWriterTest, LossyVideosOfOddSizesAreFilledUp) {
  VideoOptions options;
  options.codec = VideoCodec::kMpeg4;
  write_smooth("a.mp4", options, {31, 17});
  EXPECT_EQ(read_back("a.mp4")[0]->bgr.size(), cv::Size(32, 18));
}

TEST_F(VideoWriterTest, TheSamePicturesGiveTheSameBytes) {
  for (const auto codec : {VideoCodec::kLossless, VideoCodec::kH264, VideoCodec::kMpeg4}) {
    ASSERT_TRUE(can_encode(codec)) << "this FFmpeg lacks an encoder";
    VideoOptions options;
    options.codec = codec;
    options.rate = {30000, 1001};
    const auto ending = codec == VideoCodec::kLossless ? std::string(".mkv") : std::string(".mp4");
    write_smooth("a" + ending, options, {96, 80});
    write_smooth("b" + ending, options, {96, 80});
    const auto a = test::read_bytes(folder_ / ("a" + ending));
    EXPECT_FALSE(a.empty());
    EXPECT_EQ(a, test::read_bytes(folder_ / ("b" + ending)));
  }
}

TEST_F(VideoWriterTest, TheNameAppearsOnlyWhenTheVideoIsComplete) {
  test::write_bytes(folder_ / "a.mkv", std::string("older"));
  {
    VideoWriter writer(folder_ / "a.mkv", {4, 4});
    writer.write(noise({4, 4}, CV_8UC3, 1), 0ms);
    EXPECT_EQ(test::read_bytes(folder_ / "a.mkv").size(), 5u);
  }
  EXPECT_EQ(test::read_bytes(folder_ / "a.mkv").size(), 5u) << "given up, the older file stays";
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.mkv.part"));
  VideoWriter(folder_ / "a.mkv", {4, 4}).close();
  EXPECT_GT(test::read_bytes(folder_ / "a.mkv").size(), 5u);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.mkv.part"));
}

TEST_F(VideoWriterTest, AFullDiskIsAFailureAndLeavesNothing) {
  // A limit on file sizes stands in for the disk: both end in a write that fails.
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  for (const rlim_t bytes : {rlim_t{100}, rlim_t{40000}}) {
    const rlimit limit{bytes, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
    const auto error = error_of([&] {
      VideoWriter writer(folder_ / "a.mkv", {64, 64});
      for (int i = 0; i < 20; ++i) writer.write(noise({64, 64}, CV_8UC3, 1), 40ms * i);
      writer.close();
    });
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    ASSERT_TRUE(error) << bytes;
    EXPECT_EQ(error->fault(), Fault::kFailure);
    EXPECT_THAT(error->what(), HasSubstr("a.mkv\" cannot be written: File too large"));
    EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
  }
  std::signal(SIGXFSZ, handler);
}

TEST_F(VideoWriterTest, TheLastBytesAreCheckedToo) {
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  VideoWriter writer(folder_ / "a.mkv", {4, 4});
  writer.write(noise({4, 4}, CV_8UC3, 1), 0ms);
  const rlimit limit{10, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  const auto error = error_of([&] { writer.close(); });
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kFailure);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(VideoWriterTest, PlacesThatCannotBeWrittenAreTheUsersMistake) {
  ASSERT_EQ(::mkdir((folder_ / "folder.mkv").c_str(), 0700), 0);
  VideoOptions lossy;
  lossy.codec = VideoCodec::kMpeg4;
  struct Case {
    const char* name;
    VideoOptions options;
    cv::Size size;
  };
  for (const auto& c : {Case{"none/a.mkv", {}, {4, 4}}, Case{"folder.mkv", {}, {4, 4}}, Case{"a.avi", {}, {4, 4}},
                        Case{"a", {}, {4, 4}}, Case{"a.mp4", {}, {4, 4}}, Case{"a.mkv", {}, {0, 4}},
                        Case{"a.mkv", {}, {4, 20000}}, Case{"a.mov", lossy, {4, 4}}}) {
    const auto error = error_of([&] { VideoWriter(folder_ / c.name, c.size, c.options); });
    ASSERT_TRUE(error) << c.name;
    EXPECT_EQ(error->fault(), Fault::kUsage) << error->what();
  }
}

TEST_F(VideoWriterTest, TheEndingChoosesTheCodecUnlessTheNameIsTemporary) {
  EXPECT_EQ(video_codec_for("a.MKV"), VideoCodec::kLossless);
  EXPECT_EQ(video_codec_for("a.mp4"), can_encode(VideoCodec::kH264) ? VideoCodec::kH264 : VideoCodec::kMpeg4);
  EXPECT_TRUE(error_of([] { (void)video_codec_for("a.webm"); }));
  VideoOptions options;
  options.container = VideoContainer::kMatroska;
  VideoWriter writer(folder_ / ".a.mkv.123.tmp", {4, 4}, options);
  writer.write(noise({4, 4}, CV_8UC3, 1), 0ms);
  writer.close();
  EXPECT_EQ(read_back(".a.mkv.123.tmp").size(), 1u);
}

TEST_F(VideoWriterTest, PicturesAndTimesThatDoNotFitAreRefused) {
  VideoOptions grey;
  grey.grey = true;
  VideoWriter writer(folder_ / "a.mkv", {4, 4}, grey);
  EXPECT_TRUE(error_of([&] { writer.write(noise({4, 5}, CV_8UC1, 1), 0ms); }));
  EXPECT_TRUE(error_of([&] { writer.write(noise({4, 4}, CV_8UC3, 1), 0ms); })) << "colour into grey";
  EXPECT_TRUE(error_of([&] { writer.write(noise({4, 4}, CV_16UC1, 1), 0ms); }));
  EXPECT_TRUE(error_of([&] { writer.write(noise({4, 4}, CV_8UC1, 1), -1ms); }));
  writer.write(noise({4, 4}, CV_8UC1, 1), 40ms);
  EXPECT_TRUE(error_of([&] { writer.write(noise({4, 4}, CV_8UC1, 1), 40ms); }));
  writer.write(noise({4, 4}, CV_8UC1, 1), 40ms + std::chrono::nanoseconds(1));
  writer.close();
  const auto frames = read_back("a.mkv");
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1]->device_time, 41ms) << "at least one unit of the file later";
  EXPECT_TRUE(error_of([&] { writer.write(noise({4, 4}, CV_8UC1, 1), 80ms); })) << "closed";
}

}  // namespace
}  // namespace choreo::outputs
