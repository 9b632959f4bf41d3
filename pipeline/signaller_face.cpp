// SPDX-License-Identifier: Apache-2.0
#include "pipeline/signaller_face.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>

namespace choreo::pipeline {
namespace {

using vision::Face;

// How far from one another the same face may be found, in its widths: people sway, detectors waver.
constexpr double kSway = 1.0;
constexpr double kGrowth = 1.45;

// What hands reach, in face widths from the face's middle.
constexpr double kAside = 5.2;
constexpr double kUp = 4.2;
constexpr double kDown = 5.6;

cv::Point2d middle_of(const Face& face) { return {face.box.x + face.box.width / 2, face.box.y + face.box.height / 2}; }

bool alike(const Face& a, const Face& b) {
  const double ratio = a.box.width / b.box.width;
  return ratio < kGrowth && ratio > 1 / kGrowth && cv::norm(middle_of(a) - middle_of(b)) < kSway * a.box.width;
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The face of each view that is most like `centre`; null where none is.
std::vector<const Face*> matches(const Face& centre, std::span<const FacesOfView> views) {
  std::vector<const Face*> out(views.size(), nullptr);
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (const auto& face : views[i].faces) {
      if (!alike(centre, face)) continue;
      if (out[i] == nullptr || face.confidence > out[i]->confidence) out[i] = &face;
    }
  }
  return out;
}

Face typical_of(const std::vector<const Face*>& faces) {
  std::vector<double> x, y, width, confidence;
  for (const auto* face : faces) {
    if (face == nullptr) continue;
    x.push_back(middle_of(*face).x);
    y.push_back(middle_of(*face).y);
    width.push_back(face->box.width);
    confidence.push_back(face->confidence);
  }
  const double w = median_of(width);
  return {{median_of(x) - w / 2, median_of(y) - w / 2, w, w}, median_of(confidence)};
}

double share_set(const cv::Mat& mask, const cv::Rect2d& box) {
  const auto inside =
      cv::Rect(cvRound(box.x), cvRound(box.y), cvRound(box.width), cvRound(box.height)) & cv::Rect({}, mask.size());
  return inside.empty() ? 0.0 : double(cv::countNonZero(mask(inside))) / inside.area();
}

}  // namespace

std::vector<SignallerFace> signaller_faces(std::span<const FacesOfView> views) {
  std::vector<SignallerFace> out(views.size());
  double best_score = 0;
  std::vector<const Face*> best;
  double moved = 0;
  for (const auto& view : views) moved += cv::countNonZero(view.differs);
  for (const auto& view : views) {
    for (const auto& centre : view.faces) {
      const auto faces = matches(centre, views);
      const auto typical = typical_of(faces);
      const auto w = typical.box.width;
      const auto middle = middle_of(typical);
      const cv::Rect2d reach(middle.x - kAside * w, middle.y - kUp * w, 2 * kAside * w, (kUp + kDown) * w);
      double found = 0;
      double within = 0;
      double stirs = 0;
      for (std::size_t i = 0; i < views.size(); ++i) {
        if (faces[i] != nullptr) found += faces[i]->confidence;
        const auto area = (cv::Rect(cvRound(reach.x), cvRound(reach.y), cvRound(reach.width), cvRound(reach.height)) &
                           cv::Rect({}, views[i].differs.size()));
        if (!area.empty()) within += cv::countNonZero(views[i].differs(area));
        stirs += share_set(views[i].difference > 3, typical.box) / double(views.size());
      }
      // The larger one of two that are as good: what a small window has within reach, a large one has, too.
      const double score =
          found / double(views.size()) * (0.05 + within / std::max(1.0, moved)) * (0.15 + std::min(1.0, stirs / 0.2));
      if (score <= best_score) continue;
      best_score = score;
      best = faces;
    }
  }
  if (best.empty()) return out;
  const auto typical = typical_of(best);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double w = typical.box.width;
    const auto middle = middle_of(best[i] != nullptr ? *best[i] : typical);
    out[i].face = Face{{middle.x - w / 2, middle.y - w / 2, w, w},
                       best[i] != nullptr ? best[i]->confidence : 0.5 * typical.confidence};
    out[i].seen = best[i] != nullptr;
  }
  return out;
}

SignallerFace best_face(std::span<const Face> faces) {
  SignallerFace out;
  double best = 0;
  for (const auto& face : faces) {
    const double score = face.confidence * face.box.width;
    if (score <= best) continue;
    best = score;
    out = {face, true};
  }
  return out;
}

}  // namespace choreo::pipeline
