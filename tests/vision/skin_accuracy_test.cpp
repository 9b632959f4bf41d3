// SPDX-License-Identifier: Apache-2.0
// How well skin learned from the face finds bare arms: the tables of docs/tones.md.
#include <array>
#include <cstdio>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "config/colour_table.hpp"
#include "devices/synthetic/performer.hpp"
#include "devices/synthetic/scene.hpp"
#include "support/long_lane.hpp"
#include "support/shared_data.hpp"
#include "vision/tone_learner.hpp"
#include "vision/tone_mapper.hpp"

namespace choreo::vision {
namespace {

using devices::synthetic::Performer;
using devices::synthetic::PerformerSettings;

struct Counts {
  double hits = 0, false_hits = 0, missed = 0;

  void operator+=(const Counts& other) {
    hits += other.hits;
    false_hits += other.false_hits;
    missed += other.missed;
  }
  [[nodiscard]] double precision() const { return hits / std::max(1.0, hits + false_hits); }
  [[nodiscard]] double recall() const { return hits / std::max(1.0, hits + missed); }
  [[nodiscard]] double f1() const { return 2 * hits / std::max(1.0, 2 * hits + false_hits + missed); }
};

ToneSet tones_of(const ToneLearner& learner, const ToneOptions& options) {
  ToneSet set;
  set.outliers = options.outliers;
  set.put(*learner.skin());
  if (learner.clothes()) set.put(*learner.clothes());
  return set;
}

// Learns from faces that semaphore shows in its first two seconds, then looks for the arms inside the body. Head and
// neck, which are skin and no arm, count on neither side.
Counts arms_of(const PerformerSettings& settings, const ToneOptions& options) {
  const Performer performer("semaphore", settings);
  ToneLearner learner(options);
  const auto face_of = [](const cv::Rect2d& box) {
    return TrackedFace{{box.x + box.width / 2, box.y + box.height / 2}, box.width, 1, 1, 0};
  };
  const int step = static_cast<int>(settings.fps / 10);
  for (int i = 0; i < 12; ++i) {
    const auto frame = performer.perform(performer.first_frame() + i * step);
    if (!frame.face.empty()) learner.add(frame.bgr, face_of(frame.face), to_seconds(frame.time), frame.mask);
  }
  Counts counts;
  if (!learner.skin()) {
    ADD_FAILURE() << "no skin was learned";
    return counts;
  }
  const ToneMapper mapper(tones_of(learner, options));
  const auto skin = mapper.tones().find("skin");
  for (int i = 0; i < 6; ++i) {
    const auto frame = performer.perform(performer.first_frame() + 60 + i * 450);
    if (frame.face.empty()) continue;
    const auto face = face_of(frame.face);
    cv::Mat where = frame.mask.clone();
    const cv::Point head(cvRound(face.centre.x), cvRound(face.centre.y));
    cv::ellipse(where, head, cv::Size(cvRound(face.width), cvRound(1.35 * face.width)), 0, 0, 360, 0, cv::FILLED);
    const cv::Mat arms = (frame.bare_arm[0] | frame.bare_arm[1]) & where;
    const cv::Mat found = mapper.posterior(frame.bgr, where, skin) >= 255 * options.threshold;
    counts += {double(cv::countNonZero(found & arms)), double(cv::countNonZero(found & ~arms)),
               double(cv::countNonZero(~found & arms))};
  }
  return counts;
}

// Looks that nothing was tuned on.
std::vector<std::uint64_t> unseen_looks() {
  if (test::in_long_lane()) return {11, 12, 13};
  return {11};
}

Counts over_seeds(const std::string& skin, const std::string& light, const ToneOptions& options,
                  const std::vector<std::uint64_t>& seeds = unseen_looks()) {
  Counts all;
  for (const auto seed : seeds) {
    PerformerSettings settings;
    settings.size = {320, 240};
    settings.seed = seed;
    settings.empty = 0;
    settings.skin = skin;
    settings.light = light;
    all += arms_of(settings, options);
  }
  return all;
}

class BareArms : public ::testing::TestWithParam<std::tuple<std::string, ToneKind>> {};

TEST_P(BareArms, OfAllSkinsAreFoundByTheToneOfTheFace) {
  const auto& [light, kind] = GetParam();
  ToneOptions options;
  options.model = kind;
  ASSERT_EQ(devices::synthetic::skin_names().size(), 7U);
  for (const auto& skin : devices::synthetic::skin_names().subspan(1)) {
    const auto c = over_seeds(skin, light, options);
    std::printf("skin %-9s %-8s %-11s precision %.3f recall %.3f F1 %.3f\n", name_of(kind), light.c_str(), skin.c_str(),
                c.precision(), c.recall(), c.f1());
    EXPECT_GE(c.recall(), 0.85) << skin;
    EXPECT_GE(c.f1(), skin == "dark" ? 0.6 : 0.8) << skin;
  }
}

INSTANTIATE_TEST_SUITE_P(Skin, BareArms,
                         ::testing::Combine(::testing::Values("neutral", "warm", "dim", "cool"),
                                            ::testing::Values(ToneKind::kGaussian, ToneKind::kHistogram)),
                         [](const auto& each) {
                           return std::get<0>(each.param) + "_" + name_of(std::get<1>(each.param));
                         });

// Seed 1 wears dark brown trousers, of skin's hue.
TEST(Skin, IsToldFromBrownTrousersWhereTheClothesAreLearnedToo) {
  ToneOptions with;
  ToneOptions without;
  without.learn_clothes = false;
  ASSERT_EQ(devices::synthetic::skin_names().size(), 7U);
  for (const auto& skin : devices::synthetic::skin_names().subspan(1)) {
    for (const auto* light : {"neutral", "dim"}) {
      const auto a = over_seeds(skin, light, without, {1});
      const auto b = over_seeds(skin, light, with, {1});
      std::printf("skin trousers %-8s %-11s F1 without the clothes %.3f, with them %.3f\n", light, skin.c_str(), a.f1(),
                  b.f1());
      EXPECT_GT(b.f1(), a.f1()) << skin << ", " << light;
      EXPECT_GE(b.f1(), skin == "dark" ? 0.5 : 0.75) << skin << ", " << light;
    }
  }
}

class UciSamples : public ::testing::TestWithParam<ToneKind> {};

// Of every other block of 1000 rows the model is made, by the rest it is judged: neighbouring rows are of one
// photograph.
TEST_P(UciSamples, AreToldApartInTheHalfThatWasHeldOut) {
  const auto file = test::shared_data("skin/uci/Skin_NonSkin.txt");
  if (file.empty()) GTEST_SKIP() << "the samples in ../shared/data are not here";
  const auto table = config::load_colour_table(file, "B,G,R,label");
  std::vector<cv::Vec3b> training;
  std::array<std::vector<cv::Vec3b>, 2> judged;  // By whether it is skin.
  for (std::size_t i = 0; i < table.bgr.size(); ++i) {
    const bool skin = table.label[i] == 1;
    if (i / 1000 % 2 == 0) {
      if (skin) training.push_back(table.bgr[i]);
    } else {
      judged[skin ? 1 : 0].push_back(table.bgr[i]);
    }
  }
  ToneFit fit;
  fit.kind = GetParam();
  ToneSet set;
  set.put({"skin", 0.2, fitted_parts(training, fit)});
  const ToneMapper mapper(std::move(set));
  const auto found = [&](std::vector<cv::Vec3b>& pixels) {
    const cv::Mat picture(static_cast<int>(pixels.size()), 1, CV_8UC3, pixels.data());
    return double(cv::countNonZero(mapper.posterior(picture, {}, 0) >= 128));
  };
  Counts c;
  c.hits = found(judged[1]);
  c.missed = double(judged[1].size()) - c.hits;
  c.false_hits = found(judged[0]);
  std::printf("UCI %s: precision %.4f recall %.4f F1 %.4f\n", name_of(GetParam()), c.precision(), c.recall(), c.f1());
  EXPECT_GE(c.f1(), 0.98);
}

INSTANTIATE_TEST_SUITE_P(Skin, UciSamples, ::testing::Values(ToneKind::kGaussian, ToneKind::kHistogram),
                         [](const auto& each) { return std::string(name_of(each.param)); });

}  // namespace
}  // namespace choreo::vision
