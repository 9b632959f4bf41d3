// SPDX-License-Identifier: Apache-2.0
#include "vision/face_detector.hpp"

#include <algorithm>
#include <tuple>

#include <opencv2/imgproc.hpp>

namespace choreo::vision {
namespace {

// What one look at one version of the picture gave, in pixels of the picture itself.
struct Sighting {
  Face face;
  double missing = 1;  // Product of 1 - confidence over the looks that agree.
  int looks = 0;
};

void add(std::vector<Sighting>& all, const Face& face) {
  constexpr double kSame = 0.4;
  auto* best = static_cast<Sighting*>(nullptr);
  double most = kSame;
  for (auto& known : all) {
    const double share = overlap(known.face.box, face.box);
    if (share < most) continue;
    most = share;
    best = &known;
  }
  if (best == nullptr) best = &all.emplace_back(Sighting{face});
  // Where looks disagree about the place, the surest one is right.
  if (face.confidence > best->face.confidence) best->face = face;
  best->missing *= 1 - 0.5 * face.confidence;
  ++best->looks;
}

}  // namespace

double overlap(const cv::Rect2d& a, const cv::Rect2d& b) {
  const double both = (a & b).area();
  const double either = a.area() + b.area() - both;
  return either > 0 ? both / either : 0;
}

std::vector<Face> all_faces(FaceDetector& detector, const cv::Mat& grey, double least_px) {
  constexpr int kMostSide = 4096;  // Of an enlarged picture.
  std::vector<Sighting> all;
  if (grey.empty()) return {};
  for (const double scale : {1.0, 2.0}) {
    if (scale > 1 && std::max(grey.cols, grey.rows) * scale > kMostSide) continue;
    cv::Mat scaled = grey;
    if (scale != 1) cv::resize(grey, scaled, {}, scale, scale, cv::INTER_LINEAR);
    const auto look_at = [&](const cv::Mat& picture, FaceLook look) {
      const double most = std::min(picture.cols, picture.rows);
      for (auto face : detector.detect(picture, {{0, 0}, picture.size()}, least_px * scale, most, look)) {
        const auto& box = face.box;
        face.box = {box.x / scale, box.y / scale, box.width / scale, box.height / scale};
        add(all, face);
      }
    };
    look_at(scaled, FaceLook::kFront);
    look_at(scaled, FaceLook::kBrightened);
    if (scale > 1) continue;
    look_at(scaled, FaceLook::kProfile);
    cv::Mat even;
    cv::createCLAHE(2.0, {8, 8})->apply(scaled, even);
    look_at(even, FaceLook::kFront);
    look_at(even, FaceLook::kBrightened);
  }
  std::vector<Face> faces;
  for (const auto& sighting : all) faces.push_back({sighting.face.box, 1 - sighting.missing});
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return std::tuple(-a.confidence, a.box.y, a.box.x, a.box.width) <
           std::tuple(-b.confidence, b.box.y, b.box.x, b.box.width);
  });
  return faces;
}

}  // namespace choreo::vision
