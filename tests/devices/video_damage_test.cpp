// SPDX-License-Identifier: Apache-2.0
// What is delivered of damaged recordings: the good frames, a word about the rest, never a crash or a hang.
#include <chrono>

#include <gmock/gmock.h>

#include "devices/media/ffv1_check.hpp"
#include "devices/video_fixture.hpp"

namespace choreo::devices {
namespace {

using test::all_frames;
using test::same_pixels;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

class VideoDamageTest : public VideoFileTest {
 protected:
  // Opens and reads everything; the frames, or nothing where the file is refused as it should be.
  std::vector<FramePtr> survive(const std::string& name, std::vector<std::string>* warnings = nullptr,
                                int threads = 0) {
    const auto begin = std::chrono::steady_clock::now();
    std::vector<FramePtr> frames;
    try {
      const auto source = open(name, threads);
      try {
        while (auto frame = source->read({})) {
          EXPECT_EQ(frame->bgr.size(), source->info().size);
          EXPECT_TRUE(frames.empty() || frame->device_time > frames.back()->device_time);
          EXPECT_TRUE(frames.empty() || frame->sequence > frames.back()->sequence);
          EXPECT_GE(frame->sequence, frames.size()) << "a frame left out leaves a gap";
          frames.push_back(std::move(frame));
        }
      } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::kFailure) << error.what();
      }
      if (warnings != nullptr) *warnings = source->warnings();
    } catch (const Error& error) {
      EXPECT_EQ(error.fault(), Fault::kUsage) << error.what();
      EXPECT_TRUE(frames.empty());
    }
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20)) << name;
    return frames;
  }

  // The same moving picture in a lossy codec, 60 frames at 25 a second.
  void write_lossy(const std::string& name, outputs::VideoCodec codec) {
    outputs::VideoOptions options;
    options.codec = codec;
    options.rate = {25, 1};
    outputs::VideoWriter writer(folder_ / name, {96, 64}, options);
    for (int i = 0; i < 60; ++i) {
      cv::Mat picture = test::noise({12, 8}, CV_8UC3, 3);
      cv::Mat large;
      cv::repeat(picture, 8, 8, large);
      large.rowRange(i % 32, i % 32 + 16).setTo(cv::Scalar(i, 200, 255 - i));
      writer.write(large, std::chrono::milliseconds(40 * i));
    }
    writer.close();
  }
};

TEST_F(VideoDamageTest, ATruncatedRecordingGivesItsGoodFramesAndOneWarning) {
  const auto pictures = write_noise("whole.mkv", 40);
  const auto whole = test::read_bytes(folder_ / "whole.mkv");
  ASSERT_THAT(open("whole.mkv")->warnings(), IsEmpty());
  std::size_t before = 0;
  for (std::size_t eighth = 1; eighth < 8; ++eighth) {
    test::write_bytes(
        folder_ / "part.mkv",
        test::Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.size() * eighth / 8)));
    std::vector<std::string> warnings;
    const auto frames = survive("part.mkv", &warnings);
    EXPECT_GT(frames.size(), before) << "more bytes, more frames";
    EXPECT_NEAR(static_cast<double>(frames.size()), 40.0 * static_cast<double>(eighth) / 8, 2.0);
    before = frames.size();
    for (std::size_t i = 0; i < frames.size(); ++i) {
      EXPECT_TRUE(same_pixels(frames[i]->bgr, pictures[i])) << "eighth " << eighth << " frame " << i;
      EXPECT_EQ(frames[i]->device_time, std::chrono::milliseconds(40 * i));
    }
    EXPECT_THAT(warnings, ElementsAre(HasSubstr("of the 1.6 s it declares: truncated?"))) << "eighth " << eighth;
  }
}

TEST_F(VideoDamageTest, EveryTruncationOfEveryContainerIsSurvived) {
  write_noise("a.mkv", 12);
  write_lossy("b.mp4", outputs::VideoCodec::kH264);
  write_lossy("c.mp4", outputs::VideoCodec::kMpeg4);
  test::VideoRecipe recipe;
  recipe.pixel_format = AV_PIX_FMT_YUV420P;
  recipe.encoder = "mpeg2video";
  recipe.time_base = {1, 25};
  recipe.times.clear();
  for (int i = 0; i < 30; ++i) recipe.times.push_back(i);
  make_video(folder_ / "d.ts", recipe);
  recipe.encoder = "mpeg4";
  make_video(folder_ / "e.avi", recipe);
  for (const auto* name : {"a.mkv", "b.mp4", "c.mp4", "d.ts", "e.avi"}) {
    const auto whole = test::read_bytes(folder_ / name);
    const auto complete = survive(name).size();
    EXPECT_GE(complete, 12u) << name;
    for (std::size_t part = 0; part < 16; ++part) {
      const auto cut = "cut-" + std::string(name);
      test::write_bytes(
          folder_ / cut,
          test::Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.size() * part / 16)));
      std::vector<std::string> warnings;
      EXPECT_LE(survive(cut, &warnings).size(), complete) << name;
      EXPECT_LE(warnings.size(), 2u) << name;
    }
  }
}

TEST_F(VideoDamageTest, AnMp4WithoutItsIndexSaysWhatIsMissing) {
  write_lossy("a.mp4", outputs::VideoCodec::kMpeg4);
  auto bytes = test::read_bytes(folder_ / "a.mp4");
  bytes.resize(bytes.size() / 2);
  test::write_bytes(folder_ / "a.mp4", bytes);
  const auto error = refusal("a.mp4");
  EXPECT_THAT(error.what(), HasSubstr("moov atom not found"));
  EXPECT_THAT(error.hint(), HasSubstr("cut off"));
}

TEST_F(VideoDamageTest, AFlippedBitInALosslessFrameLosesThatFrameAndNoOther) {
  const auto pictures = write_noise("a.mkv", 20);
  auto bytes = test::read_bytes(folder_ / "a.mkv");
  // Noise does not compress: the twenty frames fill nearly the whole file evenly, this is inside of one of them.
  bytes[bytes.size() * 21 / 40] ^= 0x10;
  test::write_bytes(folder_ / "a.mkv", bytes);
  const auto source = open("a.mkv");
  const auto frames = all_frames(*source);
  ASSERT_THAT(frames, SizeIs(19));
  for (const auto& frame : frames) {
    const auto index = static_cast<std::size_t>(frame->device_time / std::chrono::milliseconds(40));
    EXPECT_TRUE(same_pixels(frame->bgr, pictures[index])) << index;
  }
  EXPECT_THAT(source->warnings(), ElementsAre(HasSubstr("1 damaged frame was left out")));
}

TEST_F(VideoDamageTest, TwoHundredDamagedFilesAreSurvived) {
  write_noise("a.mkv", 12);
  write_lossy("b.mp4", outputs::VideoCodec::kH264);
  write_lossy("c.mp4", outputs::VideoCodec::kMpeg4);
  std::size_t survived = 0;
  int variant = 0;
  for (const auto* name : {"a.mkv", "b.mp4", "c.mp4"}) {
    const auto whole = test::read_bytes(folder_ / name);
    for (int i = 0; i < 67; ++i, ++variant) {
      cv::RNG random(static_cast<std::uint64_t>(variant) + 1);
      auto damaged = whole;
      // Headers lie at both ends; a few bytes there, or many anywhere.
      const int flips = 1 + variant % 20;
      for (int flip = 0; flip < flips; ++flip) {
        const auto size = static_cast<int>(damaged.size());
        const int at = variant % 3 == 0   ? random.uniform(0, std::min(size, 1000))
                       : variant % 3 == 1 ? random.uniform(std::max(0, size - 1500), size)
                                          : random.uniform(0, size);
        damaged[static_cast<std::size_t>(at)] = static_cast<std::uint8_t>(random.uniform(0, 256));
      }
      test::write_bytes(folder_ / "damaged", damaged);
      survived += survive("damaged").empty() ? 0 : 1;
    }
  }
  EXPECT_GT(survived, 20u) << "else the damage is too heavy to test anything";
}

TEST_F(VideoDamageTest, WhatDamagedFilesGiveDoesNotDependOnTheNumberOfThreads) {
  write_lossy("b.mp4", outputs::VideoCodec::kH264);
  write_lossy("c.mp4", outputs::VideoCodec::kMpeg4);
  std::size_t compared = 0;
  for (const auto* name : {"b.mp4", "c.mp4"}) {
    const auto whole = test::read_bytes(folder_ / name);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      cv::RNG random(seed);
      auto damaged = whole;
      for (int flip = 0; flip < 4; ++flip) {
        damaged[static_cast<std::size_t>(random.uniform(48, static_cast<int>(damaged.size() * 3 / 4)))] ^= 0x41;
      }
      test::write_bytes(folder_ / "damaged.mp4", damaged);
      std::vector<std::string> warnings_one;
      std::vector<std::string> warnings_many;
      const auto one = survive("damaged.mp4", &warnings_one, 1);
      const auto many = survive("damaged.mp4", &warnings_many, 4);
      ASSERT_EQ(one.size(), many.size()) << name << " seed " << seed;
      for (std::size_t i = 0; i < one.size(); ++i) {
        EXPECT_EQ(one[i]->device_time, many[i]->device_time);
        EXPECT_TRUE(same_pixels(one[i]->bgr, many[i]->bgr)) << name << " seed " << seed << " frame " << i;
      }
      compared += one.size();
      EXPECT_EQ(warnings_one, warnings_many) << name << " seed " << seed;
    }
  }
  EXPECT_GT(compared, 100u) << "else the damage is too heavy to test anything";
}

TEST(Ffv1Check, SaysNothingBeforeItHasSeenAGoodPacket) {
  Ffv1Check check;
  const test::Bytes packet(40, 9);
  EXPECT_FALSE(check.is_damaged(packet));
  EXPECT_FALSE(check.is_damaged({}));
}

TEST(Ffv1Check, FindsEverySingleFlippedBitOfASlice) {
  // A slice by hand: three bytes, their size, no error, and the parity that makes the CRC of it all zero.
  // CRC-32 with polynomial 0x04C11DB7, from 0, no reflection, computed bit by bit.
  test::Bytes slice = {0x12, 0x34, 0x56, 0, 0, 3, 0};
  std::uint32_t crc = 0;
  for (const auto byte : slice) {
    crc ^= std::uint32_t{byte} << 24;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x80000000u) != 0 ? crc << 1 ^ 0x04C11DB7u : crc << 1;
  }
  for (int shift = 24; shift >= 0; shift -= 8) slice.push_back(static_cast<std::uint8_t>(crc >> shift));
  auto two = slice;
  two.insert(two.end(), slice.begin(), slice.end());
  Ffv1Check check;
  ASSERT_FALSE(check.is_damaged(two));
  for (std::size_t bit = 0; bit < 8 * two.size(); ++bit) {
    auto flipped = two;
    flipped[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
    EXPECT_TRUE(check.is_damaged(flipped)) << bit;
  }
  EXPECT_FALSE(check.is_damaged(two));
}

}  // namespace
}  // namespace choreo::devices
