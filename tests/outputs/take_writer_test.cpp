// SPDX-License-Identifier: Apache-2.0
// Takes being written: where they grow, what is refused, what happens when the disk or the machine cannot keep up.
#include <chrono>
#include <filesystem>
#include <fstream>
#include <set>

#include <gmock/gmock.h>

#include "support/eventually.hpp"
#include "support/small_files.hpp"
#include "support/takes.hpp"
#include "support/temp_folder.hpp"

namespace choreo::test {
namespace {

using devices::FramePtr;
using outputs::TakeCodec;
using outputs::TakeWriter;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class TakeWriting : public ::testing::Test {
 protected:
  [[nodiscard]] std::string path() const { return folder_ / "take.mkv"; }
  [[nodiscard]] std::string unfinished() const { return folder_ / "take.unfinished.mkv"; }

  // How many frames the unfinished file has by now; none where it cannot be opened yet.
  [[nodiscard]] std::size_t frames_by_now() const {
    std::size_t count = 0;
    (void)error_of([&] { count = all_frames(*open_take(unfinished())).size(); });
    return count;
  }

  [[nodiscard]] std::string refusal(const std::string& path, bool force = false) const {
    auto options = whole_take();
    options.force = force;
    const auto error = error_of([&] { TakeWriter(path, info_of(*plain_frame(0, {}, {16, 16})), options); });
    EXPECT_TRUE(error) << path;
    if (!error) return {};
    EXPECT_EQ(error->fault(), Fault::kUsage);
    return std::string(error->what()) + " " + error->hint();
  }

  TempFolder folder_;
};

TEST_F(TakeWriting, AtEveryMomentTheFileHasAllFramesButTheLatest) {
  const auto frames = plain_frames(5, {32, 24}, true);
  TakeWriter writer(path(), info_of(*frames[0]), whole_take());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    writer.add(frames[i]);
    // The writer has a thread of its own.
    ASSERT_TRUE(eventually([&] { return frames_by_now() > i; }));
    ASSERT_EQ(frames_by_now(), i + 1);
  }
  EXPECT_FALSE(std::filesystem::exists(path()));
  EXPECT_THAT(open_take(unfinished()), ::testing::NotNull());
  writer.close();
  EXPECT_FALSE(std::filesystem::exists(unfinished()));
  EXPECT_THAT(all_frames(*open_take(path())), SizeIs(5));
}

TEST_F(TakeWriting, AnUnfinishedTakeSaysThatItWasCutOff) {
  const auto frames = plain_frames(5, {32, 24});
  TakeWriter writer(path(), info_of(*frames[0]), whole_take());
  for (const auto& frame : frames) writer.add(frame);
  ASSERT_TRUE(eventually([&] { return frames_by_now() == 5; }));
  const auto take = open_take(unfinished());
  all_frames(*take);
  EXPECT_THAT(take->warnings(), ::testing::ElementsAre(HasSubstr("never finished")));
  EXPECT_FALSE(take->info().duration);
}

TEST_F(TakeWriting, NobodysCloseFinishesTheFileAllTheSame) {
  const auto frames = plain_frames(3, {32, 24});
  {
    TakeWriter writer(path(), info_of(*frames[0]), whole_take());
    for (const auto& frame : frames) writer.add(frame);
  }
  EXPECT_THAT(all_frames(*open_take(path())), SizeIs(3));
}

TEST_F(TakeWriting, WithoutFramesThereIsNoFile) {
  {
    TakeWriter writer(path(), info_of(*plain_frame(0, {}, {16, 16})), whole_take());
    EXPECT_EQ(writer.close().frames, 0u);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(TakeWriting, TheSameFramesGiveTheSameBytes) {
  const auto frames = plain_frames(4, {64, 48}, true);
  auto options = whole_take();
  options.codec = TakeCodec::kFfv1;
  write_take(folder_ / "a.mkv", frames, options);
  write_take(folder_ / "b.mkv", frames, options);
  EXPECT_EQ(read_bytes(folder_ / "a.mkv"), read_bytes(folder_ / "b.mkv"));
}

TEST_F(TakeWriting, WhatIsThereIsReplacedOnlyWhereThatIsWanted) {
  std::ofstream(path()) << "precious";
  EXPECT_THAT(refusal(path()), AllOf(HasSubstr("is there already"), HasSubstr("another name")));
  auto options = whole_take();
  options.force = true;
  write_take(path(), plain_frames(2, {16, 16}), options);
  EXPECT_THAT(all_frames(*open_take(path())), SizeIs(2));

  // Of yesterday's crash, and perhaps all that is left of it: not even by force.
  std::ofstream(unfinished()) << "precious";
  std::filesystem::remove(path());
  for (const bool force : {false, true}) {
    EXPECT_THAT(refusal(path(), force), AllOf(HasSubstr("unfinished.mkv"), HasSubstr("cut off")));
  }
  EXPECT_EQ(std::filesystem::file_size(unfinished()), 8u);
}

TEST_F(TakeWriting, WhatAppearsWhileItIsRecordedIsNotReplaced) {
  const auto frames = plain_frames(2, {16, 16});
  TakeWriter writer(path(), info_of(*frames[0]), whole_take());
  for (const auto& frame : frames) writer.add(frame);
  std::ofstream(path()) << "precious";
  const auto error = error_of([&] { writer.close(); });
  ASSERT_TRUE(error);
  EXPECT_THAT(error->what(), HasSubstr("cannot be renamed"));
  EXPECT_EQ(std::filesystem::file_size(path()), 8u);
  EXPECT_THAT(all_frames(*open_take(unfinished())), SizeIs(2));
}

TEST_F(TakeWriting, WhatIsDiscardedLeavesNoFile) {
  const auto frames = plain_frames(2, {16, 16});
  TakeWriter writer(path(), info_of(*frames[0]), whole_take());
  for (const auto& frame : frames) writer.add(frame);
  writer.discard();
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

// Of a device that pairs its first pictures late.
std::vector<FramePtr> late_depth(int count, int without) {
  auto frames = plain_frames(without, {32, 24});
  for (int i = without; i < count; ++i) {
    frames.push_back(plain_frame(std::uint64_t(i), i * Nanoseconds(33'333'333), {32, 24}, true));
  }
  return frames;
}

TEST_F(TakeWriting, DepthThatComesWithinASecondIsRecorded) {
  const auto frames = late_depth(40, 20);
  auto info = info_of(*frames[0]);
  info.depth = true;
  const auto report = write_take(path(), frames, whole_take(), info);
  EXPECT_EQ(report.frames, 40u);
  EXPECT_EQ(report.without_depth, 0u);
  const auto back = all_frames(*open_take(path()));
  ASSERT_EQ(back.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) EXPECT_TRUE(same_frame(*frames[i], *back[i])) << i;
}

TEST_F(TakeWriting, DepthThatComesLaterIsMissingAndCounted) {
  const auto frames = late_depth(40, 35);
  auto info = info_of(*frames[0]);
  info.depth = true;
  const auto report = write_take(path(), frames, whole_take(), info);
  EXPECT_EQ(report.frames, 40u);
  EXPECT_EQ(report.without_depth, 5u);
}

TEST_F(TakeWriting, TheSettingsOfTheRunAreKeptForItsReplay) {
  auto options = whole_take();
  options.marks = true;
  options.settings = "mask.steps = 2\nsegmentation = \"both\"\n";
  write_take(path(), plain_frames(2, {16, 16}), options);
  EXPECT_EQ(open_take(path() + "?frames=processed")->info().settings, options.settings);
  EXPECT_EQ(open_take(path())->info().settings, "") << "then it is no replay";
}

TEST_F(TakeWriting, PlacesThatCannotBeWrittenToAreRefused) {
  EXPECT_THAT(refusal(folder_ / "take.mp4"), HasSubstr(".mkv"));
  EXPECT_THAT(refusal(folder_ / "take"), HasSubstr(".mkv"));
  EXPECT_THAT(refusal(folder_ / ".mkv"), HasSubstr(".mkv"));
  EXPECT_THAT(refusal(""), HasSubstr(".mkv"));
  EXPECT_THAT(refusal(folder_ / "missing/take.mkv"), HasSubstr("is no folder"));
  std::ofstream(folder_ / "file") << "x";
  EXPECT_THAT(refusal(folder_ / "file/take.mkv"), HasSubstr("is no folder"));
  std::filesystem::create_directory(path());
  EXPECT_THAT(refusal(path(), true), HasSubstr("no file to write to"));
}

TEST_F(TakeWriting, AFullDiskEndsTheRecordingAndKeepsWhatCameBefore) {
  const auto frames = plain_frames(40, {64, 48}, true);
  std::string trouble;
  auto options = whole_take();
  options.codec = TakeCodec::kFfv1;
  options.on_trouble = [&](const std::string& why) { trouble = why; };
  std::optional<Error> error;
  {
    const SmallFiles full(200'000);
    error = error_of([&] { write_take(path(), frames, options); });
  }
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kFailure);
  EXPECT_THAT(error->what(), HasSubstr("broke off after"));
  EXPECT_THAT(error->hint(), HasSubstr("take.unfinished.mkv"));
  EXPECT_THAT(trouble, HasSubstr("cannot be written"));
  EXPECT_FALSE(std::filesystem::exists(path()));
  const auto back = all_frames(*open_take(unfinished()));
  // 9 kB of colour and 6 kB of depth, all of it noise.
  EXPECT_GE(back.size(), 10u);
  for (std::size_t i = 0; i < back.size(); ++i) EXPECT_TRUE(same_frame(*frames[i], *back[i])) << i;
}

TEST_F(TakeWriting, WhoDoesNotWaitLeavesFramesOutAndCountsThem) {
  const auto frames = plain_frames(60, {320, 240});
  outputs::TakeOptions options;
  options.queue_bytes = 1;
  options.codec = TakeCodec::kFfv1;
  options.marks = true;
  TakeWriter writer(path(), info_of(*frames[0]), options);
  for (const auto& frame : frames) {
    writer.add(frame);
    writer.processed(frame->sequence);
  }
  const auto report = writer.close();
  EXPECT_GT(report.left_out, 0u) << "a picture takes milliseconds, handing it over does not";
  EXPECT_EQ(report.frames + report.left_out, frames.size());
  EXPECT_EQ(report.processed_missing, report.left_out);
  EXPECT_EQ(report.gaps, 0u) << "the source lost nothing";
  const auto back = all_frames(*open_take(path()));
  EXPECT_EQ(back.size(), report.frames);
  EXPECT_FALSE(back.empty());
  for (const auto& frame : back) EXPECT_TRUE(same_frame(*frames[frame->sequence], *frame));
}

TEST_F(TakeWriting, WhoWaitsLosesNothing) {
  auto options = whole_take();
  options.queue_bytes = 1;
  const auto report = write_take(path(), plain_frames(30, {160, 120}), options);
  EXPECT_EQ(report.frames, 30u);
  EXPECT_EQ(report.left_out, 0u);
}

TEST_F(TakeWriting, FramesThatTheSourceLostAreCounted) {
  auto frames = plain_frames(10, {16, 16});
  frames.erase(frames.begin() + 3, frames.begin() + 5);
  const auto report = write_take(path(), frames);
  EXPECT_EQ(report.gaps, 2u);
  EXPECT_EQ(report.frames, 8u);
  EXPECT_EQ(report.length, Nanoseconds(9 * 33'333'333LL));
  EXPECT_EQ(report.bytes, std::filesystem::file_size(path()));
}

TEST_F(TakeWriting, TheCodecFollowsTheRateThatMustBeKept) {
  const auto frames = plain_frames(2, {640, 480});
  const auto codec_at = [&](double fps, outputs::FullQueue full, bool repeatable) {
    auto info = info_of(*frames[0]);
    info.nominal_fps = fps;
    info.repeatable = repeatable;
    outputs::TakeOptions options;
    options.full = full;
    options.force = true;
    return write_take(path(), frames, options, info).codecs;
  };
  using outputs::FullQueue;
  EXPECT_EQ(codec_at(0.1, FullQueue::kLeaveOut, false), "colour ffv1") << "ten seconds a frame";
  EXPECT_EQ(codec_at(1000, FullQueue::kLeaveOut, false), "colour ffvhuff") << "a millisecond a frame";
  EXPECT_EQ(codec_at(1000, FullQueue::kWait, true), "colour ffv1") << "a file waits";
  EXPECT_EQ(codec_at(1000, FullQueue::kWait, false), "colour ffvhuff") << "a device does not";
}

TEST_F(TakeWriting, ASourceThatBreaksItsPromisesEndsTheRecordingWithWhatCameBefore) {
  const auto broken = [&](const devices::FramePtr& last) {
    auto frames = plain_frames(3, {32, 24});
    frames.push_back(last);
    auto options = whole_take();
    options.force = true;
    const auto error = error_of([&] { write_take(path(), frames, options); });
    EXPECT_TRUE(error);
    EXPECT_THAT(all_frames(*open_take(unfinished())), SizeIs(3));
    std::filesystem::remove(unfinished());
    return std::string(error ? error->what() : "");
  };
  const auto later = Nanoseconds(1'000'000'000);
  EXPECT_THAT(broken(plain_frame(3, later, {34, 24})), HasSubstr("changes from BGR3 32x24 to BGR3 34x24"));
  EXPECT_THAT(broken(plain_frame(2, later, {32, 24})), HasSubstr("does not come after"));
  EXPECT_THAT(broken(plain_frame(3, Nanoseconds(5), {32, 24})), HasSubstr("does not come after"));
  EXPECT_THAT(broken(raw_frame(3, later, noise_picture(devices::kGrey, {32, 24}, 1))), HasSubstr("GREY"));
}

TEST_F(TakeWriting, MarksThatComeBeforeTheFileBeginsAreNotLost) {
  // Whatever the order in which the threads come to it.
  for (int trial = 0; trial < 20; ++trial) {
    const auto frames = plain_frames(2, {16, 16});
    auto options = whole_take();
    options.marks = options.force = true;
    TakeWriter writer(path(), info_of(*frames[0]), options);
    writer.add(frames[0]);
    writer.processed(0);
    writer.add(frames[1]);
    writer.processed(1);
    writer.close();
    const auto back = all_frames(*open_take(path() + "?frames=processed"));
    ASSERT_THAT(back, SizeIs(2));
    for (const auto& frame : back) EXPECT_FALSE(frame->overtaken);
  }
}

TEST(TakeCodecName, IsOneOfThree) {
  EXPECT_EQ(outputs::parse_take_codec("auto"), TakeCodec::kAuto);
  EXPECT_EQ(outputs::parse_take_codec("ffv1"), TakeCodec::kFfv1);
  EXPECT_EQ(outputs::parse_take_codec("ffvhuff"), TakeCodec::kFfvhuff);
  for (const auto* text : {"", "FFV1", "h264"})
    EXPECT_TRUE(error_of([&] { (void)outputs::parse_take_codec(text); })) << text;
}

}  // namespace
}  // namespace choreo::test
