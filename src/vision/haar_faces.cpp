// SPDX-License-Identifier: Apache-2.0
#include "vision/haar_faces.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"

namespace choreo::vision {
namespace {

// The constants between the cascades' windows and the face: the one place. The frontal one is measured on the synthetic
// performer of all skin tones (tests/pipeline/face_recall_test.cpp): light faces get windows of 1.18 face widths, dark
// ones of 1.06; the centre is off by less than 0.03. Widths of real faces are not known well enough to do better.
constexpr FaceShape kFrontalShape{1 / 1.135, 0, 0.067};
// A profile's window holds the face from nose to ear; given for one that looks to the picture's left.
constexpr FaceShape kProfileShape{1 / 1.25, 0.08, 0.08};

constexpr double kGamma = 0.45;
constexpr double kHalfSure = 5;  // Agreeing windows.

bool best_first(const Face& a, const Face& b) {
  return std::tuple(-a.confidence, a.box.y, a.box.x, a.box.width) <
         std::tuple(-b.confidence, b.box.y, b.box.x, b.box.width);
}

// Best first. A few windows within a surer face are part of it.
std::vector<Face> apart(std::vector<Face> faces) {
  std::sort(faces.begin(), faces.end(), best_first);
  std::vector<Face> kept;
  for (const auto& face : faces) {
    const cv::Point2d centre = (face.box.tl() + face.box.br()) / 2;
    const auto holds = [&](const Face& surer) { return surer.box.contains(centre); };
    if (std::none_of(kept.begin(), kept.end(), holds)) kept.push_back(face);
  }
  return kept;
}

// Whether a rectangle lies in the window; a tilted one hangs by its corner, its sides along the diagonals.
bool inside(const cv::FileNode& rect, bool tilted, cv::Size window) {
  if (!rect.isSeq() || rect.size() != 5) return false;
  int v[4];
  for (int i = 0; i < 4; ++i) {
    const auto node = rect[i];
    if (!node.isInt()) return false;
    v[i] = static_cast<int>(node);
    if (v[i] < 0 || v[i] > std::max(window.width, window.height)) return false;
  }
  const auto [x, y, w, h] = std::tuple(v[0], v[1], v[2], v[3]);
  if (tilted) return x - h >= 0 && x + w <= window.width && y + w + h <= window.height;
  return x + w <= window.width && y + h <= window.height;
}

bool good_features(const cv::FileNode& features, cv::Size window) {
  for (const auto& feature : features) {
    const auto rects = feature["rects"];
    const auto tilted = feature["tilted"];
    if (!rects.isSeq() || rects.empty() || rects.size() > 3) return false;
    for (const auto& rect : rects) {
      if (!inside(rect, !tilted.empty() && static_cast<int>(tilted) != 0, window)) return false;
    }
  }
  return true;
}

// OpenCV walks from node to node without looking where it goes.
bool good_tree(const cv::FileNode& tree, int features) {
  const auto nodes = tree["internalNodes"];
  const auto leaves = tree["leafValues"];
  if (!nodes.isSeq() || !leaves.isSeq() || nodes.empty() || nodes.size() % 4 != 0) return false;
  const int count = static_cast<int>(nodes.size() / 4);
  if (leaves.size() != nodes.size() / 4 + 1) return false;
  for (const auto& leaf : leaves) {
    if (!leaf.isReal() && !leaf.isInt()) return false;
  }
  auto value = nodes.begin();
  for (int node = 0; node < count; ++node) {
    for (int branch = 0; branch < 2; ++branch, ++value) {
      if (!(*value).isInt()) return false;
      const int to = static_cast<int>(*value);
      if (to > 0 ? to <= node || to >= count : to < -count) return false;
    }
    if (!(*value).isInt()) return false;
    const int feature = static_cast<int>(*value);
    if (feature < 0 || feature >= features) return false;
    ++value;
    if (!(*value).isReal() && !(*value).isInt()) return false;
    ++value;
  }
  return true;
}

bool good_cascade(const cv::FileNode& cascade) {
  if (!cascade.isMap() || !cascade["width"].isInt() || !cascade["height"].isInt()) return false;
  const cv::Size window(static_cast<int>(cascade["width"]), static_cast<int>(cascade["height"]));
  if (window.width < 4 || window.height < 4 || window.width > 256 || window.height > 256) return false;
  const auto text = [&](const char* name) {
    const auto node = cascade[name];
    return node.isString() ? static_cast<std::string>(node) : std::string();
  };
  if (text("stageType") != "BOOST" || text("featureType") != "HAAR") return false;
  const auto categories = cascade["featureParams"]["maxCatCount"];
  if (!categories.isInt() || static_cast<int>(categories) != 0) return false;
  const auto features = cascade["features"];
  const auto stages = cascade["stages"];
  if (!features.isSeq() || features.empty() || !stages.isSeq() || stages.empty()) return false;
  if (!good_features(features, window)) return false;
  for (const auto& stage : stages) {
    const auto trees = stage["weakClassifiers"];
    const auto threshold = stage["stageThreshold"];
    if (!trees.isSeq() || trees.empty() || (!threshold.isReal() && !threshold.isInt())) return false;
    for (const auto& tree : trees) {
      if (!good_tree(tree, static_cast<int>(features.size()))) return false;
    }
  }
  return true;
}

}  // namespace

void HaarOptions::validate() const {
  if (neighbours < 1 || neighbours > 100) {
    throw usage_error(fmt::format("neighbours is {}", neighbours), {}, "it is from 1 to 100");
  }
  if (!(scale_step >= 1.01 && scale_step <= 2)) {
    throw usage_error(fmt::format("scale_step is {}", scale_step), {}, "it is from 1.01 to 2");
  }
}

cv::CascadeClassifier read_cascade(const std::string& xml, const std::string& name) {
  const auto* hint = "OpenCV's cascades, such as haarcascade_frontalface_alt.xml, are in the package opencv-data";
  if (!xml.starts_with("<?xml")) throw usage_error(fmt::format("\"{}\" is not XML", name), {}, hint);
  try {
    const cv::FileStorage storage(xml, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    const auto root = storage.isOpened() ? storage.getFirstTopLevelNode() : cv::FileNode();
    cv::CascadeClassifier cascade;
    if (good_cascade(root) && cascade.read(root) && !cascade.empty()) return cascade;
  } catch (const cv::Exception& error) {
    throw usage_error(fmt::format("\"{}\" cannot be read as XML: {}", name, error.err), {}, hint);
  }
  throw usage_error(fmt::format("\"{}\" is no Haar cascade", name), {}, hint);
}

HaarFaceDetector::HaarFaceDetector(cv::CascadeClassifier frontal, cv::CascadeClassifier profile,
                                   const HaarOptions& options)
    : frontal_(std::move(frontal)), profile_(std::move(profile)), options_(options) {
  options_.validate();
}

std::vector<Face> HaarFaceDetector::run(cv::CascadeClassifier& cascade, const cv::Mat& grey, double least_px,
                                        double most_px, const FaceShape& shape) const {
  // A face is hit by windows somewhat smaller and larger than itself, and they count.
  constexpr double kSpread = 1.2;
  // There are no windows smaller than the cascade's own, and few of that size find a dark face: small faces are
  // enlarged, though not to a blur, nor by so little that it only costs.
  constexpr double kMostEnlarged = 2, kLeastEnlarged = 1.15;
  const double wanted = 1.5 * cascade.getOriginalWindowSize().width * shape.width * kSpread / least_px;
  const double scale = wanted < kLeastEnlarged ? 1.0 : std::min(wanted, kMostEnlarged);
  cv::Mat searched = grey;
  if (scale > 1) cv::resize(grey, searched, {}, scale, scale, cv::INTER_LINEAR);
  const auto window = [&](double face, double limit) {
    return std::max(1, static_cast<int>(std::min(std::round(scale * face / shape.width), limit)));
  };
  const double limit = std::min(searched.cols, searched.rows);
  const int least = window(least_px / kSpread, limit + 1);
  const int most = window(most_px * kSpread, limit);
  if (least > most) return {};
  std::vector<cv::Rect> windows;
  // Ungrouped: OpenCV's threads deliver them in any order, and its own grouping depends on that.
  cascade.detectMultiScale(searched, windows, options_.scale_step, 0, 0, {least, least}, {most, most});
  std::sort(windows.begin(), windows.end(), [](const cv::Rect& a, const cv::Rect& b) {
    return std::tie(a.width, a.y, a.x) < std::tie(b.width, b.y, b.x);
  });
  constexpr double kAlike = 0.2;   // As in OpenCV.
  if (windows.empty()) return {};  // cv::partition looks at the first.
  std::vector<int> group_of;
  const int groups = cv::partition(windows, group_of, cv::SimilarRects(kAlike));
  std::vector<cv::Rect2d> sums(static_cast<std::size_t>(groups));
  std::vector<int> counts(sums.size());
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const auto g = static_cast<std::size_t>(group_of[i]);
    const auto& w = windows[i];
    auto& sum = sums[g];
    sum = {sum.x + w.x, sum.y + w.y, sum.width + w.width, sum.height + w.height};
    ++counts[g];
  }
  std::vector<Face> faces;
  for (std::size_t g = 0; g < sums.size(); ++g) {
    const double n = counts[g];
    if (counts[g] < options_.neighbours) continue;
    const double all = n * scale;
    const cv::Rect2d mean(sums[g].x / all, sums[g].y / all, sums[g].width / all, sums[g].height / all);
    const auto face = shape.face(mean);
    if (face.width >= least_px && face.width <= most_px) faces.push_back({face, n / (n + kHalfSure)});
  }
  return faces;
}

std::vector<Face> HaarFaceDetector::detect(const cv::Mat& grey, const cv::Rect& where, double least_px, double most_px,
                                           FaceLook look) {
  const auto searched = where & cv::Rect({0, 0}, grey.size());
  if (searched.empty() || !(least_px <= most_px)) return {};
  if (look == FaceLook::kAny) {
    for (const auto each : {FaceLook::kFront, FaceLook::kBrightened, FaceLook::kProfile}) {
      if (auto faces = detect(grey, where, least_px, most_px, each); !faces.empty()) return faces;
    }
    return {};
  }
  const cv::Mat part = grey(searched);
  std::vector<Face> faces;
  try {
    if (look == FaceLook::kProfile) {
      if (profile_.empty()) return {};
      faces = run(profile_, part, least_px, most_px, kProfileShape);
      cv::Mat flipped;
      cv::flip(part, flipped, 1);
      for (auto face : run(profile_, flipped, least_px, most_px, kProfileShape)) {
        face.box.x = part.cols - face.box.x - face.box.width;
        faces.push_back(face);
      }
    } else if (look == FaceLook::kBrightened) {
      cv::Mat curve(1, 256, CV_8UC1);
      for (int v = 0; v < 256; ++v) curve.at<uchar>(v) = cv::saturate_cast<uchar>(255 * std::pow(v / 255.0, kGamma));
      cv::Mat brightened;
      cv::LUT(part, curve, brightened);
      faces = run(frontal_, brightened, least_px, most_px, kFrontalShape);
    } else {
      faces = run(frontal_, part, least_px, most_px, kFrontalShape);
    }
  } catch (const cv::Exception& error) {
    throw failure(fmt::format("the face detector failed: {}", error.err));
  }
  for (auto& face : faces) face.box += cv::Point2d(searched.tl());
  return apart(std::move(faces));
}

}  // namespace choreo::vision
