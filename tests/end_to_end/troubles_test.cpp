// SPDX-License-Identifier: Apache-2.0
// Troubles of the world: what fails while running ends with 1, what can be lived with ends with 0 and one warning.
#include <sys/stat.h>

#include <gmock/gmock.h>

#include "end_to_end/refusal_fixture.hpp"
#include "support/make_video.hpp"
#include "support/places.hpp"

namespace choreo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class Troubles : public RefusalTest {
 protected:
  /// Runs `analyze`, which must end with 0 and exactly one warning, and leave nothing but results.
  std::string warned(const std::string& source, const std::vector<std::string>& more = {}) {
    last_ = analyze(source, out(), more);
    const auto warnings = last_.err_lines("choreoscope: warning: ");
    EXPECT_THAT(warnings, SizeIs(1)) << last_.told();
    EXPECT_THAT(last_.err_lines("choreoscope: error: "), SizeIs(0));
    for (const auto& name : files_in(out())) EXPECT_NE(name.front(), '.') << name << " was left behind";
    for (const auto* name : {"plot.png", "triangle.png"}) {
      EXPECT_FALSE(cv::imread(out() + "/" + name).empty()) << name;
    }
    const Results r(out());
    EXPECT_EQ(r.summary["warnings"], nlohmann::json(warnings));
    return warnings.empty() ? std::string() : warnings[0];
  }
  [[nodiscard]] std::string out() const { return folder_ / "out"; }

  void film(const std::string& script, const std::string& name) {
    const auto run = choreoscope({"synth", script, "-o", folder_ / name});
    ASSERT_EQ(run.status, 0) << run.told();
  }

  void picture_folder(int count, cv::Size size) {
    std::filesystem::create_directory(folder_ / "pictures");
    for (int i = 0; i < count; ++i) write_png("pictures/" + std::to_string(100 + i) + ".png", size);
  }
};

TEST_F(Troubles, AFullDiskIsToldOfAndLeavesNothing) {
  constexpr auto kClip = "synthetic://walking?size=64x48&duration=1";
  RunOptions options;
  // Masks, matrices, plots: each in turn is what does not fit.
  for (const std::uint64_t limit : {0ULL, 1000ULL, 20'000ULL, 60'000ULL}) {
    options.file_size_limit = limit;
    const auto complaint = refused(kClip, {"--save", "masks", "--set", "plot.svg=true"}, 1, options);
    EXPECT_THAT(complaint, HasSubstr("File too large")) << limit;
    EXPECT_THAT(complaint, HasSubstr("\"" + old() + "/")) << limit;
    EXPECT_THAT(complaint, ::testing::Not(HasSubstr(".tmp"))) << "nobody knows that file";
  }
}

TEST_F(Troubles, AFullDiskWhileFilmingLeavesNoHalfClip) {
  RunOptions options;
  std::filesystem::create_directory(folder_ / "clips");
  for (const std::uint64_t limit : {0ULL, 5'000ULL, 200'000ULL}) {
    options.file_size_limit = limit;
    const auto run = choreoscope({"synth", "walking?size=160x120&duration=1", "-o", folder_ / "clips/a.mkv"}, options);
    EXPECT_THAT(complaint_of(run, 1), HasSubstr("clips/")) << limit;
    EXPECT_TRUE(files_in(folder_ / "clips").empty()) << ::testing::PrintToString(files_in(folder_ / "clips"));
  }
}

TEST_F(Troubles, AFrameSizeThatChangesMidwayIsNamedWithItsTime) {
  VideoRecipe recipe;
  recipe.encoder = "mjpeg";
  recipe.format = "mjpeg";
  recipe.pixel_format = AV_PIX_FMT_YUVJ420P;
  recipe.time_base = {1, 25};
  recipe.times.clear();
  for (int i = 0; i < 30; ++i) recipe.times.push_back(i);
  Bytes both;
  for (const auto size : {cv::Size(64, 48), cv::Size(80, 48)}) {
    recipe.width = size.width;
    recipe.height = size.height;
    make_video(folder_ / "part.mjpeg", recipe);
    const auto part = read_bytes(folder_ / "part.mjpeg");
    both.insert(both.end(), part.begin(), part.end());
  }
  write_bytes(folder_ / "both.mjpeg", both);
  EXPECT_THAT(refused(folder_ / "both.mjpeg", {}, 1),
              AllOf(HasSubstr("64x48"), HasSubstr("80x48"), HasSubstr("1.200 s")));
}

TEST_F(Troubles, APictureOfAnotherSizeInAFolderIsNamed) {
  picture_folder(3, {64, 48});
  write_png("pictures/101.png", {64, 50});
  EXPECT_THAT(refused(folder_ / "pictures", {}, 1), AllOf(HasSubstr("101.png"), HasSubstr("64x50")));
}

TEST_F(Troubles, ATruncatedClipIsUsedAsFarAsItIsGood) {
  film("jumping-jacks?size=160x120&duration=4", "whole.mkv");
  auto bytes = read_bytes(folder_ / "whole.mkv");
  bytes.resize(bytes.size() * 3 / 5);
  write_bytes(folder_ / "cut.mkv", bytes);
  EXPECT_THAT(warned(folder_ / "cut.mkv"), AllOf(HasSubstr("cut.mkv\""), HasSubstr("truncated")));
  const Results r(out());
  EXPECT_GT(r.n, 60u);
  EXPECT_LT(r.n, 120u);
  EXPECT_LT(r.summary["frames_without_body"], r.n / 2);
}

TEST_F(Troubles, OneFrame) {
  EXPECT_THAT(warned("synthetic://walking?size=64x48&empty=0&duration=0.03"), HasSubstr("only one frame"));
  EXPECT_EQ(Results(out()).n, 1u);
}

TEST_F(Troubles, OnePixel) {
  picture_folder(5, {1, 1});
  (void)warned(folder_ / "pictures");
  EXPECT_EQ(Results(out()).n, 5u);
}

TEST_F(Troubles, PicturesOfEightThousandPixels) {
  std::filesystem::create_directory(folder_ / "pictures");
  cv::Mat wall(4320, 7680, CV_8UC3, cv::Scalar(90, 120, 100));
  ASSERT_TRUE(cv::imwrite(folder_ / "pictures/1.jpg", wall));
  wall(cv::Rect(3000, 1000, 1000, 3000)) = cv::Scalar(20, 20, 160);
  ASSERT_TRUE(cv::imwrite(folder_ / "pictures/2.jpg", wall));
  EXPECT_THAT(warned(folder_ / "pictures", {"--set", "background.from=" + folder_ / "pictures/1.jpg"}),
              AllOf(HasSubstr("7680"), HasSubstr("working.rows")));
  EXPECT_EQ(Results(out()).summary["working_size"], nlohmann::json({853, 480}));
}

TEST_F(Troubles, NobodyEver) {
  EXPECT_THAT(warned("synthetic://empty?size=160x120&duration=2"), HasSubstr("no body was ever seen"));
  const Results r(out());
  EXPECT_EQ(r.summary["frames_without_body"], r.n);
  EXPECT_TRUE(std::all_of(r.z_values.begin(), r.z_values.end(), [](float z) { return std::isnan(z); }));
}

TEST_F(Troubles, ABodyCutByTheFrame) {
  EXPECT_THAT(warned("synthetic://crossing?size=160x120&fps=15"), HasSubstr("cut by the picture's border"));
}

TEST_F(Troubles, OldResultsAreReplacedAsAWhole) {
  analyze(kQuick, old(), {"--save", "masks"});
  EXPECT_EQ(files_in(old()).size(), 8u);
  EXPECT_EQ(Results(old()).n, 6u);
}

TEST_F(Troubles, WhatTheOldRunWroteAndTheNewOneDoesNotIsGone) {
  analyze(kQuick, old());
  EXPECT_EQ(files_in(old()).size(), 7u) << "its masks belonged to another recording";
  analyze(kQuick, old(), {"--set", "plot.svg=true"});
  EXPECT_EQ(files_in(old()).size(), 9u);
  analyze(kQuick, old(), {"--save", "masks"});
  EXPECT_EQ(files_in(old()).size(), 8u);
}

TEST_F(Troubles, DamageBehindTheSpanFailsNobody) {
  picture_folder(20, {64, 48});
  write_png("pictures/115.png", {64, 50});
  EXPECT_THAT(refused(folder_ / "pictures", {"--span", "1f:16f"}, 1), HasSubstr("115.png"));
  const auto run = choreoscope({"analyze", folder_ / "pictures", "--out", out(), "--span", "1f:15f"});
  EXPECT_EQ(run.status, 0) << run.told();
  EXPECT_EQ(Results(out()).n, 15u);
}

TEST_F(Troubles, APictureLeftOutLeavesAGapInTheNumbers) {
  picture_folder(6, {64, 48});
  write_bytes(folder_ / "pictures/102.png", std::string("not a picture"));
  const auto run = choreoscope({"analyze", folder_ / "pictures", "--out", out(), "--span", "2f:3f"});
  EXPECT_EQ(Results(out()).n, 1u) << "frame 2; frame 3 is damaged. " << run.told();
}

TEST_F(Troubles, ALongRecordingIsThinnedUntilItFits) {
  constexpr auto kClip = "synthetic://jumping-jacks?size=64x48&duration=2&empty=1";
  const auto all = folder_ / "all";
  analyze(kClip, all, {"--save", "masks"});
  EXPECT_THAT(warned(kClip, {"--set", "matrix.most_rows=25", "--save", "masks"}),
              AllOf(HasSubstr("every 4th"), HasSubstr("90 frames")));
  const Results r(out());
  const Results whole(all);
  ASSERT_EQ(r.n, 23u) << "frames 1, 5, ... 89 of 90";
  EXPECT_EQ(r.summary["thinned_to_every"], 4);
  EXPECT_EQ(r.summary["frames_seen"], 90);
  const auto masks = read_npy(out() + "/masks.npy");
  const auto whole_masks = read_npy(all + "/masks.npy");
  ASSERT_EQ(masks.shape.at(0), 23u);
  const std::size_t size = masks.data.size() / 23;
  for (std::size_t i = 0; i < r.n; ++i) {
    EXPECT_EQ(r.time_s[i], whole.time_s[4 * i]);
    EXPECT_TRUE(std::equal(masks.data.begin() + std::ptrdiff_t(i * size),
                           masks.data.begin() + std::ptrdiff_t((i + 1) * size),
                           whole_masks.data.begin() + std::ptrdiff_t(4 * i * size)))
        << i;
    for (std::size_t j = 0; j < r.n; ++j) {
      const bool gap = std::isnan(whole.Z(4 * i, 4 * j));
      ASSERT_TRUE(gap ? std::isnan(r.Z(i, j)) : r.Z(i, j) == whole.Z(4 * i, 4 * j)) << i << ", " << j;
    }
  }
  EXPECT_EQ(Results(out()).summary["frames_without_body"], 8) << "1 s without a body, every 4th frame of it";
}

TEST_F(Troubles, AMatrixTooLargeForTheDiskIsRefusedBeforeTheWork) {
  const auto complaint =
      refused("synthetic://walking?size=64x48&fps=240&duration=36000", {"--set", "matrix.most_rows=1000000"});
  EXPECT_THAT(complaint, AllOf(HasSubstr("1000000 frames"), HasSubstr("8000.0 GB"), HasSubstr("left")));
  EXPECT_THAT(hint(), HasSubstr("--every"));
}

TEST_F(Troubles, ThumbnailsBehindTheEnd) {
  EXPECT_THAT(warned("synthetic://jumping-jacks?size=64x48&duration=1", {"--set", "plot.thumbnails_at_s=[0.5, 99]"}),
              AllOf(HasSubstr("99 s"), HasSubstr("plot.thumbnails_at_s")));
}

TEST_F(Troubles, StandardOutputThatIsFullIsAFailure) {
  const auto run = run_program("/bin/sh", {"-c", "exec \"" + program() + "\" config show > /dev/full"});
  EXPECT_THAT(complaint_of(run, 1), HasSubstr("standard output"));
}

}  // namespace
}  // namespace choreo::test
