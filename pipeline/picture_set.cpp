// SPDX-License-Identifier: Apache-2.0
#include "pipeline/picture_set.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "pipeline/signaller_face.hpp"
#include "vision/difference.hpp"
#include "vision/shared_wall.hpp"
#include "vision/tone_learner.hpp"
#include "vision/tone_mapper.hpp"

namespace choreo::pipeline {
namespace {

using vision::AgainstWall;
using vision::Face;

constexpr double kSeconds = 0.1;  // Between pictures, for a learner that thinks of films.
constexpr int kClosing = 2;
constexpr int kFaint = 70;       // Of 255: what just differs.
constexpr int kCertain = 128;    // Posterior of 255.
constexpr double kSpeck = 0.02;  // Face widths squared.
constexpr double kLeastOverlap = 0.45;
constexpr double kLeastSeen = 0.25;    // Arms: a picture that shows less shows none.
constexpr std::size_t kSmallSet = 12;  // Of more pictures, each arm moves in some.
constexpr double kOverlapSpread = 0.03;
constexpr std::size_t kThorough = 6;  // Pictures of a scene.

// A picture and what is known of it, on the canvas of its scene.
struct View {
  std::size_t picture = 0;
  cv::Matx23d picture_from_canvas = {1, 0, 0, 0, 1, 0};
  AgainstWall against;  // Of a picture by itself only bgr.
  std::vector<Face> faces;
};

cv::Point2d moved(const cv::Matx23d& m, cv::Point2d p) {
  return {m(0, 0) * p.x + m(0, 1) * p.y + m(0, 2), m(1, 0) * p.x + m(1, 1) * p.y + m(1, 2)};
}

cv::Matx23d inverse(const cv::Matx23d& m) {
  const auto i = cv::Matx33d(m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), 0, 0, 1).inv();
  return {i(0, 0), i(0, 1), i(0, 2), i(1, 0), i(1, 1), i(1, 2)};
}

cv::Point2d middle_of(const cv::Rect2d& box) { return {box.x + box.width / 2, box.y + box.height / 2}; }

Face moved(const cv::Matx23d& m, const Face& face) {
  const auto centre = moved(m, middle_of(face.box));
  const double scale = std::hypot(m(0, 0), m(1, 0));
  return {{centre.x - face.box.width * scale / 2, centre.y - face.box.height * scale / 2, face.box.width * scale,
           face.box.height * scale},
          face.confidence};
}

// The tones, of which some are arms.
struct Tones {
  vision::ToneSet set;
  std::vector<std::size_t> arms;
};

Tones tones_of(const vision::ToneLearner& learner, const PictureSetOptions& options) {
  Tones out;
  out.set = options.given;
  out.set.outliers = options.tones.outliers;
  if (options.tones.learn_skin && learner.skin()) out.set.put(*learner.skin());
  if (learner.clothes()) out.set.put(*learner.clothes());
  for (const auto& name : options.tones.arms) {
    const auto at = out.set.find(name);
    if (at < out.set.tones.size()) out.arms.push_back(at);
  }
  return out;
}

vision::TrackedFace tracked(const Face& face) { return {middle_of(face.box), face.box.width, face.confidence, 0, 0}; }

// What is seen of arms in one picture: the arms' tone, as sure as it differs from the wall.
cv::Mat arms_seen(const cv::Mat& posterior, const cv::Mat& certainty, double face_width) {
  cv::Mat seen = cv::Mat::zeros(posterior.size(), CV_8UC1);
  if (certainty.empty()) {
    seen.setTo(255, posterior >= kCertain);
  } else {
    certainty.copyTo(seen, posterior >= kCertain);
    cv::max(seen, kFaint, seen);
    seen.setTo(0, posterior < kCertain);
  }
  const int side = 2 * kClosing + 1;
  cv::morphologyEx(seen, seen, cv::MORPH_CLOSE, cv::getStructuringElement(cv::MORPH_RECT, {side, side}));
  seen.setTo(0, ~vision::without_specks(seen > 0, int(kSpeck * face_width * face_width), false));
  return seen;
}

// Fills in what the picture shows, from how well each sign covers it.
void tell(const View& view, const recognition::SignCoverage& coverage, double to_given, PictureReading& reading) {
  const auto all_signs = body::semaphore_signs();
  const auto& overlap = coverage.overlap;
  const auto best = std::size_t(std::max_element(overlap.begin(), overlap.end()) - overlap.begin());
  reading.overlap = overlap[best];
  if (reading.overlap <= 0) {
    reading.confidence = 1;
    return;
  }
  for (std::size_t s = 0; s < 2; ++s) {
    const auto& arm = coverage.arms[best][s];
    reading.arms[s] = {moved(view.picture_from_canvas, arm.from) * to_given,
                       moved(view.picture_from_canvas, arm.to) * to_given};
  }
  const auto likelihood = [&](double value) { return std::exp((value - overlap[best]) / kOverlapSpread); };
  double all = likelihood(kLeastOverlap);
  std::size_t next = best == 0 ? 1 : 0;
  for (std::size_t k = 0; k < overlap.size(); ++k) {
    all += likelihood(overlap[k]);
    if (k != best && overlap[k] > overlap[next]) next = k;
  }
  if (overlap[best] >= kLeastOverlap && coverage.seen >= kLeastSeen) {
    reading.sign = all_signs[best].name;
    reading.runner_up = all_signs[next].name;
    reading.confidence = 1 / all;
  } else {
    reading.runner_up = all_signs[best].name;
    reading.confidence = likelihood(kLeastOverlap) / all;
  }
}

}  // namespace

cv::Mat reduced_picture(const cv::Mat& picture, int longest_side) {
  const int longer = std::max(picture.cols, picture.rows);
  if (longer <= longest_side) return picture;
  const double shrink = double(longest_side) / longer;
  cv::Mat out;
  cv::resize(picture, out, {std::max(1, cvRound(picture.cols * shrink)), std::max(1, cvRound(picture.rows * shrink))},
             0, 0, cv::INTER_AREA);
  return out;
}

void PictureSetOptions::validate() const {
  if (longest_side < 64 || longest_side > 4096) {
    throw usage_error(fmt::format("longest_side is {}", longest_side), {}, "64 to 4096 pixels");
  }
  if (!(least_face > 0 && least_face <= 0.5)) {
    throw usage_error(fmt::format("least_face is {}", least_face), {}, "above 0, up to 0.5");
  }
  if (!(least_threshold >= 1 && least_threshold <= 255)) {
    throw usage_error(fmt::format("least_threshold is {}", least_threshold), {}, "1 to 255 grey levels");
  }
  semaphore.validate();
  tones.validate(given.names());
}

std::optional<std::vector<PictureReading>> read_pictures(std::span<const cv::Mat> pictures,
                                                         vision::FaceDetector& detector,
                                                         const PictureSetOptions& options,
                                                         const std::function<void(double)>& progress,
                                                         std::stop_token stop) {
  options.validate();
  std::vector<PictureReading> readings(pictures.size());
  std::vector<cv::Mat> small;
  std::vector<double> scales;
  std::vector<cv::Mat> greys;
  std::vector<std::vector<Face>> faces;
  const auto report = [&](double share) {
    if (progress) progress(share);
  };
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (stop.stop_requested()) return std::nullopt;
    small.push_back(reduced_picture(pictures[i], options.longest_side));
    scales.push_back(double(small.back().cols) / pictures[i].cols);
    cv::Mat grey;
    cv::cvtColor(small.back(), grey, cv::COLOR_BGR2GRAY);
    const double longer = std::max(grey.cols, grey.rows);
    faces.push_back(detector.detect(grey, cv::Rect({}, grey.size()), options.least_face * longer, 0.4 * longer,
                                    vision::FaceLook::kFront));
    greys.push_back(std::move(grey));
    report(0.4 * double(i + 1) / double(pictures.size()));
  }
  const auto scenes = vision::shared_scenes(small);
  report(0.6);
  if (stop.stop_requested()) return std::nullopt;
  // The thorough search takes seconds: it is for scenes in which the quick one hardly finds anybody.
  const auto search_thoroughly = [&](std::span<const std::size_t> members) {
    const auto missing = [&](std::size_t i) { return faces[i].empty(); };
    const auto without = std::size_t(std::count_if(members.begin(), members.end(), missing));
    if (2 * without <= members.size()) return;
    std::size_t searched = 0;
    for (const auto i : members) {
      if (!missing(i) || searched == kThorough) continue;
      ++searched;
      faces[i] = vision::all_faces(detector, greys[i], options.least_face * std::max(greys[i].cols, greys[i].rows));
    }
  };
  const recognition::SignCover signs(options.semaphore.mirrored);
  std::vector<char> done(pictures.size(), 0);
  // Reads pictures of one scene, or one alone.
  const auto read_views = [&](std::vector<View>& views, bool shared) {
    std::vector<std::size_t> members;
    for (const auto& view : views) members.push_back(view.picture);
    search_thoroughly(members);
    std::vector<FacesOfView> seen;
    for (const auto& view : views) {
      std::vector<Face> on_canvas;
      const auto back = inverse(view.picture_from_canvas);
      for (const auto& face : faces[view.picture]) on_canvas.push_back(moved(back, face));
      seen.push_back({std::move(on_canvas), view.against.difference, view.against.differs});
    }
    const auto whose = shared ? signaller_faces(seen) : std::vector{best_face(seen.front().faces)};
    auto all_alike = options.tones;  // A set has no time in which the light would change.
    all_alike.learn_s = 60;
    all_alike.adapt_s = 0;
    all_alike.rebuild_s = 0;
    vision::ToneLearner learner(all_alike);
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (whose[i].seen) learner.add(views[i].against.bgr, tracked(*whose[i].face), kSeconds * double(i));
    }
    const auto tones = tones_of(learner, options);
    std::optional<vision::ToneMapper> mapper;
    if (!tones.set.tones.empty()) mapper.emplace(tones.set);
    std::vector<cv::Mat> evidence(views.size());
    const auto covered = [&](bool one_hangs) {
      std::vector<recognition::SignCoverage> out(views.size());
      tbb::parallel_for(std::size_t(0), views.size(), [&](std::size_t i) {
        if (evidence[i].empty()) return;
        const auto& box = whose[i].face->box;
        out[i] = signs.cover(evidence[i], middle_of(box), box.width, one_hangs);
      });
      return out;
    };
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (!whose[i].face || !mapper || tones.arms.empty()) continue;
      const cv::Mat posterior = mapper->posterior(views[i].against.bgr, views[i].against.differs, tones.arms);
      evidence[i] = arms_seen(posterior, views[i].against.certainty, whose[i].face->box.width);
    }
    auto coverages = covered(false);
    if (shared && views.size() <= kSmallSet) {
      // A to D alone: the arm that hangs in all of them is part of the wall. One arm must then explain all that is seen
      // clearly better than two.
      auto one_arm = covered(true);
      const auto explained = [](const std::vector<recognition::SignCoverage>& all) {
        double sum = 0;
        for (const auto& c : all) sum += *std::max_element(c.overlap.begin(), c.overlap.end());
        return sum / double(all.size());
      };
      if (explained(one_arm) > explained(coverages) + 0.05) coverages = std::move(one_arm);
    }
    for (std::size_t i = 0; i < views.size(); ++i) {
      const auto p = views[i].picture;
      auto& reading = readings[p];
      reading.shared = shared;
      reading.faces = int(faces[p].size());
      reading.face_seen = whose[i].seen;
      if (!whose[i].face) continue;
      const double to_given = 1 / scales[p];
      reading.face = moved(views[i].picture_from_canvas, *whose[i].face);
      auto& box = reading.face->box;
      box = {box.x * to_given, box.y * to_given, box.width * to_given, box.height * to_given};
      if (evidence[i].empty()) continue;
      cv::warpAffine(evidence[i], reading.evidence, inverse(views[i].picture_from_canvas), small[p].size(),
                     cv::INTER_NEAREST | cv::WARP_INVERSE_MAP, cv::BORDER_CONSTANT);
      tell(views[i], coverages[i], to_given, reading);
    }
  };
  for (const auto& scene : scenes) {
    std::optional<vision::SharedWall> wall;
    if (scene.members.size() > 2) wall.emplace(small, scene);
    std::vector<View> views;
    for (std::size_t m = 0; m < scene.members.size(); ++m) {
      if (stop.stop_requested()) return std::nullopt;
      View view;
      view.picture = scene.members[m];
      view.picture_from_canvas = scene.picture_from_canvas[m];
      if (wall) {
        view.against = wall->compare(small[view.picture], view.picture_from_canvas, options.least_threshold);
      } else {
        // Of two pictures the other is the wall: what stands where it stood there is taken for wall.
        vision::SharedScene other = scene;
        other.members = {scene.members[1 - m]};
        other.picture_from_canvas = {scene.picture_from_canvas[1 - m]};
        view.against = vision::SharedWall(small, other)
                           .compare(small[view.picture], view.picture_from_canvas, options.least_threshold);
      }
      done[view.picture] = 1;
      views.push_back(std::move(view));
    }
    read_views(views, true);
  }
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (done[i] != 0) continue;
    if (stop.stop_requested()) return std::nullopt;
    std::vector<View> alone(1);
    alone.front().picture = i;
    alone.front().against.bgr = small[i];
    read_views(alone, false);
  }
  report(1);
  return readings;
}

}  // namespace choreo::pipeline
