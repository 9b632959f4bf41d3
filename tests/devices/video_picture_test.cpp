// SPDX-License-Identifier: Apache-2.0
// Upright, of square pixels, in the right colours: what a decoded frame becomes.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include <gmock/gmock.h>

#include "devices/media/deinterlacer.hpp"
#include "devices/media/picture.hpp"
#include "devices/video_fixture.hpp"

namespace choreo::devices {
namespace {

using test::all_frames;
using test::fill_plane;
using test::make_video;
using test::VideoRecipe;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::int32_t kOne = 1 << 16;

std::vector<std::int32_t> matrix(double a, double b, double c, double d) {
  const auto fixed = [](double x) { return static_cast<std::int32_t>(std::lround(x * kOne)); };
  return {fixed(a), fixed(b), 0, fixed(c), fixed(d), 0, 0, 0, 1 << 30};
}

// A picture of 3x2 without loss whose pixels are the letters A to F as grey values.
VideoRecipe letters() {
  VideoRecipe recipe;
  recipe.encoder = "png";
  recipe.pixel_format = AV_PIX_FMT_RGB24;
  recipe.width = 3;
  recipe.height = 2;
  recipe.time_base = {1, 600};
  recipe.times = {0, 20};
  recipe.paint = [](AVFrame& frame, int) {
    for (int y = 0; y < 2; ++y) {
      for (int x = 0; x < 9; ++x)
        frame.data[0][y * frame.linesize[0] + x] = static_cast<std::uint8_t>('A' + 3 * y + x / 3);
    }
  };
  return recipe;
}

std::string as_letters(const cv::Mat& picture) {
  std::string out;
  for (int y = 0; y < picture.rows; ++y) {
    if (y > 0) out += '/';
    for (int x = 0; x < picture.cols; ++x) out += static_cast<char>(picture.at<cv::Vec3b>(y, x)[0]);
  }
  return out;
}

TEST_F(VideoFileTest, EveryDisplayMatrixHangsThePictureUpright) {
  // Source (p, q) goes to (a p + c q, b p + d q), p to the right and q down; worked by hand for ABC/DEF.
  struct Case {
    double a, b, c, d;
    const char* expected;
  };
  constexpr std::array<Case, 8> kCases = {{{1, 0, 0, 1, "ABC/DEF"},
                                           {0, 1, -1, 0, "DA/EB/FC"},
                                           {-1, 0, 0, -1, "FED/CBA"},
                                           {0, -1, 1, 0, "CF/BE/AD"},
                                           {-1, 0, 0, 1, "CBA/FED"},
                                           {1, 0, 0, -1, "DEF/ABC"},
                                           {0, 1, 1, 0, "AD/BE/CF"},
                                           {0, -1, -1, 0, "FC/EB/DA"}}};
  for (const auto& c : kCases) {
    auto recipe = letters();
    recipe.display_matrix = matrix(c.a, c.b, c.c, c.d);
    make_video(folder_ / "a.mov", recipe);
    const auto source = open("a.mov");
    const auto frames = all_frames(*source);
    ASSERT_EQ(frames.size(), 2u);
    EXPECT_EQ(as_letters(frames[0]->bgr), c.expected);
    EXPECT_EQ(as_letters(frames[1]->bgr), c.expected);
    EXPECT_EQ(source->info().size, frames[0]->bgr.size());
    EXPECT_THAT(source->warnings(), IsEmpty());
  }
}

TEST_F(VideoFileTest, AnotherAngleBecomesTheNearestQuarterTurnWithAWarning) {
  auto recipe = letters();
  const double angle = 80 * 3.14159265358979 / 180;
  recipe.display_matrix = matrix(std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle));
  make_video(folder_ / "a.mov", recipe);
  const auto source = open("a.mov");
  EXPECT_EQ(as_letters(source->read({})->bgr), "DA/EB/FC");
  EXPECT_THAT(source->warnings(), ElementsAre(HasSubstr("nearest quarter turn")));
}

TEST(Hanging, EveryAngleIsTheNearestQuarterTurn) {
  for (int degrees = 0; degrees < 360; ++degrees) {
    if (degrees % 90 == 45) continue;  // As near to one as to the other.
    const double angle = degrees * 3.14159265358979 / 180;
    for (const int mirror : {1, -1}) {
      const auto m = matrix(mirror * std::cos(angle), mirror * std::sin(angle), -std::sin(angle), std::cos(angle));
      const auto hanging = hanging_of(m.data());
      EXPECT_EQ(hanging.exact, degrees % 90 == 0) << degrees;
      // With the mirror on p before the turn: turning by t after a horizontal flip is flipping after turning by -t.
      const int turns = (degrees + 45) / 90 % 4;
      EXPECT_EQ(hanging.orientation.quarter_turns, mirror == 1 ? turns : (4 - turns) % 4) << degrees;
      EXPECT_EQ(hanging.orientation.flip_horizontal, mirror == -1) << degrees;
    }
  }
}

TEST(Hanging, ScalesAndZerosTurnNothing) {
  EXPECT_TRUE(hanging_of(matrix(2, 0, 0, 0.5).data()).orientation.is_identity());
  EXPECT_TRUE(hanging_of(matrix(2, 0, 0, 0.5).data()).exact);
  EXPECT_TRUE(hanging_of(matrix(0, 0, 0, 0).data()).orientation.is_identity());
  EXPECT_TRUE(hanging_of(matrix(0, 0, 0, 0).data()).exact);
}

TEST_F(VideoFileTest, RotateAndFlipComeAfterTheFilesOwnOrientation) {
  auto recipe = letters();
  recipe.display_matrix = matrix(0, 1, -1, 0);
  make_video(folder_ / "a.mov", recipe);
  EXPECT_EQ(as_letters(open("a.mov?rotate=90")->read({})->bgr), "FED/CBA");
  EXPECT_EQ(as_letters(open("a.mov?flip=vertical")->read({})->bgr), "FC/EB/DA");
}

TEST_F(VideoFileTest, PixelsBecomeSquareByScalingTheWidth) {
  struct Case {
    AVRational aspect;
    int width, height;
    cv::Size expected;
  };
  for (const auto& c : {Case{{2, 1}, 16, 8, {32, 8}}, Case{{1, 2}, 16, 8, {8, 8}}, Case{{1, 50}, 8, 8, {1, 8}},
                        Case{{12, 11}, 72, 57, {79, 57}}, Case{{1, 1}, 5, 3, {5, 3}}}) {
    VideoRecipe recipe;
    recipe.width = c.width;
    recipe.height = c.height;
    recipe.sample_aspect = c.aspect;
    recipe.paint = [](AVFrame& frame, int) { fill_plane(frame, 0, 77); };
    make_video(folder_ / "a.mkv", recipe);
    const auto source = open("a.mkv");
    EXPECT_EQ(source->info().size, c.expected);
    const auto frame = source->read({});
    EXPECT_EQ(frame->bgr.size(), c.expected);
    EXPECT_EQ(cv::norm(frame->bgr, cv::Mat(c.expected, CV_8UC3, cv::Scalar::all(77)), cv::NORM_INF), 0);
  }
}

TEST(SquarePixels, UnknownAspectsChangeNothing) {
  EXPECT_EQ(with_square_pixels({10, 4}, {0, 1}), cv::Size(10, 4));
  EXPECT_EQ(with_square_pixels({10, 4}, {3, 0}), cv::Size(10, 4));
  EXPECT_EQ(with_square_pixels({10, 4}, {-2, 1}), cv::Size(10, 4));
}

TEST_F(VideoFileTest, AnisotropicPixelsAreScaledBeforeThePictureIsTurned) {
  auto recipe = letters();
  recipe.sample_aspect = {2, 1};
  recipe.display_matrix = matrix(0, 1, -1, 0);
  make_video(folder_ / "a.mov", recipe);
  EXPECT_EQ(open("a.mov")->info().size, cv::Size(2, 6)) << "stored 3x2, shown 6x2, turned 2x6";
}

struct ColourCase {
  const char* name;
  AVColorSpace space;
  AVColorRange range;
  int height;
  cv::Vec3d bgr;
};

// Y 126, Cb 90, Cr 170, worked by hand: limited range y = 110/219, pb = -38/224, pr = 42/224; full range y = 126/255,
// pb = -38/255, pr = 42/255; then r = y + 2 (1 - Kr) pr and so on with Kr, Kb of the standard.
const ColourCase kColours[] = {
    {"BT.709", AVCOL_SPC_BT709, AVCOL_RANGE_MPEG, 16, {47.8, 113.8, 203.4}},
    {"BT.601", AVCOL_SPC_SMPTE170M, AVCOL_RANGE_MPEG, 16, {51.4, 108.8, 195.1}},
    {"BT.2020", AVCOL_SPC_BT2020_NCL, AVCOL_RANGE_MPEG, 16, {46.7, 107.9, 198.6}},
    {"BT.601 full range", AVCOL_SPC_SMPTE170M, AVCOL_RANGE_JPEG, 16, {58.7, 109.1, 184.9}},
    {"unspecified, small", AVCOL_SPC_UNSPECIFIED, AVCOL_RANGE_UNSPECIFIED, 718, {51.4, 108.8, 195.1}},
    {"unspecified, large", AVCOL_SPC_UNSPECIFIED, AVCOL_RANGE_UNSPECIFIED, 720, {47.8, 113.8, 203.4}},
};

TEST_F(VideoFileTest, ColoursFollowTheMatrixAndRangeOfTheFrame) {
  for (const auto& c : kColours) {
    for (const auto format : {AV_PIX_FMT_YUV444P, AV_PIX_FMT_YUV420P, AV_PIX_FMT_YUV422P10, AV_PIX_FMT_YUV420P16}) {
      const int depth = format == AV_PIX_FMT_YUV422P10 ? 10 : format == AV_PIX_FMT_YUV420P16 ? 16 : 8;
      // Full range of more bits ends at 1023, not at 255 * 4: a difference below the tolerance.
      VideoRecipe recipe;
      recipe.pixel_format = format;
      recipe.height = c.height;
      recipe.times = {0};
      recipe.colour_space = c.space;
      recipe.colour_range = c.range;
      recipe.paint = [depth](AVFrame& frame, int) {
        const int samples[] = {126, 90, 170};
        for (int plane = 0; plane < 3; ++plane) fill_plane(frame, plane, samples[plane] << (depth - 8), depth > 8);
      };
      make_video(folder_ / "a.mkv", recipe);
      const auto frame = open("a.mkv")->read({});
      double worst = 0;
      for (int channel = 0; channel < 3; ++channel) {
        worst = std::max(worst, std::abs(frame->bgr.at<cv::Vec3b>(5, 5)[channel] - c.bgr[channel]));
      }
      EXPECT_LE(worst, 1.5) << c.name << ", " << depth << " bit: " << frame->bgr.at<cv::Vec3b>(5, 5);
    }
  }
}

TEST_F(VideoFileTest, BlackAndWhiteAreReached) {
  struct Case {
    AVColorRange range;
    int black, white;
  };
  for (const auto& c : {Case{AVCOL_RANGE_MPEG, 16, 235}, Case{AVCOL_RANGE_JPEG, 0, 255}}) {
    for (const auto format : {AV_PIX_FMT_YUV420P, AV_PIX_FMT_GRAY8}) {
      VideoRecipe recipe;
      recipe.pixel_format = format;
      recipe.colour_range = c.range;
      recipe.times = {0, 40};
      recipe.paint = [&](AVFrame& frame, int index) {
        fill_plane(frame, 0, index == 0 ? c.black : c.white);
        for (int plane = 1; plane < 3 && frame.data[plane] != nullptr; ++plane) fill_plane(frame, plane, 128);
      };
      make_video(folder_ / "a.mkv", recipe);
      const auto frames = all_frames(*open("a.mkv"));
      ASSERT_EQ(frames.size(), 2u);
      EXPECT_EQ(frames[0]->bgr.at<cv::Vec3b>(3, 3), cv::Vec3b(0, 0, 0)) << format;
      EXPECT_EQ(frames[1]->bgr.at<cv::Vec3b>(3, 3), cv::Vec3b(255, 255, 255)) << format;
    }
  }
}

TEST_F(VideoFileTest, PaletteAlphaAndDeepPicturesAreRead) {
  struct Case {
    const char* encoder;
    AVPixelFormat format;
    const char* name;
  };
  for (const auto& c : {Case{"png", AV_PIX_FMT_PAL8, "a.mov"}, Case{"gif", AV_PIX_FMT_PAL8, "a.gif"},
                        Case{"ffv1", AV_PIX_FMT_GRAY16LE, "a.mkv"}, Case{"ffv1", AV_PIX_FMT_GBRP10LE, "a.mkv"},
                        Case{"ffv1", AV_PIX_FMT_BGRA, "a.mkv"}, Case{"png", AV_PIX_FMT_RGBA64BE, "a.mov"},
                        Case{"png", AV_PIX_FMT_MONOBLACK, "a.mov"}}) {
    VideoRecipe recipe;
    recipe.encoder = c.encoder;
    recipe.pixel_format = c.format;
    recipe.width = 33;
    recipe.height = 17;
    recipe.time_base = std::string(c.encoder) == "gif" ? AVRational{1, 100} : AVRational{1, 1000};
    recipe.times = {0, 4};
    recipe.paint = [&](AVFrame& frame, int) {
      // All samples at their largest: white in every format.
      for (int plane = 0; plane < 3 && frame.data[plane] != nullptr; ++plane) {
        if (plane == 1 && c.format == AV_PIX_FMT_PAL8) {
          std::fill_n(frame.data[1], AVPALETTE_SIZE, std::uint8_t{255});
        } else {
          fill_plane(frame, plane, c.format == AV_PIX_FMT_GBRP10LE ? 1023 : 0xffff, true);
        }
      }
    };
    make_video(folder_ / c.name, recipe);
    const auto source = open(c.name);
    EXPECT_EQ(source->info().size, cv::Size(33, 17));
    const auto frame = source->read({});
    EXPECT_EQ(frame->bgr.type(), CV_8UC3);
    EXPECT_EQ(frame->bgr.at<cv::Vec3b>(16, 32), cv::Vec3b(255, 255, 255)) << c.encoder << " " << c.format;
  }
}

TEST_F(VideoFileTest, EightThousandPixelsAreRead) {
  VideoRecipe recipe;
  recipe.encoder = "mjpeg";
  recipe.pixel_format = AV_PIX_FMT_YUVJ420P;
  recipe.width = 7680;
  recipe.height = 4320;
  recipe.times = {0};
  recipe.paint = [](AVFrame& frame, int) {
    fill_plane(frame, 0, 200);
    fill_plane(frame, 1, 128);
    fill_plane(frame, 2, 128);
  };
  make_video(folder_ / "a.mkv", recipe);
  const auto frame = open("a.mkv")->read({});
  ASSERT_EQ(frame->bgr.size(), cv::Size(7680, 4320));
  EXPECT_EQ(frame->bgr.at<cv::Vec3b>(4319, 7679), cv::Vec3b(200, 200, 200));
}

// A square that moves by eight pixels a frame, its odd lines filmed half a frame later.
void paint_square_of_two_moments(AVFrame& frame, int index) {
  for (int plane = 0; plane < 3; ++plane) test::fill_plane(frame, plane, plane == 0 ? 60 : 128);
  for (int y = 24; y < 72; ++y) {
    const int left = 10 + 8 * index + (y % 2 == 0 ? 0 : 4);
    std::fill_n(frame.data[0] + std::ptrdiff_t{y} * frame.linesize[0] + left, 30, std::uint8_t{200});
  }
}

TEST_F(VideoFileTest, AnInterlacedFilmIsDeinterlacedThoughItDoesNotSaySo) {
  for (const std::size_t length : {1u, 2u, 9u}) {
    VideoRecipe recipe;
    recipe.pixel_format = AV_PIX_FMT_YUV420P;
    recipe.width = 128;
    recipe.height = 96;
    recipe.times.clear();
    for (std::size_t k = 0; k < length; ++k) recipe.times.push_back(std::int64_t(40 * k + (k > 3 ? 7 : 0)));
    recipe.paint = paint_square_of_two_moments;
    make_video(folder_ / "a.mkv", recipe);
    const auto frames = all_frames(*open("a.mkv"));
    ASSERT_EQ(frames.size(), length);
    for (std::size_t k = 0; k < length; ++k) {
      EXPECT_EQ(frames[k]->device_time, std::chrono::milliseconds(recipe.times[k]));
      EXPECT_EQ(frames[k]->sequence, k);
      // Where the square is in either field alone: four pixels at each side of it.
      int combs = 0;
      for (int y = 26; y < 70; ++y) {
        const auto green = [&](int line, int x) { return int(frames[k]->bgr.at<cv::Vec3b>(line, x)[1]); };
        for (const int x : {int(11 + 8 * k), int(42 + 8 * k)}) combs += std::abs(green(y, x) - green(y + 1, x)) > 40;
      }
      // That it is interlaced shows in what moved.
      if (k > 0 && length > 2) {
        EXPECT_LE(combs, 4) << k << " of " << length;
      }
    }
  }
}

Libav<AVFrame> frame_of(const std::function<int(int, int)>& value) {
  Libav<AVFrame> frame(av_frame_alloc());
  frame->format = AV_PIX_FMT_YUV420P;
  frame->width = 128;
  frame->height = 96;
  EXPECT_GE(av_frame_get_buffer(frame.get(), 0), 0);
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 128; ++x) frame->data[0][y * frame->linesize[0] + x] = std::uint8_t(value(x, y));
  }
  return frame;
}

// Whether it is seen in the second of two.
bool interlaced(const std::function<int(int, int)>& first, const std::function<int(int, int)>& second) {
  Interlacing interlacing;
  EXPECT_FALSE(interlacing.is_seen_in(*frame_of(first))) << "nothing moved yet";
  return interlacing.is_seen_in(*frame_of(second));
}

TEST(Interlacing, IsSeenWhereAFrameSaysSoOrWhatMovedHasCombs) {
  const auto edge = [](int at) { return [at](int x, int y) { return x > at + y % 2 * 3 ? 200 : 50; }; };
  EXPECT_TRUE(interlaced(edge(30), edge(36)));
  const auto plain = frame_of([](int, int) { return 100; });
  EXPECT_FALSE(Interlacing().is_seen_in(*plain));
  plain->interlaced_frame = 1;
  EXPECT_TRUE(Interlacing().is_seen_in(*plain));
}

TEST(Interlacing, IsNotSeenInNoiseOrPatternsOrStripes) {
  cv::RNG random(1);
  const auto noise = [&](int, int) { return random.uniform(0, 256); };
  EXPECT_FALSE(interlaced(noise, noise));
  const auto stripes = [](int, int y) { return y % 2 * 200; };
  EXPECT_FALSE(interlaced(stripes, stripes)) << "a blind that hangs still";
  const auto broad = [](int by) { return [by](int, int y) { return (y + by) / 8 % 2 * 200; }; };
  EXPECT_FALSE(interlaced(broad(0), broad(3)));
  const auto checks = [](int by) { return [by](int x, int y) { return (x + y + by) % 2 * 200; }; };
  EXPECT_FALSE(interlaced(checks(0), checks(1)));
  const auto edge = [](int at) { return [at](int x, int) { return x > at ? 200 : 50; }; };
  EXPECT_FALSE(interlaced(edge(30), edge(36))) << "progressive";
}

TEST_F(VideoFileTest, ATinyFilmThatIsTaggedInterlacedIsReadAsItIs) {
  VideoRecipe recipe;
  recipe.pixel_format = AV_PIX_FMT_YUV420P;
  recipe.width = recipe.height = 2;
  recipe.paint = [](AVFrame& frame, int) { frame.interlaced_frame = 1; };
  make_video(folder_ / "a.mkv", recipe);
  EXPECT_EQ(all_frames(*open("a.mkv")).size(), recipe.times.size());
}

}  // namespace
}  // namespace choreo::devices
