// SPDX-License-Identifier: Apache-2.0
// Every setting by itself: its default, the ends of its range, what lies outside, what is of another kind.
#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config.hpp"
#include "config/schema.hpp"
#include "core/text.hpp"
#include "support/frames.hpp"

namespace choreo::config {
namespace {

using test::error_of;
using ::testing::HasSubstr;

struct Case {
  std::string key;
  std::vector<std::string> good;  // TOML, the ends of the range among them.
  std::vector<std::string> bad;
};

// What no number may be.
std::vector<std::string> no_number(std::vector<std::string> more) {
  more.insert(more.end(), {"nan", "-nan", "inf", "-inf", "true", "\"1\"", "[1]", "{x = 1}", "1979-05-27", "\"\""});
  return more;
}
std::vector<std::string> no_integer(std::vector<std::string> more) {
  more.insert(more.end(), {"1.0", "1e1", "nan", "inf", "true", "\"1\"", "[1]", "9223372036854775807",
                           "-9223372036854775808", "4294967297"});
  return more;
}
const std::vector<std::string> kNoFlag = {"0", "1", "\"true\"", "\"yes\"", "[]", "1.0"};
const std::vector<std::string> kNoWord = {"\"\"", "\"Both\"", "\"both \"", "1", "true", "[\"both\"]", "\"none\""};
const std::vector<std::string> kNoZone = {"[]",
                                          "[0, 0, 1]",
                                          "[0, 0, 1, 1, 1]",
                                          "[0, 0, 0, 1]",
                                          "[0, 1, 1, 1]",
                                          "[0.5, 0, 0.4, 1]",
                                          "[-0.1, 0, 1, 1]",
                                          "[0, 0, 1, 1.1]",
                                          "[0, 0, nan, 1]",
                                          "[0, 0, inf, 1]",
                                          "[0, 0, \"1\", 1]",
                                          "1",
                                          "\"all\"",
                                          "[[0, 0, 1, 1]]",
                                          "{left = 0}"};

std::string repeated(const std::string& item, int times) {
  std::vector<std::string> items(static_cast<std::size_t>(times), item);
  return "[" + join(items) + "]";
}

std::vector<Case> cases() {
  auto no_zones = std::vector<std::string>{"[0, 0, 1, 1]",
                                           "[1]",
                                           "[[]]",
                                           "[[0, 0, 1]]",
                                           "[[0, 0, 1, 1], [0, 0, 0, 1]]",
                                           "\"none\"",
                                           "1",
                                           repeated("[0, 0, 1, 1]", 65)};
  return {
      {"segmentation", {"\"auto\"", "\"colour\"", "\"depth\"", "\"both\"", "\"person\""}, kNoWord},
      {"background.from",
       {"\"auto\"", "\"first:1s\"", "\"first:0.5\"", "\"first:10min\"", "\"a plate.png\"",
        R"("C:\\x \"y\" \u007f\t\n")", "'/tmp/\u00e9.png'"},
       {"\"\"", "1", "true", "\"first:\"", "\"first:0s\"", "\"first:soon\"", "\"first:-1s\"", "[\"auto\"]"}},
      {"background.follow_exposure", {"true", "false"}, kNoFlag},
      {"background.follow_s", {"0", "3600", "0.30000000000000004", "-0.0"}, no_number({"-0.001", "3600.1"})},
      {"background.sudden_percent", {"1", "100", "59.5"}, no_number({"0.999", "100.1", "0"})},
      {"background.relearn_s", {"0", "60", "0.1"}, no_number({"-1", "60.1"})},
      {"mask.threshold",
       {"\"auto\"", "255", "0.001", "12.300000000000001"},
       no_number({"0", "-1", "255.1", "\"Auto\"", "5e-324"})},
      {"mask.noise_factor", {"1", "20", "3.7"}, no_number({"0.99", "20.1"})},
      {"mask.least_threshold", {"1", "255", "7.5"}, no_number({"0.99", "255.1"})},
      {"mask.steps", {"0", "32", "0x10"}, no_integer({"-1", "33"})},
      {"mask.half_contrast_edge", {"true", "false"}, kNoFlag},
      {"mask.drop_soft_light", {"true", "false"}, kNoFlag},
      {"mask.largest_only", {"true", "false"}, kNoFlag},
      {"mask.speck_percent", {"0", "100", "1e-9"}, no_number({"-0.1", "100.1"})},
      {"mask.min_body_percent", {"0", "100", "0.1"}, no_number({"-0.1", "100.1"})},
      {"mask.roi", {"[0, 0, 1, 1]", "[0.1, 0.2, 0.30000000000000004, 0.4]", "[0, 0.5, 1, 0.75]"}, kNoZone},
      {"mask.ignore",
       {"[]", "[[0, 0, 1, 1]]", "[[0, 0, 0.5, 1], [0.25, 0.125, 1, 1.0]]", repeated("[0, 0, 1, 1]", 64)},
       std::move(no_zones)},
      {"depth.threshold_mm", {"\"auto\"", "5000", "0.5"}, no_number({"0", "-1", "5000.1", "\"Auto\""})},
      {"depth.spread_factor", {"1", "20", "3.7"}, no_number({"0.99", "20.1"})},
      {"depth.least_threshold_mm", {"1", "1000", "12.5"}, no_number({"0.99", "1000.1"})},
      {"depth.near_mm", {"0", "20000", "499.5"}, no_number({"-1", "20000.1"})},
      {"depth.far_mm", {"0", "20000", "4000"}, no_number({"-1", "20000.1"})},
      {"person.models", {"\"\"", "\"a folder\""}, {"1", "true"}},
      {"person.network", {"\"full\"", "\"lite\""}, kNoWord},
      {"person.choose", {"\"largest\"", "\"left\"", "\"middle\"", "\"right\""}, kNoWord},
      {"person.others", {"\"left-out\"", "\"bodies\""}, kNoWord},
      {"person.smooth_hz", {"0", "1", "100"}, no_number({"-0.1", "101"})},
      {"person.smooth_hz_per_mps", {"0", "5", "1000"}, no_number({"-1", "1001"})},
      {"person.looks_per_s", {"0.1", "10", "1000"}, no_number({"0.05", "1001"})},
      {"person.delay_s", {"0.01", "0.06", "2"}, no_number({"0.005", "2.1"})},
      {"face.choose", {"\"tracked\"", "\"largest\""}, kNoWord},
      {"face.least_share", {"0.01", "0.5"}, no_number({"0.0099", "0.51"})},
      {"face.most_share", {"0.02", "1"}, no_number({"0.01", "1.01"})},
      {"face.persistence", {"1", "100"}, no_integer({"0", "101"})},
      {"face.coast_s", {"0", "60"}, no_number({"-0.1", "60.1"})},
      {"face.hidden_s", {"0", "600"}, no_number({"-0.1", "600.1"})},
      {"face.delay_frames", {"1", "60"}, no_integer({"0", "61"})},
      {"face.near_frames", {"1", "1000"}, no_integer({"0", "1001"})},
      {"face.whole_frames", {"1", "100000"}, no_integer({"0", "100001"})},
      {"face.lost_frames", {"1", "1000"}, no_integer({"0", "1001"})},
      {"face.rows", {"60", "4320"}, no_integer({"59", "4321"})},
      {"face.neighbours", {"1", "100"}, no_integer({"0", "101"})},
      {"face.scale_step", {"1.01", "2"}, no_number({"1", "2.01"})},
      {"face.cascades", {"\"\"", "\"a folder\"", "'/tmp/\u00e9'"}, {"1", "true", "[\"a\"]"}},
      {"face.model", {"\"\"", "\"yunet.onnx\"", "'/tmp/\u00e9'"}, {"1", "true", "[\"a\"]"}},
      {"tones.skin", {"\"learned\"", "\"file\""}, kNoWord},
      {"tones.file", {"\"\"", "\"team.tones\"", "'/tmp/\u00e9'"}, {"1", "true", "[\"a\"]"}},
      {"tones.arms",
       {"[\"skin\"]", R"(["red glove", "blue glove"])", repeated("\"a\"", 8)},
       {"[]", "\"skin\"", "1", "[1]", "[\"\"]", "[[\"skin\"]]", repeated("\"a\"", 9)}},
      {"tones.model", {"\"gaussian\"", "\"histogram\""}, kNoWord},
      {"tones.threshold", {"0.01", "0.99"}, no_number({"0", "1"})},
      {"tones.skin_prior", {"0.001", "1000"}, no_number({"0", "1001"})},
      {"tones.outliers", {"0.001", "1000"}, no_number({"0", "1001"})},
      {"tones.noise", {"0", "50"}, no_number({"-1", "50.1"})},
      {"tones.learn_s", {"0", "60"}, no_number({"-1", "60.1"})},
      {"tones.adapt_s", {"0", "3600"}, no_number({"-1", "3601"})},
      {"tones.rebuild_s", {"0", "60"}, no_number({"-1", "60.1"})},
      {"tones.learn_clothes", {"true", "false"}, kNoFlag},
      {"arms.reach", {"1", "10"}, no_number({"0.9", "10.1"})},
      {"arms.shoulder_aside", {"0", "5"}, no_number({"-0.1", "5.1"})},
      {"arms.shoulder_below", {"0", "5"}, no_number({"-0.1", "5.1"})},
      {"arms.typical_arm", {"0.1", "10"}, no_number({"0.09", "10.1"})},
      {"arms.least_arm", {"0.02", "5"}, no_number({"0.01", "5.1"})},
      {"arms.largest_arm", {"0.02", "30"}, no_number({"0.01", "30.1"})},
      {"arms.least_piece", {"0", "5"}, no_number({"-0.1", "5.1"})},
      {"arms.piece_gap", {"0", "3"}, no_number({"-0.1", "3.1"})},
      {"arms.anneal", {"0", "0.3"}, no_number({"-0.1", "0.31"})},
      {"arms.memory_s", {"0", "10"}, no_number({"-1", "10.1"})},
      {"particles.alpha_max", {"0.01", "100"}, no_number({"0", "1e-9", "0.009", "100.1"})},
      {"particles.c_max", {"0.01", "100"}, no_number({"0", "1e-9", "0.009", "100.1"})},
      {"particles.eta_max", {"0.01", "100"}, no_number({"0", "1e-9", "0.009", "100.1"})},
      {"semaphore.mirrored", {"true", "false"}, kNoFlag},
      {"semaphore.least_similarity", {"0.5", "0.999"}, no_number({"0.49", "1"})},
      {"semaphore.margin", {"0", "0.5"}, no_number({"-0.1", "0.51"})},
      {"semaphore.hysteresis", {"0", "0.5"}, no_number({"-0.1", "0.51"})},
      {"semaphore.hold_s", {"0.05", "5"}, no_number({"0", "5.1"})},
      {"semaphore.still_widths_s", {"0.05", "50"}, no_number({"0", "50.1"})},
      {"semaphore.still_degrees_s", {"0.1", "500"}, no_number({"0", "500.1"})},
      {"semaphore.bridge_s", {"0", "5"}, no_number({"-1", "5.1"})},
      {"semaphore.word_gap", {"0.05", "20"}, no_number({"0", "20.1"})},
      {"working.rows", {"0", "1", "8640"}, no_integer({"-1", "8641"})},
      {"motion.window_s", {"0.001", "10", "1"}, no_number({"0", "10.1", "-1", "1e-320"})},
      {"matrix.most_rows", {"2", "20000", "1000000"}, no_integer({"1", "0", "1000001"})},
      {"plot.channels", {"\"both\"", "\"z\"", "\"zstar\""}, kNoWord},
      {"plot.page", {"\"light\"", "\"dark\""}, kNoWord},
      {"plot.svg", {"true", "false"}, kNoFlag},
      {"plot.width_px", {"320", "8000"}, no_integer({"319", "8001", "-1"})},
      {"plot.contrast", {"\"full\"", "\"auto\""}, kNoWord},
      {"plot.thumbnails", {"0", "32"}, no_integer({"-1", "33"})},
      {"plot.thumbnails_at_s",
       {"[]", "[0]", "[1.5, 1e3, 0.30000000000000004]", repeated("1", 64)},
       {"1", "[-1]", "[nan]", "[inf]", "[\"1\"]", "[[1]]", repeated("1", 65)}},
  };
}

// A file with that one setting.
std::string file_of(const std::string& key, const std::string& value) {
  const auto dot = key.find('.');
  if (dot == std::string::npos) return "# of no section\n" + key + " = " + value + "\n";
  return "[" + key.substr(0, dot) + "]\n" + key.substr(dot + 1) + " = " + value + "\n";
}

// Whether two values of TOML are the same; 1 and 1.0 are.
bool same_value(const toml::node& a, const toml::node& b) {
  if (const auto* list = a.as_array()) {
    const auto* other = b.as_array();
    return other != nullptr && std::equal(list->begin(), list->end(), other->begin(), other->end(), same_value);
  }
  if (a.is_number()) return b.is_number() && a.value<double>() == b.value<double>();
  if (a.is_string()) return b.is_string() && a.value<std::string>() == b.value<std::string>();
  return a.is_boolean() && b.is_boolean() && a.value<bool>() == b.value<bool>();
}

bool same_value(const std::string& a, const std::string& b) {
  const auto both = toml::parse("a = " + a + "\nb = " + b);
  return same_value(*both.get("a"), *both.get("b"));
}

// Asks of every setting; a failure names it, and the others are still asked.
void of_every_setting(const std::function<void(const Field&, const Case&)>& check) {
  static const auto all = cases();
  std::size_t asked = 0;
  for (const auto& field : schema()) {
    SCOPED_TRACE(field.key);
    const auto c = std::find_if(all.begin(), all.end(), [&](const Case& each) { return each.key == field.key; });
    if (c == all.end()) continue;  // EveryOneOfThemIsTestedHere says so.
    ++asked;
    EXPECT_NO_THROW(check(field, *c));
  }
  EXPECT_EQ(asked, all.size());
}

TEST(Settings, EveryOneOfThemIsTestedHere) {
  std::vector<std::string> tested;
  std::vector<std::string> known;
  for (const auto& c : cases()) {
    tested.push_back(c.key);
    EXPECT_FALSE(c.good.empty()) << c.key;
    EXPECT_FALSE(c.bad.empty()) << c.key;
  }
  for (const auto& f : schema()) known.push_back(f.key);
  EXPECT_EQ(tested, known);
}

TEST(Settings, EveryOneOfThemSaysItsRangeAndWhatItDoes) {
  for (const auto& f : schema()) {
    EXPECT_FALSE(f.range.empty()) << f.key;
    EXPECT_TRUE(f.help.ends_with('.')) << f.key;
    EXPECT_EQ(f.help.find('\n'), std::string::npos) << f.key;
  }
}

TEST(Settings, EveryDefaultIsInRangeAndReadsBack) {
  of_every_setting([](const Field& field, const Case& c) {
    const auto initial = field.print(Options{});
    Config config;
    ASSERT_NO_THROW(config.load_text(file_of(c.key, initial), "default.toml"));
    EXPECT_EQ(field.print(config.options()), initial);
  });
}

TEST(Settings, EveryValueOfTheRangeIsTakenAndPrintsAsWhatReadsBackTheSame) {
  of_every_setting([](const Field& field, const Case& c) {
    for (const auto& value : c.good) {
      Config config;
      ASSERT_FALSE(error_of([&] { config.load_text(file_of(c.key, value), "good.toml"); })) << value;
      EXPECT_EQ(config.origin(c.key), "good.toml:2");
      const auto printed = field.print(config.options());
      EXPECT_TRUE(same_value(value, printed)) << value << " is printed as " << printed;
      Config again;
      ASSERT_FALSE(error_of([&] { again.load_text(file_of(c.key, printed), "printed.toml"); })) << value;
      EXPECT_EQ(field.print(again.options()), printed) << value;
      EXPECT_NO_THROW(config.options().depth.validate()) << "the module's own range is the same: " << value;
      EXPECT_NO_THROW(config.options().mask.validate()) << "the module's own range is the same: " << value;
    }
  });
}

TEST(Settings, WhatIsOutOfRangeOrOfAnotherKindIsRefusedAtItsPlaceWithTheRange) {
  of_every_setting([](const Field& field, const Case& c) {
    const auto column = c.key.size() - c.key.find('.') + 3;  // Behind "name = ".
    for (const auto& value : c.bad) {
      Config config;
      const auto error = error_of([&] { config.load_text(file_of(c.key, value), "bad.toml"); });
      ASSERT_TRUE(error) << value;
      EXPECT_EQ(error->fault(), Fault::kUsage);
      EXPECT_EQ(error->where(), "bad.toml:2:" + std::to_string(column)) << value;
      EXPECT_THAT(error->what(), HasSubstr(c.key + " is ")) << value;
      EXPECT_EQ(error->hint(), c.key + " is " + field.range);
      EXPECT_EQ(field.print(config.options()), field.print(Options{})) << "nothing has changed";
      EXPECT_EQ(config.origin(c.key), "default");
    }
  });
}

TEST(Settings, EveryValueCanBeSetOnTheCommandLine) {
  of_every_setting([](const Field& field, const Case& c) {
    for (const auto& value : c.good) {
      Config from_file;
      from_file.load_text(file_of(c.key, value), "good.toml");
      Config config;
      ASSERT_FALSE(error_of([&] { config.set(c.key + "=" + value); })) << value;
      EXPECT_EQ(config.origin(c.key), "--set");
      EXPECT_EQ(field.print(config.options()), field.print(from_file.options())) << value;
    }
  });
}

TEST(Settings, WhatIsOutOfRangeIsRefusedOnTheCommandLineToo) {
  const auto unchanged = Config().show();
  of_every_setting([&](const Field& field, const Case& c) {
    for (const auto& value : c.bad) {
      Config config;
      const auto error = error_of([&] { config.set(c.key + "=" + value); });
      ASSERT_TRUE(error) << value;
      EXPECT_EQ(error->fault(), Fault::kUsage);
      EXPECT_THAT(error->where(), HasSubstr("--set " + c.key)) << value;
      EXPECT_EQ(error->hint(), c.key + " is " + field.range);
      EXPECT_EQ(config.show(), unchanged);
    }
  });
}

TEST(Settings, AMistypedOneIsNamedAsTheNearest) {
  of_every_setting([](const Field& field, const Case&) {
    auto wrong = field.key;
    auto at = wrong.find('.') + 2;
    while (wrong[at] == wrong[at + 1]) ++at;
    std::swap(wrong[at], wrong[at + 1]);  // Two neighbours of the name swapped.
    Config config;
    const auto error = error_of([&] { config.load_text(file_of(wrong, "1"), "typo.toml"); });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->where(), "typo.toml:2:1");
    EXPECT_THAT(error->what(), HasSubstr("unknown setting \"" + wrong + "\""));
    EXPECT_EQ(error->hint(), "did you mean \"" + field.key + "\"?");
  });
}

}  // namespace
}  // namespace choreo::config
