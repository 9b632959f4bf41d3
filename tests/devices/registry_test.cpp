// SPDX-License-Identifier: Apache-2.0
#include "devices/registry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/frames.hpp"
#include "support/temp_folder.hpp"

namespace choreo::devices {
namespace {

using test::error_of;
using ::testing::HasSubstr;

// One picture of 3x2 whose top left pixel is 200; remembers what it was opened with.
class OnePicture final : public Source {
 public:
  explicit OnePicture(std::string name) {
    info_.name = std::move(name);
    info_.size = {3, 2};
  }
  const SourceInfo& info() const override { return info_; }
  FramePtr read(std::stop_token /*stop*/) override {
    if (given_) return nullptr;
    given_ = true;
    auto frame = std::make_shared<Frame>();
    frame->bgr = cv::Mat::zeros(info_.size, CV_8UC3);
    frame->bgr.at<cv::Vec3b>(0, 0) = {200, 200, 200};
    return frame;
  }

 private:
  SourceInfo info_;
  bool given_ = false;
};

Driver driver_of(const std::string& scheme, std::vector<std::string> also = {}) {
  Driver driver;
  driver.scheme = scheme;
  driver.also_schemes = std::move(also);
  driver.open = [scheme](const SourceUri& uri, SettingReader& settings, const OpenOptions&) {
    settings.refuse_the_rest();
    return std::make_unique<OnePicture>(scheme + " " + uri.location);
  };
  return driver;
}

class RegistryTest : public ::testing::Test {
 protected:
  RegistryTest() {
    registry_.add(driver_of("synthetic"));
    registry_.add(driver_of("file", {"http", "rtsp"}));
    registry_.add(driver_of("folder"));
  }
  std::string opened(const std::string& source) { return registry_.open(source)->info().name; }

  test::TempFolder folder_;
  Registry registry_;
};

TEST_F(RegistryTest, APathGoesToTheDriverOfFilesOrOfFolders) {
  const auto file = folder_ / "what?.mp4";
  test::write_bytes(file, std::string("x"));
  EXPECT_EQ(opened(file), "file " + file);
  EXPECT_EQ(opened(file + "?rotate=90"), "file " + file);
  EXPECT_EQ(opened(folder_.path()), "folder " + folder_.path());
  EXPECT_EQ(opened("file://" + folder_.path()), "folder " + folder_.path());
}

TEST_F(RegistryTest, ASchemeGoesToItsDriver) {
  EXPECT_EQ(opened("synthetic://walk"), "synthetic walk");
  EXPECT_EQ(opened("rtsp://host/cam?user=me&rotate=90"), "file rtsp://host/cam?user=me");
}

TEST_F(RegistryTest, AnUnknownSchemeListsTheKnownOnes) {
  const auto error = error_of([&] { (void)opened("kinekt://0"); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_THAT(error->what(), HasSubstr("unknown scheme \"kinekt\""));
  EXPECT_EQ(error->hint(), "known: synthetic, file, http, rtsp, folder");
}

TEST_F(RegistryTest, AMissingPathIsNamedAsItIs) {
  for (const auto& missing :
       {folder_ / "none.mp4", "file://" + (folder_ / "none.mp4"), folder_ / "none.mp4?flip=both"}) {
    const auto error = error_of([&] { (void)opened(missing); });
    ASSERT_TRUE(error) << missing;
    EXPECT_EQ(error->fault(), Fault::kUsage);
    EXPECT_EQ(std::string(error->what()), "\"" + (folder_ / "none.mp4") + "\" does not exist");
    EXPECT_FALSE(error->hint().empty());
  }
}

TEST_F(RegistryTest, EverySourceCanBeTurnedAndFlipped) {
  const auto place = [&](const std::string& settings) {
    const auto source = registry_.open("synthetic://walk?" + settings);
    const auto frame = source->read({});
    EXPECT_EQ(frame->bgr.size(), source->info().size);
    cv::Point where;
    cv::Mat one;
    cv::extractChannel(frame->bgr, one, 0);
    cv::minMaxLoc(one, nullptr, nullptr, nullptr, &where);
    return where;
  };
  EXPECT_EQ(place("rotate=0"), cv::Point(0, 0));
  EXPECT_EQ(place("rotate=90"), cv::Point(1, 0));
  EXPECT_EQ(place("rotate=180"), cv::Point(2, 1));
  EXPECT_EQ(place("rotate=270"), cv::Point(0, 2));
  EXPECT_EQ(place("flip=horizontal"), cv::Point(2, 0));
  EXPECT_EQ(place("flip=vertical"), cv::Point(0, 1));
  EXPECT_EQ(place("flip=both"), cv::Point(2, 1));
  EXPECT_EQ(place("flip=horizontal&rotate=90"), cv::Point(0, 0)) << "turned to the top right, then flipped";
}

TEST_F(RegistryTest, WrongAndUnknownSettingsAreRefused) {
  for (const auto* bad : {"synthetic://walk?rotate=45", "synthetic://walk?flip=up", "synthetic://walk?rotat=90"}) {
    const auto error = error_of([&] { (void)opened(bad); });
    ASSERT_TRUE(error) << bad;
    EXPECT_EQ(error->fault(), Fault::kUsage) << bad;
    EXPECT_THAT(error->hint(), HasSubstr(std::string(bad).find("flip") != std::string::npos ? "horizontal" : "rotate"));
  }
}

TEST(EmptyRegistry, WithoutDriversEverySchemeIsUnknown) {
  EXPECT_TRUE(error_of([] { (void)Registry().open("synthetic://walk"); }));
}

}  // namespace
}  // namespace choreo::devices
