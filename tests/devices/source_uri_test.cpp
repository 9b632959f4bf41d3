// SPDX-License-Identifier: Apache-2.0
#include "devices/source_uri.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/frames.hpp"

namespace choreo::devices {
namespace {

using test::error_of;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::UnorderedElementsAre;

bool nothing_exists(const std::string& /*path*/) { return false; }

SourceUri parsed(std::string_view text) { return parse_source_uri(text, nothing_exists); }

TEST(SourceUri, APlainPathHasNoScheme) {
  const auto uri = parsed("clips/walk 1.mp4");
  EXPECT_EQ(uri.scheme, "");
  EXPECT_EQ(uri.location, "clips/walk 1.mp4");
  EXPECT_THAT(uri.settings, IsEmpty());
  EXPECT_EQ(uri.text, "clips/walk 1.mp4");
}

TEST(SourceUri, SettingsStandBehindTheLastQuestionMark) {
  const auto uri = parsed("what?.mp4?rotate=90&flip=both");
  EXPECT_EQ(uri.location, "what?.mp4");
  EXPECT_THAT(uri.settings, UnorderedElementsAre(Pair("rotate", "90"), Pair("flip", "both")));
}

TEST(SourceUri, APathThatExistsIsAPathWhateverItsName) {
  for (const auto* name : {"what?.mp4", "synthetic://walk", "a:b?c=d", "http://x", "100%.mp4"}) {
    const auto uri = parse_source_uri(name, [](const std::string&) { return true; });
    EXPECT_EQ(uri.scheme, "") << name;
    EXPECT_EQ(uri.location, name);
    EXPECT_THAT(uri.settings, IsEmpty()) << name;
  }
}

TEST(SourceUri, AnExistingPathWithAColonMayHaveSettings) {
  const auto uri =
      parse_source_uri("take:1.mkv?rotate=90", [](const std::string& path) { return path == "take:1.mkv"; });
  EXPECT_EQ(uri.scheme, "");
  EXPECT_EQ(uri.location, "take:1.mkv");
  EXPECT_THAT(uri.settings, UnorderedElementsAre(Pair("rotate", "90")));
}

TEST(SourceUri, TheSchemeIsLowerCaseAndTheTwoSlashesAreOptional) {
  for (const auto* text : {"Synthetic://walk?seed=2", "synthetic:walk?seed=2"}) {
    const auto uri = parsed(text);
    EXPECT_EQ(uri.scheme, "synthetic");
    EXPECT_EQ(uri.location, "walk");
    EXPECT_THAT(uri.settings, UnorderedElementsAre(Pair("seed", "2")));
  }
  EXPECT_EQ(parsed("file:///tmp/a.mp4").location, "/tmp/a.mp4");
}

TEST(SourceUri, WhatOnlyLooksLikeASchemeIsAPath) {
  for (const auto* text : {"c:clip.mp4", "./a:b.mp4", "1:30.mp4", "take one:2.mp4", ":x"}) {
    EXPECT_EQ(parsed(text).scheme, "") << text;
    EXPECT_EQ(parsed(text).location, text);
  }
}

TEST(SourceUri, PercentSignsAreDecodedInUrisAndSettingsButNotInPaths) {
  EXPECT_EQ(parsed("file:///tmp/50%25%20off%3f.mp4").location, "/tmp/50% off?.mp4");
  EXPECT_EQ(parsed("50%20.mp4").location, "50%20.mp4");
  EXPECT_EQ(parsed("a.mp4?x=%26%3D%41").settings.at("x"), "&=A");
  EXPECT_EQ(parsed("a.mp4?%41=1").settings.at("A"), "1");
}

TEST(SourceUri, MalformedPercentSignsAndSettingsAreRefusedAsTheUsersMistake) {
  for (const auto* bad : {"", "file:///a%2", "file:///a%zz", "file:///a%00b", "a.mp4?x=%", "a.mp4?x=%4", "a.mp4?rotate",
                          "a.mp4?=1", "a.mp4?x=1&x=2", "a.mp4?x=1&%78=2", "synthetic://", "synthetic:?a=1"}) {
    const auto error = error_of([&] { (void)parsed(bad); });
    ASSERT_TRUE(error) << bad;
    EXPECT_EQ(error->fault(), Fault::kUsage) << bad;
  }
  EXPECT_TRUE(error_of([] { (void)parsed(std::string_view("a\0b", 3)); }));
}

TEST(SourceUri, NoPlaceIsTheFirstOfDevicesThatAreFoundByThemselves) {
  EXPECT_EQ(parsed("freenect://").location, "");
  EXPECT_EQ(parsed("freenect:?led=off").location, "");
  EXPECT_THAT(parsed("freenect:?led=off").settings, UnorderedElementsAre(Pair("led", "off")));
}

TEST(SourceUri, EmptySettingsAreNone) {
  EXPECT_THAT(parsed("a.mp4?").settings, IsEmpty());
  EXPECT_THAT(parsed("a.mp4?&x=1&&").settings, UnorderedElementsAre(Pair("x", "1")));
  EXPECT_EQ(parsed("a.mp4?x=").settings.at("x"), "");
}

TEST(SourceUri, TheServersPartOfANetworkAddressIsLeftToTheServer) {
  const auto uri = parsed("http://host:8080/a%20b?token=x%3D&rotate=90&part=2&flip=both");
  EXPECT_EQ(uri.scheme, "http");
  EXPECT_EQ(uri.location, "http://host:8080/a%20b?token=x%3D&part=2");
  EXPECT_THAT(uri.settings, UnorderedElementsAre(Pair("rotate", "90"), Pair("flip", "both")));
  EXPECT_EQ(parsed("rtsp://host/cam?rotate=180").location, "rtsp://host/cam");
  EXPECT_EQ(parsed("udp://0.0.0.0:5000?fifo_size=9").location, "udp://0.0.0.0:5000?fifo_size=9");
}

TEST(SourceUri, OnlyRtspHasATransportOfItsOwn) {
  const auto rtsp = parsed("rtsps://host/cam?transport=udp&listen=1&patience=2&silence=5&channel=3");
  EXPECT_EQ(rtsp.location, "rtsps://host/cam?channel=3");
  EXPECT_THAT(rtsp.settings, UnorderedElementsAre(Pair("transport", "udp"), Pair("listen", "1"), Pair("patience", "2"),
                                                  Pair("silence", "5")));
  EXPECT_EQ(parsed("tcp://0.0.0.0:5000?listen=1&patience=2").location, "tcp://0.0.0.0:5000?listen=1");
}

TEST(SourceUri, ThePasswordIsUsedButNotShown) {
  const auto uri = parsed("rtsp://me:s3cret@host:554/cam?pwd=s3cret&channel=1&patience=4");
  EXPECT_EQ(uri.location, "rtsp://me:s3cret@host:554/cam?pwd=s3cret&channel=1");
  EXPECT_EQ(uri.text, "rtsp://me:***@host:554/cam?pwd=***&channel=1&patience=4");
}

TEST(SourceUri, WhatHidesPasswordsLeavesTheRest) {
  for (const auto* harmless : {"", "walk?key=1.mkv", "http://host/a@b:c", "http://me@host/", "http://host?user=me",
                               "\"tcp://10.0.0.1:80\" does not answer", "a://", "@:@:"}) {
    EXPECT_EQ(without_password(harmless), harmless);
  }
  EXPECT_EQ(without_password("http://a:b@c@host:80/x:y@z"), "http://a:***@host:80/x:y@z");
  EXPECT_EQ(without_password("http://a:b c@host"), "http://a:***@host");
  EXPECT_EQ(without_password("\"http://a:@h\": no, http://u:p@i?Token=1&x=2#k failed"),
            "\"http://a:***@h\": no, http://u:***@i?Token=***&x=2#k failed");
}

TEST(SourceUri, NoRefusalShowsAPassword) {
  const auto error = error_of([&] { (void)parsed("rtps://me:s3cret@host/%zz"); });
  ASSERT_TRUE(error);
  EXPECT_EQ(std::string(error->what()).find("s3cret"), std::string::npos) << error->what();
}

TEST(SourceUri, FFmpegGetsItsSchemeInLowerCase) {
  EXPECT_EQ(parsed("HTTP://Host/Path?Q=1").location, "http://Host/Path?Q=1");
}

TEST(SettingReader, TakesWhatFitsAndFallsBackWhereNothingIsGiven) {
  const auto uri = parsed("synthetic://walk?a=1.5&b=-3&c=on&d=no&e=red&f=any");
  SettingReader reader(uri);
  const std::vector<std::string> colours = {"red", "blue"};
  EXPECT_EQ(reader.take_number("a", 9, 0, 2), 1.5);
  EXPECT_EQ(reader.take_integer("b", 9, -5, 5), -3);
  EXPECT_TRUE(reader.take_flag("c", false));
  EXPECT_FALSE(reader.take_flag("d", true));
  EXPECT_EQ(reader.take_choice("e", "blue", colours), "red");
  EXPECT_EQ(reader.take_text("f", "none"), "any");
  EXPECT_EQ(reader.take_number("absent", 9, 0, 2), 9);
  EXPECT_EQ(reader.take_choice("absent", "blue", colours), "blue");
  EXPECT_NO_THROW(reader.refuse_the_rest());
}

TEST(SettingReader, SaysValueRangeAndDefaultOfWhatDoesNotFit) {
  SettingReader reader(parsed("pictures?fps=0&n=2.5&on=maybe&flip=up"));
  const auto number = error_of([&] { (void)reader.take_number("fps", 30, 0.01, 1000); });
  ASSERT_TRUE(number);
  EXPECT_THAT(number->what(), HasSubstr("fps is \"0\""));
  EXPECT_EQ(number->hint(), "fps is a number from 0.01 to 1000 (default 30)");
  EXPECT_TRUE(error_of([&] { (void)reader.take_integer("n", 1, 0, 9); }));
  EXPECT_TRUE(error_of([&] { (void)reader.take_flag("on", true); }));
  const std::vector<std::string> flips = {"none", "both"};
  const auto choice = error_of([&] { (void)reader.take_choice("flip", "none", flips); });
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->hint(), "flip is one of none, both (default none)");
}

TEST(SettingReader, RefusesWhatNobodyAskedForAndNamesTheNearest) {
  SettingReader reader(parsed("pictures?fsp=25"));
  (void)reader.take_number("fps", 30, 0.01, 1000);
  const auto error = error_of([&] { reader.refuse_the_rest(); });
  ASSERT_TRUE(error);
  EXPECT_THAT(error->what(), HasSubstr("unknown setting \"fsp\""));
  EXPECT_EQ(error->hint(), "did you mean \"fps\"?");
}

}  // namespace
}  // namespace choreo::devices
