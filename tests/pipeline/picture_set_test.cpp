// SPDX-License-Identifier: Apache-2.0
#include "pipeline/picture_set.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "body/semaphore_signs.hpp"
#include "core/error.hpp"
#include "pipeline/face_models.hpp"
#include "pipeline/signaller_face.hpp"
#include "support/long_lane.hpp"
#include "support/signaller.hpp"
#include "vision/face_detector.hpp"
#include "vision/tone_model.hpp"

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

std::vector<PictureReading> read(const std::vector<Still>& stills, const PictureSetOptions& options = {}) {
  KnownFaces faces(faces_of(stills));
  return read_pictures(pictures_of(stills), faces, options).value();
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
  for (const auto& reading : readings) EXPECT_NE(reading.sign.has_value(), reading.why.has_value());
}

TEST(PictureSet, AFaceTooSmallToLearnSkinFromTellsNothingAndThatIsWhy) {
  const auto readings = read({{"", cv::Mat(360, 480, CV_8UC3, cv::Scalar(90, 120, 60)), cv::Rect2d(220, 80, 8, 8)}});
  ASSERT_EQ(readings.size(), 1U);
  EXPECT_TRUE(readings[0].face);
  EXPECT_EQ(readings[0].why, NoSign::kNoTone);
  EXPECT_EQ(readings[0].confidence, 0);
}

TEST(PictureSet, WithoutFacesWithoutMovementAndWithoutPicturesThereIsNoSign) {
  KnownFaces nobody({});
  const auto stills = signaller_stills("RU", 13);
  const auto faceless = read_pictures(pictures_of(stills), nobody, {}).value();
  ASSERT_EQ(faceless.size(), 2U);
  for (const auto& reading : faceless) {
    EXPECT_FALSE(reading.sign);
    EXPECT_FALSE(reading.face);
    EXPECT_EQ(reading.why, NoSign::kNoFace);
    EXPECT_EQ(reading.confidence, 0) << "nothing is known";
  }
  // One picture three times: nothing differs from the wall.
  const std::vector<Still> same(3, stills.front());
  const auto still = read(same);
  ASSERT_EQ(still.size(), 3U);
  for (const auto& reading : still) EXPECT_FALSE(reading.sign);
  EXPECT_TRUE(read_pictures({}, nobody, {}).value().empty());
}

TEST(PictureSet, TellsHowFarItIsWithoutLeapsOrStepsBack) {
  const auto stills = signaller_stills("DHMRUX", 13);
  KnownFaces faces(faces_of(stills));
  double before = 0;
  ASSERT_TRUE(read_pictures(pictures_of(stills), faces, {}, [&](double share) {
    EXPECT_GE(share, before);
    EXPECT_LE(share, before + 0.25);
    before = share;
  }));
  EXPECT_EQ(before, 1);
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

TEST(PictureSet, FlagsAreReadByTheirToneAndByTheirPlaceAtTheArmsEnds) {
  devices::synthetic::PerformerSettings signaller;
  signaller.flags = true;
  signaller.sleeves = "long";
  signaller.skin = "light";
  const auto stills = signaller_stills(kAlphabet, 51, signaller);
  PictureSetOptions options;
  options.given.put(flag_tone());
  options.tones.arms = {"flag"};
  options.arms.reach = 6;  // As of the preset.
  options.arms.typical_arm = 4;
  options.arms.largest_arm = 12;
  EXPECT_EQ(letters_of(read(stills, options)), kAlphabet);
}

TEST(PictureSet, OnlyWhatIsAsLikelyAsTheThresholdIsSeenOfArms) {
  const auto stills = signaller_stills("RUX", 13);
  const auto seen_at = [&](double threshold) {
    PictureSetOptions options;
    options.tones.threshold = threshold;
    int seen = 0;
    for (const auto& reading : read(stills, options)) seen += cv::countNonZero(reading.evidence);
    return seen;
  };
  const auto usual = seen_at(0.5);
  EXPECT_LT(seen_at(0.99), usual);
  EXPECT_GT(seen_at(0.05), usual);
}

TEST(PictureSet, WithoutLearningOnlyTheGivenTonesAreLookedFor) {
  PictureSetOptions options;
  options.tones.learn_skin = false;
  options.tones.file = "flag.toml";
  options.tones.arms = {"flag"};
  options.given.put(flag_tone());
  const auto stills = signaller_stills("RUN", 11);
  EXPECT_EQ(letters_of(read(stills)), "RUN") << "by its skin";
  const auto readings = read(stills, options);
  ASSERT_EQ(readings.size(), 3U);
  for (const auto& reading : readings) EXPECT_FALSE(reading.sign);
}

/// Remembers which faces were asked for.
class AskedFaces final : public vision::FaceDetector {
 public:
  std::vector<vision::Face> detect(const cv::Mat&, const cv::Rect&, double least, double most,
                                   vision::FaceLook) override {
    least_.push_back(least);
    most_.push_back(most);
    return {};
  }
  std::vector<double> least_, most_;
};

TEST(PictureSet, FacesAreSearchedInTheSizesThatAreSet) {
  AskedFaces detector;
  PictureSetOptions options;
  options.least_face = 0.1;
  options.most_face = 0.3;
  const std::vector<cv::Mat> one = {cv::Mat::zeros(300, 500, CV_8UC3)};
  ASSERT_TRUE(read_pictures(one, detector, options));
  EXPECT_DOUBLE_EQ(detector.least_.front(), 30);
  EXPECT_DOUBLE_EQ(detector.most_.front(), 90);
  options.most_face = 0.1;
  EXPECT_THROW((void)read_pictures(one, detector, options), Error);
}

recognition::SignCoverage coverage_of(const std::string& sign, double overlap, double seen) {
  recognition::SignCoverage out;
  out.overlap.fill(0.2);
  const auto signs = body::semaphore_signs();
  for (std::size_t k = 0; k < signs.size(); ++k) {
    if (signs[k].name == sign) out.overlap[k] = overlap;
  }
  out.seen = seen;
  return out;
}

TEST(PictureAnswer, IsTheSignThatCoversMostAndThatIsCertain) {
  const auto answer = answer_of(coverage_of("K", 0.8, 1.8));
  EXPECT_EQ(answer.sign, "K");
  EXPECT_FALSE(answer.why);
  EXPECT_GT(answer.confidence, 0.99);
  EXPECT_LT(answer_of(coverage_of("K", 0.5, 1.8)).confidence, 0.95);
}

TEST(PictureAnswer, ThatNothingIsShownIsAsCertainAsWhatDecidedIt) {
  // However well a sign covers it: a speck is no arm.
  const auto speck = answer_of(coverage_of("K", 0.9, 0.02));
  EXPECT_FALSE(speck.sign);
  EXPECT_GT(speck.confidence, 0.95);
  EXPECT_EQ(speck.runner_up, "K");
  EXPECT_EQ(speck.why, NoSign::kNoArms);
  EXPECT_NEAR(answer_of(coverage_of("K", 0.9, 0.2499)).confidence, 0.5, 0.01);
  const auto unlike = answer_of(coverage_of("K", 0.3, 1.8));
  EXPECT_FALSE(unlike.sign);
  EXPECT_GT(unlike.confidence, 0.95);
  EXPECT_EQ(unlike.why, NoSign::kUnlikeAny);
  EXPECT_EQ(answer_of({}).confidence, 1);
  EXPECT_EQ(answer_of({}).why, NoSign::kNoArms);
}

TEST(PictureAnswer, HangingArmsAreNoLetterAndNoRunnerUp) {
  auto hanging = coverage_of("REST", 0.8, 1.8);
  hanging.overlap[0] = 0.5;
  const auto answer = answer_of(hanging);
  EXPECT_FALSE(answer.sign);
  EXPECT_GT(answer.confidence, 0.99) << "that it is no letter";
  EXPECT_EQ(answer.runner_up, body::semaphore_signs()[0].name);
  EXPECT_EQ(answer.why, NoSign::kArmsHang);
}

// What docs/semaphore.md publishes: nothing but the pictures is given, and nothing was tuned on these performers.
TEST(PictureSet, TheWholeAlphabetIsReadWithTheFacesThatTheDetectorFinds) {
  const auto detector = load_face_detector({});
  std::size_t right = 0;
  constexpr std::uint64_t kFirst = 51;
  const std::size_t signallers = test::in_long_lane() ? 4 : 1;
  for (std::uint64_t seed = kFirst; seed < kFirst + signallers; ++seed) {
    const auto stills = signaller_stills(kAlphabet, seed);
    const auto readings = read_pictures(pictures_of(stills), *detector, {}).value();
    const auto letters = letters_of(readings);
    const auto seen = std::count_if(readings.begin(), readings.end(), [](const auto& r) { return r.face_seen; });
    std::printf("signaller %d: %s, face seen in %d\n", int(seed), letters.c_str(), int(seen));
    for (std::size_t i = 0; i < stills.size(); ++i) {
      right += readings[i].sign == stills[i].letter ? 1 : 0;
      EXPECT_TRUE(!readings[i].sign || readings[i].sign == stills[i].letter) << "no letter is taken for another";
    }
  }
  EXPECT_EQ(right, signallers * std::string_view(kAlphabet).size());
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
  ASSERT_EQ(found.size(), views.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_TRUE(found[i].face);
    EXPECT_NEAR(found[i].face->box.x, 102, 4) << i;
    EXPECT_EQ(found[i].seen, i != 2) << "where it is missed, it is where it is in the others";
  }
  EXPECT_FALSE(signaller_faces(std::vector<FacesOfView>{view({}, {0, 0})}).front().face);
}

}  // namespace
}  // namespace choreo::pipeline
