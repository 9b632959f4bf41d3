// SPDX-License-Identifier: Apache-2.0
// Arms that cannot be seen by their skin: what tones of flags make of them, and what is said where nothing can be done.
#include <functional>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "devices/synthetic/performer.hpp"
#include "end_to_end/refusal_fixture.hpp"

namespace choreo::test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

using devices::synthetic::Performer;
using devices::synthetic::PerformerSettings;

class SignalTroubles : public RefusalTest {
 protected:
  [[nodiscard]] std::string out() const { return folder_ / "out"; }

  static PerformerSettings signaller(const std::string& text) {
    PerformerSettings settings;
    settings.text = text;
    settings.size = {320, 240};
    settings.fps = 10;
    settings.seed = 5;
    settings.skin = "light";
    return settings;
  }

  // A picture of the signaller and a mask over what `mask_of` says, as a user would paint it, and the tone of both.
  std::string tone_file(const std::string& name, PerformerSettings settings,
                        const std::function<cv::Mat(const PerformerSettings&, int frame)>& mask_of) {
    const Performer performer("semaphore", settings);
    const int frame = performer.first_frame() + int(2.2 * settings.fps);
    cv::imwrite(folder_ / "picture.png", performer.perform(frame).bgr);
    cv::imwrite(folder_ / "mask.png", mask_of(settings, frame));
    const auto file = folder_ / (name + ".toml");
    const auto run = choreoscope({"tones", "train", "--picture", folder_ / "picture.png", "--mask",
                                  folder_ / "mask.png", "--name", name, "--parts", "2", "-o", file});
    EXPECT_EQ(run.status, 0) << run.told();
    return file;
  }

  // Where pictures with and without flags differ, sticks included.
  static cv::Mat flags_of(PerformerSettings settings, int frame) {
    settings.noise = 0;
    settings.flags = true;
    const auto with = Performer("semaphore", settings).perform(frame).bgr;
    settings.flags = false;
    cv::Mat difference;
    cv::absdiff(with, Performer("semaphore", settings).perform(frame).bgr, difference);
    cv::transform(difference, difference, cv::Matx13f(1, 1, 1));
    return difference > 20;
  }

  std::vector<std::string> warnings_of(const std::string& source, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"--recognise", "semaphore"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return analyze(source, out(), arguments).err_lines("choreoscope: warning: ");
  }
};

TEST_F(SignalTroubles, FlagsAndLongSleevesAreReadByTheToneOfTheFlags) {
  auto settings = signaller("R");
  settings.flags = true;
  const auto file = tone_file("flag", settings, flags_of);
  const std::vector<std::string> by_skin = {"--recognise", "semaphore"};
  const std::vector<std::string> by_flag = {"--recognise", "semaphore", "--config",
                                            "flags",       "--set",     "tones.file=" + file};
  // The first second is for the face.
  for (const auto* sleeves : {"half", "long"}) {
    SCOPED_TRACE(sleeves);
    const auto source =
        std::string("synthetic://semaphore?text=%20WOK&fps=10&seed=5&skin=light&size=320x240&flags=1&sleeves=") +
        sleeves;
    EXPECT_THAT(analyze(source, out(), by_skin).out, Not(EndsWith("\nWOK\n")));
    EXPECT_THAT(analyze(source, out(), by_flag).out, EndsWith("\nWOK\n"));
  }
}

TEST_F(SignalTroubles, FlagsOfASetOfPicturesAreReadByTheSameSettings) {
  auto settings = signaller("R");
  settings.size = {480, 360};
  settings.flags = true;
  settings.sleeves = "long";
  const auto file = tone_file("flag", settings, flags_of);
  const auto set = folder_ / "set";
  std::filesystem::create_directory(set);
  for (const char letter : std::string("RUN")) {
    settings.text = std::string(1, letter);
    const Performer performer("semaphore", settings);
    const int held = performer.first_frame() + int(2.2 * settings.fps);
    cv::imwrite(set + "/" + letter + "_.png", performer.perform(held).bgr);
  }
  const std::vector<std::string> by_skin = {"--recognise", "semaphore"};
  const std::vector<std::string> by_flag = {"--recognise", "semaphore", "--config",
                                            "flags",       "--set",     "tones.file=" + file};
  EXPECT_THAT(analyze(set, out(), by_skin).out, HasSubstr(": - - -\n"));
  // Before the red things of this wall R is left open.
  EXPECT_THAT(analyze(set, out(), by_flag).out, HasSubstr(": N - U\n"));
}

TEST_F(SignalTroubles, WhereTheArmsToneIsNowhereThatIsSaid) {
  auto settings = signaller("R");
  settings.flags = true;
  const auto file = tone_file("flag", settings, flags_of);
  const auto warnings = warnings_of("synthetic://semaphore?text=R&fps=10&seed=6&skin=light&size=320x240",
                                    {"--config", "flags", "--set", "tones.file=" + file});
  EXPECT_THAT(warnings, Contains(HasSubstr("none of the body has the tone of flag")));
}

TEST_F(SignalTroubles, WhereEverythingHasTheArmsToneThatIsSaid) {
  const auto file = tone_file("all", signaller("R"), [](const PerformerSettings& of, int frame) {
    return Performer("semaphore", of).perform(frame).mask;
  });
  const auto warnings =
      warnings_of("synthetic://semaphore?text=R&fps=10&seed=5&skin=light&size=320x240",
                  {"--set", "tones.file=" + file, "--set", R"(tones.arms=["all"])", "--set", "tones.skin=file"});
  EXPECT_THAT(warnings, Contains(AllOf(HasSubstr("most of the body has the tone of all"), HasSubstr("tones train"))));
}

// Two signallers side by side.
TEST_F(SignalTroubles, OfSeveralFacesItIsSaidWhichCounts) {
  const auto clip = folder_ / "clip";
  std::filesystem::create_directory(clip);
  auto left = signaller("R"), right = signaller("U");
  right.seed = 7;
  const Performer first("semaphore", left), second("semaphore", right);
  for (int k = 0; k < 60; ++k) {
    cv::Mat both;
    cv::hconcat(first.perform(k).bgr, second.perform(k).bgr, both);
    cv::imwrite(clip + "/" + std::to_string(1000 + k) + ".png", both);
  }
  const auto source = clip + "?fps=10";
  // The clip is short: the whole picture is looked at more often than by default.
  EXPECT_THAT(warnings_of(source, {"--set", "face.whole_frames=3"}),
              Contains(AllOf(HasSubstr("several faces"), HasSubstr("the one that was there first counts"))));
  EXPECT_THAT(warnings_of(source, {"--set", "face.whole_frames=3", "--set", "face.choose=largest"}),
              Contains(AllOf(HasSubstr("several faces"), HasSubstr("the largest counts"))));
}

// Whoever stands before a grey wall has colours, and whoever is filmed in greys has none before a coloured plate.
TEST_F(SignalTroubles, ColoursAreThoseOfThePerformerNotOfTheWall) {
  auto settings = signaller(" R");
  settings.tail = 1;
  const Performer performer("semaphore", settings);
  for (const auto* name : {"coloured", "grey"}) std::filesystem::create_directory(folder_ / name);
  const cv::Mat wall(settings.size, CV_8UC3, cv::Scalar::all(150));
  for (int k = 0; k < performer.frame_count(); ++k) {
    const auto shot = performer.perform(k);
    const auto name = "/" + std::to_string(1000 + k) + ".png";
    cv::Mat before_grey = wall.clone();
    shot.bgr.copyTo(before_grey, shot.mask);
    cv::imwrite(folder_ / "coloured" + name, before_grey);
    cv::Mat grey;
    cv::cvtColor(shot.bgr, grey, cv::COLOR_BGR2GRAY);
    cv::imwrite(folder_ / "grey" + name, grey);
  }
  cv::imwrite(folder_ / "grey.png", wall);
  cv::imwrite(folder_ / "coloured.png", performer.room());
  for (const auto& background : {std::string("auto"), folder_ / "grey.png"}) {
    const auto run =
        analyze(folder_ / "coloured?fps=10", out(), {"--recognise", "semaphore", "--background", background});
    EXPECT_THAT(run.out, EndsWith("\nR\n")) << run.told();
  }
  EXPECT_THAT(warnings_of(folder_ / "grey?fps=10", {"--background", folder_ / "coloured.png"}),
              Contains(HasSubstr("no colour")));
}

// Silhouettes of as many rows as a face takes fill the memory, and cannot be compared with every frame in time.
TEST_F(SignalTroubles, GreyPicturesGoOnLiveWithSilhouettesOfTheirOwnSize) {
  const auto grey = folder_ / "grey";
  std::filesystem::create_directory(grey);
  for (int k = 0; k < 30; ++k) {
    cv::Mat picture(480, 640, CV_8UC3, cv::Scalar::all(120));
    if (k > 22) picture(cv::Rect(100 + 10 * k, 100, 90, 300)).setTo(cv::Scalar::all(30));
    cv::imwrite(grey + "/" + std::to_string(1000 + k) + ".png", picture);
  }
  const auto run = choreoscope({"live", grey + "?fps=10", "--headless", "--pace", "max", "--out", out(), "--recognise",
                                "semaphore", "--state", "particles"});
  EXPECT_EQ(run.status, 0) << run.told();
  EXPECT_THAT(run.err_lines("choreoscope: warning: "), Contains(HasSubstr("no colour")));
  EXPECT_EQ(Results(out()).summary["working_size"], nlohmann::json({160, 120}));
}

TEST_F(SignalTroubles, AGreyPictureInASetIsSaidToShowNoColour) {
  const auto set = folder_ / "set";
  std::filesystem::create_directory(set);
  for (const char letter : {'R', 'U', 'N'}) {
    auto settings = signaller(std::string(1, letter));
    settings.size = {480, 360};
    settings.noise = 0;
    const Performer performer("semaphore", settings);
    cv::Mat grey;
    cv::cvtColor(performer.perform(performer.first_frame() + 22).bgr, grey, cv::COLOR_BGR2GRAY);
    cv::imwrite(set + "/" + letter + "_.png", grey);
  }
  const auto warnings = warnings_of(set, {});
  EXPECT_THAT(warnings, Contains(HasSubstr("no colour")));
}

}  // namespace
}  // namespace choreo::test
