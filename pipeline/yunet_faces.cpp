// SPDX-License-Identifier: Apache-2.0
#include "pipeline/yunet_faces.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>
#include <opencv2/objdetect/face.hpp>

#include "core/error.hpp"

namespace choreo::pipeline {
namespace {

using vision::Face;
using vision::FaceLook;

// Its boxes go from cheek to cheek and from chin to hairline, as trained on WIDER FACE.
constexpr vision::FaceShape kShape{1, 0, 0};
constexpr int kStep = 32;  // The network halves the picture five times.
constexpr float kLeastScore = 0.6F;

// OpenCV logs what it does not like of a file; one line of ours is to say it.
class Silence {
 public:
  Silence() : before_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {}
  ~Silence() { cv::utils::logging::setLogLevel(before_); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  cv::utils::logging::LogLevel before_;
};

class YunetDetector final : public vision::FaceDetector {
 public:
  explicit YunetDetector(cv::Ptr<cv::FaceDetectorYN> network) : network_(std::move(network)) {}

  std::vector<Face> detect(const cv::Mat& grey, const cv::Rect& where, double least_px, double most_px,
                           FaceLook look) override {
    const auto searched = where & cv::Rect({0, 0}, grey.size());
    if (searched.empty() || !(least_px <= most_px) || look == FaceLook::kProfile) return {};
    try {
      return found(grey(searched), searched.tl(), least_px, most_px, look);
    } catch (const cv::Exception& error) {
      throw failure(fmt::format("the face detector failed: {}", error.err));
    }
  }

 private:
  std::vector<Face> found(const cv::Mat& part, cv::Point corner, double least_px, double most_px, FaceLook look) {
    cv::Mat picture = part.clone();
    if (look == FaceLook::kBrightened) cv::equalizeHist(part, picture);
    const auto padded = [](int side) { return (side + kStep - 1) / kStep * kStep; };
    cv::copyMakeBorder(picture, picture, 0, padded(part.rows) - part.rows, 0, padded(part.cols) - part.cols,
                       cv::BORDER_REPLICATE);
    cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
    network_->setInputSize(picture.size());
    cv::Mat rows;  // One a face: box (4), landmarks (10), score.
    network_->detect(picture, rows);
    std::vector<Face> faces;
    for (int r = 0; r < rows.rows; ++r) {
      const auto* v = rows.ptr<float>(r);
      const cv::Rect2d box(v[0], v[1], v[2], v[3]);
      const auto finite = [](float x) { return std::isfinite(x); };
      if (!std::all_of(v, v + 4, finite) || !(v[14] > 0) || !(box.width > 0)) continue;
      const auto face = kShape.face(box) + cv::Point2d(corner);
      if (face.width >= least_px && face.width <= most_px) faces.push_back({face, std::min(1.0, double(v[14]))});
    }
    std::stable_sort(faces.begin(), faces.end(),
                     [](const Face& a, const Face& b) { return a.confidence > b.confidence; });
    return faces;
  }

  cv::Ptr<cv::FaceDetectorYN> network_;
};

}  // namespace

std::unique_ptr<vision::FaceDetector> load_yunet(const std::string& path) {
  const Silence silence;
  std::string cause = "the network does not give faces";
  try {
    auto network = cv::FaceDetectorYN::create(path, "", {320, 320}, kLeastScore);
    if (!network.empty()) {
      auto detector = std::make_unique<YunetDetector>(std::move(network));
      (void)detector->detect(cv::Mat::zeros(96, 96, CV_8UC1), {0, 0, 96, 96}, 1, 96, FaceLook::kFront);
      return detector;
    }
  } catch (const cv::Exception& error) {
    cause = error.err;
  } catch (const std::exception& error) {
    cause = error.what();
  }
  throw usage_error(fmt::format("\"{}\" is no face model that OpenCV {} knows: {}", path, CV_VERSION, cause), {},
                    "face_detection_yunet_2022mar.onnx is one; without a model OpenCV's cascades are used");
}

}  // namespace choreo::pipeline
