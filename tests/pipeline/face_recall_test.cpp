// SPDX-License-Identifier: Apache-2.0
// How many faces are found, how exactly, how many false ones, and at what cost: synthetic performers of every skin tone
// in three rooms and lights, and recordings of people.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "devices/registry.hpp"
#include "devices/synthetic/look.hpp"
#include "devices/synthetic/performer.hpp"
#include "devices/video_file/video_file.hpp"
#include "pipeline/face_models.hpp"
#include "pipeline/stages/face_stage.hpp"
#include "support/long_lane.hpp"
#include "support/shared_data.hpp"

namespace choreo::pipeline {
namespace {

using devices::synthetic::Performer;
using devices::synthetic::PerformerSettings;

// Adds up the time that the detector takes.
class Timed final : public vision::FaceDetector {
 public:
  Timed(std::unique_ptr<vision::FaceDetector> detector, double& seconds)
      : detector_(std::move(detector)), seconds_(seconds) {}
  std::vector<vision::Face> detect(const cv::Mat& grey, const cv::Rect& where, double least_px, double most_px,
                                   vision::FaceLook look) override {
    timespec from{}, to{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &from);
    auto faces = detector_->detect(grey, where, least_px, most_px, look);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &to);
    seconds_ += double(to.tv_sec - from.tv_sec) + 1e-9 * double(to.tv_nsec - from.tv_nsec);
    return faces;
  }

 private:
  std::unique_ptr<vision::FaceDetector> detector_;
  double& seconds_;
};

// All of it in one thread, so that its time can be told.
class FaceRecall : public ::testing::Test {
 protected:
  FaceRecall() : threads_(cv::getNumThreads()) { cv::setNumThreads(1); }
  ~FaceRecall() override { cv::setNumThreads(threads_); }

 private:
  int threads_;
};

struct Tally {
  int frames = 0;                    // That were looked at.
  int visible = 0;                   // Of these, with a face to be seen, once there was a second to find it.
  int found = 0;                     // Of these, with a face within half a width of it.
  int elsewhere = 0;                 // Frames with a face that is nowhere near.
  double dx = 0, dy = 0, width = 0;  // Sums over `found`, in face widths.
  double dx2 = 0, dy2 = 0;
  double first_s = 0;  // Until the first found one, summed over takes.
  int takes = 0;
  double detector_s = 0;

  void print(const std::string& name) const {
    const double n = std::max(1, found);
    std::printf(
        "%-26s recall %5.1f %% of %d, elsewhere %.2f %%, off by (%+.3f, %+.3f) rms (%.3f, %.3f), width %.3f, "
        "first after %.2f s, %.2f ms a frame\n",
        name.c_str(), 100.0 * found / std::max(1, visible), visible, 100.0 * elsewhere / std::max(1, frames), dx / n,
        dy / n, std::sqrt(dx2 / n), std::sqrt(dy2 / n), width / n, first_s / std::max(1, takes),
        1000 * detector_s / std::max(1, frames));
  }
};

// @param with_mask  the performer's true silhouette is known, as a body mask would have it.
void follow(const std::string& script, const PerformerSettings& settings, int stride, bool with_mask, Tally& tally) {
  const Performer performer(script, settings);
  FaceStage stage(std::make_unique<Timed>(load_face_detector({}), tally.detector_s), {});
  double seen_since = -1;
  double first = -1;
  const double start = performer.first_frame() / settings.fps;
  for (int i = 0, n = 0; i < performer.frame_count(); i += stride, ++n) {
    const auto truth = performer.perform(i);
    auto frame = std::make_shared<devices::Frame>();
    frame->sequence = std::uint64_t(n);
    frame->device_time = truth.time;
    frame->bgr = truth.bgr;
    Observation observation;
    observation.frame = frame;
    observation.time = truth.time;
    if (with_mask) {
      observation.mask.mask = truth.mask;
      observation.mask.body = truth.present;
    }
    stage.process(observation);
    ++tally.frames;
    const double time = to_seconds(truth.time);
    if (truth.face.empty()) seen_since = -1;
    if (!truth.face.empty() && seen_since < 0) seen_since = time;
    const cv::Point2d centre = (truth.face.tl() + truth.face.br()) / 2;
    const bool visible = !truth.face.empty() && time >= seen_since + 1;
    tally.visible += visible ? 1 : 0;
    if (!observation.face) continue;
    const auto off = (observation.face->centre - centre) / truth.face.width;
    const bool near = !truth.face.empty() && cv::norm(off) < 0.5;
    if (near && first < 0) first = time - start;
    // Turned away, the face coasts: that is no face elsewhere.
    if (!truth.face.empty() ? cv::norm(off) > 1 : observation.face->unseen_s == 0) ++tally.elsewhere;
    if (!visible || !near) continue;
    ++tally.found;
    tally.dx += off.x;
    tally.dy += off.y;
    tally.dx2 += off.x * off.x;
    tally.dy2 += off.y * off.y;
    tally.width += observation.face->width / truth.face.width;
  }
  EXPECT_GT(tally.visible, 0) << "nobody was there to be found";
  tally.first_s += first < 0 ? to_seconds(Nanoseconds(std::chrono::seconds(10))) : first;
  ++tally.takes;
}

PerformerSettings signaller(const std::string& skin, const std::string& room, const std::string& light) {
  PerformerSettings settings;
  settings.skin = skin;
  settings.room = room;
  settings.light = light;
  settings.empty = 0.5;
  settings.text = "ANT";
  settings.letters_per_minute = 24;
  settings.seed = 11 + std::uint64_t(room[0]);
  return settings;
}

class SkinTone : public FaceRecall, public ::testing::WithParamInterface<const char*> {};

TEST_P(SkinTone, FacesOfSignallersAreFollowed) {
  Tally tally;
  const auto skins = devices::synthetic::skin_names().subspan(1);
  const auto own_room = std::size_t(std::find(skins.begin(), skins.end(), GetParam()) - skins.begin()) % 3;
  constexpr std::array<std::array<const char*, 2>, 3> kRooms = {
      {{"plain", "neutral"}, {"cluttered", "dim"}, {"wooden", "warm"}}};
  for (std::size_t k = 0; k < kRooms.size(); ++k) {
    if (!test::in_long_lane() && k != own_room) continue;
    follow("semaphore", signaller(GetParam(), kRooms[k][0], kRooms[k][1]), 2, false, tally);
  }
  tally.print(GetParam());
  EXPECT_GE(tally.found, 0.97 * tally.visible);
  EXPECT_LE(tally.elsewhere, 0.01 * tally.frames);
  EXPECT_NEAR(tally.width / tally.found, 1, 0.1);
  EXPECT_LT(std::abs(tally.dx / tally.found), 0.04);
  EXPECT_LT(std::abs(tally.dy / tally.found), 0.04);
}

INSTANTIATE_TEST_SUITE_P(Every, SkinTone, ::testing::Values("very-light", "light", "medium", "tan", "brown", "dark"));

TEST_F(FaceRecall, WithTheBodyKnownThePosterOnTheWallIsNobody) {
  Tally tally;
  for (const auto* skin : {"light", "dark"}) {
    auto settings = signaller(skin, "plain", "neutral");
    settings.poster = true;
    settings.empty = 3;
    follow("semaphore", settings, 2, true, tally);
  }
  tally.print("poster");
  EXPECT_GE(tally.found, 0.9 * tally.visible);
  EXPECT_EQ(tally.elsewhere, 0);
}

TEST_F(FaceRecall, FacesOfThoseWhoStandFarOffAreFollowed) {
  Tally tally;
  for (const auto* skin : {"light", "dark"}) {
    auto settings = signaller(skin, "cluttered", "neutral");
    settings.distance = 1.5;
    settings.place = 0.2;
    follow("semaphore", settings, 2, false, tally);
  }
  tally.print("far and aside");
  EXPECT_GE(tally.found, 0.8 * tally.visible);
  EXPECT_LE(tally.elsewhere, 0.01 * tally.frames);
}

TEST_F(FaceRecall, DancersFacesAreFollowed) {
  for (const auto* script : {"jumping-jacks", "idle"}) {
    PerformerSettings settings;
    settings.empty = 0.5;
    settings.duration = 6;
    settings.seed = 5;
    Tally one;
    follow(script, settings, 1, false, one);
    one.print(script);
    EXPECT_GE(one.found, 0.75 * one.visible) << script;
    EXPECT_LE(one.elsewhere, 0.03 * one.frames) << script;
  }
}

TEST_F(FaceRecall, APictureSearchedThoroughlyShowsItsFaceFirst) {
  const auto detector = load_face_detector({});
  int pictures = 0, first = 0, anywhere = 0, others = 0;
  for (const auto* skin : {"very-light", "medium", "dark"}) {
    const Performer performer("semaphore", signaller(skin, "wooden", "neutral"));
    const auto truth = performer.perform(performer.first_frame() + 45);
    cv::Mat grey;
    cv::cvtColor(truth.bgr, grey, cv::COLOR_BGR2GRAY);
    const auto faces = vision::all_faces(*detector, grey, 0.045 * grey.rows);
    ++pictures;
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const bool right = vision::overlap(faces[f].box, truth.face) > 0.4;
      first += right && f == 0 ? 1 : 0;
      anywhere += right ? 1 : 0;
      others += right ? 0 : 1;
    }
  }
  std::printf("stills: %d of %d first, %d found, %d others\n", first, pictures, anywhere, others);
  EXPECT_EQ(first, pictures);
}

struct Clip {
  const char* name;
  int stride;        // In the long lane,
  int short_stride;  // and else.
};

class RealVideo : public FaceRecall, public ::testing::WithParamInterface<Clip> {};

// Nobody in these clips looks into the camera for long: what they measure is false faces.
TEST_P(RealVideo, HardlyEverShowsAFaceWhereThereIsNone) {
  const auto path = test::shared_data(std::string("video/clear/") + GetParam().name);
  if (path.empty()) GTEST_SKIP() << "the recordings in ../shared/data are not here; see tests/support/shared_data.hpp";
  devices::Registry registry;
  registry.add(devices::video_file_driver());
  const auto source = registry.open(path);
  double seconds = 0;
  FaceStage stage(std::make_unique<Timed>(load_face_detector({}), seconds), {});
  const int stride = test::in_long_lane() ? GetParam().stride : GetParam().short_stride;
  int frames = 0, with_face = 0, n = 0;
  while (const auto frame = source->read({})) {
    if (n++ % stride != 0) continue;
    Observation observation;
    observation.frame = frame;
    observation.time = frame->device_time;
    stage.process(observation);
    ++frames;
    if (!observation.face) continue;
    ++with_face;
    if (with_face % 10 == 1) {
      std::printf("%s frame %d: face at (%.0f, %.0f), %.0f wide, confidence %.2f\n", GetParam().name, n,
                  observation.face->centre.x, observation.face->centre.y, observation.face->width,
                  observation.face->confidence);
    }
  }
  std::printf("%s: a face in %d of %d frames, %.2f ms a frame\n", GetParam().name, with_face, frames,
              1000 * seconds / std::max(1, frames));
  EXPECT_GE(frames, 50);
  EXPECT_LE(with_face, 0.05 * frames);
}

INSTANTIATE_TEST_SUITE_P(Clips, RealVideo,
                         ::testing::Values(Clip{"intel_one-by-one-person-detection.mp4", 2, 6},
                                           Clip{"pose2sim_single_cam01.mp4", 1, 2},
                                           Clip{"pose2sim_single_cam02.mp4", 1, 2}),
                         [](const auto& clip) { return "number" + std::to_string(clip.index); });

}  // namespace
}  // namespace choreo::pipeline
