// SPDX-License-Identifier: Apache-2.0
// All files of a run under their final names, or none: what is there before, during and after, also when it goes wrong.
#include "outputs/output_set.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "outputs/npy.hpp"
#include "outputs/plot.hpp"
#include "outputs/video_writer.hpp"
#include "support/frames.hpp"
#include "support/small_files.hpp"
#include "support/temp_folder.hpp"

namespace choreo::outputs {
namespace {

namespace fs = std::filesystem;
using test::error_of;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class OutputSetTest : public ::testing::Test {
 protected:
  // Everything in the folder, below it too.
  std::set<std::string> there() const {
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path())) {
      names.insert(fs::relative(entry.path(), folder_.path()).string());
    }
    return names;
  }
  std::string content(const std::string& name) const {
    const auto bytes = test::read_bytes(folder_ / name);
    return {bytes.begin(), bytes.end()};
  }
  void write(const std::string& name, const std::string& text) const { test::write_bytes(folder_ / name, text); }

  test::TempFolder folder_;
};

TEST_F(OutputSetTest, NothingHasItsFinalNameBeforeCommitAndEverythingAfter) {
  OutputSet files(folder_.path());
  EXPECT_THAT(there(), IsEmpty()) << "the trial leaves nothing";
  for (const auto* name : {"a.txt", "b.npy"}) {
    const auto path = files.add(name);
    EXPECT_EQ(path.parent_path(), folder_.path()) << "of the same disk, so that renaming is one step";
    EXPECT_NE(path.filename(), name);
    write_file(path, name);
  }
  EXPECT_FALSE(fs::exists(folder_ / "a.txt"));
  EXPECT_FALSE(fs::exists(folder_ / "b.npy"));
  files.commit();
  EXPECT_THAT(there(), ElementsAre("a.txt", "b.npy"));
  EXPECT_EQ(content("a.txt"), "a.txt");
}

TEST_F(OutputSetTest, AnAbandonedRunLeavesNothingAndOlderFilesAsTheyWere) {
  write("a.txt", "old");
  write("foreign.txt", "not ours");
  {
    OutputSet files(folder_.path());
    write_file(files.add("a.txt"), "new");
    (void)files.add("never-written.txt");
  }
  EXPECT_THAT(there(), ElementsAre("a.txt", "foreign.txt"));
  EXPECT_EQ(content("a.txt"), "old");
}

TEST_F(OutputSetTest, CommitReplacesOlderFilesAndLeavesOthersAlone) {
  write("a.txt", "old");
  write("foreign.txt", "not ours");
  OutputSet files(folder_.path());
  write_file(files.add("a.txt"), "new");
  files.commit();
  EXPECT_EQ(content("a.txt"), "new");
  EXPECT_EQ(content("foreign.txt"), "not ours");
}

TEST_F(OutputSetTest, MissingFoldersAreMadeAndGoAgainWhenTheRunIsAbandoned) {
  for (const auto* path : {"x/y/z", "x/y/z/", "./x//y", "x/../x/y", "x/y/.."}) {
    { const OutputSet files(folder_ / path); }
    EXPECT_THAT(there(), IsEmpty()) << path;
    OutputSet files(folder_ / path);
    write_file(files.add("a.txt"), "text");
    files.commit();
    EXPECT_TRUE(fs::exists(folder_ / (std::string(path) + "/a.txt"))) << path;
    fs::remove_all(folder_ / "x");
  }
}

TEST_F(OutputSetTest, FoldersThatWereThereBeforeStay) {
  fs::create_directory(folder_ / "mine");
  { const OutputSet files(folder_ / "mine/new"); }
  EXPECT_THAT(there(), ElementsAre("mine"));
}

TEST_F(OutputSetTest, AFolderItMadeStaysWhereSomebodyPutAFileIntoIt) {
  {
    OutputSet files(folder_ / "new");
    write_file(files.add("a.txt"), "ours");
    write("new/foreign.txt", "not ours");
  }
  EXPECT_THAT(there(), ElementsAre("new", "new/foreign.txt"));
}

TEST_F(OutputSetTest, ARelativeFolderIsMadeWhereTheProgramStands) {
  const auto before = fs::current_path();
  fs::current_path(folder_.path());
  {
    OutputSet files("out/deep");
    write_file(files.add("a.txt"), "text");
    files.commit();
  }
  fs::current_path(before);
  EXPECT_EQ(content("out/deep/a.txt"), "text");
}

TEST_F(OutputSetTest, AFileInTheFoldersPlaceIsRefused) {
  write("file", "text");
  fs::create_symlink("nowhere", folder_ / "dangling");
  const std::string long_name(300, 'x');
  for (const auto& path :
       {folder_ / "file", folder_ / "file/below", folder_ / "dangling", std::string("/dev/null"), folder_ / long_name,
        folder_ / ("new/" + long_name), std::string(), std::string("a\0b", 3)}) {
    const auto error = error_of([&] { const OutputSet files(path); });
    ASSERT_TRUE(error) << path;
    EXPECT_EQ(error->fault(), Fault::kUsage) << path;
  }
  EXPECT_THAT(there(), ElementsAre("dangling", "file")) << "what was made on the way is gone";
}

TEST_F(OutputSetTest, AFolderThatCannotBeWrittenToIsRefused) {
  // Nobody writes into /proc, root included.
  for (const auto* path : {"/proc", "/proc/choreoscope/out", "/proc/self/fd"}) {
    const auto error = error_of([&] { const OutputSet files(path); });
    ASSERT_TRUE(error) << path;
    EXPECT_EQ(error->fault(), Fault::kUsage);
    EXPECT_THAT(error->what(), HasSubstr("\"/proc")) << path;
  }
}

TEST_F(OutputSetTest, AFolderWithoutTheRightToWriteIsRefused) {
  // Root may write everywhere, so the test is somebody else meanwhile.
  ::chmod(folder_.path().c_str(), 0555);
  const auto me = ::geteuid();
  if (me == 0) {
    ASSERT_EQ(::seteuid(65534), 0);
  }
  const auto error = error_of([&] { const OutputSet files(folder_.path()); });
  const auto below = error_of([&] { const OutputSet files(folder_ / "a/b"); });
  if (me == 0) {
    ASSERT_EQ(::seteuid(0), 0);
  }
  ::chmod(folder_.path().c_str(), 0755);
  ASSERT_TRUE(error && below);
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_THAT(error->what(), HasSubstr("Permission denied"));
  EXPECT_THAT(below->what(), HasSubstr("Permission denied"));
}

TEST_F(OutputSetTest, WhatAKilledRunOfTheSameNumberLeftIsNoObstacle) {
  // In a container every run has the same process number.
  std::string first;
  {
    OutputSet files(folder_.path());
    first = files.add("a.txt").string();
  }
  test::write_bytes(first, std::string("left behind"));
  write(".choreoscope." + std::to_string(::getpid()) + ".tmp", "");
  OutputSet files(folder_.path());
  write_file(files.add("a.txt"), "new");
  files.commit();
  EXPECT_EQ(content("a.txt"), "new");
}

TEST_F(OutputSetTest, AFolderOfTheFinalNameIsRefusedBeforeAnythingIsWritten) {
  fs::create_directory(folder_ / "plot.png");
  OutputSet files(folder_.path());
  const auto error = error_of([&] { (void)files.add("plot.png"); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_THAT(error->what(), HasSubstr("plot.png\" is a folder"));
}

TEST_F(OutputSetTest, AFileThatWasNeverWrittenFailsTheCommitAndLeavesNoTemporaries) {
  {
    OutputSet files(folder_.path());
    (void)files.add("missing.txt");
    write_file(files.add("b.txt"), "b");
    const auto error = error_of([&] { files.commit(); });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->fault(), Fault::kFailure);
    EXPECT_THAT(error->what(), HasSubstr("missing.txt\" cannot be written"));
  }
  EXPECT_THAT(there(), IsEmpty());
}

TEST_F(OutputSetTest, NoneIsCommittedWhereOneWasNeverWritten) {
  write("a.txt", "old");
  {
    OutputSet files(folder_.path());
    write_file(files.add("a.txt"), "new");
    (void)files.add("missing.txt");
    EXPECT_TRUE(error_of([&] { files.commit(); }));
  }
  EXPECT_EQ(content("a.txt"), "old");
}

TEST_F(OutputSetTest, SupersededFilesGoWithTheCommitAndNotBefore) {
  write("masks.npy", "old");
  write("plot.svg", "old");
  fs::create_directory(folder_ / "triangle.svg");
  {
    OutputSet abandoned(folder_.path());
    abandoned.supersede("masks.npy");
  }
  EXPECT_EQ(content("masks.npy"), "old");
  OutputSet files(folder_.path());
  write_file(files.add("a.txt"), "new");
  for (const auto* name : {"masks.npy", "triangle.svg", "never-there"}) files.supersede(name);
  EXPECT_EQ(content("masks.npy"), "old");
  files.commit();
  EXPECT_THAT(there(), ElementsAre("a.txt", "plot.svg", "triangle.svg")) << "a folder of that name is the user's";
}

TEST_F(OutputSetTest, OnAFullDiskEveryWriterFailsAndNothingIsLeftBehind) {
  {
    OutputSet files(folder_ / "out");
    const auto plot_path = files.add("plot.png");
    const auto svg_path = files.add("plot.svg");
    const auto video_path = files.add("clip.mkv");
    const float one = 1.0F;
    const double time = 0.0;
    PlotOptions options;
    options.width_px = 400;
    const Plot plot({{&one, 1, 1}, {&one, 1, 1}, {&time, 1}, {}}, options);
    const test::SmallFiles full(2000);
    EXPECT_TRUE(error_of([&] { plot.write_png(plot_path); }));
    EXPECT_TRUE(error_of([&] { plot.write_svg(svg_path); }));
    EXPECT_TRUE(error_of([&] { write_file(files.add("frames.csv"), std::string(5000, 'x')); }));
    EXPECT_TRUE(error_of([&] { const NpyMatrix matrix(files.add("z.npy"), 100, 100); }));
    EXPECT_TRUE(error_of([&] {
      VideoOptions video;
      video.container = VideoContainer::kMatroska;
      VideoWriter writer(video_path.string(), {64, 48}, video);
      for (int i = 0; i < 20; ++i) {
        writer.write(test::noise({64, 48}, CV_8UC3, static_cast<std::uint64_t>(i)), std::chrono::milliseconds(40 * i));
      }
      writer.close();
    }));
  }
  EXPECT_THAT(there(), IsEmpty());
}

TEST_F(OutputSetTest, WhatIsAbandonedHalfwayThroughAVideoIsGoneToo) {
  {
    OutputSet files(folder_ / "out");
    VideoOptions options;
    options.container = VideoContainer::kMatroska;
    VideoWriter writer(files.add("clip.mkv").string(), {64, 48}, options);
    writer.write(test::noise({64, 48}, CV_8UC3, 1), {});
    EXPECT_FALSE(there().contains("out/clip.mkv"));
  }
  EXPECT_THAT(there(), IsEmpty());
}

TEST_F(OutputSetTest, ADrawingAndAVideoCommittedAreUnderTheirNamesAlone) {
  OutputSet files(folder_.path());
  const float one = 1.0F;
  const double time = 0.0;
  PlotOptions options;
  options.width_px = 400;
  Plot({{&one, 1, 1}, {&one, 1, 1}, {&time, 1}, {}}, options).write_png(files.add("plot.png"));
  VideoOptions video;
  video.container = VideoContainer::kMatroska;
  VideoWriter writer(files.add("clip.mkv").string(), {64, 48}, video);
  writer.write(test::noise({64, 48}, CV_8UC3, 1), {});
  writer.close();
  files.commit();
  EXPECT_THAT(there(), ElementsAre("clip.mkv", "plot.png"));
}

TEST_F(OutputSetTest, WriteFileWritesEveryByteAndReplacesLongerFiles) {
  const std::string all("a\0b\r\n\xff", 6);
  write("x", std::string(100, 'y'));
  write_file(folder_ / "x", all);
  EXPECT_EQ(content("x"), all);
  write_file(folder_ / "x", "");
  EXPECT_EQ(content("x"), "");
  EXPECT_THAT(error_of([] { write_file("/dev/full", "x"); })->what(), HasSubstr("No space left on device"));
}

}  // namespace
}  // namespace choreo::outputs
