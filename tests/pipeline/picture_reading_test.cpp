// SPDX-License-Identifier: Apache-2.0
// Pictures of a signaller that are read by tone, each by itself.
#include "pipeline/picture_reading.hpp"

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "support/signaller.hpp"
#include "vision/tone_model.hpp"

namespace choreo::pipeline {
namespace {

using test::signaller_stills;
using test::Still;

constexpr const char* kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZ";

/// Knows where the face is; what detectors make of pictures has tests of its own.
class KnownFace final : public vision::FaceDetector {
 public:
  std::vector<vision::Face> detect(const cv::Mat&, const cv::Rect&, double least, double most,
                                   vision::FaceLook) override {
    if (most_ == 0) {
      least_ = least;
      most_ = most;
    }
    if (face_.empty()) return {};
    return {{face_, 0.7}};
  }
  cv::Rect2d face_;
  double least_ = 0, most_ = 0;
};

std::string letters_of(const std::vector<Still>& stills, const ToneReaderOptions& options = {}) {
  KnownFace face;
  const ToneReader reader(face, options);
  std::string out;
  for (const auto& still : stills) {
    face.face_ = still.face;
    const auto reading = reader.read(still.bgr);
    out += reading.sign ? std::string(*reading.sign) : "-";
  }
  return out;
}

/// The flags' red and yellow, as a user would have trained them.
vision::Tone flag_tone() {
  vision::Tone tone{"flag", 0.2, {}};
  for (const auto& bgr : {cv::Vec3b(36, 30, 204), cv::Vec3b(24, 206, 246)}) {
    std::vector<cv::Vec3b> pixels;
    cv::RNG random(9);
    for (int k = 0; k < 400; ++k) {
      cv::Vec3b pixel;
      const double light = random.uniform(0.8, 1.15);
      for (int c = 0; c < 3; ++c) pixel[c] = cv::saturate_cast<std::uint8_t>(light * bgr[c] + random.gaussian(4));
      pixels.push_back(pixel);
    }
    tone.parts.push_back({1, std::make_shared<vision::GaussianTone>(vision::GaussianTone::fitted(pixels))});
  }
  return tone;
}

ToneReaderOptions with_flags() {
  ToneReaderOptions options;
  options.given.put(flag_tone());
  options.tones.arms = {"flag"};
  options.arms.reach = 6;  // As of the preset.
  options.arms.typical_arm = 4;
  options.arms.largest_arm = 12;
  return options;
}

devices::synthetic::PerformerSettings somebody(const char* skin, const char* sleeves, bool flags = false) {
  devices::synthetic::PerformerSettings settings;
  settings.skin = skin;
  settings.sleeves = sleeves;
  settings.flags = flags;
  return settings;
}

// How many are right; none is another.
int right_of(const std::string& read) {
  int right = 0;
  for (std::size_t k = 0; k < read.size(); ++k) {
    right += read[k] == kAlphabet[k] ? 1 : 0;
    EXPECT_TRUE(read[k] == '-' || read[k] == kAlphabet[k]) << read;
  }
  std::printf("%s %d\n", read.c_str(), right);
  return right;
}

// O and W cross the face, and are one with it by tone.
TEST(TonePictures, BareForearmsAreReadBeforeAWallOfOtherColours) {
  EXPECT_GE(right_of(letters_of(signaller_stills(kAlphabet, 51, somebody("light", "half"), "cluttered"))), 22);
  EXPECT_GE(right_of(letters_of(signaller_stills(kAlphabet, 52, somebody("dark", "half"), "cluttered"))), 22);
  EXPECT_GE(right_of(letters_of(signaller_stills(kAlphabet, 53, somebody("medium", "none"), "plain"))), 22);
}

TEST(TonePictures, WhatCannotBeToldIsLeftOpenAndNotGuessed) {
  right_of(letters_of(signaller_stills(kAlphabet, 51, somebody("light", "half"), "wooden")));
  right_of(letters_of(signaller_stills(kAlphabet, 54, somebody("light", "long"), "cluttered")));
}

TEST(TonePictures, FlagsAreReadByTheirToneAndByTheirPlaceAtTheArmsEnds) {
  EXPECT_GE(right_of(letters_of(signaller_stills(kAlphabet, 51, somebody("light", "long", true), "cluttered"), with_flags())), 10);
}

TEST(TonePictures, WithoutAFaceOrATonesPixelsThatIsWhy) {
  KnownFace face;
  const ToneReader reader(face, {});
  const auto still = signaller_stills("R", 51).front();
  EXPECT_EQ(reader.read(still.bgr).why, NoSign::kNoFace);
  EXPECT_EQ(reader.read(still.bgr).confidence, 0);
  face.face_ = {10, 10, 4, 4};
  EXPECT_EQ(reader.read(still.bgr).why, NoSign::kNoTone);
  face.face_ = still.face;
  EXPECT_EQ(reader.read(cv::Mat(450, 600, CV_8UC3, cv::Scalar(90, 120, 200))).sign, std::nullopt);
}

TEST(TonePictures, FacesAreSearchedInTheSizesThatAreSet) {
  KnownFace face;
  ToneReaderOptions options;
  options.least_face = 0.1;
  options.most_face = 0.3;
  (void)ToneReader(face, options).read(cv::Mat::zeros(300, 500, CV_8UC3));
  EXPECT_DOUBLE_EQ(face.least_, 30);
  EXPECT_DOUBLE_EQ(face.most_, 90);
  options.most_face = 0.1;
  EXPECT_THROW(ToneReader(face, options), Error);
}

TEST(ReducedPicture, IsTheSameWhereItIsSmallEnough) {
  const cv::Mat small(600, 800, CV_8UC3), large(1200, 1600, CV_8UC3, cv::Scalar(1, 2, 3));
  EXPECT_EQ(reduced_picture(small).data, small.data);
  EXPECT_EQ(reduced_picture(large).size(), cv::Size(800, 600));
}

}  // namespace
}  // namespace choreo::pipeline
