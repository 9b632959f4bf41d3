// SPDX-License-Identifier: Apache-2.0
#include "pipeline/picture_set.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

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
constexpr double kSpeck = 0.02;  // Face widths squared.
constexpr double kLeastOverlap = 0.45;
constexpr double kLeastSeen = 0.25;    // Arms: a picture that shows less shows none.
constexpr std::size_t kSmallSet = 12;  // Of more pictures, each arm moves in some.
constexpr double kOverlapSpread = 0.03;
constexpr double kSeenSpread = 0.05;
constexpr std::size_t kThorough = 6;  // Pictures of a scene.
constexpr std::size_t kBlock = 32;    // Pictures compared with the signs between two reports.

// Of the whole work, for people who wait.
constexpr double kFacesShare = 0.4;
constexpr double kScenesShare = 0.2;

// Bytes a pixel of a reduced picture: itself, what differs from the wall, what is seen of arms; and while the wall is
// made.
constexpr std::uint64_t kBytes = 12;
constexpr std::uint64_t kWallBytes = 14;

// A picture and what is known of it, on the canvas of its scene. What is large is let go as soon as it has told.
struct View {
  std::size_t picture = 0;
  cv::Matx23d picture_from_canvas = {1, 0, 0, 0, 1, 0};
  AgainstWall against;  // Of a picture by itself only bgr.
  SignallerFace whose;
  cv::Mat evidence;  // CV_8UC1, how sure each pixel is of an arm; empty where nothing can be told.
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
  if (learner.skin()) out.set.put(*learner.skin());
  if (learner.clothes()) out.set.put(*learner.clothes());
  for (const auto& name : options.tones.arms) {
    const auto at = out.set.find(name);
    if (at < out.set.tones.size()) out.arms.push_back(at);
  }
  return out;
}

vision::TrackedFace tracked(const Face& face) { return {middle_of(face.box), face.box.width, face.confidence, 0, 0}; }

// What is seen of arms in one picture: the arms' tone, as sure as it differs from the wall.
// @param least  of the posterior, of 255.
cv::Mat arms_seen(const cv::Mat& posterior, const cv::Mat& certainty, double face_width, int least) {
  cv::Mat seen = cv::Mat::zeros(posterior.size(), CV_8UC1);
  if (certainty.empty()) {
    seen.setTo(255, posterior >= least);
  } else {
    certainty.copyTo(seen, posterior >= least);
    cv::max(seen, kFaint, seen);
    seen.setTo(0, posterior < least);
  }
  const int side = 2 * kClosing + 1;
  cv::morphologyEx(seen, seen, cv::MORPH_CLOSE, cv::getStructuringElement(cv::MORPH_RECT, {side, side}));
  seen.setTo(0, ~vision::without_specks(seen > 0, int(kSpeck * face_width * face_width), false));
  return seen;
}

recognition::SignCoverOptions cover_options(const PictureSetOptions& options) {
  recognition::SignCoverOptions out;
  out.mirrored = options.semaphore.mirrored;
  out.reach = options.arms.reach;
  out.typical_arm = options.arms.typical_arm;
  out.shoulder_aside = options.arms.shoulder_aside;
  out.shoulder_below = options.arms.shoulder_below;
  return out;
}

// Reads one set.
class SetReader {
 public:
  SetReader(std::span<const cv::Mat> pictures, vision::FaceDetector& detector, const PictureSetOptions& options,
            const std::function<void(double)>& progress, std::stop_token stop)
      : given_(pictures),
        detector_(detector),
        options_(options),
        progress_(progress),
        stop_(std::move(stop)),
        signs_(cover_options(options)),
        readings_(pictures.size()) {}

  std::optional<std::vector<PictureReading>> read() {
    if (!find_faces()) return std::nullopt;
    const auto scenes = vision::shared_scenes(
        small_, [this](double share) { report(kFacesShare + kScenesShare * share); }, stop_);
    if (!scenes) return std::nullopt;
    std::vector<char> shared(small_.size(), 0);
    for (const auto& scene : *scenes) {
      for (const auto i : scene.members) shared[i] = 1;
      if (!read_scene(scene)) return std::nullopt;
    }
    for (std::size_t i = 0; i < small_.size(); ++i) {
      if (shared[i] != 0) continue;
      std::vector<View> alone(1);
      alone.front().picture = i;
      alone.front().against.bgr = small_[i];
      settle(0.5);
      if (!read_views(alone, false)) return std::nullopt;
    }
    report(1);
    return std::move(readings_);
  }

 private:
  [[nodiscard]] bool stopped() const { return stop_.stop_requested(); }

  void report(double share) const {
    if (progress_) progress_(share);
  }

  // Of the pictures' own part, in pictures.
  void settle(double pictures) {
    settled_ += pictures;
    constexpr double kBefore = kFacesShare + kScenesShare;
    report(kBefore + (1 - kBefore) * std::min(1.0, settled_ / double(small_.size())));
  }

  [[nodiscard]] double least_px(const cv::Mat& picture) const { return options_.least_face * picture.rows; }
  [[nodiscard]] double most_px(const cv::Mat& picture) const {
    return std::min(options_.most_face * picture.rows, double(std::min(picture.cols, picture.rows)));
  }

  [[nodiscard]] static cv::Mat grey_of(const cv::Mat& picture) {
    cv::Mat grey;
    cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
    return grey;
  }

  // The quick search, of all pictures.
  bool find_faces() {
    for (const auto& picture : given_) {
      if (stopped()) return false;
      small_.push_back(reduced_picture(picture, options_.longest_side));
      const auto& small = small_.back();
      scales_.push_back(double(small.cols) / picture.cols);
      faces_.push_back(detector_.detect(grey_of(small), cv::Rect({}, small.size()), least_px(small), most_px(small),
                                        vision::FaceLook::kFront));
      report(kFacesShare * double(small_.size()) / double(given_.size()));
    }
    return true;
  }

  // The thorough search takes seconds: it is for scenes in which the quick one hardly finds anybody.
  bool search_thoroughly(const std::vector<View>& views) {
    const auto missing = [&](const View& view) { return faces_[view.picture].empty(); };
    const auto without = std::size_t(std::count_if(views.begin(), views.end(), missing));
    if (2 * without <= views.size()) return true;
    std::size_t searched = 0;
    for (const auto& view : views) {
      if (!missing(view) || searched == kThorough) continue;
      if (stopped()) return false;
      ++searched;
      const auto& small = small_[view.picture];
      auto& faces = faces_[view.picture];
      faces = vision::all_faces(detector_, grey_of(small), least_px(small));
      std::erase_if(faces, [&](const Face& face) { return face.box.width > most_px(small); });
    }
    return true;
  }

  // Lays the pictures of a scene over its wall, and reads them.
  bool read_scene(const vision::SharedScene& scene) {
    std::optional<vision::SharedWall> wall;
    if (scene.members.size() > 2) wall.emplace(small_, scene);
    std::vector<View> views;
    for (std::size_t m = 0; m < scene.members.size(); ++m) {
      if (stopped()) return false;
      View view;
      view.picture = scene.members[m];
      view.picture_from_canvas = scene.picture_from_canvas[m];
      if (wall) {
        view.against = wall->compare(small_[view.picture], view.picture_from_canvas, options_.least_threshold);
      } else {
        // Of two pictures the other is the wall: what stands where it stood there is taken for wall.
        vision::SharedScene other = scene;
        other.members = {scene.members[1 - m]};
        other.picture_from_canvas = {scene.picture_from_canvas[1 - m]};
        view.against = vision::SharedWall(small_, other)
                           .compare(small_[view.picture], view.picture_from_canvas, options_.least_threshold);
      }
      view.against.covered.release();
      views.push_back(std::move(view));
      settle(0.5);
    }
    wall.reset();
    return read_views(views, true);
  }

  // Reads pictures of one scene, or one alone.
  bool read_views(std::vector<View>& views, bool shared) {
    if (!search_thoroughly(views)) return false;
    choose_faces(views, shared);
    take_evidence(views);
    auto coverages = covered(views, false);
    if (shared && views.size() <= kSmallSet) {
      // A to D alone: the arm that hangs in all of them is part of the wall. One arm must then explain all that is seen
      // clearly better than two.
      auto one_arm = covered(views, true);
      const auto explained = [](const std::vector<recognition::SignCoverage>& all) {
        double sum = 0;
        for (const auto& c : all) sum += *std::max_element(c.overlap.begin(), c.overlap.end());
        return sum / double(all.size());
      };
      if (explained(one_arm) > explained(coverages) + 0.05) coverages = std::move(one_arm);
    }
    if (stopped()) return false;
    for (std::size_t i = 0; i < views.size(); ++i) write_reading(views[i], coverages[i], shared);
    return true;
  }

  // Whose face it is, in every view.
  void choose_faces(std::vector<View>& views, bool shared) const {
    std::vector<FacesOfView> seen;
    for (auto& view : views) {
      std::vector<Face> on_canvas;
      const auto back = inverse(view.picture_from_canvas);
      for (const auto& face : faces_[view.picture]) on_canvas.push_back(moved(back, face));
      seen.push_back({std::move(on_canvas), std::exchange(view.against.difference, {}), view.against.differs});
    }
    const auto whose = shared ? signaller_faces(seen) : std::vector{best_face(seen.front().faces)};
    for (std::size_t i = 0; i < views.size(); ++i) views[i].whose = whose[i];
  }

  // The tones of the arms and of what else there is, learned from all views together where they are to be.
  [[nodiscard]] Tones learned_tones(const std::vector<View>& views) const {
    auto all_alike = options_.tones;  // A set has no time in which the light would change.
    all_alike.learn_s = 60;
    all_alike.adapt_s = 0;
    all_alike.rebuild_s = 0;
    vision::ToneLearner learner(all_alike);
    for (std::size_t i = 0; options_.tones.learn_skin && i < views.size(); ++i) {
      if (views[i].whose.seen) learner.add(views[i].against.bgr, tracked(*views[i].whose.face), kSeconds * double(i));
    }
    return tones_of(learner, options_);
  }

  // What every view shows of arms.
  void take_evidence(std::vector<View>& views) const {
    const auto tones = learned_tones(views);
    std::optional<vision::ToneMapper> mapper;
    if (!tones.set.tones.empty()) mapper.emplace(tones.set);
    const int least = int(std::ceil(255 * options_.tones.threshold));
    for (auto& view : views) {
      const auto against = std::exchange(view.against, {});
      if (!view.whose.face || !mapper || tones.arms.empty()) continue;
      const cv::Mat posterior = mapper->posterior(against.bgr, against.differs, tones.arms);
      view.evidence = arms_seen(posterior, against.certainty, view.whose.face->box.width, least);
    }
  }

  // How well every sign covers it. Not of all views where it is stopped.
  [[nodiscard]] std::vector<recognition::SignCoverage> covered(const std::vector<View>& views, bool one_hangs) {
    std::vector<recognition::SignCoverage> out(views.size());
    for (std::size_t begin = 0; begin < views.size(); begin += kBlock) {
      const auto end = std::min(views.size(), begin + kBlock);
      tbb::parallel_for(begin, end, [&](std::size_t i) {
        if (views[i].evidence.empty() || stopped()) return;
        const auto& box = views[i].whose.face->box;
        out[i] = signs_.cover(views[i].evidence, middle_of(box), box.width, one_hangs);
      });
      if (!one_hangs) settle(0.5 * double(end - begin));
    }
    return out;
  }

  void write_reading(const View& view, const recognition::SignCoverage& coverage, bool shared) {
    auto& reading = readings_[view.picture];
    reading.shared = shared;
    reading.faces = int(faces_[view.picture].size());
    reading.face_seen = view.whose.seen;
    if (!view.whose.face) return;
    const double to_given = 1 / scales_[view.picture];
    reading.face = moved(view.picture_from_canvas, *view.whose.face);
    auto& box = reading.face->box;
    box = {box.x * to_given, box.y * to_given, box.width * to_given, box.height * to_given};
    if (view.evidence.empty()) {
      reading.why = NoSign::kNoTone;
      return;
    }
    cv::warpAffine(view.evidence, reading.evidence, inverse(view.picture_from_canvas), small_[view.picture].size(),
                   cv::INTER_NEAREST | cv::WARP_INVERSE_MAP, cv::BORDER_CONSTANT);
    const auto answer = answer_of(coverage);
    reading.sign = answer.sign;
    reading.confidence = answer.confidence;
    reading.runner_up = answer.runner_up;
    reading.why = answer.why;
    reading.overlap = *std::max_element(coverage.overlap.begin(), coverage.overlap.end());
    if (reading.overlap <= 0) return;
    const auto nearest =
        std::size_t(std::max_element(coverage.overlap.begin(), coverage.overlap.end()) - coverage.overlap.begin());
    for (std::size_t s = 0; s < 2; ++s) {
      const auto& arm = coverage.arms[nearest][s];
      reading.arms[s] = {moved(view.picture_from_canvas, arm.from) * to_given,
                         moved(view.picture_from_canvas, arm.to) * to_given};
    }
  }

  std::span<const cv::Mat> given_;
  vision::FaceDetector& detector_;
  const PictureSetOptions& options_;
  const std::function<void(double)>& progress_;
  std::stop_token stop_;
  recognition::SignCover signs_;
  std::vector<cv::Mat> small_;  // Reduced, of each picture.
  std::vector<double> scales_;  // Of the reduced picture over the given one.
  std::vector<std::vector<Face>> faces_;
  std::vector<PictureReading> readings_;
  double settled_ = 0;
};

}  // namespace

PictureAnswer answer_of(const recognition::SignCoverage& coverage) {
  const auto& signs = body::semaphore_signs();
  const auto& overlap = coverage.overlap;
  const double top = *std::max_element(overlap.begin(), overlap.end());
  PictureAnswer answer;
  if (top <= 0) {
    answer.confidence = 1;
    answer.why = NoSign::kNoArms;
    return answer;
  }
  const auto likelihood = [&](double value) { return std::exp((value - top) / kOverlapSpread); };
  // Nothing is shown where no sign covers enough, where both arms hang, and where hardly anything is seen of arms.
  double none = likelihood(kLeastOverlap);
  double letters = 0;
  std::vector<std::size_t> by_overlap;
  for (std::size_t k = 0; k < overlap.size(); ++k) {
    if (signs[k].name == "REST") {
      none += likelihood(overlap[k]);
    } else {
      letters += likelihood(overlap[k]);
      by_overlap.push_back(k);
    }
  }
  std::stable_sort(by_overlap.begin(), by_overlap.end(), [&](auto a, auto b) { return overlap[a] > overlap[b]; });
  const auto best = by_overlap[0];
  const double enough = 1 / (1 + std::exp((kLeastSeen - coverage.seen) / kSeenSpread));
  if (overlap[best] == top && top >= kLeastOverlap && coverage.seen >= kLeastSeen) {
    answer.sign = signs[best].name;
    answer.runner_up = signs[by_overlap[1]].name;
    answer.confidence = enough / (letters + none);
  } else {
    answer.runner_up = signs[best].name;
    answer.confidence = 1 - enough * letters / (letters + none);
    answer.why = coverage.seen < kLeastSeen ? NoSign::kNoArms
                 : top < kLeastOverlap      ? NoSign::kUnlikeAny
                                            : NoSign::kArmsHang;
  }
  return answer;
}

std::uint64_t bytes_to_read(std::uint64_t pixels, std::uint64_t pictures) {
  const auto at_a_time = std::min<std::uint64_t>(pictures, vision::SharedWall::kMostPictures);
  return kBytes * pixels + (pictures > 0 ? kWallBytes * pixels / pictures * at_a_time : 0);
}

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
  if (!(least_face >= 0.01 && least_face <= 0.5)) {
    throw usage_error(fmt::format("is {}", least_face), "face.least_share", "from 0.01 to 0.5");
  }
  if (!(most_face > least_face && most_face <= 1)) {
    throw usage_error(fmt::format("is {}", most_face), "face.most_share", "above face.least_share, up to 1");
  }
  if (!(least_threshold >= 1 && least_threshold <= 255)) {
    throw usage_error(fmt::format("least_threshold is {}", least_threshold), {}, "1 to 255 grey levels");
  }
  semaphore.validate();
  tones.validate(given.names());
  arms.validate();
}

std::optional<std::vector<PictureReading>> read_pictures(std::span<const cv::Mat> pictures,
                                                         vision::FaceDetector& detector,
                                                         const PictureSetOptions& options,
                                                         const std::function<void(double)>& progress,
                                                         std::stop_token stop) {
  options.validate();
  return SetReader(pictures, detector, options, progress, std::move(stop)).read();
}

}  // namespace choreo::pipeline
