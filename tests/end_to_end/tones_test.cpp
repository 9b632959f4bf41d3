// SPDX-License-Identifier: Apache-2.0
// choreoscope tones: from labelled pixels to a file that is tested and shown, and what it refuses.
#include <gmock/gmock.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "end_to_end/choreoscope_run.hpp"
#include "support/places.hpp"

namespace choreo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class Tones : public ::testing::Test {
 protected:
  // Skin as in UCI's samples, and bluish others.
  static std::string samples(const std::string& header = {}) {
    std::string csv = header;
    for (int i = 0; i < 200; ++i) {
      csv +=
          std::to_string(120 + i % 9) + "," + std::to_string(150 + i % 7) + "," + std::to_string(210 + i % 11) + ",1\n";
      csv +=
          std::to_string(150 + i % 50) + "," + std::to_string(90 + i % 40) + "," + std::to_string(60 + i % 30) + ",2\n";
    }
    return csv;
  }
  std::string file(const std::string& name, const std::string& bytes) {
    write_bytes(folder_ / name, bytes);
    return folder_ / name;
  }
  std::string refused(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "tones");
    const auto run = choreoscope(arguments);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out.toml"));
    return complaint_of(run, 2);
  }
  std::string refused_training(const std::string& csv, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"train", file("bad.csv", csv), "--name", "skin", "--out", folder_ / "out.toml"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return refused(arguments);
  }
  TempFolder folder_;
};

TEST_F(Tones, AreTrainedFromACsvTestedAndShown) {
  const auto csv = file("samples.csv", samples());
  for (const auto* model : {"gaussian", "histogram"}) {
    const auto out = folder_ / "skin.toml";
    const auto run =
        choreoscope({"tones", "train", csv, "--name", "skin", "--model", model, "--others", "other", "-o", out});
    EXPECT_EQ(run.status, 0) << run.told();
    EXPECT_THAT(run.out, HasSubstr("200 pixels"));
    const auto test = choreoscope({"tones", "test", out, csv});
    EXPECT_EQ(test.status, 0) << test.told();
    EXPECT_THAT(test.out, AllOf(HasSubstr("200 of 400 pixels"), HasSubstr("f1 1.0000")));
    const auto show = choreoscope({"tones", "show", out});
    EXPECT_EQ(show.status, 0) << show.told();
    EXPECT_THAT(show.out, AllOf(HasSubstr("skin: prior"), HasSubstr(model), HasSubstr("other: prior")));
  }
}

TEST_F(Tones, AreTrainedFromAPictureWithAMaskAndMerged) {
  cv::Mat picture(60, 80, CV_8UC3, cv::Scalar(90, 140, 100));
  cv::Mat mask = cv::Mat::zeros(60, 80, CV_8UC1);
  picture(cv::Rect(10, 10, 20, 20)) = cv::Scalar(30, 30, 210);
  picture(cv::Rect(30, 10, 20, 20)) = cv::Scalar(20, 200, 230);
  mask(cv::Rect(10, 10, 40, 20)) = 255;
  cv::imwrite(folder_ / "p.png", picture);
  cv::imwrite(folder_ / "m.png", mask);
  const auto csv = file("samples.csv", samples());
  EXPECT_EQ(choreoscope({"tones", "train", csv, "--name", "skin", "-o", folder_ / "my.toml"}).status, 0);
  const auto run = choreoscope({"tones", "train", "--picture", folder_ / "p.png", "--mask", folder_ / "m.png", "--name",
                                "flag", "--parts", "2", "--merge", folder_ / "my.toml", "-o", folder_ / "my.toml"});
  EXPECT_EQ(run.status, 0) << run.told();
  const auto show = choreoscope({"tones", "show", folder_ / "my.toml"});
  EXPECT_THAT(show.out, AllOf(HasSubstr("skin: prior"), HasSubstr("flag: prior"), HasSubstr("weight 0.50")));
  EXPECT_EQ(files_in(folder_.path()), (std::set<std::string>{"p.png", "m.png", "samples.csv", "my.toml"}));
}

TEST_F(Tones, BadSamplesAreRefusedByLine) {
  EXPECT_THAT(refused_training("1,2,3,1\n4,5,nan,2\n"), HasSubstr("bad.csv:2: \"nan\""));
  EXPECT_THAT(refused_training("1,2,3,1\n4,5,300,2\n"), HasSubstr("bad.csv:2: \"300\""));
  EXPECT_THAT(refused_training("1,2,3,1\n4,5,2\n"), HasSubstr("bad.csv:2: 3 columns"));
  EXPECT_THAT(refused_training(""), HasSubstr("no colour"));
  EXPECT_THAT(refused_training("1,2,3,1\n4,5,6,1\n"), HasSubstr("one class"));
  EXPECT_THAT(refused_training("1,2,3,1\n4,5,6,2\n"), HasSubstr("too few pixels"));
  EXPECT_THAT(refused_training(samples(), {"--label", "7"}), HasSubstr("one class"));
  EXPECT_THAT(refused_training(samples(), {"--model", "gausian"}), HasSubstr("\"gausian\""));
}

TEST_F(Tones, TheHelpNamesTheChoices) {
  EXPECT_THAT(choreoscope({"tones", "train", "--help"}).out,
              AllOf(HasSubstr("MODEL:{gaussian,histogram}"), HasSubstr("ROWS:{all,first,second}")));
}

TEST_F(Tones, MorePartsThanTheColoursFallIntoAreRefusedByPart) {
  std::string two;
  for (int i = 0; i < 300; ++i) two += i % 2 == 0 ? "30,30,210,1\n" : "20,200,230,1\n";
  for (const auto* model : {"gaussian", "histogram"}) {
    EXPECT_THAT(refused_training(two + "9,9,9,2\n", {"--parts", "3", "--model", model}),
                AllOf(HasSubstr("bad.csv"), HasSubstr("part 3 of 3 is of 0 of the 300 pixels")));
  }
  EXPECT_THAT(refused_training("30,30,210,1\n20,20,200,1\n9,9,9,2\n", {"--parts", "3"}),
              HasSubstr("too few pixels for a tone of 3 parts: 2"));
}

TEST_F(Tones, AHalfWithoutARowIsSaidToBeThat) {
  EXPECT_THAT(refused_training(samples(), {"--half", "second"}),
              HasSubstr("none of the 400 rows is of the second half"));
}

TEST_F(Tones, NamesThatNoFileCouldHoldAreRefused) {
  const auto csv = file("samples.csv", samples());
  const std::string latin = "gr\xfcn";
  EXPECT_THAT(refused({"train", csv, "--name", latin, "-o", folder_ / "out.toml"}),
              AllOf(HasSubstr("--name \"gr\\xfcn\""), HasSubstr("UTF-8")));
  EXPECT_THAT(refused({"train", csv, "--name", "skin", "--others", latin, "-o", folder_ / "out.toml"}),
              HasSubstr("--others \"gr\\xfcn\""));
  const auto out = folder_ / "green.toml";
  EXPECT_EQ(choreoscope({"tones", "train", csv, "--name", "gr\xc3\xbcn", "-o", out}).status, 0);
  EXPECT_THAT(choreoscope({"tones", "show", out}).out, HasSubstr("gr\xc3\xbcn: prior"));
}

// A shell that is given the first line makes the same file.
TEST_F(Tones, TheFirstLineOfAFileSaysHowItIsMadeAgain) {
  const auto csv = file("my samples.csv", samples());
  EXPECT_EQ(choreoscope({"tones", "train", csv, "--name", "glove", "-o", folder_ / "glove.toml"}).status, 0);
  EXPECT_EQ(choreoscope({"tones", "train", csv, "--name", "it's", "--label", "2", "--prior", "0.7", "--outliers",
                         "0.25", "--noise", "3.5", "--half", "first", "--merge", folder_ / "glove.toml", "-o",
                         folder_ / "first.toml"})
                .status,
            0);
  const auto bytes = read_bytes(folder_ / "first.toml");
  const std::string text(bytes.begin(), bytes.end());
  const std::string begin = "# Made by choreoscope ";
  ASSERT_THAT(text, StartsWith(begin));
  const auto line = text.substr(begin.size(), text.find('\n') - begin.size());
  const auto again =
      run_program("/bin/sh", {"-c", program() + " " + line + " -o '" + std::string(folder_ / "again.toml") + "'"});
  ASSERT_EQ(again.status, 0) << again.told();
  EXPECT_EQ(read_bytes(folder_ / "again.toml"), bytes);
}

// As the samples of the University of California have it.
TEST_F(Tones, ColumnsThatAreCalledWhatTheyAreNotAreNoticed) {
  EXPECT_THAT(refused_training(samples("r,g,b,skin\n")), HasSubstr("bluer than red"));
  const auto csv = file("samples.csv", samples("r,g,b,skin\n"));
  EXPECT_EQ(choreoscope({"tones", "train", csv, "--columns", "B,G,R,label", "--name", "skin", "-o", folder_ / "s.toml"})
                .status,
            0);
}

TEST_F(Tones, FilesThatAreNoneAreRefused) {
  const auto csv = file("samples.csv", samples());
  const auto none = file("none.toml", "[mask]\nsteps = 1\n");
  EXPECT_THAT(refused({"show", none}), HasSubstr("is no tones file"));
  EXPECT_THAT(refused({"test", none, csv}), HasSubstr("is no tones file"));
  EXPECT_THAT(refused({"train", csv, "--name", "skin", "--merge", none, "-o", folder_ / "out.toml"}),
              HasSubstr("is no tones file"));
  EXPECT_THAT(refused({"show", folder_ / "nowhere.toml"}), HasSubstr("no such tones file"));
  EXPECT_EQ(choreoscope({"tones", "train", csv, "--name", "hat", "-o", folder_ / "s.toml"}).status, 0);
  EXPECT_THAT(refused({"test", folder_ / "s.toml", csv}), HasSubstr("holds no tone \"skin\""));
}

TEST_F(Tones, PicturesThatDoNotGoTogetherAreRefused) {
  const auto train = [&](const std::string& picture, const std::string& mask) {
    return refused({"train", "--picture", folder_ / picture, "--mask", folder_ / mask, "--name", "flag", "-o",
                    folder_ / "out.toml"});
  };
  cv::imwrite(folder_ / "red.png", cv::Mat(20, 20, CV_8UC3, cv::Scalar(0, 0, 200)));
  cv::imwrite(folder_ / "grey.png", cv::Mat(20, 20, CV_8UC1, cv::Scalar(90)));
  cv::imwrite(folder_ / "small.png", cv::Mat(10, 20, CV_8UC1, cv::Scalar(255)));
  cv::imwrite(folder_ / "white.png", cv::Mat(20, 20, CV_8UC1, cv::Scalar(255)));
  cv::imwrite(folder_ / "black.png", cv::Mat(20, 20, CV_8UC1, cv::Scalar(0)));
  EXPECT_THAT(train("red.png", "small.png"), HasSubstr("20 x 10 pixels"));
  EXPECT_THAT(train("red.png", "white.png"), HasSubstr("one class"));
  EXPECT_THAT(train("red.png", "black.png"), HasSubstr("too few pixels for a tone: 0"));
  EXPECT_THAT(train("grey.png", "black.png"), HasSubstr("tones need colour"));
  EXPECT_THAT(train("red.png", "nowhere.png"), HasSubstr("no picture that can be read"));
  // Not read: a file of such a size without a byte on the disk.
  write_bytes(folder_ / "large.png", std::string());
  std::filesystem::resize_file(folder_ / "large.png", std::uintmax_t{10} << 30U);
  EXPECT_THAT(train("red.png", "large.png"),
              HasSubstr("the mask \"" + std::string(folder_ / "large.png") + "\" is larger"));
  EXPECT_THAT(train("large.png", "red.png"), HasSubstr("no picture"));
  EXPECT_THAT(refused({"train", "--picture", folder_ / "red.png", "--name", "x", "-o", folder_ / "out.toml"}),
              HasSubstr("needs a mask"));
  EXPECT_THAT(refused({"train", "--name", "x", "-o", folder_ / "out.toml"}), HasSubstr("a CSV, or a picture"));
}

}  // namespace
}  // namespace choreo::test
