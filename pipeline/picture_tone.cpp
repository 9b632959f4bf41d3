// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "pipeline/picture_reading.hpp"
#include "vision/tone_learner.hpp"
#include "vision/tone_mapper.hpp"

namespace choreo::pipeline {
namespace {

// What furniture of skin's colour is taken for is less sure than this.
constexpr double kSureEnough = 0.75;

// A hand alone, out of a sleeve, points nowhere.
bool points_somewhere(const vision::Blob& arm) {
  constexpr double kLong = 2;  // Times as long as broad.
  const auto& m = arm.moments;
  const double middle = (m.mu20 + m.mu02) / 2, off = std::hypot((m.mu20 - m.mu02) / 2, m.mu11);
  return middle + off >= kLong * kLong * (middle - off);
}

}  // namespace

cv::Mat reduced_picture(const cv::Mat& picture) {
  const int longer = std::max(picture.cols, picture.rows);
  if (longer <= kLongestPictureSide) return picture;
  const double shrink = double(kLongestPictureSide) / longer;
  cv::Mat out;
  cv::resize(picture, out, {std::max(1, cvRound(picture.cols * shrink)), std::max(1, cvRound(picture.rows * shrink))},
             0, 0, cv::INTER_AREA);
  return out;
}

void ToneReaderOptions::validate() const {
  if (!(least_face >= 0.01 && least_face <= 0.5)) {
    throw usage_error(fmt::format("is {}", least_face), "face.least_share", "from 0.01 to 0.5");
  }
  if (!(most_face > least_face && most_face <= 1)) {
    throw usage_error(fmt::format("is {}", most_face), "face.most_share", "above face.least_share, up to 1");
  }
  semaphore.validate();
  tones.validate(given.names());
  arms.validate();
  bounds.validate();
}

ToneReader::ToneReader(vision::FaceDetector& faces, ToneReaderOptions options)
    : faces_(faces), options_(std::move(options)), signs_(options_.semaphore, options_.bounds) {
  options_.validate();
  options_.arms.min_probability = options_.tones.threshold;
}

std::optional<vision::Face> ToneReader::face_in(const cv::Mat& picture) const {
  const double least = options_.least_face * picture.rows;
  const double most = std::min(options_.most_face * picture.rows, double(std::min(picture.cols, picture.rows)));
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  auto faces = faces_.detect(grey, cv::Rect({}, picture.size()), least, most, vision::FaceLook::kFront);
  if (faces.empty()) faces = vision::all_faces(faces_, grey, least);
  std::erase_if(faces, [&](const auto& face) { return face.box.width > most; });
  const auto best =
      std::ranges::max_element(faces, {}, [](const auto& face) { return face.confidence * face.box.width; });
  return best != faces.end() ? std::optional(*best) : std::nullopt;
}

vision::ToneSet ToneReader::tones_of(const cv::Mat& picture, const vision::TrackedFace& face) const {
  auto at_once = options_.tones;  // A picture has no time in which the light would change.
  at_once.learn_s = 60;
  at_once.adapt_s = 0;
  at_once.rebuild_s = 0;
  auto tones = options_.given;
  tones.outliers = options_.tones.outliers;
  vision::ToneLearner learner(at_once);
  if (options_.tones.learn_skin || options_.tones.learn_clothes) learner.add(picture, face, 0);
  if (options_.tones.learn_skin && learner.skin()) tones.put(*learner.skin());
  if (learner.clothes()) tones.put(*learner.clothes());
  return tones;
}

PictureReading ToneReader::read(const cv::Mat& picture) const {
  PictureReading out;
  out.face = face_in(picture);
  if (!out.face) return out;
  const auto& box = out.face->box;
  const vision::TrackedFace face{
      {box.x + box.width / 2, box.y + box.height / 2}, box.width, out.face->confidence, 0, 0};
  const auto tones = tones_of(picture, face);
  std::vector<std::size_t> arm_tones;
  for (const auto& name : options_.tones.arms) {
    if (const auto at = tones.find(name); at < tones.tones.size()) arm_tones.push_back(at);
  }
  out.why = NoSign::kNoTone;
  if (arm_tones.empty()) return out;
  const cv::Mat everywhere(picture.size(), CV_8UC1, cv::Scalar(255));
  const cv::Mat posterior = vision::ToneMapper(tones).posterior(picture, everywhere, arm_tones);
  out.evidence = posterior >= std::ceil(255 * options_.tones.threshold);
  const auto arms = vision::ArmFinder(options_.arms).find(posterior, everywhere, face, 0);
  out.why = NoSign::kHidden;
  const bool bare = std::ranges::find(options_.tones.arms, "skin") != options_.tones.arms.end();
  if (arms.found != vision::ArmCase::kTwoArms || (bare && !std::ranges::all_of(arms.blob, points_somewhere)))
    return out;
  const auto state = body::particle_state_of(arms, face, options_.bounds);
  if (!state) return out;
  const auto reading = signs_.read(state);
  out.confidence = reading.confidence;
  out.runner_up = reading.runner_up;
  if (reading.sign && *reading.sign != "REST" && (!bare || reading.confidence >= kSureEnough)) {
    out.sign = reading.sign;
    out.why.reset();
  } else {
    const bool rest = reading.sign && *reading.sign == "REST";
    out.why = rest ? NoSign::kArmsHang : NoSign::kUnlikeAny;
    if (reading.sign && !rest) {
      out.runner_up = *reading.sign;
      out.confidence = 1 - reading.confidence;
    }
  }
  if (out.runner_up == "REST") out.runner_up = {};
  return out;
}

}  // namespace choreo::pipeline
