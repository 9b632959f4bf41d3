// SPDX-License-Identifier: Apache-2.0
// What can be known of V4L2 without a camera: modes, names, pixel formats. The rest is asked of the kernel's own
// virtual camera (v4l2_vivid_test.cpp).
#include <linux/videodev2.h>

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>

#include "core/error.hpp"
#include "devices/fourcc.hpp"
#include "devices/source_uri.hpp"
#include "devices/v4l2/v4l2_controls.hpp"
#include "devices/v4l2/v4l2_driver.hpp"
#include "devices/v4l2/v4l2_session.hpp"
#include "pipeline/steady_clock.hpp"
#include "support/frames.hpp"
#include "support/temp_folder.hpp"

namespace choreo::devices::v4l2 {
namespace {

using ::testing::HasSubstr;

Mode mode(std::uint32_t fourcc, std::uint32_t width, std::uint32_t height, std::vector<std::uint32_t> fps) {
  Mode mode{fourcc, width, height, {}, {}};
  for (const auto f : fps) mode.rates.push_back({1, f});
  return mode;
}

// A webcam on USB 2: raw pictures are small or slow.
std::vector<Mode> webcam() {
  return {mode(V4L2_PIX_FMT_YUYV, 640, 480, {30, 15}), mode(V4L2_PIX_FMT_YUYV, 1280, 720, {10}),
          mode(V4L2_PIX_FMT_GREY, 640, 480, {60, 30}), mode(V4L2_PIX_FMT_NV12, 640, 480, {30}),
          mode(v4l2_fourcc('H', '2', '6', '4'), 640, 480, {120})};
}

TEST(ChooseMode, WithoutAWishIs640x480InTheFormatThatLosesLeast) {
  const auto chosen = choose_mode(webcam(), {});
  ASSERT_TRUE(chosen);
  EXPECT_EQ(name_of_fourcc(chosen->fourcc), "YUYV");
  EXPECT_EQ(chosen->width, 640U);
  EXPECT_EQ(chosen->height, 480U);
}

TEST(ChooseMode, AFasterFormatIsTakenWhereTheRateAsksForIt) {
  Wish wish;
  wish.fps = 60;
  EXPECT_EQ(name_of_fourcc(choose_mode(webcam(), wish)->fourcc), "GREY");
  wish.fps = 15;
  EXPECT_EQ(name_of_fourcc(choose_mode(webcam(), wish)->fourcc), "YUYV");
}

TEST(ChooseMode, WhatIsAskedForIsTakenOrNothing) {
  Wish wish;
  wish.size = cv::Size(1280, 720);
  EXPECT_EQ(choose_mode(webcam(), wish)->width, 1280U);
  wish.size = cv::Size(1281, 720);
  EXPECT_FALSE(choose_mode(webcam(), wish));
  Wish format;
  format.fourcc = V4L2_PIX_FMT_NV12;
  EXPECT_EQ(choose_mode(webcam(), format)->fourcc, V4L2_PIX_FMT_NV12);
  format.fourcc = V4L2_PIX_FMT_UYVY;
  EXPECT_FALSE(choose_mode(webcam(), format));
}

TEST(ChooseMode, OfSizesInStepsAnyOnTheGridCanBeHad) {
  auto card = mode(V4L2_PIX_FMT_YUYV, 16, 16, {60});
  card.steps = {1920, 1080, 2, 1};
  Wish wish;
  wish.size = cv::Size(642, 481);
  EXPECT_EQ(choose_mode({card}, wish)->width, 642U);
  EXPECT_EQ(choose_mode({card}, wish)->height, 481U);
  wish.size = cv::Size(643, 480);
  EXPECT_FALSE(choose_mode({card}, wish)) << "between two steps";
  wish.size = cv::Size(1922, 1080);
  EXPECT_FALSE(choose_mode({card}, wish)) << "too large";
  EXPECT_EQ(choose_mode({card}, {})->width, 640U) << "what is common";
}

TEST(ChooseMode, AFormatThatNobodyHereReadsIsNone) {
  EXPECT_FALSE(choose_mode({mode(v4l2_fourcc('H', '2', '6', '4'), 640, 480, {30})}, {}));
  EXPECT_FALSE(choose_mode({}, {}));
}

TEST(NearestRate, OfARangeIsTheOneThatIsWantedOrItsEnd) {
  auto range = mode(V4L2_PIX_FMT_YUYV, 640, 480, {60, 5});
  EXPECT_NEAR(range.nearest_rate(30).fps(), 5, 1e-9) << "two rates are no range";
  range.any_rate = true;
  for (const double wanted : {5.0, 24.0, 30.0, 29.97, 59.5, 60.0}) {
    EXPECT_NEAR(range.nearest_rate(wanted).fps(), wanted, 1e-3);
  }
  EXPECT_EQ(range.nearest_rate(30).numerator, 1U) << "in small numbers";
  EXPECT_NEAR(range.nearest_rate(100).fps(), 60, 1e-9);
  EXPECT_NEAR(range.nearest_rate(1).fps(), 5, 1e-9);
}

TEST(NearestRate, OfAListIsOneOfIt) {
  const auto list = mode(V4L2_PIX_FMT_YUYV, 640, 480, {60, 30, 15});
  EXPECT_NEAR(list.nearest_rate(29).fps(), 30, 1e-9);
  EXPECT_NEAR(list.nearest_rate(20).fps(), 15, 1e-9);
  EXPECT_NEAR(list.nearest_rate(1000).fps(), 60, 1e-9);
}

TEST(NearestRate, OfNonsenseIsHarmless) {
  EXPECT_EQ(mode(V4L2_PIX_FMT_YUYV, 640, 480, {}).nearest_rate(30).fps(), 0);
  Mode odd{V4L2_PIX_FMT_YUYV, 640, 480, {{1, 60}, {0, 0}}};
  odd.any_rate = true;
  EXPECT_NEAR(odd.nearest_rate(30).fps(), 30, 1e-3);
  EXPECT_GT(odd.nearest_rate(1e-9).denominator, 0U);
}

Identity webcam_at(const std::string& port, const std::string& serial) {
  return {"HD Pro Webcam C920", "usb-0000:00:14.0-" + port, "uvcvideo", serial, "00", "0"};
}

TEST(LikenessOf, TheSameAtTheSamePortIsTheSame) {
  EXPECT_EQ(likeness_of(webcam_at("2", ""), webcam_at("2", ""), false), Likeness::kSame);
  EXPECT_EQ(likeness_of(webcam_at("2", "A1"), webcam_at("2", "A1"), false), Likeness::kSame);
}

TEST(LikenessOf, AnotherPortNeedsASerialNumberOrALink) {
  EXPECT_EQ(likeness_of(webcam_at("2", ""), webcam_at("3", ""), false), Likeness::kOther);
  EXPECT_EQ(likeness_of(webcam_at("2", "A1"), webcam_at("3", "A1"), false), Likeness::kMoved)
      << "less than the same: another one may share its number";
  EXPECT_EQ(likeness_of(webcam_at("2", ""), webcam_at("3", ""), true), Likeness::kSame);
}

TEST(LikenessOf, AnotherSerialNumberIsAnotherCamera) {
  EXPECT_EQ(likeness_of(webcam_at("2", "A1"), webcam_at("2", "B7"), false), Likeness::kOther);
  EXPECT_EQ(likeness_of(webcam_at("2", "A1"), webcam_at("2", ""), false), Likeness::kOther);
}

TEST(LikenessOf, ASiblingOfTheSameDeviceIsAnother) {
  const auto colour = webcam_at("2", "A1");
  auto infrared = colour;
  infrared.interface = "02";
  auto second = colour;
  second.index = "2";
  auto renamed = colour;
  renamed.card = "HD Pro Webcam C930";
  for (const bool linked : {false, true}) {
    EXPECT_EQ(likeness_of(colour, infrared, linked), Likeness::kOther);
    EXPECT_EQ(likeness_of(colour, second, linked), Likeness::kOther);
    EXPECT_EQ(likeness_of(colour, renamed, linked), Likeness::kOther);
  }
}

TEST(WithSysfs, ReadsWhatTheKernelKnowsOfAUsbDevice) {
  // As in /sys: the node leads to its interface, which lies in its device.
  const test::TempFolder sys;
  std::filesystem::create_directories(sys / "usb/1-2/1-2:1.2");
  std::filesystem::create_directories(sys / "node");
  std::filesystem::create_directory_symlink(sys / "usb/1-2/1-2:1.2", sys / "node/device");
  std::ofstream(sys / "usb/1-2/serial") << "A1B2\n";
  std::ofstream(sys / "usb/1-2/1-2:1.2/bInterfaceNumber") << "02\n";
  std::ofstream(sys / "node/index") << "1\n";
  const auto found = with_sysfs({"card", "bus", "driver"}, sys / "node");
  EXPECT_EQ(found.card, "card");
  EXPECT_EQ(found.serial, "A1B2");
  EXPECT_EQ(found.interface, "02");
  EXPECT_EQ(found.index, "1");
  const auto none = with_sysfs({"card", "bus", "driver"}, sys / "nowhere");
  EXPECT_EQ(none.serial + none.interface + none.index, "");
}

TEST(SettingsOf, AreWhatCanBeReadAndSetAgain) {
  Control brightness;
  brightness.name = "brightness";
  brightness.type = V4L2_CTRL_TYPE_INTEGER;
  brightness.value = 77;
  auto gain = brightness;
  gain.name = "gain";
  gain.value = -3;
  auto button = brightness;
  button.name = "reset";
  button.type = V4L2_CTRL_TYPE_BUTTON;
  auto pan = brightness;
  pan.name = "pan_relative";
  pan.flags = V4L2_CTRL_FLAG_WRITE_ONLY;
  auto fixed = brightness;
  fixed.name = "temperature";
  fixed.flags = V4L2_CTRL_FLAG_READ_ONLY;
  EXPECT_EQ(settings_of({brightness, button, pan, fixed, gain}), "brightness=77&gain=-3");
  EXPECT_EQ(settings_of({button}), "");
}

TEST(ControlName, IsAsV4l2CtlWritesIt) {
  EXPECT_EQ(control_name("Brightness"), "brightness");
  EXPECT_EQ(control_name("Exposure Time, Absolute"), "exposure_time_absolute");
  EXPECT_EQ(control_name("White Balance, Automatic"), "white_balance_automatic");
  EXPECT_EQ(control_name("Pan (Absolute)"), "pan_absolute");
  EXPECT_EQ(control_name(""), "");
}

TEST(OtherSpelling, GoesBothWays) {
  EXPECT_EQ(other_spelling("exposure_absolute"), "exposure_time_absolute");
  EXPECT_EQ(other_spelling("exposure_time_absolute"), "exposure_absolute");
  EXPECT_EQ(other_spelling("auto_exposure"), "exposure_auto");
  EXPECT_EQ(other_spelling("gain"), "gain");
}

class V4l2Source : public ::testing::Test {
 protected:
  std::string refused(const std::string& source) {
    Registry registry;
    registry.add(v4l2_driver(clock_));
    const auto error = test::error_of([&] { (void)registry.open(source); });
    if (!error) return "opened";
    EXPECT_EQ(error->fault(), Fault::kUsage);
    return std::string(error->what()) + " / " + error->hint();
  }
  pipeline::SteadyClock clock_;
};

TEST_F(V4l2Source, RefusesWhatCannotBe) {
  EXPECT_THAT(refused("v4l2:///dev/video987"), HasSubstr("/dev/video987"));
  EXPECT_THAT(refused("v4l2:///dev/null"), HasSubstr("no camera"));
  EXPECT_THAT(refused("v4l2://"), HasSubstr("names no place"));
  EXPECT_THAT(refused("v4l2:///dev/video0?size=big"), HasSubstr("640x480"));
  EXPECT_THAT(refused("v4l2:///dev/video0?size=640x480x2"), HasSubstr("640x480"));
  EXPECT_THAT(refused("v4l2:///dev/video0?format=ABCD"), HasSubstr("YUYV"));
  EXPECT_THAT(refused("v4l2:///dev/video0?fps=-1"), HasSubstr("fps"));
}

}  // namespace
}  // namespace choreo::devices::v4l2
