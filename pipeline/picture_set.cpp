// SPDX-License-Identifier: Apache-2.0
#include "pipeline/picture_set.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
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

// A picture and what is known of it, on the canvas of its scene.
struct View {
  std::size_t picture = 0;
  cv::Matx23d picture_from_canvas = {1, 0, 0, 0, 1, 0};
  AgainstWall against;  // Of a picture by itself only bgr.
  std::vector<Face> faces;
};

cv::Mat reduced(const cv::Mat& picture, int longest_side) {
  const int longer = std::max(picture.cols, picture.rows);
  if (longer <= longest_side) return picture;
  const double shrink = double(longest_side) / longer;
  cv::Mat out;
  cv::resize(picture, out, {std::max(1, cvRound(picture.cols * shrink)), std::max(1, cvRound(picture.rows * shrink))},
             0, 0, cv::INTER_AREA);
  return out;
}

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

void read(const View& view, const Face& face, const vision::ToneMapper* mapper, const Tones& tones,
          const recognition::SignCover& signs, double scale, cv::Size size, PictureReading& reading) {
  const double to_given = 1 / scale;
  reading.face = moved(view.picture_from_canvas, face);
  for (auto* value :
       {&reading.face->box.x, &reading.face->box.y, &reading.face->box.width, &reading.face->box.height}) {
    *value *= to_given;
  }
  if (mapper == nullptr || tones.arms.empty()) return;
  const cv::Mat posterior = mapper->posterior(view.against.bgr, view.against.differs, tones.arms);
  const double width = face.box.width;
  cv::Mat seen = posterior >= 128;
  seen = vision::annealed(seen, kClosing);
  seen = vision::without_specks(seen, int(0.02 * width * width), false);
  const auto coverage = signs.cover(seen, middle_of(face.box), width);
  const auto best =
      std::size_t(std::max_element(coverage.overlap.begin(), coverage.overlap.end()) - coverage.overlap.begin());
  reading.overlap = coverage.overlap[best];
  cv::warpAffine(seen, reading.evidence, inverse(view.picture_from_canvas), size,
                 cv::INTER_NEAREST | cv::WARP_INVERSE_MAP, cv::BORDER_CONSTANT);
  if (reading.overlap <= 0) return;
  for (std::size_t s = 0; s < 2; ++s) {
    const auto& arm = coverage.arms[best][s];
    reading.arms[s] = {moved(view.picture_from_canvas, arm.from) * to_given,
                       moved(view.picture_from_canvas, arm.to) * to_given};
  }
  std::size_t next = best == 0 ? 1 : 0;
  for (std::size_t k = 0; k < coverage.overlap.size(); ++k) {
    if (k != best && coverage.overlap[k] > coverage.overlap[next]) next = k;
  }
  const auto all_signs = body::semaphore_signs();
  reading.sign = all_signs[best].name;
  reading.runner_up = all_signs[next].name;
  reading.confidence = coverage.overlap[best] - coverage.overlap[next];
}

}  // namespace

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
  tones.validate();
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
  std::vector<std::vector<Face>> faces;
  const auto tell = [&](double share) {
    if (progress) progress(share);
  };
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (stop.stop_requested()) return std::nullopt;
    small.push_back(reduced(pictures[i], options.longest_side));
    scales.push_back(double(small.back().cols) / pictures[i].cols);
    cv::Mat grey;
    cv::cvtColor(small.back(), grey, cv::COLOR_BGR2GRAY);
    faces.push_back(vision::all_faces(detector, grey, options.least_face * std::max(grey.cols, grey.rows)));
    readings[i].faces = int(faces.back().size());
    tell(0.4 * double(i + 1) / double(pictures.size()));
  }
  const auto scenes = vision::shared_scenes(small);
  tell(0.6);
  if (stop.stop_requested()) return std::nullopt;
  const recognition::SignCover signs(options.semaphore.mirrored);
  std::vector<char> done(pictures.size(), 0);
  // Reads pictures of one scene, or one alone.
  const auto read_views = [&](std::vector<View>& views, bool shared) {
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
    for (std::size_t i = 0; i < views.size(); ++i) {
      auto& reading = readings[views[i].picture];
      reading.shared = shared;
      reading.face_seen = whose[i].seen;
      if (!whose[i].face) continue;
      const auto p = views[i].picture;
      read(views[i], *whose[i].face, mapper ? &*mapper : nullptr, tones, signs, scales[p], small[p].size(), reading);
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
  tell(1);
  return readings;
}

}  // namespace choreo::pipeline
