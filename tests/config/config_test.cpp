// SPDX-License-Identifier: Apache-2.0
// Configurations as a whole: files good and bad, assignments, what overrides what, and that all of it reads back.
#include "config/config.hpp"

#include <sys/stat.h>

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/schema.hpp"
#include "support/frames.hpp"
#include "support/places.hpp"
#include "support/temp_folder.hpp"

namespace choreo::config {
namespace {

using test::error_of;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

std::optional<Error> text_error(const std::string& text) {
  return error_of([&] { Config().load_text(text, "a.toml"); });
}

std::optional<Error> set_error(const std::string& assignment) {
  return error_of([&] { Config().set(assignment); });
}

// Whatever is set, what `show` prints makes the same configuration.
void expect_round_trip(const Config& config) {
  Config again;
  ASSERT_FALSE(error_of([&] { again.load_text(config.show(), "shown.toml"); })) << config.show();
  for (const auto& field : schema()) {
    EXPECT_EQ(field.print(again.options()), field.print(config.options())) << field.key;
  }
}

TEST(Config, TakesSectionsDottedKeysAndInlineTablesAlike) {
  for (const auto* text : {"[mask]\nsteps = 7\n", "mask.steps = 7", "mask = {steps = 7}", "[\"mask\"]\n'steps' = 7",
                           "\xEF\xBB\xBF[mask]\r\nsteps = 7\r\n"}) {
    Config config;
    config.load_text(text, "a.toml");
    EXPECT_EQ(config.options().mask.steps, 7) << text;
  }
}

TEST(Config, AnEmptyFileChangesNothing) {
  for (const auto* text : {"", "\n\n", "# nothing\n", "[mask]\n", "\t"}) {
    Config config;
    config.load_text(text, "a.toml");
    EXPECT_EQ(config.show(), Config().show()) << text;
  }
}

TEST(Config, WhatIsUnknownIsNamedWithItsPlaceAndTheNearestSetting) {
  struct Unknown {
    const char* text;
    const char* name;
    const char* where;
    const char* hint;
  };
  for (const auto& u : {
           Unknown{"[mask]\nsteps = 1\nthreshhold = 2\n", "mask.threshhold", "a.toml:3:1",
                   "did you mean \"mask.threshold\"?"},
           Unknown{"[maks]\nsteps = 1\n", "maks.steps", "a.toml:2:1", "did you mean \"mask.steps\"?"},
           Unknown{"[plot]\n  threshold = 1\n", "plot.threshold", "a.toml:2:3", "did you mean \"mask.threshold\"?"},
           Unknown{"steps = 3", "steps", "a.toml:1:1", "did you mean \"mask.steps\"?"},
           Unknown{"[camera]\ngain = 3", "camera.gain", "a.toml:2:1", "`choreoscope config show` lists every setting"},
           Unknown{"[camera]\n", "camera", "a.toml:1:2", "`choreoscope config show` lists every setting"},
           Unknown{"mask = 3", "mask", "a.toml:1:1", "`choreoscope config show` lists every setting"},
           Unknown{"[mask]\n\"a b\" = 1", "mask.a b", "a.toml:2:1", "`choreoscope config show` lists every setting"},
       }) {
    const auto error = text_error(u.text);
    ASSERT_TRUE(error) << u.text;
    EXPECT_EQ(error->fault(), Fault::kUsage);
    EXPECT_EQ(std::string(error->what()), std::string(u.where) + ": unknown setting \"" + u.name + "\"");
    EXPECT_EQ(error->hint(), u.hint) << u.text;
  }
}

TEST(Config, ASettingThatIsASectionIsOfTheWrongKind) {
  const auto error = text_error("[mask.steps]\nx = 1\n");
  ASSERT_TRUE(error);
  EXPECT_THAT(error->what(), HasSubstr("mask.steps is "));
  EXPECT_EQ(error->hint(), "mask.steps is from 0 to 32 pixels");
}

TEST(Config, WhatIsNoTomlIsRefusedAtItsPlace) {
  for (const auto& [text, where] : {std::pair{"[mask]\nsteps = \n", "a.toml:2:"},
                                    {"[mask\n", "a.toml:1:"},
                                    {"[mask]\nsteps = 1\nsteps = 2\n", "a.toml:3:"},
                                    {"[mask]\nsteps = 1 2\n", "a.toml:2:"},
                                    {"[mask]\nsteps = \"open\n", "a.toml:2:"},
                                    {"\n\n= 3\n", "a.toml:3:1"},
                                    {"a = 99999999999999999999", "a.toml:1:"},
                                    {"mask = {steps = 1}\n[mask]\n", "a.toml:2:"}}) {
    const auto error = text_error(text);
    ASSERT_TRUE(error) << text;
    EXPECT_EQ(error->fault(), Fault::kUsage);
    EXPECT_THAT(error->where(), ContainsRegex("^a\\.toml:[0-9]+:[0-9]+$")) << text;
    EXPECT_THAT(error->where(), HasSubstr(where)) << text;
    EXPECT_THAT(error->hint(), HasSubstr("not TOML")) << text;
  }
}

TEST(Config, RubbishIsRefusedInOneLine) {
  std::string all_bytes;
  for (int i = 0; i < 256; ++i) all_bytes += static_cast<char>(i);
  const std::string deep(100'000, '[');
  for (const auto& rubbish :
       {all_bytes, deep, "a = " + deep, std::string("\0\0\0", 3), std::string("\x89PNG\r\n\x1a\n"),
        std::string("[mask]\n\"a\\nb\" = 1"), "[mask]\n" + std::string(500'000, 'x') + " = 1",
        "[mask]\nsteps = \"" + std::string(500'000, 'x') + "\"", std::string("[mask]\nsteps = \"a\\nb\\u0007\"")}) {
    const auto error = text_error(rubbish);
    ASSERT_TRUE(error);
    const std::string what = error->what();
    EXPECT_EQ(what.find_first_of("\n\r\a\x1b"), std::string::npos) << what;
    EXPECT_LT(what.size(), 300u) << what.substr(0, 300);
  }
}

TEST(Config, AFileThatFailsChangesNothing) {
  Config config;
  config.load_text("[mask]\nsteps = 5\n[plot]\nwidth_px = 500\n", "good.toml");
  const auto before = config.show();
  // The first settings are right, the last is not.
  EXPECT_TRUE(error_of([&] { config.load_text("[mask]\nsteps = 9\n[plot]\nwidth_px = 5\n", "bad.toml"); }));
  EXPECT_TRUE(error_of([&] { config.load_text("[mask]\nsteps = 9\nstep = 9\n", "bad.toml"); }));
  EXPECT_TRUE(error_of([&] { config.set("mask.steps=99"); }));
  EXPECT_EQ(config.show(), before);
  EXPECT_EQ(config.origin("mask.steps"), "good.toml:2");
}

TEST(Config, TheLaterOverridesTheEarlierAndTheOriginSaysWhich) {
  Config config;
  EXPECT_EQ(config.origin("mask.steps"), "default");
  config.load_text("[mask]\nsteps = 5\nspeck_percent = 1\n", "stage.toml");
  config.load_text("\n\n[mask]\nsteps = 6\n", "night.toml");
  EXPECT_EQ(config.options().mask.steps, 6);
  EXPECT_EQ(config.origin("mask.steps"), "night.toml:4");
  EXPECT_EQ(config.origin("mask.speck_percent"), "stage.toml:3");
  config.set("mask.steps=7");
  config.set_text("background.from", "first:2s", "--background");
  EXPECT_EQ(config.options().mask.steps, 7);
  EXPECT_EQ(config.options().background, "first:2s");
  EXPECT_EQ(config.origin("mask.steps"), "--set");
  EXPECT_EQ(config.origin("background.from"), "--background");
  config.load_text("mask.steps = 8", "last.toml");
  EXPECT_EQ(config.origin("mask.steps"), "last.toml:1");
  EXPECT_THAT(config.show(), HasSubstr("\nsteps = 8  # last.toml:1\n"));
}

TEST(ConfigSet, TakesNumbersWordsListsAndTexts) {
  Config config;
  for (const auto* assignment :
       {"mask.threshold=18", "plot.channels=zstar", "plot.page=\"dark\"", "mask.ignore=[[0,0,0.5,1]]", "plot.svg=true",
        "plot.thumbnails_at_s=[1, 2.5]", "background.from=my room=1.png", "mask.speck_percent= 0.25 "}) {
    ASSERT_FALSE(error_of([&] { config.set(assignment); })) << assignment;
  }
  const auto& o = config.options();
  EXPECT_EQ(o.mask.threshold, 18.0);
  EXPECT_EQ(o.plot.channels, "zstar");
  EXPECT_EQ(o.plot.page, "dark");
  EXPECT_EQ(o.mask.ignore, (std::vector<vision::Zone>{{0, 0, 0.5, 1}}));
  EXPECT_TRUE(o.plot.svg);
  EXPECT_EQ(o.plot.thumbnails_at_s, (std::vector<double>{1, 2.5}));
  EXPECT_EQ(o.background, "my room=1.png");
  EXPECT_EQ(o.mask.speck_percent, 0.25);
  config.set("mask.threshold=auto");
  EXPECT_FALSE(config.options().mask.threshold);
  expect_round_trip(config);
}

TEST(ConfigSet, WhatIsNoAssignmentIsRefusedAsItWasWritten) {
  for (const auto* bad : {"", "mask.steps", "=3", "mask.steps 3"}) {
    const auto error = set_error(bad);
    ASSERT_TRUE(error) << bad;
    EXPECT_EQ(std::string(error->what()), "--set " + std::string(bad) + ": is not of the form key=value");
    EXPECT_THAT(error->hint(), HasSubstr("mask.steps=3"));
  }
}

TEST(ConfigSet, AnUnknownKeyIsNamedWithTheNearest) {
  const auto error = set_error("mask.step=3");
  ASSERT_TRUE(error);
  EXPECT_STREQ(error->what(), "--set mask.step=3: unknown setting \"mask.step\"");
  EXPECT_EQ(error->hint(), "did you mean \"mask.steps\"?");
  EXPECT_TRUE(set_error("steps=3"));
  EXPECT_TRUE(set_error("mask=3"));
  EXPECT_TRUE(set_error(" mask.steps=3"));
}

TEST(ConfigSet, AValueCannotBringAlongAnotherSetting) {
  for (const auto* bad :
       {"mask.steps=3\nother = 4", "mask.steps=3\n", "mask.steps=\n[plot]", "mask.steps=3 # x\n[a]"}) {
    EXPECT_TRUE(set_error(bad)) << bad;
  }
}

TEST(ConfigSet, MessagesStayOnOneLineWhateverWasWritten) {
  for (const auto* bad : {"mask.steps=a\nb", "mask\n.steps=1", "a\nb", "\x1b[2J=1", "mask.steps=\xff\xfe"}) {
    const auto error = set_error(bad);
    ASSERT_TRUE(error);
    EXPECT_EQ(std::string(error->what()).find_first_of("\n\x1b\xff"), std::string::npos) << error->what();
    EXPECT_EQ(error->where().find('\n'), std::string::npos);
  }
}

TEST(ConfigShow, ReadsBackAsTheSameConfiguration) {
  expect_round_trip({});
  Config config;
  config.load_text(
      "[background]\nfrom = \"a\\\\b \\\"c\\\" \\u0001\\u007f\\n\\t\u00e9\"\n[mask]\nroi = [0.1, 0.2, 0.3, 0.7]\n"
      "ignore = [[0, 0, 0.1, 1], [0.3333333333333333, 0, 1, 1]]\nthreshold = 0.1\n",
      "odd\nname\x7f.toml");
  expect_round_trip(config);
  config.set_text("background.from", "a\nb = 3\n[plot]", "--background");
  expect_round_trip(config);
}

TEST(ConfigShow, ATextThatCouldNotReadBackIsRefused) {
  Config config;
  EXPECT_TRUE(error_of([&] { config.set_text("background.from", "caf\xe9.png", "--background"); })) << "not UTF-8";
  EXPECT_TRUE(error_of([&] { config.set("background.from=caf\xe9.png"); }));
  EXPECT_FALSE(error_of([&] { config.set("background.from=caf\xc3\xa9.png"); }));
}

TEST(ConfigShow, SaysOfEverySettingWhatItDoesItsRangeAndItsOrigin) {
  const auto shown = Config().show();
  for (const auto& field : schema()) {
    const auto name = field.key.substr(field.key.find('.') + 1);
    EXPECT_THAT(shown, HasSubstr("# " + field.help + "\n# " + field.range + "\n" + name + " = " +
                                 field.print(Options{}) + "  # default\n"));
  }
}

class ConfigFile : public ::testing::Test {
 protected:
  std::optional<Error> load_error(const std::string& path) {
    return error_of([&] { Config().load_file(path); });
  }
  test::TempFolder folder_;
};

TEST_F(ConfigFile, IsReadAndNamedInTheOrigins) {
  test::write_bytes(folder_ / "a b.toml", std::string("[mask]\nsteps = 4"));
  Config config;
  config.load_file(folder_ / "a b.toml");
  EXPECT_EQ(config.options().mask.steps, 4);
  EXPECT_EQ(config.origin("mask.steps"), folder_ / "a b.toml" + ":2");
}

TEST_F(ConfigFile, WhatCannotBeReadIsTheUsersMistake) {
  for (const auto& [path, cause] : {std::pair{folder_ / "none.toml", "no such configuration file"},
                                    {folder_.path(), "is a folder"},
                                    {folder_ / "none.toml/x", "no such configuration file"},
                                    {std::string("/proc/self/mem"), "cannot be read"},
                                    {std::string(), "no such configuration file"}}) {
    const auto error = load_error(path);
    ASSERT_TRUE(error) << path;
    EXPECT_EQ(error->fault(), Fault::kUsage) << path;
    EXPECT_EQ(error->where(), path);
    EXPECT_THAT(error->what(), HasSubstr(cause)) << path;
  }
}

TEST_F(ConfigFile, AtMostOneMebibyteIsTaken) {
  std::string text = "# ";
  text.resize(1 << 20, 'x');
  test::write_bytes(folder_ / "large.toml", text);
  EXPECT_FALSE(load_error(folder_ / "large.toml"));
  text += 'x';
  test::write_bytes(folder_ / "larger.toml", text);
  const auto error = load_error(folder_ / "larger.toml");
  ASSERT_TRUE(error);
  EXPECT_THAT(error->what(), HasSubstr("larger than 1 MiB"));
  EXPECT_THAT(load_error("/dev/zero")->what(), HasSubstr("larger than 1 MiB"))
      << "what never ends is not read for ever";
}

TEST_F(ConfigFile, APictureIsNoConfiguration) {
  test::write_bytes(folder_ / "a.png", std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16));
  const auto error = load_error(folder_ / "a.png");
  ASSERT_TRUE(error);
  EXPECT_THAT(error->where(), HasSubstr("a.png:1:"));
}

TEST(Presets, EveryOneOfThemLoadsSaysWhatItIsForAndIsInRange) {
  const auto folder = std::filesystem::path(test::project_file("config/presets"));
  int found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".toml") continue;
    ++found;
    Config config;
    const auto error = error_of([&] { config.load_file(entry.path()); });
    EXPECT_FALSE(error) << error->what() << "; " << error->hint();
    EXPECT_NO_THROW(config.options().mask.validate());
    EXPECT_EQ(test::read_bytes(entry.path().string())[0], '#') << entry.path() << " begins with its purpose";
    expect_round_trip(config);
  }
  EXPECT_GT(found, 0);
}

TEST(Presets, TheDefaultOneChangesNothing) {
  Config config;
  config.load_file(test::project_file("config/presets/default.toml"));
  for (const auto& field : schema()) EXPECT_EQ(field.print(config.options()), field.print(Options{})) << field.key;
}

TEST(Differing, NamesWhatWasAndWhatIs) {
  Config was, is;
  EXPECT_EQ(differing(was.values(), is.values()), "");
  was.set("mask.steps=2");
  is.set("segmentation=both");
  is.set("plot.width_px=320");
  EXPECT_EQ(differing(was.values(), is.values()),
            "mask.steps was 2 and is 1, segmentation was \"auto\" and is \"both\"");
}

TEST(Differing, WhatOneVersionAloneKnowsIsLeftOut) {
  EXPECT_EQ(differing("gone = 1\nsame = 2\n", "same = 2\nnew = 3\n"), "");
  EXPECT_EQ(differing("", "a = 1\n"), "");
  EXPECT_EQ(differing("no line of that kind", "a = 1"), "");
}

}  // namespace
}  // namespace choreo::config
