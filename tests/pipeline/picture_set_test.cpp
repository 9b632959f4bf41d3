// SPDX-License-Identifier: Apache-2.0
#include "pipeline/picture_set.hpp"

#include <algorithm>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "pipeline/signaller_face.hpp"
#include "support/signaller.hpp"
#include "vision/face_detector.hpp"

namespace choreo::pipeline {
namespace {

using test::signaller_stills;
using test::Still;

/// Knows where the faces are; what detectors make of pictures has tests of its own.
class KnownFaces final : public vision::FaceDetector {
 public:
  explicit KnownFaces(std::vector<std::vector<vision::Face>> faces) : faces_(std::move(faces)) {}
  std::vector<vision::Face> detect(const cv::Mat& grey, const cv::Rect&, double, double, vision::FaceLook) override {
    if (grey.empty() || faces_.empty()) return {};
    return faces_[next_++ % faces_.size()];
  }

 private:
  std::vector<std::vector<vision::Face>> faces_;
  std::size_t next_ = 0;
};

std::vector<cv::Mat> pictures_of(const std::vector<Still>& stills) {
  std::vector<cv::Mat> out;
  for (const auto& still : stills) out.push_back(still.bgr);
  return out;
}

/// The true faces with an error of a few pixels, and a false one here and there.
std::vector<std::vector<vision::Face>> faces_of(const std::vector<Still>& stills) {
  cv::RNG random(5);
  std::vector<std::vector<vision::Face>> out;
  for (std::size_t i = 0; i < stills.size(); ++i) {
    std::vector<vision::Face> faces;
    const auto& f = stills[i].face;
    if (!f.empty()) {
      const double width = f.width * random.uniform(0.9, 1.1);
      const cv::Point2d at(f.x + f.width / 2 + random.uniform(-2.0, 2.0),
                           f.y + f.height / 2 + random.uniform(-2.0, 2.0));
      faces.push_back({{at.x - width / 2, at.y - width / 2, width, width}, 0.7});
    }
    if (i % 6 == 1) faces.push_back({{30.0 + 11 * double(i), 300, 60, 60}, 0.8});
    out.push_back(faces);
  }
  return out;
}

std::vector<PictureReading> read(const std::vector<Still>& stills) {
  KnownFaces faces(faces_of(stills));
  return read_pictures(pictures_of(stills), faces, {}).value();
}

std::string letters_of(const std::vector<PictureReading>& readings) {
  std::string out;
  for (const auto& reading : readings) out += reading.sign ? std::string(*reading.sign) : "-";
  return out;
}

constexpr const char* kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZ";

// A performer, room and light that nothing was tuned on.
TEST(PictureSet, TheWholeAlphabetIsReadBeforeWoodOfSkinsColourByAMovingCamera) {
  EXPECT_EQ(letters_of(read(signaller_stills(kAlphabet, 41))), kAlphabet);
}

TEST(PictureSet, AFewPicturesAreReadWhetherOrNotBothArmsMove) {
  EXPECT_EQ(letters_of(read(signaller_stills("RUN", 11))), "RUN");
  EXPECT_EQ(letters_of(read(signaller_stills("ABCD", 1))), "ABCD") << "the left arm hangs in all";
}

TEST(PictureSet, TheOrderOfThePicturesChangesNoLetter) {
  auto stills = signaller_stills("DHMRUX", 13);
  const auto there = letters_of(read(stills));
  std::reverse(stills.begin(), stills.end());
  auto back = letters_of(read(stills));
  std::reverse(back.begin(), back.end());
  EXPECT_EQ(there, "DHMRUX");
  EXPECT_EQ(back, there);
}

TEST(PictureSet, APictureOfAnotherRoomIsReadByItselfAndSpoilsNothing) {
  auto stills = signaller_stills("KLRU", 13);
  stills.insert(stills.begin() + 1, {"", cv::Mat(300, 700, CV_8UC3, cv::Scalar(90, 120, 60)), {}});
  const auto readings = read(stills);
  EXPECT_FALSE(readings[1].shared);
  EXPECT_FALSE(readings[1].sign);
  EXPECT_EQ(letters_of(readings), "K-LRU");
}

TEST(PictureSet, WithoutFacesWithoutMovementAndWithoutPicturesThereIsNoSign) {
  KnownFaces nobody({});
  const auto stills = signaller_stills("RU", 13);
  const auto faceless = read_pictures(pictures_of(stills), nobody, {}).value();
  for (const auto& reading : faceless) {
    EXPECT_FALSE(reading.sign);
    EXPECT_FALSE(reading.face);
  }
  // One picture three times: nothing differs from the wall.
  const std::vector<Still> same(3, stills.front());
  for (const auto& reading : read(same)) EXPECT_FALSE(reading.sign);
  EXPECT_TRUE(read_pictures({}, nobody, {}).value().empty());
}

TEST(PictureSet, StoppingGivesNothingAndOptionsOutOfRangeAreRefused) {
  KnownFaces nobody({});
  std::stop_source stop;
  stop.request_stop();
  const std::vector<cv::Mat> one = {cv::Mat::zeros(100, 100, CV_8UC3)};
  EXPECT_FALSE(read_pictures(one, nobody, {}, {}, stop.get_token()));
  PictureSetOptions options;
  options.longest_side = 10;
  EXPECT_THROW((void)read_pictures(one, nobody, options), Error);
}

FacesOfView view(std::vector<vision::Face> faces, cv::Point arm) {
  FacesOfView out;
  out.faces = std::move(faces);
  out.differs = cv::Mat::zeros(300, 400, CV_8UC1);
  out.differs(cv::Rect(arm, cv::Size(12, 60))).setTo(255);
  out.difference = out.differs.clone();
  return out;
}

TEST(SignallerFace, IsTheOneThatStirsAndHasArmsAboutIt) {
  const vision::Face poster{{300, 40, 30, 30}, 0.9};
  const vision::Face stray{{20, 200, 50, 50}, 0.95};
  std::vector<FacesOfView> views;
  for (int i = 0; i < 6; ++i) {
    const vision::Face own{{100.0 + i, 80, 30, 30}, 0.5};
    std::vector<vision::Face> faces = {poster, own};
    if (i == 2) faces = {poster, stray};
    views.push_back(view(faces, {60 + 10 * i, 120}));
    views.back().difference(cv::Rect(105, 85, 10, 10)).setTo(9);
  }
  const auto found = signaller_faces(views);
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_TRUE(found[i].face);
    EXPECT_NEAR(found[i].face->box.x, 102, 4) << i;
    EXPECT_EQ(found[i].seen, i != 2) << "where it is missed, it is where it is in the others";
  }
  EXPECT_FALSE(signaller_faces(std::vector<FacesOfView>{view({}, {0, 0})}).front().face);
}

}  // namespace
}  // namespace choreo::pipeline
