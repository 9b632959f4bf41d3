// SPDX-License-Identifier: Apache-2.0
// Which tones the arms are looked for by, and what the stage refuses.
#include "pipeline/stages/particle_stage.hpp"

#include <cstdint>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "vision/blobs.hpp"

namespace choreo::pipeline {
namespace {

using ::testing::HasSubstr;

const cv::Scalar kSkin(142, 178, 226);  // Blue green red.
const cv::Scalar kShirt(70, 100, 150);

// A face above a brown shirt, which is skin of somebody else.
Observation dressed_like_skin(double time_s) {
  Observation seen;
  seen.time = Nanoseconds(std::int64_t(time_s * 1e9));
  seen.picture = cv::Mat(240, 320, CV_8UC3, cv::Scalar(190, 187, 178));
  cv::rectangle(seen.picture, {110, 84}, {210, 239}, kShirt, cv::FILLED);
  cv::ellipse(seen.picture, {160, 62}, {18, 22}, 0, 0, 360, kSkin, cv::FILLED);
  seen.face = vision::TrackedFace{{160, 60}, 36, 1, 0, 0};
  seen.mask.mask = cv::Mat(240, 320, CV_8UC1, cv::Scalar(255));
  seen.mask.area = 240 * 320;
  return seen;
}

// Skin as wide as a file has it from photographs of many people.
ParticleStageOptions skin_of_a_file() {
  vision::GaussianTone::Parameters skin;
  skin.mean = {0.36, 0.14, 0.8};
  skin.covariance = cv::Matx33d::diag({0.026, 0.02, 0.1});
  ParticleStageOptions options;
  options.tones.learn_skin = false;
  options.tones.file = "skin.toml";
  options.given.put({"skin", 0.3, {{1, std::make_shared<vision::GaussianTone>(skin)}}});
  return options;
}

double share_of_skin(const ParticleStageOptions& options) {
  ParticleStage stage(options);
  Observation last;
  for (int i = 0; i < 30; ++i) {
    last = dressed_like_skin(i * 0.1);
    stage.process(last);
  }
  EXPECT_EQ(stage.learned_s() > 0, options.tones.learn_skin);
  return last.tone_share;
}

std::string complaint(const ParticleStageOptions& options) {
  try {
    const ParticleStage stage(options);
  } catch (const Error& error) {
    EXPECT_EQ(error.fault(), Fault::kUsage);
    return error.what();
  }
  return "nothing was refused";
}

TEST(ParticleStage, LearnsTheClothesWhereTheSkinIsGivenToo) {
  auto options = skin_of_a_file();
  const double with = share_of_skin(options);
  options.tones.learn_clothes = false;
  const double without = share_of_skin(options);
  EXPECT_GT(without, 0.2) << "the shirt is skin to the file's tone";
  EXPECT_LT(with, 0.05);
  EXPECT_GT(with, 0.005) << "the face is still skin";
}

TEST(ParticleStage, SaysHowFarTheSkinIsLearned) {
  ParticleStage learning({}), given(skin_of_a_file());
  for (int i = 0; i <= 30; ++i) {
    auto seen = dressed_like_skin(i * 0.1);
    learning.process(seen);
    EXPECT_NEAR(seen.skin_learned, i / 30.0, 1e-6) << "three seconds of face";
    given.process(seen = dressed_like_skin(i * 0.1));
    EXPECT_EQ(seen.skin_learned, 1);
  }
}

TEST(ParticleStage, RefusesBoundsOutOfTheirRange) {
  ParticleStageOptions options;
  EXPECT_EQ(complaint(options), "nothing was refused");
  options.bounds.alpha_max = 1e-9;
  EXPECT_THAT(complaint(options), HasSubstr("particles.alpha_max"));
}

TEST(ParticleStage, RefusesPicturesTooLargeForArmsAndSaysWhatIsNot) {
  ParticleStage stage({});
  Observation wide;
  wide.picture = cv::Mat(40, 2 * vision::kLongestSide, CV_8UC3, cv::Scalar(0, 0, 0));
  wide.mask.mask = cv::Mat(wide.picture.size(), CV_8UC1, cv::Scalar(255));
  try {
    stage.process(wide);
    ADD_FAILURE() << "not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.fault(), Fault::kUsage);
    EXPECT_THAT(error.what(), HasSubstr("working.rows: pictures of 8192 x 40 are too large"));
    EXPECT_THAT(error.hint(), HasSubstr("at most 20"));
  }
}

}  // namespace
}  // namespace choreo::pipeline
