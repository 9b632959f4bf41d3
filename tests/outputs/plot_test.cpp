// SPDX-License-Identifier: Apache-2.0
#include "outputs/plot.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"

// Fontconfig 2.14 keeps 288 bytes of its own for ever, once a process; everything else that leaks is ours.
extern "C" const char* __lsan_default_suppressions() { return "leak:libfontconfig"; }

namespace choreo::outputs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

/// A body whose arms swing one after the other: symmetric at whole seconds, asymmetric between.
struct Clip {
  std::vector<float> z, zstar;
  std::vector<double> times;

  explicit Clip(std::size_t n, double seconds_a_frame = 0.1) : z(n * n), zstar(n * n), times(n) {
    for (std::size_t i = 0; i < n; ++i) {
      times[i] = seconds_a_frame * static_cast<double>(i);
      for (std::size_t j = 0; j < n; ++j) {
        const double a = std::sin(3.14159265 * times[i]),
                     b = std::sin(3.14159265 * seconds_a_frame * static_cast<double>(j));
        z[i * n + j] = static_cast<float>(std::exp(-(a - b) * (a - b)));
        zstar[i * n + j] = static_cast<float>(std::exp(-4.0 * (a + b) * (a + b)));
      }
    }
  }
  void gap(std::size_t i) {
    for (std::size_t j = 0, n = times.size(); j < n; ++j) {
      for (auto* m : {&z, &zstar}) (*m)[i * n + j] = (*m)[j * n + i] = std::nanf("");
    }
  }
  [[nodiscard]] PlotData data() const {
    const auto n = times.size();
    return {.z = {z.data(), n, n}, .zstar = {zstar.data(), n, n}, .times_s = times};
  }
};

class PlotFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              (std::string("plot_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static std::string read(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  [[nodiscard]] std::string svg(const Plot& plot) const {
    plot.write_svg(folder_ / "plot.svg");
    return read(folder_ / "plot.svg");
  }

  fs::path folder_;
};

PlotOptions small(PlotForm form = PlotForm::kSquare) {
  PlotOptions options;
  options.form = form;
  options.width_px = 480;
  return options;
}

/// Every tag is closed in order and every `&` begins one of XML's own entities.
testing::AssertionResult is_well_formed(const std::string& xml) {
  std::vector<std::string> open;
  for (std::size_t at = 0; at < xml.size(); ++at) {
    if (xml[at] == '&') {
      bool known = false;
      for (const auto* entity : {"&amp;", "&lt;", "&gt;", "&quot;"})
        known |= xml.compare(at, std::string(entity).size(), entity) == 0;
      if (!known) return testing::AssertionFailure() << "bare & at " << at;
    }
    if (xml[at] != '<') continue;
    const auto end = xml.find('>', at);
    if (end == std::string::npos) return testing::AssertionFailure() << "open tag at " << at;
    const auto tag = xml.substr(at + 1, end - at - 1);
    if (tag.find('<') != std::string::npos) return testing::AssertionFailure() << "< within a tag at " << at;
    const auto name = tag.substr(tag[0] == '/', tag.find_first_of(" /", 1) - (tag[0] == '/'));
    if (tag[0] == '/') {
      if (open.empty() || open.back() != name) return testing::AssertionFailure() << "</" << name << "> at " << at;
      open.pop_back();
    } else if (tag[0] != '?' && tag.back() != '/') {
      open.push_back(name);
    }
    at = end;
  }
  if (!open.empty()) return testing::AssertionFailure() << "<" << open.back() << "> is never closed";
  return testing::AssertionSuccess();
}

TEST(Plot, TheDiagonalIsWhiteForASymmetricPoseAndRedForAnAsymmetricOne) {
  const Clip clip(11);
  const Plot plot(clip.data(), small());
  const auto page = plot.render();
  const auto box = plot.raster_box();
  const auto at = [&](double seconds) {
    const int k = static_cast<int>(seconds / 1.1 * box.width);
    return page.at<cv::Vec3b>(box.y + k, box.x + k);
  };
  EXPECT_EQ(at(0.05), cv::Vec3b(255, 255, 255));
  const auto asymmetric = at(0.55);
  EXPECT_EQ(asymmetric[2], 255);
  EXPECT_LT(asymmetric[0], 2);
  EXPECT_EQ(asymmetric[0], asymmetric[1]);
}

TEST(Plot, TheRasterStandsOnThePagePixelByPixel) {
  const Clip clip(40);
  const auto options = small();
  const Plot plot(clip.data(), options);
  const auto width = raster_width_px(options);
  const auto raster = similarity::reduce(options.form, clip.data().z, clip.data().zstar, clip.times, width);
  const auto picture = similarity::paint(raster, options.channels, {}, {});
  const auto box = plot.raster_box();
  ASSERT_EQ(box.width, static_cast<int>(width));
  EXPECT_EQ(cv::norm(plot.render()(box), picture, cv::NORM_INF), 0.0);
}

TEST(Plot, ATriangleStandsOnItsBaseAndLeavesThePageBesideItFree) {
  const Clip clip(11);
  auto options = small(PlotForm::kTriangle);
  options.range = ValueRange{0.0, 1.0};
  const Plot plot(clip.data(), options);
  const auto page = plot.render();
  const auto box = plot.raster_box();
  EXPECT_EQ(box.height, box.width / 2);
  const auto first_frame = page.at<cv::Vec3b>(box.y + box.height - 2, box.x + box.width / 22);
  EXPECT_EQ(first_frame, cv::Vec3b(255, 255, 255));
  const auto fifth = page.at<cv::Vec3b>(box.y + box.height - 2, box.x + box.width / 2);
  EXPECT_EQ(fifth[2], 255);
  EXPECT_LT(fifth[0], 2);
  // The apex, the first frame against the last, both symmetric; right of it the bare page.
  EXPECT_EQ(page.at<cv::Vec3b>(box.y + 3, box.x + box.width / 2), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(page.at<cv::Vec3b>(box.y + box.height / 2, box.x + box.width - 4), cv::Vec3b(255, 255, 255));
}

TEST(Plot, AGapHasAToneOfItsOwnAndStandsInTheKey) {
  Clip clip(11);
  clip.gap(5);
  for (const bool dark : {false, true}) {
    auto options = small();
    options.dark = dark;
    const Plot plot(clip.data(), options);
    const auto page = plot.render();
    const auto box = plot.raster_box();
    const auto tone = page.at<cv::Vec3b>(box.y + box.height / 2, box.x + 5);
    EXPECT_NE(tone[0], tone[1]) << "no mixture of red and cyan has it";
    EXPECT_EQ(tone, page.at<cv::Vec3b>(box.y + 5, box.x + box.width / 2));
    int in_key = 0;
    for (int y = 0; y < box.y; ++y) {
      for (int x = 0; x < page.cols; ++x) in_key += page.at<cv::Vec3b>(y, x) == tone;
    }
    EXPECT_GT(in_key, 30);
  }
}

TEST(Plot, GreyscaleHasEqualChannels) {
  const Clip clip(20);
  for (const auto channels : {PlotChannels::kZ, PlotChannels::kZstar}) {
    auto options = small(PlotForm::kSquare);
    options.channels = channels;
    const Plot plot(clip.data(), options);
    const cv::Mat raster = plot.render()(plot.raster_box());
    std::vector<std::uint8_t> seen;
    for (int y = 0; y < raster.rows; ++y) {
      for (int x = 0; x < raster.cols; ++x) {
        const auto p = raster.at<cv::Vec3b>(y, x);
        ASSERT_TRUE(p[0] == p[1] && p[1] == p[2]);
        seen.push_back(p[0]);
      }
    }
    const auto [least, most] = std::minmax_element(seen.begin(), seen.end());
    EXPECT_GT(*most - *least, 100);
  }
}

TEST(Plot, ASingleSimilarityNeedsNoOther) {
  const Clip clip(5);
  auto options = small();
  options.channels = PlotChannels::kZ;
  const auto both = Plot(clip.data(), options).render();
  auto data = clip.data();
  data.zstar = {};
  EXPECT_EQ(cv::norm(Plot(data, options).render(), both, cv::NORM_INF), 0.0);
}

TEST(Plot, EveryLengthGivesAPage) {
  for (const std::size_t n : {1u, 2u, 3u, 10u, 500u}) {
    for (const double step : {0.03, 14.4}) {
      for (const auto form : {PlotForm::kSquare, PlotForm::kTriangle}) {
        const Clip clip(n, step);
        const Plot plot(clip.data(), small(form));
        const auto page = plot.render();
        EXPECT_EQ(page.cols, 480);
        const auto box = plot.raster_box();
        EXPECT_GT(page.rows, box.y + box.height);
        EXPECT_GT(cv::mean(page(box))[2], 30.0) << n << " frames of " << step << " s";
      }
    }
  }
}

TEST(Plot, ARecordingWithoutAnyBodyIsAllGapAndStillAFigure) {
  Clip clip(6);
  for (std::size_t i = 0; i < 6; ++i) clip.gap(i);
  auto options = small();
  options.range.reset();
  const Plot plot(clip.data(), options);
  const cv::Mat raster = plot.render()(plot.raster_box());
  const auto tone = raster.at<cv::Vec3b>(0, 0);
  EXPECT_EQ(cv::norm(raster, cv::Mat(raster.size(), CV_8UC3, cv::Scalar(tone)), cv::NORM_INF), 0.0);
  EXPECT_EQ(plot.range().lo, 0.0);
}

TEST_F(PlotFile, ThePngIsAPngOfThePageAndTheSameOnEveryRun) {
  const Clip clip(30);
  auto options = small(PlotForm::kTriangle);
  options.title = "clip.mp4";
  const Plot plot(clip.data(), options);
  plot.write_png(folder_ / "a.png");
  Plot(clip.data(), options).write_png(folder_ / "b.png");
  const auto bytes = read(folder_ / "a.png");
  ASSERT_THAT(bytes, StartsWith("\x89PNG\r\n\x1a\n"));
  const auto number = [&](std::size_t at) {
    int v = 0;
    for (std::size_t k = 0; k < 4; ++k) v = v * 256 + static_cast<unsigned char>(bytes[at + k]);
    return v;
  };
  const auto page = plot.render();
  EXPECT_EQ(number(16), page.cols);
  EXPECT_EQ(number(20), page.rows);
  EXPECT_EQ(bytes, read(folder_ / "b.png"));
  const auto first = svg(plot);
  EXPECT_EQ(first, svg(plot));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 3) << "temporary files are gone";
}

TEST_F(PlotFile, TheSvgIsWellFormedAndItsTypeIsText) {
  Clip clip(31);
  auto options = small();
  options.title = "a <b> & \"c\"\x01 \xff.mp4";
  options.range = ValueRange{0.25, 1.0};
  const auto text = svg(Plot(clip.data(), options));
  EXPECT_TRUE(is_well_formed(text));
  for (const auto* part : {"a &lt;b&gt; &amp; &quot;c&quot;", ">31 frames, 3.1 s</text>", ">time (s)</text>",
                           ">0</text>", ">1.0</text>", ">3.0</text>", ">Z</text>", ">Z*</text>", ">0.25</text>",
                           "image-rendering:pixelated", "data:image/png;base64,"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  EXPECT_THAT(text, Not(HasSubstr("no body")));
  EXPECT_THAT(text, Not(HasSubstr("\x01")));
  clip.gap(4);
  EXPECT_THAT(svg(Plot(clip.data(), options)), HasSubstr(">no body</text>"));
}

TEST_F(PlotFile, ATriangleSaysLag) {
  const auto text = svg(Plot(Clip(31).data(), small(PlotForm::kTriangle)));
  EXPECT_TRUE(is_well_formed(text));
  EXPECT_THAT(text, HasSubstr(">lag (s)</text>"));
  EXPECT_THAT(text, HasSubstr("<clipPath"));
}

TEST_F(PlotFile, ALongTitleIsShortenedInTheMiddle) {
  auto options = small();
  options.title = std::string(100000, 'x') + ".mp4";
  const auto text = svg(Plot(Clip(3).data(), options));
  EXPECT_THAT(text, HasSubstr("xxx..."));
  EXPECT_THAT(text, HasSubstr("x.mp4</text>"));
  EXPECT_THAT(text, Not(HasSubstr(std::string(200, 'x'))));
}

TEST_F(PlotFile, ThumbnailsStandAtTheirTimesAndNeverInEachOthersPlace) {
  const Clip clip(100);
  const auto picture = [](cv::Scalar color) { return cv::Mat(40, 30, CV_8UC4, color); };
  for (const auto form : {PlotForm::kSquare, PlotForm::kTriangle}) {
    auto data = clip.data();
    data.thumbnails = {{5.0, picture({200, 0, 0, 255})},  {5.1, picture({0, 200, 0, 255})},
                       {2.5, picture({0, 0, 0, 0})},      {9.9, picture({200, 0, 200, 255})},
                       {-1.0, picture({0, 200, 0, 255})}, {11.0, picture({0, 200, 0, 255})}};
    const Plot plot(data, small(form));
    const auto page = plot.render();
    const auto box = plot.raster_box();
    const auto where = [&](cv::Vec3b color) {
      double sum = 0.0;
      int count = 0;
      for (int y = 0; y < page.rows; ++y) {
        for (int x = 0; x < page.cols; ++x) {
          if (y >= box.y && y < box.y + box.height) continue;
          if (page.at<cv::Vec3b>(y, x) == color) sum += x, ++count;
        }
      }
      return count < 200 ? -1.0 : sum / count;
    };
    EXPECT_NEAR(where({200, 0, 0}), box.x + 0.5 * box.width, 1.5);
    EXPECT_GT(where({200, 0, 200}), box.x + 0.93 * box.width);
    EXPECT_EQ(where({0, 200, 0}), -1.0) << "in the place of another, or outside of the axis";
    auto text = svg(plot);
    std::size_t images = 0;
    for (auto at = text.find("<image"); at != std::string::npos; at = text.find("<image", at + 1)) ++images;
    EXPECT_EQ(images, 5u) << "the raster, the key and three pictures";
  }
}

TEST_F(PlotFile, AFullDiskIsReported) {
  const Plot plot(Clip(5).data(), small());
  for (const bool png : {true, false}) {
    try {
      png ? plot.write_png("/dev/full") : plot.write_svg("/dev/full");
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.fault(), Fault::kFailure);
      EXPECT_STREQ(error.what(), "/dev/full: cannot write the plot: No space left on device");
    }
  }
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_F(PlotFile, AFolderThatDoesNotExistIsReportedAndNothingIsLeft) {
  const Plot plot(Clip(5).data(), small());
  EXPECT_THROW(plot.write_png(folder_ / "no" / "plot.png"), Error);
  fs::create_directory(folder_ / "plot.png");
  EXPECT_THROW(plot.write_png(folder_ / "plot.png"), Error);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

TEST(PlotOptions, ValuesOutOfRangeAreRefusedByName) {
  PlotOptions options;
  EXPECT_NO_THROW(options.validate());
  options.width_px = 100;
  EXPECT_THROW(options.validate(), Error);
  options.width_px = 1600;
  for (const ValueRange bad : {ValueRange{0.5, 0.5}, {-0.1, 1.0}, {0.0, 1.1}, {std::nan(""), 1.0}}) {
    options.range = bad;
    EXPECT_THROW(options.validate(), Error);
  }
}

TEST(PlotOptions, TheRasterOfAnotherWidthIsRefused) {
  const Clip clip(5);
  auto raster = similarity::reduce(PlotForm::kSquare, clip.data().z, clip.data().zstar, clip.times, 100);
  EXPECT_THROW(Plot(std::move(raster), 5, {}, small()), Error);
}

}  // namespace
}  // namespace choreo::outputs
