// SPDX-License-Identifier: Apache-2.0
// Runs of the built program that look at faces and arms: what they write, that live equals the batch, what they refuse.
#include <fstream>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "devices/synthetic/performer.hpp"
#include "end_to_end/refusal_fixture.hpp"
#include "support/places.hpp"

namespace choreo::test {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::Not;

class Semaphore : public RefusalTest {
 protected:
  // Who says one letter, in a room that is empty for a second first.
  static constexpr auto kSays = "synthetic://semaphore?text=RU&fps=10&seed=5&skin=light&size=480x360";

  [[nodiscard]] std::string out() const { return folder_ / "out"; }

  static nlohmann::json json_of(const std::string& path) {
    const auto text = read_bytes(path);
    return nlohmann::json::parse(text.begin(), text.end());
  }

  // Reads a set into `out()`.
  [[nodiscard]] std::string read_bytes_of_set(const std::string& set) const {
    analyze(set, out(), {"--recognise", "semaphore"});
    const auto bytes = read_bytes(out() + "/letters.json");
    return {bytes.begin(), bytes.end()};
  }

  // Alphabets are read elsewhere: three pictures show how.
  // @param numbered  they are called as cameras call them: DSC_0101.png, DSC_0102.png, ...
  void film_pictures(const std::string& letters, bool numbered = false) {
    int number = 101;
    for (const char letter : letters) {
      devices::synthetic::PerformerSettings settings;
      settings.text = std::string(1, letter);
      settings.size = {480, 360};
      settings.seed = 4;
      settings.skin = "light";
      const devices::synthetic::Performer performer("semaphore", settings);
      const auto held = performer.first_frame() + int(2.2 * settings.fps);
      const auto name = numbered ? "DSC_0" + std::to_string(number++) : std::string(1, letter) + "_";
      cv::imwrite(folder_ / "pictures" + "/" + name + ".png", performer.perform(held).bgr);
      if (!numbered) cv::imwrite(folder_ / "wall.png", performer.perform(0).bgr);
    }
  }
};

TEST_F(Semaphore, TheBundledClipIsSpelled) {
  const auto run = analyze(project_file("recordings/semaphore-dance.mp4"), out(), {"--recognise", "semaphore"});
  EXPECT_TRUE(run.out.ends_with("\nDANCE\n")) << run.out;
  const auto json = json_of(out() + "/letters.json");
  EXPECT_EQ(json["text"], "DANCE");
  std::string letters;
  double before = 0;
  for (const auto& letter : json["letters"]) {
    letters += letter["letter"].get<std::string>();
    EXPECT_LT(before, letter["from"].get<double>());
    EXPECT_LT(letter["from"].get<double>(), letter["to"].get<double>());
    before = letter["to"];
  }
  EXPECT_EQ(letters, "DANCE");
}

TEST_F(Semaphore, ParticlesAreComparedWrittenAndTheSameLive) {
  analyze(kSays, out(),
          {"--state", "particles", "--save", "particles", "--set", "working.rows=360", "--background", "first:1s",
           "--threads", "1"});
  const Results results(out());
  // A second of nobody, then somebody who stands with both arms in sight once the face is known.
  EXPECT_TRUE(std::isnan(results.Z(0, 0)));
  const auto last = results.n - 1;
  EXPECT_EQ(results.Z(last, last), 1);
  EXPECT_GT(results.Zstar(last, last), 0.98) << "REST is its own mirror image";
  EXPECT_EQ(json_of(out() + "/summary.json")["state"], "particles");
  std::ifstream csv(out() + "/particles.csv");
  std::string line;
  std::size_t rows = 0;
  std::size_t with_arms = 0;
  while (std::getline(csv, line)) {
    ++rows;
    with_arms += line.find(",two_arms,") != std::string::npos ? 1 : 0;
  }
  EXPECT_EQ(rows, results.n + 1);
  EXPECT_GT(with_arms, results.n / 2);

  const auto live_out = folder_ / "live";
  const auto live = choreoscope({"live", kSays, "--headless", "--pace", "max", "--state", "particles", "--background",
                                 "first:1s", "--out", live_out});
  ASSERT_EQ(live.status, 0) << live.told();
  for (const auto* name : {"z.npy", "zstar.npy", "times.npy", "plot.png"}) {
    EXPECT_TRUE(read_bytes(out() + "/" + name) == read_bytes(live_out + "/" + name)) << name;
  }
}

TEST_F(Semaphore, LiveSpellsAndWritesTheLetters) {
  const auto run = choreoscope({"live", kSays, "--headless", "--pace", "max", "--recognise", "semaphore",
                                "--background", "first:1s", "--out", out()});
  ASSERT_EQ(run.status, 0) << run.told();
  EXPECT_TRUE(run.out.ends_with("\nRU\n")) << run.told();
  EXPECT_EQ(json_of(out() + "/letters.json")["text"], "RU");
  // Without a window every letter has its line, while the run goes on.
  EXPECT_THAT(run.err, AllOf(Not(HasSubstr("signs are read from ")), Not(HasSubstr("no letter was read"))));
  EXPECT_THAT(run.out, ContainsRegex("s: R .*\n.*s: U .*\n(.*\n)*RU\n"));
}

// Memory does not grow with the run, so what the files have is of the history. What is told is told at once.
TEST_F(Semaphore, LiveForgetsLettersThatAreOlderThanItsHistoryAndSaysSo) {
  const auto run = choreoscope({"live", kSays, "--headless", "--pace", "max", "--recognise", "semaphore",
                                "--background", "first:1s", "--history", "3s", "--out", out()});
  ASSERT_EQ(run.status, 0) << run.told();
  EXPECT_THAT(run.out, ContainsRegex("s: R .*\n.*s: U .*\n(.*\n)*[.][.][.]U\n")) << run.told();
  const auto json = json_of(out() + "/letters.json");
  EXPECT_EQ(json["text"], "U");
  ASSERT_EQ(json["letters"].size(), 1U);
  EXPECT_EQ(json["letters"][0]["letter"], "U");
  EXPECT_GE(json["letters"][0]["to"].get<double>(), json["since"].get<double>());
}

// The face comes into sight late: no sign before was read, which is said; and where none was at all, too.
TEST_F(Semaphore, WhenReadingBeganAndThatNothingWasReadIsSaid) {
  const auto said = [&](const std::string& source, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"--recognise", "semaphore"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return analyze(source, out(), arguments).err;
  };
  EXPECT_THAT(said(kSays, {"--set", "face.lost_frames=20"}), HasSubstr("signs are read from "));
  EXPECT_THAT(said(kSays, {"--span", "0:1.5"}), HasSubstr("no letter was read"));
}

TEST_F(Semaphore, ASetOfPicturesHasALetterEach) {
  std::filesystem::create_directory(folder_ / "pictures");
  film_pictures("RUN");
  const auto run = analyze(folder_ / "pictures", out(), {"--recognise", "semaphore"});
  const auto json = json_of(out() + "/letters.json");
  std::vector<std::string> read;
  for (const auto& picture : json["pictures"])
    read.push_back(picture["file"].get<std::string>() + picture["letter"].dump());
  EXPECT_THAT(read, ElementsAre("N_.png\"N\"", "R_.png\"R\"", "U_.png\"U\""));
  EXPECT_THAT(files_in(out()), IsSupersetOf({"letters.json", "pictures.png"}));
}

TEST_F(Semaphore, NumberedPhotographsOfWhichNothingIsReadAreToldHowToBeASet) {
  std::filesystem::create_directory(folder_ / "pictures");
  film_pictures("RUN", true);
  const auto film = analyze(folder_ / "pictures", out(), {"--recognise", "semaphore"});
  EXPECT_THAT(film.err_lines("choreoscope: warning: "),
              Contains(AllOf(HasSubstr("no letter was read"), HasSubstr("append ?stills=1"))));
  EXPECT_NE(json_of(out() + "/summary.json")["warnings"].dump().find("?stills=1"), std::string::npos);
  const auto slow = analyze(folder_ / "pictures" + "?fps=2", out(), {"--recognise", "semaphore"});
  EXPECT_THAT(slow.err_lines("choreoscope: warning: "), Contains(HasSubstr("append &stills=1")));
  for (const auto* said : {"?stills=1", "?stills=0"}) {
    const auto run = analyze(folder_ / "pictures" + said, out(), {"--recognise", "semaphore"});
    EXPECT_EQ(run.err.find("append"), std::string::npos) << said << run.err;
  }
  EXPECT_EQ(analyze(folder_ / "pictures", out()).err.find("stills"), std::string::npos) << "nothing is to be read";
}

TEST_F(Semaphore, APictureWithoutALetterSaysWhy) {
  std::filesystem::create_directory(folder_ / "pictures");
  film_pictures("RUN");
  std::filesystem::copy_file(folder_ / "wall.png", folder_ / "pictures" + "/wall.png");
  const auto run = analyze(folder_ / "pictures", out(), {"--recognise", "semaphore"});
  EXPECT_TRUE(
      run.out.starts_with("3 of 4 pictures show a sign: N R U -\n"
                          "wall.png: no letter, no face (confidence 0.000)\n"))
      << run.out;
  EXPECT_THAT(run.err_lines("choreoscope: warning: "), Contains(HasSubstr("no face was found in 1 of 4 pictures")));
  const auto wall = json_of(out() + "/letters.json")["pictures"][3];
  EXPECT_TRUE(wall["letter"].is_null());
  EXPECT_EQ(wall["confidence"], 0) << "nothing can be told";
}

TEST_F(Semaphore, OnePictureIsNoFilmAndIsToldWhereItIsRead) {
  std::filesystem::create_directory(folder_ / "pictures");
  film_pictures("R");
  const auto picture = folder_ / "pictures" + "/R_.png";
  for (const auto& source : {picture, folder_ / "pictures"}) {
    const auto run = analyze(source, out());
    EXPECT_THAT(run.err_lines("choreoscope: warning: "),
                Contains(AllOf(HasSubstr("only one frame"), HasSubstr("analyze PICTURE --recognise semaphore"))))
        << source;
  }
  const auto run = choreoscope({"calibrate", picture, "-o", folder_ / "bounds.toml"});
  EXPECT_THAT(complaint_of(run, 2), HasSubstr("one picture"));
  EXPECT_THAT(hint_of(run), HasSubstr("analyze PICTURE --recognise semaphore"));
  const auto live = choreoscope({"live", picture, "--headless"});
  EXPECT_EQ(live.status, 0) << live.told();
  EXPECT_THAT(live.err, AllOf(HasSubstr("\n1 frame in "), HasSubstr("analyze PICTURE --recognise semaphore")));
  const auto film = analyze(kQuick, out(), {"--span", "1f:1f"});
  EXPECT_THAT(film.err_lines("choreoscope: warning: "), Contains(::testing::EndsWith("nothing to compare it with")));
}

TEST_F(Semaphore, APicturesFileIsReadLikeAFolderOfIt) {
  std::filesystem::create_directory(folder_ / "pictures");
  film_pictures("R");
  const auto folder = read_bytes_of_set(folder_ / "pictures");
  film_pictures("U");
  EXPECT_EQ(read_bytes_of_set(folder_ / "pictures" + "/R_.png"), folder);
  EXPECT_THAT(folder, HasSubstr(R"({"file": "R_.png", "letter": "R",)"));
}

TEST_F(Semaphore, FlagsWithoutTheirToneAreToldWhereItComesFrom) {
  const auto run = choreoscope({"analyze", kSays, "--out", out(), "--recognise", "semaphore", "--config", "flags"});
  EXPECT_THAT(complaint_of(run, 2), AllOf(HasSubstr("tones.arms"), HasSubstr("\"flag\"")));
  EXPECT_THAT(hint_of(run), AllOf(HasSubstr("choreoscope tones train"), HasSubstr("--name flag"),
                                  HasSubstr("--set tones.file=FILE")));
  const auto mistyped =
      choreoscope({"analyze", kSays, "--out", out(), "--recognise", "semaphore", "--set", "tones.arms=[\"skni\"]"});
  EXPECT_THAT(complaint_of(mistyped, 2), HasSubstr("skni"));
  EXPECT_EQ(hint_of(mistyped), "did you mean \"skin\"?");
}

TEST_F(Semaphore, ASetAndASequenceInOneFolderLeaveNothingOfEachOther) {
  std::filesystem::create_directory(folder_ / "pictures");
  film_pictures("RU");
  const auto set = folder_ / "pictures" + "?stills=1";
  const std::string letters = read_bytes_of_set(set);
  analyze(kQuick, out(), {"--save", "masks"});
  auto names = files_in(out());
  EXPECT_EQ(names.count("pictures.png") + names.count("letters.json"), 0U) << ::testing::PrintToString(names);
  EXPECT_EQ(read_bytes_of_set(set), letters);
  EXPECT_THAT(files_in(out()), ::testing::UnorderedElementsAre("letters.json", "pictures.png"));
}

TEST_F(Semaphore, WhatMeansNothingForASetIsRefused) {
  std::filesystem::create_directory(folder_ / "pictures");
  film_pictures("R");
  const std::vector<std::vector<std::string>> meaningless = {{"--save", "particles"},  {"--save", "masks"},
                                                             {"--state", "particles"}, {"--span", "0:1"},
                                                             {"--every", "2"},         {"--background", "first:1s"}};
  for (const auto& option : meaningless) {
    const auto complaint = refused(folder_ / "pictures", {"--recognise", "semaphore", option[0], option[1]});
    EXPECT_THAT(complaint, AllOf(HasSubstr(option[0]), HasSubstr("set of pictures")));
  }
}

// Forty thousand names of one file.
TEST_F(Semaphore, ASetThatTheMemoryCannotHoldIsRefusedBeforeItIsRead) {
  const auto many = folder_ / "many";
  std::filesystem::create_directory(many);
  ASSERT_TRUE(cv::imwrite(many + "/a.png", cv::Mat(800, 800, CV_8UC3, cv::Scalar(90, 120, 150))));
  for (int k = 0; k < 40'000; ++k)
    std::filesystem::create_hard_link(many + "/a.png", many + "/b" + std::to_string(k) + ".png");
  const auto run = choreoscope({"analyze", many + "?stills=1", "--out", out(), "--recognise", "semaphore"});
  EXPECT_THAT(complaint_of(run, 2), AllOf(HasSubstr("40001 pictures"), HasSubstr("GB of memory")));
  EXPECT_THAT(hint_of(run), HasSubstr("folders"));
  EXPECT_FALSE(std::filesystem::exists(out()));
}

TEST_F(Semaphore, TheSettingsOfFacesReachASet) {
  std::filesystem::create_directory(folder_ / "pictures");
  film_pictures("RU");
  const auto run =
      analyze(folder_ / "pictures" + "?stills=1", out(),
              {"--recognise", "semaphore", "--set", "face.least_share=0.4", "--set", "face.most_share=0.5"});
  EXPECT_THAT(run.err_lines("choreoscope: warning: "), Contains(HasSubstr("no face was found in 2 of 2 pictures")));
}

TEST_F(Semaphore, GreyPicturesGoOnWithTheSilhouetteAndSaySo) {
  const auto clip = folder_ / "grey.avi";
  // An image folder of greys: no colour at all.
  const auto grey = folder_ / "grey";
  std::filesystem::create_directory(grey);
  for (int k = 0; k < 12; ++k) {
    cv::Mat picture(120, 160, CV_8UC3, cv::Scalar::all(120));
    if (k > 3) picture(cv::Rect(40 + 4 * k, 30, 30, 80)).setTo(cv::Scalar::all(30));
    cv::imwrite(grey + "/f" + std::to_string(100 + k) + ".png", picture);
  }
  const auto run = analyze(grey, out(), {"--state", "particles", "--recognise", "semaphore"});
  EXPECT_THAT(run.err_lines("choreoscope: warning: "), Contains(HasSubstr("no colour"))) << run.told();
  EXPECT_EQ(json_of(out() + "/letters.json")["letters"].size(), 0U);
  const Results results(out());
  EXPECT_EQ(results.Z(results.n - 1, results.n - 1), 1) << "silhouettes";
}

TEST_F(Semaphore, WithoutAFaceItSaysWhatIsMissing) {
  const auto run =
      analyze("synthetic://walking?size=160x120&fps=10&duration=2&seed=4", out(), {"--state", "particles"});
  EXPECT_THAT(run.err_lines("choreoscope: warning: "), Contains(HasSubstr("no face was ever seen"))) << run.told();
}

TEST_F(Semaphore, FilesThatAreNotWhatTheyShouldBeAreRefusedBeforeTheRun) {
  const auto nothing = folder_ / "nothing";
  std::ofstream(nothing + ".txt") << "hello\n";
  const std::vector<std::pair<std::string, std::string>> bad = {{"tones.file=" + nothing + ".toml", "nothing.toml"},
                                                                {"tones.file=" + nothing + ".txt", "nothing.txt"},
                                                                {"face.cascades=" + nothing, "haarcascade_frontalface"},
                                                                {"face.model=" + nothing + ".onnx", "nothing.onnx"},
                                                                {"face.model=" + nothing + ".txt", "nothing.txt"},
                                                                {"tones.arms=[\"glove\"]", "glove"},
                                                                {"arms.largest_arm=0.1", "largest_arm"},
                                                                {"face.most_share=0.02", "most_share"}};
  for (const auto& [setting, named] : bad) {
    const auto run = choreoscope({"analyze", kSays, "--out", out(), "--recognise", "semaphore", "--set", setting});
    EXPECT_THAT(complaint_of(run, 2) + hint_of(run), HasSubstr(named)) << setting;
    EXPECT_TRUE(files_in(out()).empty()) << setting;
  }
}

TEST_F(Semaphore, AnUnknownStateOrAlphabetIsRefused) {
  EXPECT_THAT(complaint_of(choreoscope({"analyze", kSays, "--out", out(), "--state", "joints"}), 2),
              HasSubstr("--state"));
  EXPECT_THAT(complaint_of(choreoscope({"live", kSays, "--recognise", "morse"}), 2), HasSubstr("--recognise"));
}

}  // namespace
}  // namespace choreo::test
