// SPDX-License-Identifier: Apache-2.0
// Dumps of the first Kinect: what was written comes back, and what is damaged is told or refused.
#include "devices/kinect_dump/kinect_dump.hpp"

#include <sys/stat.h>

#include <filesystem>
#include <map>

#include <gmock/gmock.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "devices/fourcc.hpp"
#include "devices/kinect_fixture.hpp"
#include "support/small_files.hpp"
#include "support/temp_folder.hpp"

namespace choreo::devices {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::error_of;
using test::kinect_colour;
using test::kinect_words;
using test::kKinectPeriod;
using test::same_pixels;
using test::TempFolder;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class KinectDump : public ::testing::Test {
 protected:
  KinectDump() { registry_.add(kinect_dump_driver()); }

  std::unique_ptr<Source> open(const std::string& settings = "", bool keep_raw = false) {
    OpenOptions options;
    options.keep_raw = keep_raw;
    return registry_.open("kinect-dump:" + dump_ + settings, options);
  }
  // What opening says against it, with its hint; "opened" where it says nothing.
  std::string refused(const std::string& settings = "") {
    const auto error = error_of([&] { (void)open(settings); });
    if (!error) return "opened";
    EXPECT_EQ(error->fault(), Fault::kUsage);
    return std::string(error->what()) + " / " + error->hint();
  }
  void write(int frames) { test::write_kinect_dump(dump_, frames); }
  void write_index(const std::string& text) {
    fs::create_directories(dump_);
    test::write_bytes(dump_ + "/INDEX.txt", text);
  }
  std::string index() {
    const auto bytes = test::read_bytes(dump_ + "/INDEX.txt");
    return {bytes.begin(), bytes.end()};
  }
  // The names of the pictures, in the order of the index.
  std::vector<std::string> names() {
    std::vector<std::string> all;
    std::istringstream in(index());
    for (std::string line; std::getline(in, line);) all.push_back(line);
    return all;
  }
  void change_picture(std::size_t at, const std::function<void(test::Bytes&)>& change) {
    const auto path = dump_ + "/" + names().at(at);
    auto bytes = test::read_bytes(path);
    change(bytes);
    test::write_bytes(path, bytes);
  }

  TempFolder folder_;
  std::string dump_ = folder_ / "dump";
  Registry registry_;
};

TEST_F(KinectDump, GivesBackEveryPixelAndEveryWord) {
  write(4);
  const auto source = open("?depth=raw", true);
  EXPECT_EQ(source->info().size, cv::Size(640, 480));
  EXPECT_EQ(source->info().nominal_fps, 30);
  EXPECT_TRUE(source->info().repeatable);
  const auto frames = test::all_frames(*source);
  ASSERT_EQ(frames.size(), 4U);
  for (int k = 0; k < 4; ++k) {
    const auto& frame = *frames[static_cast<std::size_t>(k)];
    EXPECT_EQ(frame.sequence, static_cast<std::uint64_t>(k));
    EXPECT_EQ(frame.device_time, 100s + k * kKinectPeriod);
    EXPECT_TRUE(same_pixels(frame.bgr, kinect_colour(k)));
    EXPECT_TRUE(same_pixels(frame.depth, kinect_depth(kinect_words(k))));
    ASSERT_TRUE(frame.raw_depth);
    EXPECT_EQ(frame.raw_depth->fourcc, kKinectDepth);
    EXPECT_EQ(frame.raw_depth->size, cv::Size(640, 480));
    EXPECT_EQ(frame.raw_depth->bytes, kinect_words(k));
    EXPECT_FALSE(frame.raw_colour) << "bgr has every byte of it";
  }
  EXPECT_THAT(source->warnings(), IsEmpty());
}

TEST_F(KinectDump, DepthLiesOnTheColourUnlessToldOtherwise) {
  write(1);
  const auto own = open("?depth=raw")->read({});
  EXPECT_TRUE(same_pixels(open()->read({})->depth, kinect_registered(own->depth)));
  EXPECT_FALSE(own->raw_depth) << "nobody asked for it";
  const auto off = open("?depth=off")->read({});
  EXPECT_TRUE(off->depth.empty());
  EXPECT_TRUE(same_pixels(off->bgr, own->bgr));
}

TEST_F(KinectDump, MillimetresComeBackAsTheNearestThatTheWordsHave) {
  cv::Mat mm(kKinectSize, CV_16UC1);
  for (int y = 0; y < mm.rows; ++y) {
    for (int x = 0; x < mm.cols; ++x) mm.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>((y * 640 + x) % 6000);
  }
  {
    outputs::KinectDumpWriter writer(dump_);
    writer.write_colour(kinect_colour(0), 1s);
    writer.write_depth(mm, 1s);
  }
  const auto back = open("?depth=raw")->read({})->depth;
  for (int y = 0; y < mm.rows; y += 7) {
    for (int x = 0; x < mm.cols; ++x) {
      const int was = mm.at<std::uint16_t>(y, x);
      const int is = back.at<std::uint16_t>(y, x);
      if (was < 400) {
        ASSERT_EQ(is, 0) << was;
      } else {
        // Half a word's step, which grows as the square of the distance and is 52 mm at 6 m, and what is truncated.
        ASSERT_NEAR(is, was, 1 + 60.0 * was / 6000 * was / 6000) << was;
      }
    }
  }
}

TEST_F(KinectDump, AFolderWithSuchAnIndexIsTakenWithoutAScheme) {
  write(1);
  const auto source = registry_.open(dump_);
  EXPECT_EQ(source->info().size, cv::Size(640, 480));
  const auto claims = kinect_dump_driver().claims;
  EXPECT_TRUE(claims(dump_));
  EXPECT_FALSE(claims(folder_.path()));
  EXPECT_FALSE(claims(dump_ + "/INDEX.txt"));
  EXPECT_FALSE(claims("/dev/null"));
  write_index("a shopping list\n");
  EXPECT_FALSE(claims(dump_));
}

TEST_F(KinectDump, BothSpellingsOfTheSchemeMeanTheFolder) {
  write(1);
  EXPECT_NO_THROW((void)registry_.open("kinect-dump://" + dump_));
  EXPECT_EQ(registry_.open("kinect-dump:" + dump_)->info().duration, Nanoseconds{33'333'333});
}

TEST_F(KinectDump, PicturesArePairedWithTheNearestInTime) {
  {
    outputs::KinectDumpWriter writer(dump_);
    for (int k = 0; k < 4; ++k) writer.write_colour(kinect_colour(k), 100s + k * 33ms);
    writer.write_words(kinect_words(10), 100s - 10ms);  // Colour 0's, but 2 ms off is nearer:
    writer.write_words(kinect_words(11), 100s + 2ms);
    writer.write_words(kinect_words(12), 100s + 33ms + 16ms);  // Colour 1's: 16 ms and 17 ms.
    writer.write_words(kinect_words(13), 100s + 99ms - 1ms);   // Colour 3's; colour 2 has none.
  }
  const auto source = open("?depth=raw", true);
  const auto frames = test::all_frames(*source);
  ASSERT_EQ(frames.size(), 3U);
  const int expected_depth[] = {11, 12, 13};
  const std::uint64_t expected_colour[] = {0, 1, 3};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(frames[k]->sequence, expected_colour[k]) << "the gap shows";
    EXPECT_EQ(frames[k]->raw_depth->bytes, kinect_words(expected_depth[k]));
  }
  EXPECT_THAT(source->warnings(), ElementsAre(HasSubstr("1 colour picture without a depth picture of its time")));
}

TEST_F(KinectDump, ColourAloneIsADumpToo) {
  {
    outputs::KinectDumpWriter writer(dump_);
    for (int k = 0; k < 3; ++k) writer.write_colour(kinect_colour(k), 1s + k * kKinectPeriod);
  }
  const auto source = open();
  const auto frames = test::all_frames(*source);
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_TRUE(frames[2]->depth.empty());
  EXPECT_THAT(source->warnings(), IsEmpty());
}

TEST_F(KinectDump, WithoutColourOrWithoutOnePairItIsRefused) {
  {
    outputs::KinectDumpWriter writer(dump_);
    writer.write_words(kinect_words(0), 1s);
  }
  EXPECT_THAT(refused(), HasSubstr("names no colour picture"));
  write_index("");
  EXPECT_THAT(refused(), HasSubstr("names no colour picture"));
  write_index("r-1.0-0.ppm\nd-2.0-0.pgm\n");
  EXPECT_THAT(refused(), AllOf(HasSubstr("no colour picture has a depth picture"), HasSubstr("depth=off")));
}

TEST_F(KinectDump, AFolderWithoutIndexIsRefused) {
  EXPECT_THAT(refused(), HasSubstr("No such file"));
  fs::create_directories(dump_ + "/INDEX.txt");
  EXPECT_THAT(refused(), HasSubstr("not a file"));
}

TEST_F(KinectDump, AnIndexThatIsAPipeIsNotWaitedFor) {
  fs::create_directories(dump_);
  ASSERT_EQ(::mkfifo((dump_ + "/INDEX.txt").c_str(), 0600), 0);
  EXPECT_THAT(refused(), HasSubstr("not a file"));
}

TEST_F(KinectDump, NamesThatAreNoneAreRefusedWithTheirLine) {
  for (const std::string bad : {"r-1.0-0.ppm\r",
                                "../r-1.0-0.ppm",
                                "r-1.0-0./../../etc/passwd",
                                "r-1.0-0.ppm/x",
                                "/etc/passwd",
                                "r-1.0-0.",
                                "",
                                "r-1-0.ppm",
                                "r-1.-0.ppm",
                                "r-.5-0.ppm",
                                "r--1.0-0.ppm",
                                "r-nan-0.ppm",
                                "r-1e3.0-0.ppm",
                                "r-inf.0-0.ppm",
                                "r-1.0-.ppm",
                                "r-1.0-4294967296.ppm",
                                "r-1.0-99999999999999999999.ppm",
                                "r-4000000001.0-0.ppm",
                                "r-99999999999999999999.0-0.ppm",
                                "r-1.0000000001-0.ppm",
                                "x-1.0-0.ppm",
                                "R-1.0-0.PPM",
                                "r-1.0-0.ppm ",
                                " r-1.0-0.ppm",
                                "r-1.0-0.averylongone",
                                "r_1.0_0.ppm"}) {
    write_index("r-1.0-0.ppm\n" + bad + "\n");
    EXPECT_THAT(refused(), AllOf(HasSubstr("INDEX.txt:2: "), HasSubstr("is no picture of a Kinect's dump"),
                                 HasSubstr("r-1290450193.124921-3431872.ppm")))
        << bad;
  }
  write_index(std::string("r-1.0-0.ppm\0\n", 13));
  EXPECT_THAT(refused(), HasSubstr("INDEX.txt:1: "));
}

TEST_F(KinectDump, TimesThatAreDaysApartAreRefused) {
  write_index("r-1.0-0.ppm\nr-86402.0-0.ppm\n");
  EXPECT_THAT(refused(), AllOf(HasSubstr("INDEX.txt:2: "), HasSubstr("more than a day")));
  write_index("r-3999999999.0-0.ppm\nd-1.0-0.pgm\n");
  EXPECT_THAT(refused(), AllOf(HasSubstr("INDEX.txt:2: "), HasSubstr("more than a day")));
}

TEST_F(KinectDump, TimesThatGoBackAreLeftOutAndCounted) {
  write(3);
  const auto all = names();
  write_index(all[0] + "\n" + all[1] + "\n" + all[4] + "\n" + all[5] + "\n" + all[2] + "\n" + all[3] + "\n" + all[4] +
              "\n");
  const auto source = open();
  EXPECT_EQ(test::all_frames(*source).size(), 2U);
  EXPECT_THAT(source->warnings(), ElementsAre(HasSubstr("3 pictures whose time is not after")));
}

TEST_F(KinectDump, AccelerationIsNotLookedAt) {
  write(1);
  write_index("a-100.001-7.dump\n" + index());
  const auto source = open();
  EXPECT_EQ(test::all_frames(*source).size(), 1U);
  EXPECT_THAT(source->warnings(), IsEmpty());
}

TEST_F(KinectDump, PicturesThatCannotBeReadAreLeftOutAndTheFirstIsNamed) {
  const std::map<std::string, std::function<void(test::Bytes&)>> damages = {
      {"921614 bytes instead of 921615", [](test::Bytes& b) { b.pop_back(); }},
      {"921616 bytes instead of 921615", [](test::Bytes& b) { b.push_back(0); }},
      {"0 bytes instead of 921615", [](test::Bytes& b) { b.clear(); }},
      {"does not begin with \"P6 640 480 255\"", [](test::Bytes& b) { b[1] = '5'; }},
      {"does not begin with \"P6 640 480 255\" ", [](test::Bytes& b) { b[14] = '\r'; }}};
  for (const auto& [told, damage] : damages) {
    fs::remove_all(dump_);
    write(3);
    change_picture(2, damage);
    const auto source = open();
    const auto frames = test::all_frames(*source);
    ASSERT_EQ(frames.size(), 2U) << told;
    EXPECT_EQ(frames[1]->sequence, 2U);
    EXPECT_THAT(source->warnings(),
                ElementsAre(AllOf(HasSubstr("1 frame that could not be read"), HasSubstr(names()[2]),
                                  HasSubstr(told.substr(0, told.find_last_not_of(' ') + 1)))));
  }
}

TEST_F(KinectDump, AFrameWhoseDepthCannotBeReadIsLeftOut) {
  write(3);
  change_picture(1, [](test::Bytes& b) { b.resize(b.size() / 2); });
  fs::remove(dump_ + "/" + names()[3]);
  const auto source = open();
  const auto frames = test::all_frames(*source);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0]->sequence, 2U);
  EXPECT_THAT(source->warnings(), ElementsAre(AllOf(HasSubstr("2 frames that could not be read"),
                                                    HasSubstr("307208 bytes instead of 614417"))));
}

TEST_F(KinectDump, WithoutOnePictureThatCanBeReadItIsRefused) {
  write_index("r-1.0-0.ppm\nr-2.0-0.ppm\n");
  EXPECT_THAT(refused(),
              AllOf(HasSubstr("no picture that can be read"), HasSubstr("r-1.0-0.ppm"), HasSubstr("No such file")));
  fs::create_directory(dump_ + "/r-1.0-0.ppm");
  EXPECT_THAT(refused(), HasSubstr("not a file"));
}

TEST_F(KinectDump, APictureThatIsAPipeOrADeviceIsNotWaitedFor) {
  write_index("r-1.0-0.ppm\nr-2.0-0.ppm\n");
  ASSERT_EQ(::mkfifo((dump_ + "/r-1.0-0.ppm").c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", dump_ + "/r-2.0-0.ppm");
  EXPECT_THAT(refused(), HasSubstr("not a file"));
}

TEST_F(KinectDump, AnIndexCutAtAnyByteGivesTheGoodFramesOrIsRefused) {
  write(2);
  const auto whole = index();
  const auto lines = [](std::string_view text) { return std::count(text.begin(), text.end(), '\n'); };
  for (std::size_t n = 0; n <= whole.size(); ++n) {
    const auto text = whole.substr(0, n);
    write_index(text);
    const auto said = refused("?depth=off");
    if (lines(text) == 0) {
      EXPECT_THAT(said, HasSubstr("names no colour picture")) << n;
      continue;
    }
    ASSERT_EQ(said, "opened") << n;
    const auto source = open("?depth=off");
    EXPECT_EQ(test::all_frames(*source).size(), lines(text) >= 3 ? 2U : 1U) << n;
    if (text.back() == '\n') {
      EXPECT_THAT(source->warnings(), IsEmpty()) << n;
    } else {
      EXPECT_THAT(source->warnings(), ElementsAre(HasSubstr("cut off"))) << n;
    }
  }
}

TEST_F(KinectDump, AnyByteOfTheIndexMayBeWrong) {
  write(2);
  const auto whole = index();
  int refusals = 0;
  int frames = 0;
  for (std::size_t n = 0; n < whole.size(); ++n) {
    for (const unsigned char bit : {0x01, 0x10, 0x80}) {
      auto text = whole;
      text[n] = static_cast<char>(static_cast<unsigned char>(text[n]) ^ bit);
      write_index(text);
      if (const auto said = refused("?depth=off"); said != "opened") {
        ++refusals;
        continue;
      }
      const auto source = open("?depth=off");
      Nanoseconds last{-1};
      for (const auto& frame : test::all_frames(*source)) {
        EXPECT_GT(frame->device_time, last);
        EXPECT_EQ(frame->bgr.size(), cv::Size(640, 480));
        last = frame->device_time;
        ++frames;
      }
    }
  }
  EXPECT_GT(refusals, 0);
  EXPECT_GT(frames, 0);
}

TEST_F(KinectDump, AnyByteOfAPicturesHeaderMayBeWrong) {
  write(2);
  for (std::size_t n = 0; n < 15; ++n) {
    change_picture(0, [&](test::Bytes& b) { b[n] ^= 0x20; });
    const auto source = open("?depth=off");
    const auto frames = test::all_frames(*source);
    ASSERT_EQ(frames.size(), 1U) << n;
    EXPECT_TRUE(same_pixels(frames[0]->bgr, kinect_colour(1)));
    change_picture(0, [&](test::Bytes& b) { b[n] ^= 0x20; });
  }
}

TEST_F(KinectDump, RefusesSettingsThatCannotBe) {
  write(1);
  EXPECT_THAT(refused("?depth=near"), HasSubstr("registered, raw, off"));
  EXPECT_THAT(refused("?dept=raw"), HasSubstr("did you mean \"depth\""));
}

TEST_F(KinectDump, ReadingStopsWhenItIsToldTo) {
  write(2);
  const auto source = open();
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(source->read(stop.get_token()), nullptr);
  EXPECT_NE(source->read({}), nullptr) << "and nothing was lost";
}

class KinectDumpWriter : public KinectDump {};

TEST_F(KinectDumpWriter, WritesWhatFakenectReads) {
  {
    outputs::KinectDumpWriter writer(dump_);
    writer.write_colour(cv::Mat(480, 640, CV_8UC3, cv::Scalar(1, 2, 3)), 1290450193s + 124921us);
    writer.write_depth(cv::Mat(480, 640, CV_16UC1, cv::Scalar(1193)), 71s + 582'788'267ns);
  }
  // 1290450193.124921 s * 60 MHz = 77427011587495260 = 4054930780 modulo 2^32; 71.582788267 s is when they wrap.
  EXPECT_EQ(index(), "r-1290450193.124921000-4054930780.ppm\nd-71.582788267-0.pgm\n");
  const auto colour = test::read_bytes(dump_ + "/" + names()[0]);
  ASSERT_EQ(colour.size(), 15U + 640 * 480 * 3);
  EXPECT_EQ(std::string(colour.begin(), colour.begin() + 18), "P6 640 480 255\n\x03\x02\x01") << "red comes first";
  const auto depth = test::read_bytes(dump_ + "/" + names()[1]);
  ASSERT_EQ(depth.size(), 17U + 640 * 480 * 2);
  EXPECT_EQ(std::string(depth.begin(), depth.begin() + 19), "P5 640 480 65535\n\x20\x03") << "800, the low byte first";
}

TEST_F(KinectDumpWriter, RefusesOtherSizesAndTypes) {
  outputs::KinectDumpWriter writer(dump_);
  const auto fault = [](auto action) {
    const auto error = error_of(action);
    return error ? std::optional(error->fault()) : std::nullopt;
  };
  EXPECT_EQ(fault([&] { writer.write_colour(cv::Mat(), 1s); }), Fault::kFailure);
  EXPECT_EQ(fault([&] { writer.write_colour(cv::Mat::zeros(240, 320, CV_8UC3), 1s); }), Fault::kFailure);
  EXPECT_EQ(fault([&] { writer.write_colour(cv::Mat::zeros(480, 640, CV_8UC1), 1s); }), Fault::kFailure);
  EXPECT_EQ(fault([&] { writer.write_depth(cv::Mat::zeros(480, 640, CV_8UC1), 1s); }), Fault::kFailure);
  EXPECT_EQ(fault([&] { writer.write_words(std::vector<std::uint8_t>(614401), 1s); }), Fault::kFailure);
  EXPECT_EQ(index(), "");
}

TEST_F(KinectDumpWriter, RefusesTimesThatDoNotIncreaseInAStream) {
  outputs::KinectDumpWriter writer(dump_);
  writer.write_colour(kinect_colour(0), 5s);
  EXPECT_TRUE(error_of([&] { writer.write_colour(kinect_colour(1), 5s); }));
  EXPECT_TRUE(error_of([&] { writer.write_colour(kinect_colour(1), 4s); }));
  EXPECT_TRUE(error_of([&] { writer.write_colour(kinect_colour(1), 4'000'000'000s); }));
  EXPECT_TRUE(error_of([&] { writer.write_words(kinect_words(0), -1ns); }));
  EXPECT_NO_THROW(writer.write_words(kinect_words(0), 0ns)) << "the streams are independent";
  EXPECT_NO_THROW(writer.write_colour(kinect_colour(1), 6s));
}

TEST_F(KinectDumpWriter, LeavesAFolderWithSomethingInItAlone) {
  write(1);
  const auto before = index();
  const auto error = error_of([&] { outputs::KinectDumpWriter again(dump_); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_THAT(error->what(), HasSubstr("not empty"));
  EXPECT_EQ(index(), before);
  EXPECT_TRUE(error_of([&] { outputs::KinectDumpWriter below(dump_ + "/INDEX.txt"); }));
}

TEST_F(KinectDumpWriter, OnAFullDiskWhatWasWrittenStaysGood) {
  {
    outputs::KinectDumpWriter writer(dump_);
    writer.write_colour(kinect_colour(0), 1s);
    const test::SmallFiles full(100'000);
    const auto error = error_of([&] { writer.write_colour(kinect_colour(1), 2s); });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->fault(), Fault::kFailure);
  }
  const auto source = open();
  EXPECT_EQ(test::all_frames(*source).size(), 1U);
  EXPECT_THAT(source->warnings(), IsEmpty());
  EXPECT_EQ(std::distance(fs::directory_iterator(dump_), {}), 2) << "no half a picture is left";
}

}  // namespace
}  // namespace choreo::devices
