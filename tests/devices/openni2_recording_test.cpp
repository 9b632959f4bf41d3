// SPDX-License-Identifier: Apache-2.0
// Recordings of OpenNI2, whole and damaged.
#include <sys/stat.h>

#include <random>
#include <thread>

#include "devices/openni2_fixture.hpp"
#include "support/places.hpp"

namespace choreo::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class OpenNi2RecordingTest : public OpenNi2Test {
 protected:
  // Recorded once: the camera needs its time.
  static void SetUpTestSuite() { kept_ = new TempFolder; }
  static void TearDownTestSuite() { delete std::exchange(kept_, nullptr); }

  [[nodiscard]] std::string take() {
    const auto path = *kept_ / "take.oni";
    if (!std::filesystem::exists(path)) record(path, 30);
    return path;
  }
  static TempFolder* kept_;
};

TempFolder* OpenNi2RecordingTest::kept_ = nullptr;

TEST_F(OpenNi2RecordingTest, EveryPictureComesOnceWithItsOwnDepth) {
  const auto source = open(take());
  EXPECT_EQ(source->info().size, cv::Size(kOniWidth, kOniHeight));
  EXPECT_EQ(source->info().nominal_fps, kOniFps);
  EXPECT_TRUE(source->info().repeatable);
  const auto frames = all_frames(*source);
  ASSERT_GE(frames.size(), 25U);
  const int first = picture_number(frames[0]->bgr);
  ASSERT_GE(first, 0);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const int number = first + static_cast<int>(k);
    EXPECT_EQ(picture_number(frames[k]->bgr), number);
    // It was stopped between a picture and its depth, perhaps.
    const bool cut = k + 1 == frames.size() && frames[k]->depth.empty();
    EXPECT_TRUE(cut || is_depth_of(frames[k]->depth, number)) << number;
    EXPECT_EQ(frames[k]->sequence, k);
    EXPECT_EQ(frames[k]->device_time - frames[0]->device_time, std::chrono::microseconds(k * kOniStepUs));
  }
  EXPECT_THAT(source->warnings(), IsEmpty());
}

TEST_F(OpenNi2RecordingTest, APlainPathIsClaimedByItsEndingOrByItsFirstBytes) {
  EXPECT_TRUE(open("openni2:" + take())->read({}));
  const auto elsewhere = folder_ / "take.bin";
  std::filesystem::copy_file(take(), elsewhere);
  EXPECT_TRUE(open(elsewhere)->read({}));
}

TEST_F(OpenNi2RecordingTest, AVeryLongPathIsReadAllTheSame) {
  auto deep = folder_.path();
  for (int k = 0; k < 4; ++k) deep += "/" + std::string(100, static_cast<char>('a' + k));
  std::filesystem::create_directories(deep);
  std::filesystem::copy_file(take(), deep + "/take.oni");
  EXPECT_TRUE(open(deep + "/take.oni")->read({}));
}

TEST_F(OpenNi2RecordingTest, OpeningAnewGivesTheSameFrames) {
  const auto once = all_frames(*open(take()));
  const auto again = all_frames(*open(take()));
  ASSERT_GE(once.size(), 25U);
  ASSERT_EQ(once.size(), again.size());
  for (std::size_t k = 0; k < once.size(); ++k) {
    EXPECT_EQ(once[k]->device_time, again[k]->device_time);
    EXPECT_TRUE(same_pixels(once[k]->bgr, again[k]->bgr));
    EXPECT_EQ(once[k]->depth.empty(), again[k]->depth.empty());
  }
}

TEST_F(OpenNi2RecordingTest, AReaderThatPausesLosesNothing) {
  const auto source = open(take());
  const auto first = source->read({});
  std::this_thread::sleep_for(std::chrono::milliseconds(600));  // Longer than any wait of the helper's.
  auto last = first->sequence;
  while (const auto frame = source->read({})) {
    EXPECT_EQ(frame->sequence, last + 1);
    last = frame->sequence;
  }
  EXPECT_GE(last, 24U);
}

TEST_F(OpenNi2RecordingTest, WithoutVideoTheDepthIsThePicture) {
  const auto source = open(take() + "?video=off");
  const auto frames = all_frames(*source);
  ASSERT_GE(frames.size(), 24U);
  EXPECT_TRUE(is_depth_of(frames[0]->depth, (frames[0]->depth.at<std::uint16_t>(0, 63) - 600 - 20 * 63) / 10));
  EXPECT_EQ(frames[0]->bgr.size(), frames[0]->depth.size());
  EXPECT_EQ(frames[0]->bgr.type(), CV_8UC3);
}

TEST_F(OpenNi2RecordingTest, WithoutDepthThereIsNone) {
  const auto frames = all_frames(*open(take() + "?depth=off"));
  ASSERT_GE(frames.size(), 25U);
  EXPECT_TRUE(frames[0]->depth.empty());
  EXPECT_GE(picture_number(frames[0]->bgr), 0);
}

TEST_F(OpenNi2RecordingTest, WhatARecordingHasNotIsRefused) {
  const auto infrared = error_of([&] { (void)open(take() + "?video=ir"); });
  ASSERT_TRUE(infrared);
  EXPECT_EQ(infrared->fault(), Fault::kUsage);
  EXPECT_THAT(infrared->what(), HasSubstr("there is no infrared"));
  EXPECT_THAT(infrared->hint(), HasSubstr("colour"));
  const auto size = error_of([&] { (void)open(take() + "?size=64x48"); });
  ASSERT_TRUE(size);
  EXPECT_THAT(size->what(), HasSubstr("unknown setting \"size\""));
  const auto nothing = error_of([&] { (void)open(take() + "?video=off&depth=off"); });
  ASSERT_TRUE(nothing);
  EXPECT_THAT(nothing->what(), HasSubstr("neither video nor depth"));
}

TEST_F(OpenNi2RecordingTest, WhatIsNoRecordingIsRefusedWithWhatItIs) {
  write_bytes(folder_ / "empty.oni", std::string());
  write_bytes(folder_ / "text.oni", std::string("this is a letter\n"));
  write_bytes(folder_ / "stub.oni", std::string("NI10"));
  ASSERT_EQ(::mkfifo((folder_ / "pipe.oni").c_str(), 0600), 0);
  std::filesystem::create_directory(folder_ / "folder.oni");
  for (const auto* name : {"empty.oni", "text.oni"}) {
    const auto error = error_of([&] { (void)open(folder_ / name); });
    ASSERT_TRUE(error) << name;
    EXPECT_EQ(error->fault(), Fault::kUsage);
    EXPECT_THAT(error->what(), HasSubstr("is no recording of OpenNI2")) << name;
  }
  for (const auto* name : {"stub.oni", "pipe.oni", "none.oni", "folder.oni"}) {
    const auto error = error_of([&] { (void)open("openni2:" + (folder_ / name)); });
    ASSERT_TRUE(error) << name;
    EXPECT_EQ(error->fault(), Fault::kUsage) << name;
    EXPECT_THAT(error->what(), HasSubstr(name));
  }
}

/// What became of a file that nobody can trust.
struct Reading {
  std::size_t frames = 0;
  std::string refusal;
  std::vector<std::string> warnings;
};

class OpenNi2DamageTest : public OpenNi2RecordingTest {
 protected:
  OpenNi2DamageTest() { registry_ = {}, registry_.add(devices::openni2_driver(clock_, std::chrono::seconds(1))); }

  Reading read(const Bytes& bytes) {
    const auto path = folder_ / "damaged.oni";
    write_bytes(path, bytes);
    Reading reading;
    try {
      const auto source = open(path);
      Nanoseconds last{-1};
      while (const auto frame = source->read({})) {
        ++reading.frames;
        EXPECT_EQ(frame->bgr.size(), source->info().size);
        EXPECT_EQ(frame->bgr.type(), CV_8UC3);
        EXPECT_TRUE(frame->depth.empty() || frame->depth.size() == frame->bgr.size());
        EXPECT_GT(frame->device_time, last);
        last = frame->device_time;
      }
      EXPECT_GE(reading.frames, 1U) << "else opening it is refused";
      reading.warnings = source->warnings();
    } catch (const Error& error) {
      EXPECT_EQ(error.fault(), Fault::kUsage) << error.what();
      EXPECT_THAT(error.what(), HasSubstr("damaged.oni"));
      reading.refusal = error.what();
    }
    return reading;
  }
};

TEST_F(OpenNi2DamageTest, ATruncatedRecordingGivesWhatIsThereAndSaysSo) {
  const auto whole = read_bytes(take());
  const auto frames = all_frames(*open(take())).size();
  std::size_t refused = 0;
  // A finished recording has its index at its end: OpenNI2 opens none that lacks it.
  for (const double share : {0.0001, 0.002, 0.02, 0.1, 0.3, 0.45, 0.7, 0.999}) {
    const auto reading = read(Bytes(whole.begin(), whole.begin() + static_cast<long>(share * double(whole.size()))));
    EXPECT_LE(reading.frames, frames);
    if (!reading.refusal.empty()) {
      ++refused;
    } else if (reading.frames < frames) {
      EXPECT_THAT(reading.warnings, Contains(HasSubstr("ends after"))) << share;
    }
  }
  EXPECT_GE(refused, 2U);
}

TEST_F(OpenNi2DamageTest, ARecordingWhoseRecorderWasKilledGivesItsFramesWhereverItIsCut) {
  const auto path = folder_ / "killed.oni";
  RunOptions options;
  options.limit = std::chrono::seconds(4);
  ASSERT_TRUE(run_program(built("oni_record"), {path, "100000"}, options).timed_out);
  auto whole = read_bytes(path);
  ASSERT_GT(whole.size(), 100'000U);
  // The library's recorder writes the number of streams into its header at some time of its own choice, and opens no
  // recording that lacks it: that time had come.
  whole[20] = 2;
  write_bytes(path, whole);
  std::size_t before = 0;
  for (const double share : {0.4, 0.7, 1.0}) {
    const auto reading = read(Bytes(whole.begin(), whole.begin() + static_cast<long>(share * double(whole.size()))));
    EXPECT_EQ(reading.refusal, "");
    EXPECT_GT(reading.frames, before);
    EXPECT_THAT(reading.warnings, Contains(HasSubstr("breaks off")));
    before = reading.frames;
  }
  const auto frames = all_frames(*open(path));
  for (std::size_t k = 1; k < frames.size(); ++k) {
    EXPECT_EQ(picture_number(frames[k]->bgr), (picture_number(frames[k - 1]->bgr) + 1) % 256);
  }
}

TEST_F(OpenNi2DamageTest, FlippedBytesNeverEndInACrashOrAHang) {
  const auto whole = read_bytes(take());
  std::size_t read_through = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 chance(seed);
    auto bytes = whole;
    // Where the headers and properties are, the library is weakest.
    const auto reach = seed % 2 == 0 ? std::size_t{4000} : bytes.size();
    for (unsigned flips = 1U << (seed % 6); flips > 0; --flips) {
      bytes[4 + chance() % (reach - 4)] ^= static_cast<std::uint8_t>(1U << (chance() % 8));
    }
    const auto reading = read(bytes);
    if (reading.refusal.empty()) ++read_through;
  }
  EXPECT_GE(read_through, 20U) << "a flipped pixel is no reason to refuse";
  EXPECT_LE(read_through, 195U) << "the damage reaches nothing";
}

}  // namespace
}  // namespace choreo::test
