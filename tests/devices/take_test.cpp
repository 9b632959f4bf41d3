// SPDX-License-Identifier: Apache-2.0
// Takes read back: every byte, number and time as it was; damage left out and told of; enemies refused.
#include <array>
#include <filesystem>
#include <fstream>
#include <limits>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "devices/fourcc.hpp"
#include "devices/media/kinect_depth.hpp"
#include "devices/oriented_source.hpp"
#include "support/takes.hpp"
#include "support/temp_folder.hpp"

namespace choreo::test {
namespace {

using devices::FramePtr;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class Take : public ::testing::Test {
 protected:
  [[nodiscard]] std::string path() const { return folder_ / "take.mkv"; }

  void put(const Bytes& bytes) const {
    std::ofstream file(path(), std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  }

  void expect_comes_back(const std::vector<FramePtr>& frames, const outputs::TakeOptions& options,
                         const std::string& what) const {
    auto replacing = options;
    replacing.force = true;
    EXPECT_EQ(write_take(path(), frames, replacing).frames, frames.size()) << what;
    const auto take = open_take(path(), true);
    const auto back = all_frames(*take);
    ASSERT_EQ(back.size(), frames.size()) << what;
    for (std::size_t i = 0; i < frames.size(); ++i) EXPECT_TRUE(same_frame(*frames[i], *back[i])) << what << ", " << i;
    EXPECT_THAT(take->warnings(), IsEmpty()) << what;
  }

  TempFolder folder_;
};

outputs::TakeOptions with_codec(outputs::TakeCodec codec) {
  auto options = whole_take();
  options.codec = codec;
  return options;
}

constexpr std::array kCodecs = {outputs::TakeCodec::kFfv1, outputs::TakeCodec::kFfvhuff};
const std::array kSizes = {cv::Size(2, 2), cv::Size(6, 4), cv::Size(16, 2), cv::Size(64, 48), cv::Size(354, 290)};

TEST_F(Take, EveryFormatComesBackByteForByte) {
  using namespace devices;
  for (const auto fourcc : {kBgr3, kRgb3, kYuyv, kUyvy, kYvyu, kNv12, kGrey}) {
    for (const auto size : kSizes) {
      for (const auto codec : kCodecs) {
        std::vector<FramePtr> frames;
        for (std::uint64_t i = 0; i < 3; ++i) {
          frames.push_back(raw_frame(i, i * Nanoseconds(33'333'333), noise_picture(fourcc, size, i + 1)));
        }
        expect_comes_back(
            frames, with_codec(codec),
            name_of_fourcc(fourcc) + " " + std::to_string(size.width) + "x" + std::to_string(size.height));
      }
    }
  }
}

TEST_F(Take, JpegPacketsAreKeptAsTheyAre) {
  std::vector<FramePtr> frames;
  for (std::uint64_t i = 0; i < 3; ++i) {
    auto raw = std::make_shared<devices::RawPicture>();
    raw->fourcc = devices::kMjpg;
    raw->size = {64, 48};
    ASSERT_TRUE(cv::imencode(".jpg", noise(raw->size, CV_8UC3, i), raw->bytes));
    raw->bytes.insert(raw->bytes.end(), i, 0);  // Cameras pad their packets.
    frames.push_back(raw_frame(i, i * Nanoseconds(33'333'333), raw));
  }
  expect_comes_back(frames, whole_take(), "MJPG");
}

TEST_F(Take, PicturesWithoutRawBytesAndDepthOfSixteenBitsComeBack) {
  for (const auto size : {cv::Size(1, 1), cv::Size(3, 5), cv::Size(64, 48), cv::Size(355, 289)}) {
    for (const auto codec : kCodecs) {
      expect_comes_back(plain_frames(3, size, true), with_codec(codec), std::to_string(size.width));
    }
  }
}

TEST_F(Take, AViewOfALargerPictureComesBack) {
  const auto large = noise({80, 60}, CV_8UC3, 5);
  auto frame = plain_frame(0, Nanoseconds(0), {33, 21});
  frame->bgr = large(cv::Rect(7, 9, 33, 21));
  expect_comes_back({frame}, whole_take(), "a view");
}

TEST_F(Take, RawDepthComesBackAsBytesAndAsMillimetres) {
  auto frame = plain_frame(4, Nanoseconds(9), {64, 48}, true);
  auto raw = std::make_shared<devices::RawPicture>();
  raw->fourcc = devices::kZ16;
  raw->size = frame->depth.size();
  raw->bytes.assign(frame->depth.data, frame->depth.data + frame->depth.total() * 2);
  frame->raw_depth = raw;
  expect_comes_back({frame}, whole_take(), "Z16");
  EXPECT_EQ(all_frames(*open_take(path())).front()->raw_depth, nullptr) << "nobody asked for it";
}

TEST_F(Take, TheKinectsOwnDepthComesBackAsBytesAndOntoTheColour) {
  for (const bool registered : {false, true}) {
    auto frame = plain_frame(4, Nanoseconds(9), devices::kKinectSize);
    auto raw = std::make_shared<devices::RawPicture>();
    raw->fourcc = devices::kKinectDepth;
    raw->size = devices::kKinectSize;
    for (int i = 0; i < raw->size.area(); ++i) {
      const auto word = std::uint16_t(400 + (i * 7 + i / 640) % 700);
      raw->bytes.push_back(std::uint8_t(word & 0xffU));
      raw->bytes.push_back(std::uint8_t(word >> 8U));
    }
    frame->depth = devices::kinect_depth(raw->bytes);
    if (registered) frame->depth = devices::kinect_registered(frame->depth);
    frame->raw_depth = raw;
    auto info = info_of(*frame);
    info.registers_depth = registered;
    auto options = whole_take();
    options.force = true;
    write_take(path(), {frame}, options, info);
    const auto take = open_take(path(), true);
    EXPECT_EQ(take->info().registers_depth, registered) << "a take of the take is the same";
    EXPECT_TRUE(same_frame(*frame, *take->read({})));
  }
}

TEST_F(Take, TimesAreExactToTheNanosecondAndGapsStay) {
  constexpr auto kLate = 400LL * 24 * 3600 * 1'000'000'000;
  std::vector<FramePtr> frames;
  std::uint64_t sequence = 5;
  for (const long long ns : {-7LL, 0LL, 1LL, 2LL, 999'999LL, 1'000'001LL, 33'333'334LL, kLate, kLate + 1}) {
    frames.push_back(plain_frame(sequence, Nanoseconds(ns), {16, 16}));
    sequence = sequence * 3 + 1;
  }
  frames.push_back(plain_frame(std::numeric_limits<std::uint64_t>::max() / 4, Nanoseconds(kLate + 2), {16, 16}));
  expect_comes_back(frames, whole_take(), "times");
}

TEST_F(Take, AFrameMayLackItsDepth) {
  auto frames = plain_frames(4, {32, 24}, true);
  frames[2] = plain_frame(2, frames[2]->device_time, {32, 24}, false);
  expect_comes_back(frames, whole_take(), "no depth");
}

TEST_F(Take, EitherStreamMayBeLeftOut) {
  const auto frames = plain_frames(3, {32, 24}, true);
  auto options = whole_take();
  options.depth = false;
  write_take(folder_ / "colour.mkv", frames, options);
  const auto colour = all_frames(*open_take(folder_ / "colour.mkv"));
  ASSERT_THAT(colour, SizeIs(3));
  EXPECT_TRUE(same_pixels(colour[1]->bgr, frames[1]->bgr));
  EXPECT_TRUE(colour[1]->depth.empty());

  options.depth = true;
  options.colour = false;
  write_take(folder_ / "depth.mkv", frames, options);
  const auto depth = all_frames(*open_take(folder_ / "depth.mkv"));
  ASSERT_THAT(depth, SizeIs(3));
  EXPECT_TRUE(same_pixels(depth[1]->depth, frames[1]->depth));
  EXPECT_EQ(cv::countNonZero(depth[1]->bgr.reshape(1)), 0) << "nothing was seen";
  EXPECT_EQ(depth[1]->bgr.size(), cv::Size(32, 24));
}

TEST_F(Take, WhatIsKnownOfTheSourceIsKept) {
  auto info = info_of(*plain_frame(0, {}, {32, 24}));
  info.nominal_fps = 30000.0 / 1001;
  info.repeatable = false;
  info.controls = "exposure=120&gain=3";
  auto options = whole_take();
  options.marks = true;
  write_take(path(), plain_frames(30, {32, 24}), options, info);
  const auto take = open_take(path());
  EXPECT_EQ(take->info().name, path());
  EXPECT_EQ(take->info().nominal_fps, 30000.0 / 1001);
  EXPECT_EQ(take->info().controls, info.controls);
  EXPECT_EQ(take->info().size, info.size);
  EXPECT_TRUE(take->info().repeatable);
  EXPECT_TRUE(take->info().foreseeable);
  ASSERT_TRUE(take->info().duration);
  EXPECT_NEAR(to_seconds(*take->info().duration), 1.0, 0.002);
  EXPECT_FALSE(open_take(path() + "?frames=processed")->info().foreseeable) << "it stands for the device";
}

std::vector<devices::Orientation> all_orientations() {
  std::vector<devices::Orientation> all;
  for (int turns = 0; turns < 4; ++turns) {
    for (const bool horizontal : {false, true}) {
      for (const bool vertical : {false, true}) all.push_back({turns, horizontal, vertical});
    }
  }
  return all;
}

TEST_F(Take, OneOrientationAfterAnotherIsOneOrientation) {
  const auto picture = noise({5, 3}, CV_8UC3, 1);
  for (const auto& a : all_orientations()) {
    for (const auto& b : all_orientations()) {
      EXPECT_TRUE(same_pixels(oriented(oriented(picture, a), b), oriented(picture, a.then(b))));
    }
  }
}

TEST_F(Take, ATurnedCameraIsStoredAsItCameAndGivenTurned) {
  for (const auto& orientation : all_orientations()) {
    auto frame = raw_frame(0, Nanoseconds(0), noise_picture(devices::kYuyv, {32, 24}, 1));
    frame->bgr = oriented(frame->bgr, orientation);
    auto info = info_of(*frame);
    info.raw_orientation = devices::Orientation{}.then(orientation);
    auto options = whole_take();
    options.force = true;
    write_take(path(), {frame}, options, info);
    const auto take = open_take(path(), true);
    EXPECT_EQ(take->info().size, frame->bgr.size());
    EXPECT_TRUE(same_frame(*frame, *take->read({})));
    // A take of the take, turned once more, is still the camera's bytes.
    const auto turned = open_take(path() + "?rotate=90", true);
    const auto copy = folder_ / "copy.mkv";
    write_take(copy, all_frames(*turned), options, turned->info());
    const auto back = open_take(copy, true)->read({});
    EXPECT_TRUE(same_raw(back->raw_colour, frame->raw_colour));
    EXPECT_TRUE(same_pixels(back->bgr, devices::oriented(frame->bgr, {1, false, false})));
  }
}

TEST_F(Take, ProcessedFramesAreMarkedAndTheOthersOvertaken) {
  const auto frames = plain_frames(8, {16, 16});
  auto options = whole_take();
  options.marks = true;
  outputs::TakeWriter writer(path(), info_of(*frames[0]), options);
  for (const auto& frame : frames) writer.add(frame);
  for (const std::uint64_t sequence : {0, 3, 4, 6}) writer.processed(sequence);
  writer.close();

  const auto overtaken = [&](const std::string& source) {
    std::vector<bool> all;
    for (const auto& frame : all_frames(*open_take(source))) all.push_back(frame->overtaken);
    return all;
  };
  EXPECT_THAT(overtaken(path() + "?frames=processed"), ElementsAre(false, true, true, false, false, true, false, true));
  EXPECT_THAT(overtaken(path()), ElementsAre(false, false, false, false, false, false, false, false));
  EXPECT_THAT(overtaken(path() + "?frames=all"), SizeIs(8));
}

TEST_F(Take, FramesWithALateDetectionAreMarkedAmongTheProcessed) {
  const auto frames = plain_frames(6, {16, 16});
  auto options = whole_take();
  options.marks = true;
  outputs::TakeWriter writer(path(), info_of(*frames[0]), options);
  for (const auto& frame : frames) {
    writer.add(frame);
    if (frame->sequence == 2 || frame->sequence == 5) writer.late_face(frame->sequence);
    if (frame->sequence == 2 || frame->sequence == 4) writer.late_person(frame->sequence);
    if (frame->sequence != 3) writer.processed(frame->sequence);
  }
  writer.close();
  const auto late = [&](const std::string& source, bool devices::Frame::*what) {
    std::vector<bool> all;
    for (const auto& frame : all_frames(*open_take(source))) all.push_back((*frame).*what);
    return all;
  };
  const auto replayed = path() + "?frames=processed";
  EXPECT_THAT(late(replayed, &devices::Frame::late_face), ElementsAre(false, false, true, false, false, true));
  EXPECT_THAT(late(replayed, &devices::Frame::late_person), ElementsAre(false, false, true, false, true, false));
  for (const auto what : {&devices::Frame::late_face, &devices::Frame::late_person}) {
    EXPECT_THAT(late(path(), what), ElementsAre(false, false, false, false, false, false)) << "no replay of the run";
  }
}

TEST_F(Take, WithoutARunNothingIsMarkedAndAskingForItIsRefused) {
  write_take(path(), plain_frames(2, {16, 16}));
  const auto error = error_of([&] { open_take(path() + "?frames=processed"); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_THAT(error->what(), HasSubstr("without a run"));
  EXPECT_TRUE(error_of([&] { open_take(path() + "?frames=some"); }));
  EXPECT_TRUE(error_of([&] { open_take(path() + "?fps=3"); }));
}

TEST_F(Take, AStopEndsReadingAndLaterReadingGoesOn) {
  write_take(path(), plain_frames(3, {16, 16}));
  const auto take = open_take(path());
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(take->read(stop.get_token()), nullptr);
  EXPECT_THAT(all_frames(*take), SizeIs(3));
}

// The frames that are read are frames that were written, in order, to the last byte.
// @return how many.
std::size_t expect_only_good_frames(devices::Source& take, const std::vector<FramePtr>& frames,
                                    const std::string& what) {
  std::size_t next = 0;
  const auto back = all_frames(take);
  for (const auto& frame : back) {
    while (next < frames.size() && frames[next]->sequence != frame->sequence) ++next;
    if (next >= frames.size()) {
      ADD_FAILURE() << what << ": a frame that never was";
      break;
    }
    EXPECT_TRUE(same_frame(*frames[next], *frame)) << what << ", frame " << next;
    ++next;
  }
  return back.size();
}

TEST_F(Take, CutOffAnywhereItGivesTheFramesBeforeAndSaysSo) {
  for (const auto codec : kCodecs) {
    const auto frames = plain_frames(6, {32, 24}, true);
    auto options = with_codec(codec);
    options.force = true;
    write_take(path(), frames, options);
    const auto whole = read_bytes(path());
    std::size_t most = 0;
    for (std::size_t length = 0; length < whole.size(); length += 97) {
      put({whole.begin(), whole.begin() + std::ptrdiff_t(length)});
      const auto what = "cut at " + std::to_string(length);
      std::size_t count = 0;
      const auto error = error_of([&] {
        const auto take = open_take("take://" + path());
        const auto back = all_frames(*take);
        count = back.size();
        for (std::size_t i = 0; i < count; ++i) EXPECT_TRUE(same_frame(*frames[i], *back[i])) << what;
        if (count < frames.size()) {
          EXPECT_THAT(take->warnings(), ::testing::Not(IsEmpty())) << what;
        }
      });
      if (error) {
        EXPECT_EQ(error->fault(), Fault::kUsage) << what;
      }
      EXPECT_GE(count, most) << what << ": a longer file has no fewer frames";
      most = std::max(most, count);
    }
    EXPECT_EQ(most, frames.size()) << "the index at the end is not needed";
  }
}

TEST_F(Take, AFlippedBitNeverChangesAFrame) {
  for (const auto codec : kCodecs) {
    const auto frames = plain_frames(5, {32, 24}, true);
    auto options = with_codec(codec);
    options.force = true;
    write_take(path(), frames, options);
    const auto whole = read_bytes(path());
    // Behind the tags, which say what the bytes mean: from the first stamp on.
    const std::string magic = "CHT1";
    const auto first = std::search(whole.begin(), whole.end(), magic.begin(), magic.end()) - whole.begin();
    ASSERT_LT(std::size_t(first), whole.size());
    cv::RNG random(7);
    int left_out = 0;
    for (int trial = 0; trial < 300; ++trial) {
      auto bytes = whole;
      const int at = random.uniform(trial < 100 ? int(first) : 0, trial < 100 ? int(first) + 28 : int(first));
      const int place = trial < 200 ? at : random.uniform(int(first), int(bytes.size()));
      bytes[std::size_t(place)] ^= static_cast<std::uint8_t>(1U << unsigned(random.uniform(0, 8)));
      put(bytes);
      const auto what = "byte " + std::to_string(place);
      const auto error = error_of([&] {
        const auto take = open_take("take://" + path());
        if (place < first) {
          all_frames(*take);  // May mean something else now, and must not crash.
        } else {
          const auto count = expect_only_good_frames(*take, frames, what);
          if (trial < 100) {
            EXPECT_GE(count + 1, frames.size()) << what << ": a damaged stamp costs its own frame alone";
          }
          for (const auto& line : take->warnings()) left_out += line.find("damaged") != std::string::npos;
        }
      });
      if (error) {
        EXPECT_THAT(error->what(), HasSubstr("take")) << what;
      }
    }
    EXPECT_GT(left_out, 100) << "damage is noticed";
  }
}

TEST_F(Take, WhatIsNoTakeIsRefusedInOneLine) {
  const auto refusal = [&](const Bytes& bytes) {
    put(bytes);
    const auto error = error_of([&] { open_take("take://" + path()); });
    EXPECT_TRUE(error);
    if (error) {
      EXPECT_EQ(error->fault(), Fault::kUsage);
    }
    return std::string(error ? error->what() : "");
  };
  EXPECT_THAT(refusal({}), HasSubstr("is empty"));
  EXPECT_THAT(refusal({'h', 'e', 'l', 'l', 'o'}), HasSubstr("no take"));
  Bytes only_tag = {0x1a, 0x45, 0xdf, 0xa3};
  for (const char c : std::string("CHOREOSCOPE_TAKE")) only_tag.push_back(std::uint8_t(c));
  EXPECT_THAT(refusal(only_tag), HasSubstr("no take"));
  EXPECT_TRUE(error_of([&] { open_take("take://" + folder_.path()); }));
  EXPECT_TRUE(error_of([&] { open_take("take:///nowhere/take.mkv"); }));

  write_take(folder_ / "later.mkv", plain_frames(2, {16, 16}));
  auto bytes = read_bytes(folder_ / "later.mkv");
  const std::string tag = "CHOREOSCOPE_TAKE";
  const auto at = std::search(bytes.begin(), bytes.end(), tag.begin(), tag.end()) + std::ptrdiff_t(tag.size());
  *std::find(at, bytes.end(), std::uint8_t('1')) = '9';
  EXPECT_THAT(refusal(bytes), HasSubstr("this version"));
}

TEST_F(Take, ATakeIsKnownByItsContentAndNotByItsName) {
  write_take(path(), plain_frames(2, {16, 16}));
  const auto driver = devices::take_driver();
  EXPECT_TRUE(driver.claims(path()));
  std::filesystem::rename(path(), folder_ / "old recording");
  EXPECT_TRUE(driver.claims(folder_ / "old recording"));
  EXPECT_FALSE(driver.claims(path())) << "it is not there";
  EXPECT_FALSE(driver.claims(folder_.path()));
  put({0x1a, 0x45, 0xdf, 0xa3, 'C', 'H'});
  EXPECT_FALSE(driver.claims(path()));
}

TEST(TakeFormat, AStampIsReadBackAndNothingElseIsTakenForOne) {
  const devices::take::Stamp stamp{3, 0xfedcba98, Nanoseconds(-5), 0x0123456789abcdefULL};
  const auto bytes = bytes_of(stamp);
  EXPECT_EQ(devices::take::stamp_of(bytes), stamp);
  const std::array<std::uint8_t, 28> by_hand = {'C',  'H',  'T',  '1',  3,    0,    0,    0,    0x98, 0xba,
                                                0xdc, 0xfe, 0xfb, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff,
                                                0xef, 0xcd, 0xab, 0x89, 0x67, 0x45, 0x23, 0x01};
  EXPECT_EQ(bytes, by_hand);
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_FALSE(devices::take::stamp_of(std::span(bytes).first(n))) << n;
  }
  auto other = bytes;
  other[3] = '2';
  EXPECT_FALSE(devices::take::stamp_of(other)) << "a later version may mean something else";
}

TEST(TakeFormat, TheChecksumIsThatOfZlib) {
  // 28 zero bytes but for the magic, and "123456789": computed with Python's zlib.crc32.
  const std::string text = "123456789";
  const std::vector<std::uint8_t> packet(text.begin(), text.end());
  EXPECT_EQ(devices::take::checksum({}, packet), 0x2a2a56b2U);
}

TEST(TakeFormat, MarksAreReadBackAndLinesThatAreNoneAreLeftOut) {
  using devices::take::Mark;
  const std::vector<Mark> marks = {{"processed", 0, ""}, {"setting", 12, "mask.threshold = 20"}};
  EXPECT_EQ(devices::take::marks_of(line_of(marks[0]) + line_of(marks[1])), marks);
  EXPECT_THAT(devices::take::marks_of("\n\nprocessed\nprocessed x\nprocessed -1\n 3\nprocessed 99999999999999999999\n"),
              IsEmpty());
  EXPECT_THAT(devices::take::marks_of("processed 7"), SizeIs(1)) << "the last line may lack its end";
  EXPECT_THAT(devices::take::line_of({"setting", 1, "two\nlines"}), HasSubstr("setting 1 two\\nlines\n"));
}

}  // namespace
}  // namespace choreo::test
