// SPDX-License-Identifier: Apache-2.0
#include "devices/image_folder/image_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include <sys/stat.h>
#include <unistd.h>

#include "devices/image_folder/numbered_names.hpp"
#include "support/frames.hpp"
#include "support/temp_folder.hpp"

namespace choreo::devices {
namespace {

using test::all_frames;
using test::error_of;
using test::noise;
using test::same_pixels;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class ImageFolderTest : public ::testing::Test {
 protected:
  ImageFolderTest() { registry_.add(image_folder_driver()); }

  std::unique_ptr<Source> open(const std::string& settings = "") { return registry_.open(folder_.path() + settings); }
  std::unique_ptr<Source> open_any(const std::string& settings = "") {
    OpenOptions options;
    options.sets = true;
    return registry_.open(folder_.path() + settings, options);
  }
  static std::vector<std::string> names_of(Source& source) {
    std::vector<std::string> names;
    for (const auto& frame : all_frames(source)) names.push_back(frame->name);
    return names;
  }
  void put(const std::string& name, const cv::Mat& picture) {
    ASSERT_TRUE(cv::imwrite(folder_ / name, picture)) << name;
  }
  void put_grey(const std::string& name, int value) { put(name, cv::Mat(4, 6, CV_8UC3, cv::Scalar::all(value))); }
  void cut(const std::string& name, std::size_t bytes) {
    auto content = test::read_bytes(folder_ / name);
    ASSERT_GT(content.size(), bytes);
    content.resize(bytes);
    test::write_bytes(folder_ / name, content);
  }

  test::TempFolder folder_;
  Registry registry_;
};

TEST_F(ImageFolderTest, PicturesComeInTheOrderOfTheirNumbers) {
  put_grey("img10.png", 10);
  put_grey("img2.png", 2);
  put_grey("img001.PNG", 1);
  put_grey("img0300.bmp", 3);
  const auto frames = all_frames(*open());
  ASSERT_EQ(frames.size(), 4u);
  const int expected[] = {1, 2, 10, 3};
  for (unsigned i = 0; i < 4; ++i) {
    EXPECT_EQ(frames[i]->bgr.at<cv::Vec3b>(0, 0)[0], expected[i]);
    EXPECT_EQ(frames[i]->sequence, i);
  }
}

TEST_F(ImageFolderTest, TimesAreTheIndexOverTheRate) {
  for (int i = 0; i < 4; ++i) put_grey("a" + std::to_string(i + 5) + ".png", i);
  EXPECT_EQ(open()->info().nominal_fps, 30);
  const auto frames = all_frames(*open("?fps=3"));
  EXPECT_EQ(frames[0]->device_time.count(), 0);
  EXPECT_EQ(frames[1]->device_time.count(), 333'333'333);
  EXPECT_EQ(frames[2]->device_time.count(), 666'666'667);
  EXPECT_EQ(frames[3]->device_time.count(), 1'000'000'000);
  EXPECT_EQ(all_frames(*open("?fps=0.01"))[3]->device_time, std::chrono::seconds(300));
  EXPECT_EQ(all_frames(*open("?fps=1000"))[3]->device_time, std::chrono::milliseconds(3));
  EXPECT_EQ(open("?fps=8")->info().duration, std::chrono::milliseconds(500));
}

TEST_F(ImageFolderTest, RatesOutOfRangeAndUnknownSettingsAreRefused) {
  put_grey("1.png", 1);
  for (const auto* bad : {"?fps=0", "?fps=1001", "?fps=fast", "?fsp=25", "?threads=2"}) {
    const auto error = error_of([&] { (void)open(bad); });
    ASSERT_TRUE(error) << bad;
    EXPECT_EQ(error->fault(), Fault::kUsage);
    EXPECT_FALSE(error->hint().empty());
  }
}

TEST_F(ImageFolderTest, EveryKindOfPictureIsRead) {
  const char* endings[] = {"png", "bmp", "ppm", "tif", "TIFF", "jpg", "JPEG", "webp"};
  for (const auto* ending : endings) {
    test::TempFolder folder;
    ASSERT_TRUE(cv::imwrite(folder / ("x1." + std::string(ending)), cv::Mat(16, 18, CV_8UC3, cv::Scalar::all(120))));
    const auto source = registry_.open(folder.path());
    EXPECT_EQ(source->info().size, cv::Size(18, 16)) << ending;
    EXPECT_TRUE(source->info().repeatable);
    EXPECT_NEAR(source->read({})->bgr.at<cv::Vec3b>(8, 8)[1], 120, 2) << ending;
    EXPECT_EQ(source->read({}), nullptr);
  }
}

TEST_F(ImageFolderTest, HiddenAndOtherFilesAreNotLookedAt) {
  put_grey("p1.png", 1);
  put_grey(".p2.png", 2);
  test::write_bytes(folder_ / "p3.txt", std::string("notes"));
  test::write_bytes(folder_ / "png", std::string("no ending"));
  ASSERT_EQ(::mkdir((folder_ / "p4.png").c_str(), 0700), 0);
  ASSERT_EQ(::mkfifo((folder_ / "p5.png").c_str(), 0600), 0);
  const auto source = open();
  EXPECT_EQ(all_frames(*source).size(), 1u);
  EXPECT_THAT(source->warnings(), IsEmpty());
}

TEST_F(ImageFolderTest, SeveralSeriesInOneFolderAreRefusedByName) {
  put_grey("left1.png", 1);
  put_grey("right1.png", 1);
  const auto error = error_of([&] { (void)open(); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_THAT(error->what(), HasSubstr("\"left#\", \"right#\""));
}

TEST_F(ImageFolderTest, AChangeOfSizeNamesTheFileAndBothSizes) {
  put_grey("a1.png", 1);
  put_grey("a2.png", 2);
  put("a3.png", cv::Mat::zeros(9, 8, CV_8UC3));
  put_grey("a4.png", 4);
  const auto source = open();
  EXPECT_NE(source->read({}), nullptr);
  EXPECT_NE(source->read({}), nullptr);
  const auto error = error_of([&] { (void)source->read({}); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kFailure);
  EXPECT_THAT(error->what(), HasSubstr("a3.png"));
  EXPECT_THAT(error->what(), HasSubstr("8x9"));
  EXPECT_THAT(error->what(), HasSubstr("6x4"));
  EXPECT_EQ(source->read({}), nullptr) << "after a failure the source has ended";
}

TEST_F(ImageFolderTest, DamagedPicturesAreLeftOutAndCountedOnce) {
  put_grey("a1.png", 1);
  for (const auto* name : {"a2.png", "a3.jpg", "a4.bmp", "a5.ppm", "a6.webp"}) {
    put(name, noise({6, 4}, CV_8UC3, 3));
    cut(name, test::read_bytes(folder_ / name).size() - 4);
  }
  test::write_bytes(folder_ / "a7.png", std::string("not a picture"));
  test::write_bytes(folder_ / "a8.png", std::string());
  put_grey("a9.png", 9);
  const auto source = open("?fps=10");
  const auto frames = all_frames(*source);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1]->bgr.at<cv::Vec3b>(0, 0)[0], 9);
  EXPECT_EQ(frames[1]->sequence, 8u) << "the gap is visible";
  EXPECT_EQ(frames[1]->device_time, std::chrono::milliseconds(800)) << "what is left out takes its time all the same";
  EXPECT_THAT(source->warnings(), ElementsAre(HasSubstr("7 of 9 pictures could not be read and were left out, "
                                                        "the first \"a2.png\"")));
}

TEST_F(ImageFolderTest, FoldersWithoutAReadablePictureAreRefused) {
  const auto none = error_of([&] { (void)open(); });
  ASSERT_TRUE(none);
  EXPECT_EQ(none->fault(), Fault::kUsage);
  EXPECT_THAT(none->what(), HasSubstr("holds no pictures"));
  test::write_bytes(folder_ / "a1.png", std::string("x"));
  const auto broken = error_of([&] { (void)open(); });
  ASSERT_TRUE(broken);
  EXPECT_THAT(broken->what(), HasSubstr("its one picture cannot be read"));
  const auto missing = error_of([&] { (void)registry_.open("folder://" + folder_.path() + "/none"); });
  ASSERT_TRUE(missing);
  EXPECT_THAT(missing->what(), HasSubstr("No such file or directory"));
}

TEST_F(ImageFolderTest, AFolderWithoutPermissionSaysSo) {
  put_grey("a1.png", 1);
  const auto root = ::geteuid() == 0;
  ASSERT_EQ(::chmod(folder_.path().c_str(), 0), 0);
  ASSERT_EQ(root ? ::seteuid(65534) : 0, 0);
  const auto error = error_of([&] { (void)open(); });
  ASSERT_EQ(root ? ::seteuid(0) : 0, 0);
  ASSERT_EQ(::chmod(folder_.path().c_str(), 0700), 0);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_THAT(error->what(), HasSubstr("Permission denied"));
}

TEST_F(ImageFolderTest, StoppingEndsReading) {
  put_grey("a1.png", 1);
  const auto source = open();
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(source->read(stop.get_token()), nullptr);
  EXPECT_NE(source->read({}), nullptr) << "and may go on";
}

TEST_F(ImageFolderTest, NamesThatDoNotCountMakeASetWhereSetsAreReadAndARefusalElsewhere) {
  put_grey("b.png", 2);
  put_grey("A.jpg", 1);
  put_grey("semaphore-c.png", 3);
  const auto error = error_of([&] { (void)open(); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_THAT(error->what(), HasSubstr("hold no numbers"));
  EXPECT_THAT(error->hint(), HasSubstr("analyze DIR --recognise semaphore"));
  const auto set = open_any();
  EXPECT_TRUE(set->info().stills);
  EXPECT_THAT(names_of(*set), ElementsAre("A.jpg", "b.png", "semaphore-c.png"));
}

TEST_F(ImageFolderTest, ASeriesIsASequenceUnlessItIsCalledASet) {
  put_grey("p10.png", 10);
  put_grey("p9.png", 9);
  EXPECT_FALSE(open()->info().stills);
  EXPECT_FALSE(open_any()->info().stills);
  const auto set = open_any("?stills=1");
  EXPECT_TRUE(set->info().stills);
  EXPECT_THAT(names_of(*set), ElementsAre("p9.png", "p10.png"));
  EXPECT_FALSE(open("?stills=0")->info().stills);
  const auto error = error_of([&] { (void)open("?stills=1"); });
  ASSERT_TRUE(error) << "nothing here reads sets";
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_TRUE(error_of([&] { (void)open_any("?stills=perhaps"); }));
}

TEST_F(ImageFolderTest, OnlyNamesThatCountOnMakeNumberedPicturesOfAFolder) {
  put_grey("p1.png", 1);
  put_grey("p2.png", 2);
  EXPECT_TRUE(open_any()->info().numbered_pictures);
  EXPECT_FALSE(open_any("?stills=1")->info().numbered_pictures);
  EXPECT_FALSE(open_any("?stills=0")->info().numbered_pictures) << "the user said that it is a sequence";
}

TEST_F(ImageFolderTest, SeveralSeriesAreTheWayToASetWhereNoneIsRead) {
  put_grey("left1.png", 1);
  put_grey("right1.png", 1);
  const auto error = error_of([&] { (void)open(); });
  ASSERT_TRUE(error);
  EXPECT_THAT(error->what(), HasSubstr("several numbered series"));
  EXPECT_THAT(error->hint(), HasSubstr("analyze DIR --recognise semaphore"));
}

TEST_F(ImageFolderTest, ASetCalledASequenceIsRefusedAsEver) {
  put_grey("left.png", 1);
  put_grey("right.png", 1);
  const auto error = error_of([&] { (void)open_any("?stills=0"); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->hint().find("--recognise"), std::string::npos) << "that is what is being done";
}

TEST_F(ImageFolderTest, OnePictureAloneIsASet) {
  put_grey("7.png", 1);
  EXPECT_TRUE(open_any()->info().stills);
  EXPECT_FALSE(open_any("?stills=0")->info().stills);
  EXPECT_FALSE(open()->info().stills);
}

TEST_F(ImageFolderTest, APicturesFileIsASetOfOneWhereSetsAreRead) {
  put_grey("7.png", 1);
  put_grey("8.png", 1);
  OpenOptions options;
  options.sets = true;
  const auto set = registry_.open(folder_ / "8.png", options);
  EXPECT_TRUE(set->info().stills);
  EXPECT_FALSE(set->info().numbered_pictures);
  EXPECT_THAT(names_of(*set), ElementsAre("8.png"));
  test::write_bytes(folder_ / "broken.png", std::string("not a picture"));
  EXPECT_THAT(error_of([&] { (void)registry_.open(folder_ / "broken.png", options); })->what(),
              HasSubstr("broken.png\": its one picture cannot be read"));
  EXPECT_TRUE(error_of([&] { (void)registry_.open(folder_ / "8.png?stills=0", options); }));
  EXPECT_TRUE(error_of([&] { (void)registry_.open(folder_ / "8.png"); }))
      << "a video's, and no driver of these is here";
}

TEST_F(ImageFolderTest, PicturesOfASetKeepTheirSizesAndUnreadableOnesAreLeftOut) {
  put("a.png", cv::Mat::zeros(4, 6, CV_8UC3));
  put("b.png", cv::Mat::zeros(9, 8, CV_8UC3));
  test::write_bytes(folder_ / "c.png", std::string("not a picture"));
  const auto set = open_any();
  EXPECT_EQ(set->info().size, cv::Size(6, 4));
  const auto frames = all_frames(*set);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1]->bgr.size(), cv::Size(8, 9));
  EXPECT_THAT(set->warnings(), ElementsAre(HasSubstr("the first \"c.png\"")));
}

TEST(NumberedNames, TheOrderOfASetIsTheAlphabetsWithNumbersByValue) {
  EXPECT_THAT(in_name_order({"c10.png", "B.png", "b.png", "c9.jpg", "A.png", "c009.png"}),
              ElementsAre("A.png", "B.png", "b.png", "c9.jpg", "c009.png", "c10.png"));
  EXPECT_THAT(in_name_order({}), IsEmpty());
}

TEST(NumberedNames, TheNumberThatChangesDecides) {
  EXPECT_THAT(in_number_order({"a10_640x480.png", "a9_640x480.png", "a0011_640x480.png"}, "f"),
              ElementsAre("a9_640x480.png", "a10_640x480.png", "a0011_640x480.png"));
  EXPECT_THAT(in_number_order({"99999999999999999999999.png", "0.png", "00100000000000000000000000.png"}, "f"),
              ElementsAre("0.png", "99999999999999999999999.png", "00100000000000000000000000.png"));
  EXPECT_THAT(in_number_order({"cover.png"}, "f"), ElementsAre("cover.png"));
  EXPECT_THAT(in_number_order({}, "f"), IsEmpty());
}

TEST(NumberedNames, AGuessIsRefused) {
  const std::vector<std::vector<std::string>> ambiguous = {
      {"cam1_0001.png", "cam2_0001.png", "cam2_0002.png"},  // Two numbers change.
      {"a1.png", "b2.png"},                                 // The text changes.
      {"a1.png", "cover.png"},                              // One has none.
      {"a1.png", "a01.png"},                                // The same number twice.
      {"a1.png", "a1.jpg"}};
  for (const auto& names : ambiguous) {
    const auto error = error_of([&] { (void)in_number_order(names, "pictures"); });
    ASSERT_TRUE(error) << names[0] << " " << names[1];
    EXPECT_EQ(error->fault(), Fault::kUsage);
    EXPECT_THAT(error->what(), HasSubstr("\"pictures\""));
  }
  EXPECT_THAT(error_of([&] { (void)in_number_order(ambiguous[0], "f"); })->what(), HasSubstr("\"cam1_#\", \"cam2_#\""));
}

TEST(NumberedNames, OnlyVisibleNamesWithAPicturesEndingCount) {
  for (const auto* name : {"a.png", "a.JPG", "a.b.Jpeg", "1.bmp", "x.tif", "x.tiff", "x.webp", "x.pgm", "x.ppm"}) {
    EXPECT_TRUE(is_picture_name(name)) << name;
  }
  for (const auto* name : {".a.png", "png", "a.png.txt", "a.gif", "a.", "", ".png"})
    EXPECT_FALSE(is_picture_name(name));
}

}  // namespace
}  // namespace choreo::devices
